// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs of clients that read and write: over an adapter without a local echo, over one with a local echo,
// and over a blocking line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "clients.hpp"
#include "operations.hpp"

namespace trial {

template <class Line> void speak(clients<Line>& on) {
    constexpr int operations_in_a_run = 200;
    operations<Line> client{on};
    for (int i = 0; i < operations_in_a_run; ++i) client.one();
}

class plain_run {
  public:
    plain_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)} {}

    world& place() { return in_; }
    void go() { speak(in_); }

  private:
    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        c.returns_while_nobody_is_there = !c.wire.echoes && random.below(3) == 0;
        return c;
    }

    clients<line_on<servobus::unechoed>> in_;
};

/// The line is configured for a local echo; or it is not, and the adapter drops the echo; or there is an
/// echo but no device, whatever the line is configured for (G3).
class echo_run {
  public:
    echo_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : echo_run{seed, count, notes, draw(seed)} {}

    world& place() { return in_; }
    void go() { speak(in_); }

  private:
    struct drawn {
        conditions line;
        hearing adapter = hearing::itself;
        bool has_devices = true;
    };

    echo_run(std::uint64_t seed, event_counts& count, std::size_t notes, const drawn& d)
        : in_{seed, count, notes, d.line, d.adapter, d.has_devices} {}

    static drawn draw(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        drawn d;
        d.line = draw_conditions(random);
        switch (random.below(8)) {
        case 0: d.adapter = hearing::nothing; break;
        case 1: d.has_devices = false; break;
        case 2:
            d.adapter = hearing::untold;
            d.has_devices = false;
            break;
        default: break;
        }
        d.line.wire.echoes = true;
        d.line.wire.keeps_echo = d.adapter != hearing::nothing;
        return d;
    }

    clients<line_on<servobus::echoed>> in_;
};

/// The timing of a blocking line is a constant of the program. In some runs there is an echo but no device
/// (G3).
class small_run {
  public:
    small_run(std::uint64_t seed, event_counts& count, std::size_t notes) {
        if (seed / 24 % 2 == 0)
            begin(host_, seed, count, notes);
        else
            begin(strict_, seed, count, notes);
    }

    world& place() { return host_ ? static_cast<world&>(*host_) : *strict_; }
    void go() {
        if (host_) return speak(*host_);
        speak(*strict_);
    }

  private:
    template <class Line>
    static void begin(std::optional<clients<Line>>& run, std::uint64_t seed, event_counts& count,
                      std::size_t notes) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        c.wire.baud = Line::baud;
        c.timing = Line::timing();
        const bool is_strict = c.timing.mode == servobus::modbus::timing_mode::strict;
        c.resolution_us = !is_strict && random.below(4) == 0 ? 1000 : 1;
        const bool has_only_echo = random.below(10) == 0;
        c.returns_while_nobody_is_there = !c.wire.echoes && !has_only_echo && random.below(3) == 0;
        if (has_only_echo) c.wire.echoes = c.wire.keeps_echo = true;
        run.emplace(seed, count, notes, c, has_only_echo ? hearing::untold : hearing::nothing,
                    !has_only_echo);
    }

    std::optional<clients<blocking_host_line>> host_;
    std::optional<clients<blocking_strict_line>> strict_;
};

} // namespace trial
