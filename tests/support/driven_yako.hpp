// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC drive facades, each of which controls the simulated drive of its variant.
#pragma once

#include <doctest/doctest.h>

#include <servobus/device/yako.hpp>

#include <tests/support/loop_bound.hpp>
#include <tests/support/simulated_yako.hpp>

namespace simulated {

template <class Model, template <class> class Drive> struct driven_yako : simulated_yako<Model> {
    using typename simulated_yako<Model>::line_type;

    Drive<line_type> drive{this->line, 1, servobus::unsupervised};

    explicit driven_yako(servobus::sim::yako_options options = {}, std::uint64_t seed = 1)
        : simulated_yako<Model>{options, seed} {}

    std::int64_t place() const { return this->model.view().position; }
    bool is_moving() const { return this->model.view().is_moving; }

    /// Begins a command and steps it until `n` of its frames were sent, or it has ended.
    template <class Command> void begin_up_to(const Command& wanted, std::size_t n) {
        const std::size_t before = this->requests.size();
        REQUIRE(drive.begin(wanted) == servobus::errc::ok);
        for (tests::loop_bound left{"the end of a command"};
             !drive.is_idle() && this->requests.size() < before + n; left.use())
            turn();
    }
    void turn() {
        const servobus::duration idle = drive.step();
        this->wire.wait(idle.us == 0 ? servobus::microseconds(10) : idle);
    }
    void finish() {
        for (tests::loop_bound left{"the end of a command"}; !drive.is_idle(); left.use()) turn();
    }
};

using closed_axis = driven_yako<servobus::sim::yako_closed_loop, servobus::yako::closed_loop::drive>;
using open_axis = driven_yako<servobus::sim::yako_open_loop, servobus::yako::open_loop::drive>;

/// Runs a command during which one frame is lost: request number `lost`, counted from 0, or the response to
/// it. Returns false if the command had ended before.
template <class Axis, class Command>
bool run_with_a_loss(Axis& a, const Command& wanted, std::uint32_t lost, bool is_response) {
    const std::uint32_t first = a.wire.requests();
    const std::uint32_t struck = a.wire.struck();
    REQUIRE(a.drive.begin(wanted) == servobus::errc::ok);
    for (tests::loop_bound left{"the end of a command"}; !a.drive.is_idle(); left.use()) {
        const std::uint32_t passed = a.wire.requests() - first;
        a.wire.faults().lost_request = passed == lost && !is_response ? 1000 : 0;
        a.wire.faults().lost_response = passed == lost + 1 && is_response ? 1000 : 0;
        (void)a.drive.step();
        a.wire.wait(servobus::microseconds(20));
    }
    a.wire.faults() = {};
    return a.wire.struck() > struck;
}

/// True if the frame writes to this address.
inline bool writes_to(servobus::bytes f, std::uint16_t address) {
    if (f.size() < 8 || !servobus::modbus::is_write(f[1])) return false;
    const unsigned first = servobus::load_word(f, 2);
    const unsigned count = f[1] == 0x10 ? servobus::load_word(f, 4) : 1u;
    return address >= first && address < first + count;
}

/// True for the write of a marker, a target of position segment 16 of 1 to 15 pulses.
inline bool is_marker(servobus::bytes f) {
    return writes_to(f, 0x00BA) && f.size() == 13 && servobus::load_word(f, 2) == 0x00BA &&
           servobus::load_word(f, 7) + servobus::load_word(f, 9) <= 15;
}

} // namespace simulated
