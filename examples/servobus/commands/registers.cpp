// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus read and write: registers one by one, in the order of the command line.
#include <algorithm>
#include <cstdio>

#include "../parameters/terminals.hpp"
#include "../records/recorder.hpp"
#include "../registers/consent.hpp"
#include "../registers/session.hpp"
#include "../registers/typed_value.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace {

constexpr servobus::duration patience = servobus::milliseconds(2000); // with a port that is lost

struct job {
    chosen what;
    std::vector<u16> words;
};

void print(const chosen& what, std::span<const u16> words, const servobus::row_scale& scale) {
    if (what.row != nullptr) {
        std::printf("%s\n", assigned_text(what, words, scale).c_str());
        return;
    }
    const std::size_t width = what.form.width();
    for (std::size_t i = 0; i < raw_count(what); ++i) {
        const std::string name = raw_name(what, i);
        std::printf("%s=%s\n", name.c_str(), value_text(what, words.subspan(i * width, width)).c_str());
    }
}

// Reads all registers, though some may fail: what was read is printed, and each that failed is named.
int read_all(session& on, const target& of, std::span<const chosen> wanted, recorder& records) {
    const std::optional<snapshot> taken = take_snapshot(on, of, wanted);
    if (!taken) return failed;
    if (const int status = records.put(*taken); status != done) return status;
    std::string failures;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const reading& r = taken->readings[i];
        if (r.is_read()) {
            if (records.has_display()) print(wanted[i], r.words, r.scale);
        } else if (r.was_asked) {
            failures += (failures.empty() ? "" : "; ") + wanted[i].name + ": " + r.why;
        }
    }
    on.listen_on();
    if (const std::string strays = on.strays(); !strays.empty()) note("warning: " + strays);
    return failures.empty() ? done : complain(failed, failures);
}

// Says what each write may do, and asks if one may move a machine.
int warn_and_ask(const arguments& asked, const target& of, std::span<const job> jobs) {
    bool is_perilous = false;
    for (const job& j : jobs) {
        std::string words = peril(of, j.what, j.words);
        is_perilous = is_perilous || !words.empty();
        if (j.what.row != nullptr && has(j.what.row->flags, servobus::flag::scaled_elsewhere))
            words += (words.empty() ? "" : ", and ") +
                     std::string{"takes raw counts, whose worth another register sets"};
        if (!words.empty()) note("warning: " + j.what.name + " " + words);
        if (j.what.row != nullptr && j.what.row->is_part())
            note(j.what.name + " is a part of register " + hex_word(j.what.address) +
                 ": the register is read, and written with its other bits as they are");
    }
    return is_perilous ? ask_consent(asked, "write") : done;
}

// What must be known of the drive before anything is written to it.
servobus::status ask_word_order(session& on, std::span<const job> jobs) {
    for (const job& j : jobs) {
        if (j.what.row == nullptr || !has_word_order(*j.what.row)) continue;
        const servobus::status why = on.learn_word_order();
        if (why.error() != servobus::errc::ok) return why;
    }
    return {};
}

// The words of all writes, in their order.
std::vector<assignment> assignments_of(std::span<const job> jobs) {
    std::vector<assignment> all;
    for (const job& j : jobs) {
        if (j.what.form.is_bit() || (j.what.row != nullptr && j.what.row->is_part())) continue;
        for (std::size_t i = 0; i < j.words.size(); ++i)
            all.push_back({static_cast<u16>(j.what.address + i), j.words[i]});
    }
    return all;
}

// A note if this write wears the drive's EEPROM, or decides whether others do.
servobus::status warn_of_wear(session& on, const target& of, const chosen& what, std::span<const u16> words) {
    if (what.row == nullptr || !has(what.row->flags, servobus::flag::saved_on_write)) return {};
    const bool is_register = what.form.table == servobus::table::holding_registers;
    if (is_register && of.facts().eeprom_switch != 0 && what.address == of.facts().eeprom_switch) {
        // Manuals do not say whether the switch itself is kept.
        note("warning: after " + typed_assignment(what, words) +
             (words[0] == 0 ? ", what is written is lost with the power"
                            : ", each write of a saved register wears the EEPROM"));
        return {};
    }
    const std::string warning = "warning: " + what.name + " is kept in the EEPROM, which this write wears";
    if (of.facts().eeprom_switch == 0) {
        note(warning);
        return {};
    }
    bool wears = true;
    const servobus::status why = on.ask_wear(wears);
    const std::string knob = of.kind->display_name(of.facts().eeprom_switch);
    if (why.error() == servobus::errc::exception || (why.error() == servobus::errc::ok && wears))
        note(warning + "; not while " + knob + " is 0");
    if (why.error() == servobus::errc::ok && !wears)
        note("warning: " + what.name + " is lost with the power, since " + knob + " is 0");
    return why.error() == servobus::errc::exception ? servobus::status{} : why;
}

// The codes of a register, if the drive has refused one without a name.
std::string hint_after(const servobus::status& w, const job& j) {
    const bool is_refused = w.outcome() == servobus::outcome::refused;
    if (!is_refused || j.what.row == nullptr || j.words.size() != 1) return {};
    for (const servobus::named_value& v : j.what.row->values) {
        if (v.applies(j.words[0])) return {};
    }
    return what_it_takes(*j.what.row);
}

std::string count_of(std::size_t written, std::size_t all) {
    return "; " + std::to_string(written) + " of " + std::to_string(all) + " written";
}

// After a failure of one of several writes.
std::string progress_text(std::size_t written, std::size_t all) {
    return all == 1 ? std::string{} : count_of(written, all);
}

// A register that holds what was written into it: no command, and none that changes who answers or takes effect later.
// The state of a coil after another word than on and off is not known.
bool holds_its_word(const chosen& what, std::span<const u16> words) {
    using enum servobus::flag;
    if (what.form.is_bit() && words[0] > 1) return false;
    if (what.row == nullptr) return true;
    if (what.row->rights != servobus::access::rw) return false;
    for (const servobus::flag other : {trigger, communication, after_power_cycle, at_stop}) {
        if (has(what.row->flags, other)) return false;
    }
    return true;
}

// Reads back what was acknowledged: a device may acknowledge a write and ignore it. A register of which nothing says
// whether it is a command is no failure.
int check_held(session& on, const target& of, std::span<const job> jobs) {
    std::string ignored;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        const job& j = jobs[i];
        const auto is_same = [&j](const job& later) {
            const bool is_another_part =
                j.what.row != nullptr && j.what.row->is_part() && later.what.row != j.what.row;
            return later.what.address == j.what.address && later.what.form.table == j.what.form.table &&
                   !is_another_part;
        };
        if (!holds_its_word(j.what, j.words) ||
            std::any_of(jobs.begin() + static_cast<std::ptrdiff_t>(i) + 1, jobs.end(), is_same))
            continue;
        std::vector<u16> held(j.words.size());
        const servobus::status why = on.read(j.what, held);
        if (why.error() == servobus::errc::timeout && j.what.row != nullptr) {
            note("warning: " + j.what.name +
                 " is written, and the read right after it had no response: on a line that "
                 "answers other reads the device needs a pause after a write, --gap 8");
        }
        if (why.error() != servobus::errc::ok || held == j.words) continue;
        const std::string words =
            j.what.name + ": acknowledged, and the device holds " + value_text(j.what, held);
        if (j.what.row == nullptr || !of.kind->has_flags) {
            note("warning: " + words + ": it ignored the write, or the register is a command that it clears");
        } else {
            ignored += (ignored.empty() ? "" : "; ") + words + ": it ignored the write";
        }
    }
    return ignored.empty() ? done : complain(failed, ignored);
}

} // namespace

int read(const arguments& asked) {
    if (asked.words().size() < 3)
        return complain(usage, "read takes PORT DEVICE[:NODE] and at least one register");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    const std::vector<chosen> wanted = parse_readable(*of, asked);
    if (wanted.empty()) return usage;
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    recorder records;
    if (const int status = records.prepare(asked, wanted); status != done) return status;
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;
    on.wait_for_port(patience);
    return read_all(on, *of, wanted, records);
}

int write(const arguments& asked) {
    if (asked.words().size() < 3)
        return complain(usage, "write takes PORT DEVICE[:NODE] and at least one register");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    std::vector<job> jobs;
    for (std::size_t i = 2; i < asked.words().size(); ++i) {
        const std::string_view text = asked.words()[i];
        const std::size_t equals = text.find('=');
        if (equals == text.npos) return complain(usage, "'" + std::string{text} + "' is no REG=VALUE");
        const std::optional<chosen> what = parse_register(*of, text.substr(0, equals));
        if (!what) return usage;
        const std::optional<std::vector<u16>> content = parse_value(*what, text.substr(equals + 1));
        if (!content) return usage;
        jobs.push_back({*what, *content});
    }
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;
    if (const int status = warn_and_ask(asked, *of, jobs); status != done) return status;
    on.wait_for_port(patience);
    if (const servobus::status why = ask_word_order(on, jobs); why.error() != servobus::errc::ok) {
        return complain(failed, "word order, " + of->kind->display_name(of->facts().word_order_register) +
                                    ": " + why_text(*of, why, on) + "; nothing was written");
    }
    if (const clash found = find_clash(on, *of, assignments_of(jobs)); !found.is_none())
        return complain(failed, clash_text(*of, found, on));
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        const job& j = jobs[i];
        if (const servobus::status why = warn_of_wear(on, *of, j.what, j.words);
            why.error() != servobus::errc::ok) {
            return complain(failed, j.what.name + ": not sent, " + why_text(*of, why, on) +
                                        progress_text(i, jobs.size()));
        }
        const servobus::status w = on.write(j.what, j.words);
        if (!w) {
            return complain(failed, j.what.name + ": " + why_text(*of, j.what, w, on) + hint_after(w, j) +
                                        progress_text(i, jobs.size()));
        }
        print(j.what, j.words, j.what.row != nullptr ? unknown_scale(*j.what.row) : servobus::row_scale{});
        if (const std::string why = streams::why_lost(); !why.empty())
            return complain(failed, why + count_of(i + 1, jobs.size()));
    }
    return check_held(on, *of, jobs);
}

} // namespace tool
