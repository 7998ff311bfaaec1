// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Handles a C630S for the steps of its probe: sets registers, enables and starts it by virtual terminals, makes it
// safe.
#pragma once

#include <cstdint>

#include <servobus/device/c630s/registers.hpp>

#include "probe_steps.hpp"

namespace tool {

class c630s_hands : public probe_steps {
  protected:
    c630s_hands(probe_bench& on, findings& found) : probe_steps{on, found, servobus::milliseconds(50)} {}

    using in = servobus::c630s::input_function;
    using out = servobus::c630s::output_function;

    static constexpr u16 in_fault = 3; // P30-00, an assumption: only a drive that does not say so is probed
    static constexpr u16 slow = 10;    // r/min
    static constexpr u16 twice = 2 * slow; // r/min
    static constexpr int most = 100;       // readings
    // The virtual inputs that the probe uses, and the outputs.
    static constexpr u16 servo_on = 1u << 0, starts = 1u << 1, jogs = 1u << 2, marker = 1u << 15;
    static constexpr unsigned brake_out = 12, home_out = 13, ready_out = 14, again_out = 15;

    // --- Registers

    static constexpr u16 address_of_function(unsigned input) {
        return servobus::c630s::virtual_input_functions[input].address;
    }
    static constexpr u16 address_of_output(unsigned output) {
        return servobus::c630s::virtual_output_functions[output].address;
    }
    u16 read(const auto& row) { return on_->read(row.address); }
    // Changes a register, and notes what it held before the first change.
    bool set(u16 address, u16 word) {
        old_.note(address);
        return on_->write(address, word);
    }
    bool set(const auto& row, auto value) requires requires { row.address; }
    { return set(row.address, static_cast<u16>(value)); }
    bool set_pair(const auto& row, std::int32_t value) {
        old_.note_pair(row.address);
        return write_number(row.address, value);
    }
    std::int32_t read_number(const auto& row) { return probe_steps::read_number(row.address); }
    // Decides whether what is written is kept over a power cycle.
    void keep(bool is_so) {
        (void)on_->write(servobus::c630s::eeprom_update.address, is_so ? 1 : 0);
        on_->set_storing(is_so);
    }

    // --- What the steps are made of

    bool shows(unsigned output) {
        return (on_->read(servobus::c630s::virtual_output_levels.address) >> output & 1u) != 0;
    }
    // Looks at a virtual output or, where only the first of several shows it, at a wired one.
    bool shows(out function, unsigned output) {
        namespace c = servobus::c630s;
        if (shows(output)) return true;
        const unsigned conducts = read(c::output_state);
        for (unsigned n = 0; n < 6; ++n) {
            const auto wired = static_cast<u16>(c::do1_function.address + 2 * n);
            if (on_->read(wired) != static_cast<u16>(function)) continue;
            const bool is_inverted = on_->read(static_cast<u16>(wired + 1)) != 0;
            if (((conducts >> n & 1u) != 0) != is_inverted) return true;
        }
        return false;
    }
    void inputs(u16 levels) { (void)on_->write(servobus::c630s::virtual_input_levels.address, levels); }
    int speed() {
        const int r_per_min = static_cast<std::int16_t>(read(servobus::c630s::actual_speed));
        return r_per_min < 0 ? -r_per_min : r_per_min;
    }
    bool stands() {
        return until([&] { return speed() == 0; }, most);
    }
    void make_safe() {
        on_->write_safely(servobus::c630s::virtual_input_levels.address, 0);
        on_->write_safely(servobus::c630s::emergency_stop.address, 0);
        (void)stands();
    }
    // Leaves it not enabled, at standstill.
    void servo_off() {
        inputs(0);
        (void)stands();
        on_->wait(servobus::milliseconds(1500)); // the brake closes, the power goes
    }
    void reset_alarm() {
        (void)on_->write(servobus::c630s::alarm_reset.address, 0); // a drive that keeps it takes 1 once
        (void)on_->write(servobus::c630s::alarm_reset.address, 1);
        wait();
        (void)on_->write(servobus::c630s::alarm_reset.address, 0);
    }
    // True if a terminal, wired or virtual, has the function.
    bool is_assigned(in function) {
        namespace c = servobus::c630s;
        for (unsigned n = 0; n < 24; ++n) {
            const auto wired = static_cast<u16>(c::di1_function.address + 2 * n);
            if (on_->read(n < 8 ? wired : address_of_function(n - 8)) == static_cast<u16>(function))
                return true;
        }
        return false;
    }
    bool is_output_assigned(out function) {
        for (unsigned n = 0; n < 6; ++n) {
            const auto wired = static_cast<u16>(servobus::c630s::do1_function.address + 2 * n);
            if (on_->read(wired) == static_cast<u16>(function)) return true;
        }
        return false;
    }
};

} // namespace tool
