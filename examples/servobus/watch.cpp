// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus watch: registers again and again, as a live table on a terminal and one line a round elsewhere.
#include <cstdio>

#include <unistd.h>

#include "interrupts.hpp"
#include "session.hpp"
#include "streams.hpp"

namespace tool {
namespace {

// In slices, since a signal may come right before the sleep.
void wait_until(servobus::instant due) {
    while (!interrupts::came()) {
        const servobus::instant now = servobus::posix::monotonic_now();
        if (!went_back(due, now)) return;
        const servobus::duration rest = since(now, due);
        servobus::posix::sleep_for(rest < servobus::milliseconds(50) ? rest : servobus::milliseconds(50));
    }
}

struct shown {
    std::string name;
    std::string value;
};

class display {
  public:
    explicit display(bool is_table) : is_table_{is_table} {}

    /// False if it cannot.
    [[nodiscard]] bool show(const std::vector<shown>& round, std::uint64_t ms) {
        if (is_table_) {
            table(round);
        } else {
            one_line(round, ms);
        }
        return streams::flush();
    }

  private:
    void table(const std::vector<shown>& round) {
        if (rows_ != 0) std::printf("\x1b[%zuA", rows_); // up again
        std::size_t widest = 0;
        for (const shown& s : round) widest = s.name.size() > widest ? s.name.size() : widest;
        for (const shown& s : round)
            std::printf("\x1b[2K%-*s  %s\n", static_cast<int>(widest), s.name.c_str(), s.value.c_str());
        rows_ = round.size();
    }

    static void one_line(const std::vector<shown>& round, std::uint64_t ms) {
        std::printf("%u.%03u", static_cast<unsigned>(ms / 1000), static_cast<unsigned>(ms % 1000));
        const char* between = " ";
        for (const shown& s : round) {
            std::printf("%s%s=%s", between, s.name.c_str(), s.value.c_str());
            between = ", ";
        }
        (void)std::puts("");
    }

    bool is_table_;
    std::size_t rows_ = 0;
};

// Reads one register into the round. False if the port is gone.
bool read_into(std::vector<shown>& round, session& on, const target& of, const chosen& what, bool& answered) {
    std::vector<u16> content(what.words);
    const servobus::status why = on.read(what, content);
    answered = answered || why.error() == servobus::errc::ok;
    if (why.error() == servobus::errc::ok && what.row != nullptr) {
        round.push_back({what.name, value_text(what, content)});
        return true;
    }
    for (std::size_t i = 0; i < content.size(); ++i) {
        const std::string name =
            what.row != nullptr ? what.name : hex_word(static_cast<u16>(what.address + i));
        const std::string value = why.error() == servobus::errc::ok
                                      ? value_text(what, std::span<const u16>{content}.subspan(i, 1))
                                      : '(' + why_text(of, why, on.os_error()) + ')';
        round.push_back({name, value});
        if (what.row != nullptr) break;
    }
    return why.error() != servobus::errc::port_lost;
}

} // namespace

int watch(std::span<char* const> words) {
    const std::optional<arguments> asked = arguments::parse(words, session::watch_options);
    if (!asked) return usage;
    if (asked->words().size() < 3)
        return complain(usage, "watch takes PORT DEVICE[:NODE] and at least one register");
    const std::optional<target> of = parse_target(asked->words()[1]);
    if (!of) return usage;
    std::vector<chosen> wanted;
    for (std::size_t i = 2; i < asked->words().size(); ++i) {
        const std::optional<chosen> what = parse_register(*of, asked->words()[i]);
        if (!what) return usage;
        if (what->row != nullptr && what->row->rights == servobus::access::wo)
            return complain(usage, what->name + ": this register is write-only");
        wanted.push_back(*what);
    }
    const auto interval = asked->number("interval", 0, 600'000, 500);
    const auto count = asked->number("count", 1, INT32_MAX, 0);
    if (!interval || !count) return usage;
    session on;
    if (const int status = on.check(*asked, *of); status != done) return status;
    if (const int status = on.open(asked->words()[0].c_str()); status != done) return status;

    note("warning: these requests feed the drive's watchdog; motors may run on though their controller is "
         "dead");
    interrupts::arm();
    display screen{::isatty(STDOUT_FILENO) == 1};
    const auto pause = servobus::milliseconds(static_cast<std::uint32_t>(*interval));
    servobus::instant due = servobus::posix::monotonic_now();
    servobus::instant last = due;
    std::uint64_t us = 0;
    bool answered = false;
    for (std::int64_t round = 0; !interrupts::came() && (*count == 0 || round < *count); ++round) {
        wait_until(due);
        if (interrupts::came()) break;
        const servobus::instant now = servobus::posix::monotonic_now();
        us += since(last, now).us;
        last = now;
        due = now + pause;
        std::vector<shown> values;
        bool has_port = true;
        for (const chosen& what : wanted) {
            if (interrupts::came()) return done;
            has_port = has_port && read_into(values, on, *of, what, answered);
        }
        if (!screen.show(values, us / 1000)) return failed;
        if (!has_port) return complain(failed, "the port is gone");
    }
    return answered || interrupts::came() ? done : complain(failed, "no response in any round");
}

} // namespace tool
