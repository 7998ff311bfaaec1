// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus apply: the drives of a machine file get what it says. A drive's line comes last: its rate and format, then
// its address; after each of them the drive is looked for where it may be.
#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>

#include "../device_file/device_file.hpp"
#include "../machine/machine.hpp"
#include "../os/file_target.hpp"
#include "../os/interrupts.hpp"
#include "../parameters/changes.hpp"
#include "../registers/consent.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace {

// The drives that were written to and are not saved yet, by their names, in a file beside the machine file: a drive
// does not tell whether it would lose what it holds.
class unsaved_drives {
  public:
    explicit unsaved_drives(const std::string& machine) : path_{machine + ".unsaved"} {
        std::string why;
        constexpr std::size_t largest = 100'000;
        const std::string text =
            std::filesystem::exists(path_) ? read_text_file(path_, largest, why) : std::string{};
        csv::lines lines{text};
        while (!lines.is_at_end()) names_.emplace_back(csv::trimmed(lines.next()));
    }

    bool has(const std::string& name) const { return std::ranges::find(names_, name) != names_.end(); }
    int add(const std::string& name, const char* port) {
        if (has(name)) return done;
        names_.push_back(name);
        return store(port);
    }
    int remove(const std::string& name, const char* port) {
        std::erase(names_, name);
        if (!names_.empty()) return store(port);
        std::error_code error;
        std::filesystem::remove(path_, error);
        return error ? complain(failed, "cannot remove " + path_ + ": " + error.message()) : done;
    }

  private:
    int store(const char* port) {
        std::string text;
        for (const std::string& name : names_) text += name + '\n';
        file_target file{path_};
        if (const int status = file.prepare(port); status != done) return status;
        return file.put(text);
    }

    std::string path_;
    std::vector<std::string> names_{};
};

// One drive of the file.
class application {
  public:
    application(const arguments& asked, const machine_section& wanted, unsaved_drives& unsaved)
        : asked_{&asked}, wanted_{&wanted}, unsaved_{&unsaved} {}

    // Finds the drive, and prints what would be changed.
    int plan() {
        if (const int status = begin(asked_->has("dry-run")); status != done) return status;
        std::size_t unmet = 0;
        if (const int status = compare_required(at_, *wanted_, unmet); status != done) return status;
        if (unmet != 0)
            return complain(failed,
                            "[" + wanted_->name + "] is not what the file requires; nothing was written");
        if (const int status = changes_->compare(wanted_->wanted()); status != done) return status;
        changes_->print();
        if (wanted_->kind->save && unsaved_->has(wanted_->name))
            note("[" + wanted_->name + "] was left unsaved by an apply that did not end: it is saved");
        if (has_work()) {
            note("[" + wanted_->name + "] at " + text_of(at_.where) + ": " +
                 counted(changes_->differing(), "parameter") + " of " +
                 std::to_string(wanted_->wanted().size()) + " differ");
            if (const int status = changes_->say_cost(); status != done) return status;
        }
        planned_ = changes_->all();
        end();
        return done;
    }
    bool has_work() const { return must_save() || !changes_->all().empty(); }

    int carry_out() {
        if (const int status = begin(false); status != done) return status;
        if (const int status = changes_->compare(wanted_->wanted()); status != done) return status;
        if (!is_as_planned())
            return complain(failed,
                            "[" + wanted_->name +
                                "] has changed since the list above was made; nothing was written to it");
        changes_->keep_first(planned_.size());
        const char* const port = asked_->words()[0].c_str();
        if (wanted_->kind->save) {
            if (const int status = unsaved_->add(wanted_->name, port); status != done) return status;
        }
        if (const int status = changes_->write(); status != done) return status;
        if (const int status = move(); status != done) return status;
        changes last{*at_.on, at_.of, rules(false)};
        if (const int status = last.save(); status != done) return status;
        if (const int status = compare_again(); status != done) return status;
        if (wanted_->kind->save) {
            if (const int status = unsaved_->remove(wanted_->name, port); status != done) return status;
        }
        if (at_.where != finished_place(*wanted_))
            note("[" + wanted_->name + "] responds at " + text_of(at_.where) +
                 " until it is switched off and on; then at " + text_of(finished_place(*wanted_)));
        end();
        return done;
    }

  private:
    change_rules rules(bool is_dry) const {
        return {.verb = "apply",
                .is_dry = is_dry,
                .saves = true,
                .in_parts = asked_->has("part"),
                .drive = wanted_->name + '.'};
    }
    bool must_save() const {
        return wanted_->kind->save && (asked_->has("save") || unsaved_->has(wanted_->name));
    }

    int begin(bool is_dry) {
        if (const int status = find_drive(*asked_, *wanted_, at_); status != done) return status;
        changes_.emplace(*at_.on, at_.of, rules(is_dry));
        return changes_->look_for_rest();
    }
    // The next drive needs the port.
    void end() { at_.on.reset(); }

    // The plan may be a part.
    bool is_as_planned() const {
        const std::vector<change>& now = changes_->all();
        if (planned_.size() > now.size() || (!asked_->has("part") && planned_.size() != now.size()))
            return false;
        return std::equal(planned_.begin(), planned_.end(), now.begin(),
                          [](const change& a, const change& b) {
                              return a.row == b.row && a.before == b.before && a.after == b.after;
                          });
    }

    // The settings of the line that differ.
    const change* find_change(u16 address) const {
        const auto at = std::ranges::find(planned_, address, [](const change& c) { return c.row->address; });
        return at != planned_.end() ? &*at : nullptr;
    }
    int move() {
        const servobus::line_choices* const line = wanted_->kind->on_line;
        const change* const rate = line != nullptr ? find_change(line->rate_register) : nullptr;
        const bool has_formats = line != nullptr && !line->formats.is_empty();
        const change* const format = has_formats ? find_change(line->format_register) : nullptr;
        if (rate != nullptr || format != nullptr) {
            const bool is_one_frame =
                rate != nullptr && format != nullptr && line->format_register == line->rate_register + 1;
            std::vector<u16> words;
            for (const change* c : {rate, format}) {
                if (c != nullptr) words.push_back(c->after[0]);
            }
            place next = at_.where;
            const place finished = finished_place(*wanted_);
            next.baud = finished.baud;
            next.format = finished.format;
            if (is_one_frame || words.size() == 1) {
                const servobus::entry& first = *(rate != nullptr ? rate : format)->row;
                if (const int status = move_by(first, words, next); status != done) return status;
            } else {
                return complain(failed, "the rate and the format of this drive are not adjacent");
            }
        }
        const change* const node =
            wanted_->kind->node_register != 0 ? find_change(wanted_->kind->node_register) : nullptr;
        if (node == nullptr) return done;
        place next = at_.where;
        next.node = wanted_->node;
        return move_by(*node->row, node->after, next);
    }
    // Writes registers after which the drive responds at `next`, now or once it is switched off and on.
    int move_by(const servobus::entry& first, const std::vector<u16>& words, const place& next) {
        if (interrupts::came())
            return complain(failed, "interrupted; all but the settings of the line is written");
        const chosen what{name_of(first), first.address, static_cast<u16>(words.size()), nullptr};
        const servobus::status w = at_.on->write(what, words);
        if (w.outcome() == servobus::outcome::refused)
            return complain(failed, what.name + ": " + why_text(at_.of, what, w, *at_.on));
        const place before = at_.where;
        at_.on.reset();
        std::optional<found_drive> found;
        if (const int status = find_among(*asked_, *wanted_, {next, before}, found); status != done)
            return status;
        if (!found)
            return complain(failed, "[" + wanted_->name + "] responds neither at " + text_of(next) +
                                        " nor at " + text_of(before) + " after " + what.name +
                                        "; switch it off and on, and run apply again");
        at_ = std::move(*found);
        std::vector<u16> back(words.size());
        const servobus::status why = at_.on->read(what, back);
        if (why.error() != servobus::errc::ok || back != words)
            return complain(failed, what.name + " does not read back as it was written");
        std::printf("%s.%s: it responds at %s\n", wanted_->name.c_str(), what.name.c_str(),
                    text_of(at_.where).c_str());
        return done;
    }

    int compare_again() {
        changes again{*at_.on, at_.of, rules(false)};
        if (const int status = again.compare(wanted_->wanted()); status != done) return status;
        if (again.all().empty() || asked_->has("part")) return done;
        const change& c = again.all().front();
        return complain(failed, "[" + wanted_->name + "]: " + name_of(*c.row) + " is " +
                                    words_text(*c.row, c.before) + " after all, not " +
                                    words_text(*c.row, c.after));
    }

    const arguments* asked_;
    const machine_section* wanted_;
    unsaved_drives* unsaved_;
    found_drive at_{};
    std::optional<changes> changes_{};
    std::vector<change> planned_{};
};

} // namespace

int apply(const arguments& asked) {
    if (asked.words().size() < 2)
        return complain(usage, "apply takes PORT, a machine FILE, and NAMEs of its drives");
    std::vector<machine_section> sections;
    if (const int status = choose_sections(asked, sections); status != done) return status;
    for (const machine_section& s : sections) {
        if (const int status = refuse_moving(*s.kind, "apply"); status != done) return status;
    }
    interrupts::arm();
    unsaved_drives unsaved{asked.words()[1]};
    std::deque<application> all; // they stay where they are
    for (const machine_section& s : sections) {
        all.emplace_back(asked, s, unsaved);
        if (const int status = all.back().plan(); status != done) return status;
    }
    const bool has_work = std::ranges::any_of(all, &application::has_work);
    if (!has_work) {
        const bool saves =
            std::ranges::any_of(sections, [](const machine_section& s) { return s.kind->save.has_value(); });
        note(std::string{"all is as the file says; nothing to write"} +
             (saves ? "; --save keeps it over a power cycle, if write has set it" : ""));
    }
    if (!has_work || asked.has("dry-run")) return done;
    if (const int status = ask_consent(asked, "apply"); status != done) return status;
    for (application& one : all) {
        if (!one.has_work()) continue;
        if (const int status = one.carry_out(); status != done) return status;
    }
    return done;
}

} // namespace tool
