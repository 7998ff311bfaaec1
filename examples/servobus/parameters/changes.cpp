// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "changes.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include <servobus/device/c630s/alarms.hpp>

#include "../os/interrupts.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "../words/numbers.hpp"
#include "terminals.hpp"

namespace tool {
namespace {

using servobus::flag;

// Terminals that become active with a new function or polarity.
bool sets_terminals(const servobus::entry& e) {
    const std::string_view name = static_cast<const char*>(e.name);
    for (const std::string_view part : {"_function", "_logic", "_polarit", "outputs", "inputs"}) {
        if (name.find(part) != name.npos) return true;
    }
    return name.ends_with("_brake");
}

bool is_zero(std::span<const u16> words) {
    return std::ranges::all_of(words, [](u16 word) { return word == 0; });
}

bool is_stored(const change& c) { return has(c.row->flags, flag::saved_on_write); }

} // namespace

std::string name_of(const servobus::entry& e) { return std::string{e.name}; }

int refuse_moving(const device& of, const char* verb) {
    if (of.at_rest != nullptr) return done;
    const std::string refused = of.word() + ": " + verb + " is refused, since ";
    if (!of.has_flags)
        return complain(usage, refused + "the file has no column flags, which says what moves a machine");
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            const bool moves = has(e.flags, flag::motion);
            if (moves || has(e.flags, flag::when_stopped)) {
                return complain(usage,
                                refused + name_of(e) +
                                    (moves ? " moves the machine" : " is written only while a motor stands") +
                                    ", and a file does not say how to see that it is at rest");
            }
        }
    }
    return done;
}

bool is_of_line(const device& of, const servobus::entry& e) {
    if (of.node_register != 0 && e.address == of.node_register) return true;
    if (of.on_line == nullptr) return false;
    return e.address == of.on_line->rate_register ||
           (!of.on_line->formats.is_empty() && e.address == of.on_line->format_register);
}

int changes::look_for_rest(bool only_says_so) {
    if (of_->kind->at_rest == nullptr) return done; // of a file, which has nothing that moves
    const repose found = of_->kind->at_rest(*on_);
    if (found.why.error() != servobus::errc::ok)
        return complain(failed,
                        "the drive's state: " + why_text(*of_, found.why, *on_) + "; nothing was written");
    if (found.unrest.empty()) return done;
    if (only_says_so) {
        note("warning: without --dry-run it is refused: " + found.unrest);
        return done;
    }
    return complain(failed, "refused, nothing was written: " + found.unrest);
}

int changes::read_differences(std::vector<parameter> wanted) {
    std::ranges::sort(wanted, {}, [](const parameter& p) { return p.row->address; });
    std::vector<const servobus::entry*> rows;
    for (const parameter& p : wanted) rows.push_back(p.row);
    const std::optional<std::vector<parameter>> held = read_parameters(*on_, *of_, rows);
    if (!held) return failed;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const parameter& h = (*held)[i];
        if (!h.words) return complain(failed, name_of(*h.row) + ": " + h.remark + "; nothing was written");
        if (*h.words == *wanted[i].words) continue;
        all_.push_back({h.row, *h.words, *wanted[i].words});
    }
    differing_ = all_.size();
    return done;
}

int changes::compare(std::vector<parameter> wanted) {
    if (const int status = read_differences(std::move(wanted)); status != done) return status;
    for (const change& c : all_) {
        if (!is_zero(c.after) || !has(c.row->flags, flag::zero_by_name)) continue;
        if (!rules_.is_dry)
            return complain(failed, "refused, nothing was written: " + undocumented_zero(*c.row));
        note("warning: without --dry-run it is refused: " + undocumented_zero(*c.row));
    }
    release_first();
    line_last();
    return look_for_clash();
}

void changes::print() const {
    for (const change& c : all_) {
        std::printf("%s%s%s%s -> %s\n", rules_.drive.c_str(), name_of(*c.row).c_str(),
                    rules_.drive.empty() ? "=" : " ", words_text(*c.row, c.before).c_str(),
                    words_text(*c.row, c.after).c_str());
    }
}

int changes::say_cost() {
    if (const int status = count_stores(); status != done) return status;
    const auto terminals =
        std::ranges::count_if(all_, [](const change& c) { return sets_terminals(*c.row); });
    if (terminals != 0) {
        note("warning: " + std::to_string(terminals) +
             " of them set inputs, outputs or brakes: a terminal may become active; if that enables the "
             "drive, " +
             rules_.verb + " stops");
    }
    return done;
}

// Terminals whose function another one gets lose it before, so that none is on two in between.
void changes::release_first() {
    if (of_->kind->excludes == nullptr) return;
    std::vector<change> first;
    for (change& c : all_) {
        const auto takes_it = [&](const change& other) {
            return !is_zero(other.after) && other.after == c.before &&
                   of_->kind->excludes(other.row->address, c.row->address);
        };
        if (is_zero(c.after) || is_zero(c.before) || std::ranges::none_of(all_, takes_it)) continue;
        const std::vector<u16> none(c.before.size());
        first.push_back({c.row, c.before, none});
        c.before = none;
    }
    const auto loses_it = [&](const change& c) {
        return is_zero(c.after) && is_exclusive(*of_->kind, c.row->address);
    };
    std::stable_partition(all_.begin(), all_.end(), loses_it);
    all_.insert(all_.begin(), first.begin(), first.end());
}

// Puts the registers that change how all others are read and kept at the end.
void changes::line_last() {
    std::stable_partition(all_.begin(), all_.end(),
                          [](const change& c) { return !has(c.row->flags, flag::communication); });
}

int changes::look_for_clash() {
    std::vector<assignment> wanted;
    for (const change& c : all_) {
        if (c.row->words() == 1) wanted.push_back({c.row->address, c.after[0]});
    }
    const clash found = find_clash(*on_, *of_, wanted);
    return found.is_none() ? done : complain(failed, clash_text(*of_, found, *on_));
}

int changes::count_stores() {
    auto stored = static_cast<std::size_t>(std::ranges::count_if(all_, is_stored));
    if (of_->facts().eeprom_switch == 0) {
        const char* const save = !of_->kind->save ? ""
                                 : rules_.saves   ? ", but one save at the end"
                                                  : "; --save keeps the parameters over a power cycle";
        note("writes into the EEPROM: " + (stored == 0 ? "none" : std::to_string(stored)) + save);
        return done;
    }
    bool wears = true;
    const servobus::status why = on_->ask_wear(wears);
    const std::string knob = of_->kind->display_name(of_->facts().eeprom_switch);
    if (why.error() != servobus::errc::ok)
        return complain(failed, knob + ": " + why_text(*of_, why, *on_) + "; nothing was written");
    if (!wears) {
        note("writes into the EEPROM: none, since " + knob +
             " is 0; the parameters last until the next power cycle");
        return done;
    }
    if (const int status = refuse_too_many(stored); status != done) return status;
    note("writes into the EEPROM: " + std::to_string(stored));
    return done;
}

int changes::refuse_too_many(std::size_t& stored) {
    const std::size_t most = of_->kind->most_stored;
    if (most == 0 || stored <= most) return done;
    if (!rules_.in_parts) {
        const std::string whole = counted(stored, "write") + " into the EEPROM; more than " +
                                  std::to_string(most) + " raise an alarm of the drive (Er.942, " +
                                  servobus::c630s::find_alarm(0x942)->name + ")";
        if (!rules_.is_dry)
            return complain(failed,
                            "refused, nothing was written: " + whole + "; --part writes the first of them");
        note("warning: without --dry-run and --part it is refused: " + whole);
        return done;
    }
    cut_to(most);
    note("this part: the first " + counted(all_.size(), "parameter") + "; " + std::to_string(stored - most) +
         " stay for another run with --part, best after a power cycle");
    stored = most;
    return done;
}

// Up to the last change that the drive may store.
void changes::cut_to(std::size_t most) {
    std::size_t stored = 0;
    std::size_t kept = 0;
    while (kept < all_.size()) {
        if (is_stored(all_[kept]) && ++stored > most) break;
        ++kept;
    }
    all_.resize(kept);
}

int changes::write() {
    for (const change& c : all_) {
        if (is_of_line(*of_->kind, *c.row)) continue;
        if (const int status = carry_out(c); status != done) return status;
    }
    return done;
}

int changes::carry_out(const change& c) {
    if (interrupts::came()) return stop_at("interrupted");
    const chosen what = choose(*c.row);
    const std::vector<u16>& content = c.after;
    const servobus::status w = on_->write(what, content);
    if (!w) {
        return stop_at(what.name + ": " + why_text(*of_, what, w, *on_),
                       w.outcome() == servobus::outcome::unknown);
    }
    ++written_;
    std::vector<u16> back(content.size());
    const servobus::status why = on_->read(what, back);
    if (why.error() != servobus::errc::ok)
        return stop_at(what.name + " could not be read back: " + why_text(*of_, why, *on_));
    if (back != content) {
        return stop_at(what.name + " reads back as " + value_text(what, back) + ", not as " +
                       value_text(what, content));
    }
    std::printf("%s%s=%s\n", rules_.drive.c_str(), what.name.c_str(), value_text(what, back).c_str());
    if (sets_terminals(*c.row)) {
        if (const int status = look_after(what.name); status != done) return status;
    }
    const std::string lost = streams::why_lost();
    return lost.empty() ? done : stop_at(lost);
}

// A terminal may have become active.
int changes::look_after(const std::string& name) {
    if (of_->kind->at_rest == nullptr) return done;
    const repose found = of_->kind->at_rest(*on_);
    if (found.why.error() != servobus::errc::ok)
        return stop_at("the drive's state after " + name + ": " + why_text(*of_, found.why, *on_));
    return found.unrest.empty() ? done : stop_at("stopped after " + name + ": " + found.unrest);
}

// The parameters written so far are on standard output. `is_unknown`: the next one may be written or not.
int changes::stop_at(std::string why, bool is_unknown) const {
    why = rules_.drive + why + "; " + std::to_string(written_) + " of " + std::to_string(all_.size()) +
          " written";
    if (is_unknown) why += ", perhaps " + name_of(*all_[written_].row);
    constexpr std::size_t most_named = 8;
    const std::size_t first = written_ + (is_unknown ? 1 : 0);
    for (std::size_t i = first; i < all_.size(); ++i) {
        if (i == first + most_named) {
            why += " and " + std::to_string(all_.size() - i) + " more";
            break;
        }
        why += (i == first ? ", not: " : " ") + name_of(*all_[i].row);
    }
    return complain(failed, why);
}

int changes::save() {
    if (!of_->kind->save) return done;
    if (interrupts::came()) return complain(failed, "interrupted; all is written, but not saved");
    const save_command command = *of_->kind->save;
    if (command.cleared_first != 0) {
        const chosen first{"save, " + of_->kind->display_name(command.cleared_first), command.cleared_first,
                           1, nullptr};
        std::array<u16, 1> word{0};
        const servobus::status w = on_->write(first, word);
        if (!w) return complain(failed, "all is written, but not saved: " + why_text(*of_, first, w, *on_));
        word = {1};
        const servobus::status why = on_->read(first, word);
        if (why.error() != servobus::errc::ok || word[0] != 0)
            return complain(failed,
                            "all is written, but not saved: " + first.name + " does not read back as 0");
    }
    const chosen what{"save", command.address, 1, nullptr};
    const servobus::status w = on_->write(what, std::span<const u16>{&command.value, 1});
    if (w) return done;
    return complain(failed, "all is written, but the save: " + why_text(*of_, what, w, *on_));
}

} // namespace tool
