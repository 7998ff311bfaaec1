// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus restore: a drive's parameters from a file. It writes only what differs, each once, and reads each
// back; nothing is sent before the whole file has been found good.
#include <algorithm>
#include <array>
#include <cstdio>

#include <servobus/device/c630s/alarms.hpp>

#include "../os/interrupts.hpp"
#include "../parameters.hpp"
#include "../terminals.hpp"
#include "../text/streams.hpp"

namespace tool {
namespace {

using servobus::flag;

struct change {
    const servobus::entry* row;
    std::int64_t before;
    std::int64_t after;
};

std::string name_of(const servobus::entry& e) { return std::string{e.name}; }

std::string counted(std::size_t n, const char* thing) {
    return std::to_string(n) + ' ' + thing + (n == 1 ? "" : "s");
}

// Terminals that become active with a new function or polarity.
bool sets_terminals(const servobus::entry& e) {
    const std::string_view name = static_cast<const char*>(e.name);
    for (const std::string_view part : {"_function", "_logic", "_polarit", "outputs", "inputs"}) {
        if (name.find(part) != name.npos) return true;
    }
    return name.ends_with("_brake");
}

class restoration {
  public:
    restoration(const target& of, const arguments& asked) : of_{&of}, asked_{&asked} {}

    int run(const std::vector<parameter>& file) {
        interrupts::arm();
        const bool is_dry = asked_->has("dry-run");
        if (const int status = look_for_rest(is_dry); status != done) return status;
        if (const int status = compare(file); status != done) return status;
        differing_ = changes_.size();
        release_first();
        if (const int status = look_for_clash(); status != done) return status;
        if (const int status = plan(file); status != done) return status;
        if (is_dry) return show();
        if (changes_.empty() && !asked_->has("save")) return done;
        if (const int status = ask_consent(*asked_, "restore"); status != done) return status;
        if (const int status = look_for_rest(false); status != done)
            return status; // that may have taken long
        for (const change& c : changes_) {
            if (const int status = carry_out(c); status != done) return status;
        }
        return asked_->has("save") ? save() : done;
    }

    session& line() { return on_; }

  private:
    int look_for_rest(bool only_says_so) {
        if (of_->kind->at_rest == nullptr) return done; // of a file; see `refuse_moving`
        const repose found = of_->kind->at_rest(on_);
        if (found.why.error() != servobus::errc::ok)
            return complain(failed,
                            "the drive's state: " + why_text(*of_, found.why, on_) + "; nothing was written");
        if (found.unrest.empty()) return done;
        if (only_says_so) {
            note("warning: without --dry-run it is refused: " + found.unrest);
            return done;
        }
        return complain(failed, "refused, nothing was written: " + found.unrest);
    }

    int compare(const std::vector<parameter>& file) {
        std::vector<const parameter*> wanted;
        for (const parameter& p : file) {
            if (is_restorable(*p.row) && p.number) wanted.push_back(&p);
        }
        std::sort(wanted.begin(), wanted.end(),
                  [](const parameter* a, const parameter* b) { return a->row->address < b->row->address; });
        std::vector<const servobus::entry*> rows;
        for (const parameter* p : wanted) rows.push_back(p->row);
        const std::optional<std::vector<parameter>> held = read_parameters(on_, *of_, rows);
        if (!held) return failed;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const parameter& h = (*held)[i];
            if (!h.number)
                return complain(failed, name_of(*h.row) + ": " + h.remark + "; nothing was written");
            if (*h.number == *wanted[i]->number) continue;
            if (*wanted[i]->number == 0 && has(h.row->flags, flag::zero_by_name)) {
                if (!asked_->has("dry-run"))
                    return complain(failed, "refused, nothing was written: " + undocumented_zero(*h.row));
                note("warning: without --dry-run it is refused: " + undocumented_zero(*h.row));
            }
            changes_.push_back({h.row, *h.number, *wanted[i]->number});
        }
        return done;
    }

    // Terminals whose function another one gets lose it before, so that none is on two in between.
    void release_first() {
        if (of_->kind->excludes == nullptr) return;
        std::vector<change> first;
        for (change& c : changes_) {
            const auto takes_it = [&](const change& other) {
                return other.after != 0 && other.after == c.before &&
                       of_->kind->excludes(other.row->address, c.row->address);
            };
            if (c.after == 0 || c.before == 0 || std::none_of(changes_.begin(), changes_.end(), takes_it))
                continue;
            first.push_back({c.row, c.before, 0});
            c.before = 0;
        }
        const auto loses_it = [&](const change& c) {
            return c.after == 0 && is_exclusive(*of_->kind, c.row->address);
        };
        std::stable_partition(changes_.begin(), changes_.end(), loses_it);
        changes_.insert(changes_.begin(), first.begin(), first.end());
    }

    int look_for_clash() {
        std::vector<assignment> wanted;
        for (const change& c : changes_) {
            if (c.row->words() == 1) wanted.push_back({c.row->address, words_of(*c.row, c.after)[0]});
        }
        const clash found = find_clash(on_, *of_, wanted);
        return found.is_none() ? done : complain(failed, clash_text(*of_, found, on_));
    }

    // Says what will be done and what it costs.
    int plan(const std::vector<parameter>& file) {
        std::size_t skipped = 0;
        std::size_t unknown = 0;
        for (const parameter& p : file) {
            if (!is_restorable(*p.row)) {
                ++skipped;
            } else if (!p.number) {
                ++unknown;
            }
        }
        const std::size_t compared = file.size() - skipped - unknown;
        note(std::to_string(differing_) + " of " + counted(compared, "parameter") +
             " differ; skipped: " + counted(skipped, "row") + " (the line's settings, triggers, targets)" +
             (unknown != 0 ? ", " + std::to_string(unknown) + " marked ?" : ""));
        if (const int status = count_stores(); status != done) return status;
        const auto terminals = static_cast<std::size_t>(std::count_if(
            changes_.begin(), changes_.end(), [](const change& c) { return sets_terminals(*c.row); }));
        if (terminals != 0) {
            note("warning: " + std::to_string(terminals) +
                 " of them set inputs, outputs or brakes: a terminal may become active; if that enables the "
                 "drive, restore stops");
        }
        return done;
    }

    int count_stores() {
        const auto is_stored = [](const change& c) { return has(c.row->flags, flag::saved_on_write); };
        auto stored = static_cast<std::size_t>(std::count_if(changes_.begin(), changes_.end(), is_stored));
        if (of_->facts().eeprom_switch == 0) {
            const char* const save = !of_->kind->save ? ""
                                     : asked_->has("save")
                                         ? ", but one save at the end"
                                         : "; --save keeps the parameters over a power cycle";
            note("writes into the EEPROM: " + (stored == 0 ? "none" : std::to_string(stored)) + save);
            return done;
        }
        bool wears = true;
        const servobus::status why = on_.ask_wear(wears);
        const std::string knob = of_->kind->display_name(of_->facts().eeprom_switch);
        if (why.error() != servobus::errc::ok)
            return complain(failed, knob + ": " + why_text(*of_, why, on_) + "; nothing was written");
        if (!wears) {
            note("writes into the EEPROM: none, since " + knob +
                 " is 0; the parameters last until the next power cycle");
            return done;
        }
        const std::size_t most = of_->kind->most_stored;
        if (most != 0 && stored > most) {
            if (!asked_->has("part")) {
                const std::string whole = counted(stored, "write") + " into the EEPROM; more than " +
                                          std::to_string(most) + " raise an alarm of the drive (Er.942, " +
                                          servobus::c630s::find_alarm(0x942)->name + ")";
                if (!asked_->has("dry-run"))
                    return complain(failed, "refused, nothing was written: " + whole +
                                                "; --part writes the first of them");
                note("warning: without --dry-run and --part it is refused: " + whole);
            } else {
                cut_to(most);
                note("this part: the first " + counted(changes_.size(), "parameter") + "; " +
                     std::to_string(stored - most) +
                     " stay for another run with --part, best after a power cycle");
                stored = most;
            }
        }
        note("writes into the EEPROM: " + std::to_string(stored));
        return done;
    }

    // Up to the last change that the drive may store.
    void cut_to(std::size_t most) {
        std::size_t stored = 0;
        std::size_t kept = 0;
        while (kept < changes_.size()) {
            if (has(changes_[kept].row->flags, flag::saved_on_write) && ++stored > most) break;
            ++kept;
        }
        changes_.resize(kept);
    }

    int show() const {
        for (const change& c : changes_) {
            std::printf("%s=%s -> %s\n", name_of(*c.row).c_str(), number_text(*c.row, c.before).c_str(),
                        number_text(*c.row, c.after).c_str());
        }
        return done;
    }

    int carry_out(const change& c) {
        if (interrupts::came()) return stop_at("interrupted");
        const chosen what = choose(*c.row);
        const std::vector<u16> content = words_of(*c.row, c.after);
        const servobus::status w = on_.write(what, content);
        if (!w) {
            return stop_at(what.name + ": " + why_text(*of_, what, w, on_),
                           w.outcome() == servobus::outcome::unknown);
        }
        ++written_;
        std::vector<u16> back(content.size());
        const servobus::status why = on_.read(what, back);
        if (why.error() != servobus::errc::ok)
            return stop_at(what.name + " could not be read back: " + why_text(*of_, why, on_));
        if (back != content) {
            return stop_at(what.name + " reads back as " + value_text(what, back) + ", not as " +
                           value_text(what, content));
        }
        std::printf("%s=%s\n", what.name.c_str(), value_text(what, back).c_str());
        if (sets_terminals(*c.row)) {
            if (const int status = look_after(what.name); status != done) return status;
        }
        const std::string lost = streams::why_lost();
        return lost.empty() ? done : stop_at(lost);
    }

    // A terminal may have become active.
    int look_after(const std::string& name) {
        if (of_->kind->at_rest == nullptr) return done;
        const repose found = of_->kind->at_rest(on_);
        if (found.why.error() != servobus::errc::ok)
            return stop_at("the drive's state after " + name + ": " + why_text(*of_, found.why, on_));
        return found.unrest.empty() ? done : stop_at("stopped after " + name + ": " + found.unrest);
    }

    // What has been written is on standard output. `is_unknown`: the next one may be written or not.
    int stop_at(std::string why, bool is_unknown = false) const {
        why += "; " + std::to_string(written_) + " of " + std::to_string(changes_.size()) + " written";
        if (is_unknown) why += ", perhaps " + name_of(*changes_[written_].row);
        constexpr std::size_t most_named = 8;
        const std::size_t first = written_ + (is_unknown ? 1 : 0);
        for (std::size_t i = first; i < changes_.size(); ++i) {
            if (i == first + most_named) {
                why += " and " + std::to_string(changes_.size() - i) + " more";
                break;
            }
            why += (i == first ? ", not: " : " ") + name_of(*changes_[i].row);
        }
        return complain(failed, why);
    }

    int save() {
        if (interrupts::came()) return complain(failed, "interrupted; all is written, but not saved");
        const save_command command = *of_->kind->save;
        if (command.cleared_first != 0) {
            const chosen first{"save, " + of_->kind->display_name(command.cleared_first),
                               command.cleared_first, 1, nullptr};
            std::array<u16, 1> word{0};
            const servobus::status w = on_.write(first, word);
            if (!w)
                return complain(failed, "all is written, but not saved: " + why_text(*of_, first, w, on_));
            word = {1};
            const servobus::status why = on_.read(first, word);
            if (why.error() != servobus::errc::ok || word[0] != 0)
                return complain(failed,
                                "all is written, but not saved: " + first.name + " does not read back as 0");
        }
        const chosen what{"save", command.address, 1, nullptr};
        const servobus::status w = on_.write(what, std::span<const u16>{&command.value, 1});
        if (w) return done;
        return complain(failed, "all is written, but the save: " + why_text(*of_, what, w, on_));
    }

    const target* of_;
    const arguments* asked_;
    session on_;
    std::vector<change> changes_{};
    std::size_t differing_ = 0;
    std::size_t written_ = 0;
};

// A file does not say how to see that a drive is at rest. Returns `done`, or the exit status after a complaint.
int refuse_moving(const device& of) {
    if (of.at_rest != nullptr) return done;
    const std::string refused = of.word() + ": restore is refused, since ";
    if (!of.has_flags)
        return complain(usage, refused + "the file has no column flags, which says what moves a machine");
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            const bool moves = has(e.flags, flag::motion);
            if (moves || has(e.flags, flag::when_stopped)) {
                return complain(usage,
                                refused + name_of(e) +
                                    (moves ? " moves a motor" : " is written only while a motor stands") +
                                    ", and a file does not say how to see that it is at rest");
            }
        }
    }
    return done;
}

} // namespace

int restore(const arguments& asked) {
    if (asked.words().size() != 3) return complain(usage, "restore takes PORT DEVICE[:NODE] FILE");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr) return complain(usage, "restore needs a device with a map, not raw");
    if (asked.has("save") && !of->kind->save)
        return complain(usage, std::string{"--save: "} + of->facts().name + " has no command to save");
    if (asked.has("part") && of->kind->most_stored == 0)
        return complain(usage, std::string{"--part: "} + of->facts().name + " takes all at once");
    if (const int status = refuse_moving(*of->kind); status != done) return status;
    const std::optional<std::vector<parameter>> file = parse_file(*of->kind, asked.words()[2]);
    if (!file) return usage;
    restoration r{*of, asked};
    if (const int status = r.line().check(asked, *of); status != done) return status;
    if (const int status = r.line().open(asked.words()[0].c_str()); status != done) return status;
    return r.run(*file);
}

} // namespace tool
