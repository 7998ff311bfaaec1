// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stalls of the client's program: at any call of its port, for microseconds to minutes. The wire and the
// drives go on meanwhile. Causes are preemption, a debugger, a flash write or a shared bus.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/sim/faults.hpp>

#include "event_counts.hpp"

namespace trial {

class stalls {
  public:
    /// From now on the program stalls in one of `one_in` calls of the port; 0: never. The random numbers are
    /// separate from those of the traffic.
    void allow(std::uint64_t seed, std::uint32_t one_in) {
        random_ = servobus::sim::dice{seed * 0x9E37'79B9u + 11};
        one_in_ = one_in;
    }
    void end() { one_in_ = 0; }

    /// How long the program stalls here; mostly 0. Stalls are more frequent while a request leaves or its
    /// response is awaited, since few calls fall into these times.
    std::uint32_t draw_us(place at) {
        if (one_in_ == 0) return 0;
        const std::uint32_t factor = at == place::leaving ? 30 : at == place::awaiting ? 3 : 1;
        if (random_.below(one_in_) >= factor) return 0;
        switch (random_.below(6)) {
        case 0:
        case 1: return 1 + random_.below(3'000);
        case 2: return 1'000 + random_.below(40'000);
        case 3: return 20'000 + random_.below(500'000);
        case 4: return 300'000 + random_.below(1'500'000);
        default:
            return random_.below(4000) == 0 ? 60'000'000 + random_.below(120'000'000)
                                            : 1'000'000 + random_.below(3'000'000);
        }
    }

  private:
    servobus::sim::dice random_{1};
    std::uint32_t one_in_ = 0;
};

} // namespace trial
