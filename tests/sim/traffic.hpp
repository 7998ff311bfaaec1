// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs of clients that read and write: over an adapter that does not hear itself, and over one that does.
#pragma once

#include <cstddef>
#include <cstdint>

#include "clients.hpp"
#include "operations.hpp"

namespace trial {

template <class Echo> void speak(clients<Echo>& on) {
    constexpr int operations_in_a_run = 200;
    operations<Echo> client{on};
    for (int i = 0; i < operations_in_a_run; ++i) client.one();
}

class plain_run {
  public:
    plain_run(std::uint64_t seed, tally& count, std::size_t notes) : in_{seed, count, notes, drawn(seed)} {}

    world& place() { return in_; }
    void go() { speak(in_); }

  private:
    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        return draw_conditions(random);
    }

    clients<servobus::unechoed> in_;
};

/// The line was told that its adapter hears itself; or that it does not, and the adapter drops its echo; or
/// nobody is there but the echo, whatever the line was told (G3).
class echo_run {
  public:
    echo_run(std::uint64_t seed, tally& count, std::size_t notes)
        : echo_run{seed, count, notes, draw(seed)} {}

    world& place() { return in_; }
    void go() { speak(in_); }

  private:
    struct drawn {
        conditions line;
        hearing adapter = hearing::itself;
        bool has_devices = true;
    };

    echo_run(std::uint64_t seed, tally& count, std::size_t notes, const drawn& d)
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

    clients<servobus::echoed> in_;
};

} // namespace trial
