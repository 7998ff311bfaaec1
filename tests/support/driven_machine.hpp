// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated machine on a virtual line, and the facade that drives it. The test sees the machine from outside.
#pragma once

#include <cstdint>

#include <servobus/line/line.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace tests {

using on_wire = servobus::line<servobus::sim::virtual_line>;

template <class Sim, class Drive> struct driven_machine {
    Sim machine;
    servobus::sim::station<Sim> station{machine};
    servobus::sim::virtual_line wire;
    on_wire on;
    Drive drive;

    template <class Options, class By>
    driven_machine(std::uint32_t baud, const Options& options, const By& by)
        : machine{options}, wire{baud}, on{wire, servobus::modbus::timing_at(baud)}, drive{on, 1, by} {
        wire.attach(station);
    }
    driven_machine(const driven_machine&) = delete;

    void step() { on.sleep(drive.step()); }
    void pass(std::uint64_t us) {
        const std::uint64_t end = wire.time_us() + us;
        while (wire.time_us() < end) {
            const servobus::duration idle = drive.step();
            wire.wait(idle < servobus::microseconds(500) ? idle : servobus::microseconds(500));
        }
    }
};

} // namespace tests
