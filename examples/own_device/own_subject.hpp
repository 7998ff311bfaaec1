// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The winch for the judges of sim/conformance.hpp: how the simulated one is seen from outside, what may
// happen to it, and its commands. On a host:
//
//     servobus::sim::conformance<winch::subject> kit{[](void*, const servobus::sim::finding& f) { show(f.what); }};
//     if (kit.singles().findings != 0) return 1;
#pragma once

#include <cstdint>

#include <servobus/sim/conformance.hpp>

#include "own_drive.hpp"
#include "own_simulator.hpp"

namespace winch {

struct subject {
    using machine = simulated;
    template <class Line> using drive = winch::drive<Line>;

    static constexpr std::uint8_t address = 5;
    static constexpr std::uint32_t baud = 19200;
    static constexpr unsigned interpretations = 1;                  // interpretations of the manual
    static constexpr std::int64_t tolerance = 0;                    // of a place, in pulses
    static constexpr bool energises_by_reset = false;               // a fault reset
    static constexpr bool energises_by_level = true;                // a halt writes `hold`
    static servobus::sim::what_shows shows(unsigned) { return {}; } // a restart always: `host_word`
    static bool can_be_done(unsigned, const char*) { return true; }
    static machine make(unsigned) { return machine{}; }
    template <class Drive> static bool take_over(Drive& drum, machine&) {
        return static_cast<bool>(drum.run(servobus::init{}));
    }

    // Seen from outside
    static bool is_energised(const machine& m) { return m.is_energised(); }
    static bool is_turning(const machine& m) { return m.is_turning(); }
    static std::int64_t place(const machine& m) { return m.place(); }
    static std::uint32_t starts(const machine& m) { return m.starts(); }

    // Things that may happen to it
    static void restart(machine& m) { m.power_cycle(); }
    static void have_fault(machine& m) { m.raise_fault(3); }
    static void end_fault(machine& m) { m.end_fault_cause(); }
    static void press_stop(machine& m) { m.interrupt(); }
    static void release_stop(machine&) {}
    static void write_by_another(machine& m) {
        const std::uint8_t three[]{0, 3};
        (void)m.write(ramp.address, servobus::words_view{three});
    }

    // Its own commands: name, how it is enabled for it, command, what it does
    template <class Each> static void commands(const Each& each) {
        using namespace servobus;
        each("turn", enable{}, turn{60 * r_per_min}, sim::turns());
        each("move_to", enable{}, move_to{4000 * pulse}, sim::moves_to(4000));
        each("move_to, back", enable{}, move_to{-2000 * pulse}, sim::moves_to(-2000));
    }
};

} // namespace winch
