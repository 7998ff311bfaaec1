// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus watch: registers again and again, as a live table on a terminal and one line a round elsewhere, or
// as records for programs.
#include <cstdio>
#include <utility>

#include "../devices/device.hpp"
#include "../os/interrupts.hpp"
#include "../records/recorder.hpp"
#include "../registers/session.hpp"
#include "../streams/descriptors.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "commands.hpp"

namespace tool {
namespace {

// In slices, since a signal may come right before the sleep.
void wait_until(servobus::instant due) {
    while (!interrupts::came()) {
        const servobus::instant now = native::monotonic_now();
        if (!went_back(due, now)) return;
        const servobus::duration rest = since(now, due);
        native::sleep_for(rest < servobus::milliseconds(50) ? rest : servobus::milliseconds(50));
    }
}

struct shown_register {
    std::string name;
    std::string value;

    /// `current=12.34 A`, `current: no value`
    std::string assigned() const { return name + (value == no_value ? ": " : "=") + value; }
};

class display {
  public:
    explicit display(bool is_table) : is_table_{is_table} {}

    /// False if it cannot.
    [[nodiscard]] bool show(const std::vector<shown_register>& round, std::uint64_t ms) {
        // Below a note the table begins anew.
        if (std::exchange(notes_, note_count()) != note_count()) rows_ = 0;
        if (is_table_) {
            table(round);
        } else {
            one_line(round, ms);
        }
        return streams::flush();
    }

  private:
    void table(const std::vector<shown_register>& round) {
        if (rows_ != 0) std::printf("\x1b[%zuA", rows_); // up again
        std::size_t widest = 0;
        for (const shown_register& s : round) widest = s.name.size() > widest ? s.name.size() : widest;
        for (const shown_register& s : round)
            std::printf("\x1b[2K%-*s  %s\n", static_cast<int>(widest), s.name.c_str(), s.value.c_str());
        rows_ = round.size();
    }

    static void one_line(const std::vector<shown_register>& round, std::uint64_t ms) {
        std::printf("%u.%03u", static_cast<unsigned>(ms / 1000), static_cast<unsigned>(ms % 1000));
        const char* between = " ";
        for (const shown_register& s : round) {
            std::printf("%s%s", between, s.assigned().c_str());
            between = ", ";
        }
        (void)std::puts("");
    }

    bool is_table_;
    std::size_t rows_ = 0;
    std::size_t notes_ = 0;
};

// A round for people: a register each, or a word each of those without a map.
std::vector<shown_register> shown_registers(std::span<const chosen> wanted, const snapshot& taken) {
    std::vector<shown_register> round;
    for (std::size_t r = 0; r < wanted.size(); ++r) {
        const chosen& what = wanted[r];
        const reading& read = taken.readings[r];
        if (!read.was_asked) continue;
        if (what.row != nullptr) {
            round.push_back({what.name, read.is_read() ? value_text(what, read.words, read.scale)
                                                       : '(' + read.why + ')'});
            continue;
        }
        const std::size_t width = what.form.width();
        for (std::size_t i = 0; i < raw_count(what); ++i) {
            const std::span<const u16> words = std::span{read.words}.subspan(i * width, width);
            round.push_back(
                {raw_name(what, i), read.is_read() ? value_text(what, words) : '(' + read.why + ')'});
        }
    }
    return round;
}

// True if a file does not rule out that the device moves something.
bool may_move(const device& of) {
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            const bool can_write = e.rights != servobus::access::ro;
            if (has(e.flags, servobus::flag::motion) || (!of.has_flags && can_write)) return true;
        }
    }
    return false;
}

void warn_of_watchdog(const target& of) {
    const bool is_known = of.kind != nullptr && of.kind->file == nullptr;
    if (is_known ? !of.kind->has_watchdog : of.kind != nullptr && !may_move(*of.kind)) return;
    note(std::string{"warning: these requests feed the "} +
         (is_known ? "drive's watchdog" : "device's watchdog if it has one") +
         "; motors may run on though their controller is dead");
}

} // namespace

int watch(const arguments& asked) {
    if (asked.words().size() < 3)
        return complain(usage, "watch takes PORT DEVICE[:NODE] and at least one register");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    const std::vector<chosen> wanted = parse_readable(*of, asked);
    if (wanted.empty()) return usage;
    const auto interval = asked.number("interval", 0, 600'000, 500);
    const auto count = asked.number("count", 1, INT32_MAX, 0);
    if (!interval || !count) return usage;
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    recorder records;
    if (const int status = records.prepare(asked, wanted); status != done) return status;
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;

    warn_of_watchdog(*of);
    interrupts::arm();
    on.wait_for_port({}); // each round looks whether it is back
    display screen{streams::is_terminal(stdout)};
    const auto pause = servobus::milliseconds(static_cast<std::uint32_t>(*interval));
    servobus::instant due = native::monotonic_now();
    servobus::instant last = due;
    std::uint64_t us = 0;
    bool answered = false;
    bool has_port = true;
    bool has_warned = false;
    std::string why;
    for (std::int64_t round = 0; !interrupts::came() && (*count == 0 || round < *count); ++round) {
        wait_until(due);
        if (interrupts::came()) break;
        const servobus::instant now = native::monotonic_now();
        us += since(last, now).us;
        last = now;
        due = now + pause;
        const std::optional<snapshot> taken = take_snapshot(on, *of, wanted);
        if (!taken) return done;
        answered = answered || taken->has_answer();
        if (const std::string strays = has_warned ? std::string{} : on.strays(); !strays.empty()) {
            note("warning: " + strays);
            has_warned = true;
        }
        if (const int status = records.put(*taken); status != done) return status;
        if (records.has_display() && !screen.show(shown_registers(wanted, *taken), us / 1000)) return failed;
        why = taken->readings.back().why;
        has_port = taken->has_port();
        if (!has_port && !on.may_return()) return complain(failed, why);
    }
    if (!has_port) return complain(failed, why);
    if (answered || interrupts::came()) return done;
    const std::string no_response = servobus::text(servobus::errc::timeout);
    return complain(failed, no_response + " in any round" + (why == no_response ? "" : ": " + why));
}

} // namespace tool
