// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles what a C630S shows at rest: without power on the motor, and without consent.
#pragma once

#include <cstdint>
#include <optional>

#include "c630s_hands.hpp"

namespace tool {

class c630s_at_rest : public c630s_hands {
  protected:
    using c630s_hands::c630s_hands;

    void at_rest() {
        namespace c = servobus::c630s;
        response_to_10h();
        own_delay();
        (void)on_->write(c::alarm_reset.address, 1);
        wait();
        found("commands_end", read(c::alarm_reset) == 0);
        (void)on_->write(c::alarm_reset.address, 0);
        same_output_twice();
        same_input_twice();
    }
    void response_to_10h() {
        const u16 record = read(servobus::c630s::selected_fault_record);
        const std::optional<u16> count =
            on_->count_in_response(servobus::c630s::selected_fault_record.address, record);
        if (count) found("echoes_byte_count", *count == 2);
    }
    // P0C-25 is read with its smallest value, then with a delay that fits into the limit of a response beside the time
    // that the drive itself needs: a drive that is slower than the limit does not hear its old word again. A drive that
    // needs no time of its own does not tell.
    void own_delay() {
        namespace c = servobus::c630s;
        constexpr servobus::duration least_own = servobus::milliseconds(15),
                                     least = servobus::milliseconds(10);
        const auto time_of_read = [&] {
            const servobus::instant begun = on_->now();
            (void)read(c::response_delay);
            return since(begun, on_->now());
        };
        set(c::response_delay, 0);
        (void)time_of_read();
        const servobus::duration own = time_of_read();
        const servobus::duration limit = on_->longest_response();
        if (own > least_own && own + least * 2 < limit) {
            const servobus::duration room{(limit - own).us / 2};
            const u16 ms = static_cast<u16>(shorter_of(room, servobus::milliseconds(100)).us / 1000);
            const servobus::duration delay = servobus::milliseconds(ms);
            set(c::response_delay, ms);
            (void)time_of_read();
            const servobus::duration both = time_of_read();
            found("delay_is_additional",
                  both > longer_of(own, delay) + servobus::duration{shorter_of(own, delay).us / 2});
        }
        old_.restore_last_first();
    }
    // Two outputs show "servo ready", or a wired one and a virtual one do: the last of them shows it, or it does not.
    void same_output_twice() {
        namespace c = servobus::c630s;
        set(c::virtual_outputs_enable, 1);
        set(address_of_output(ready_out), static_cast<u16>(out::servo_ready));
        set(address_of_output(again_out), static_cast<u16>(out::servo_ready));
        set(static_cast<u16>(address_of_output(ready_out) + 1), 0); // not inverted
        set(static_cast<u16>(address_of_output(again_out) + 1), 0);
        wait();
        found("first_output_shows", !shows(again_out));
        old_.restore_last_first();
    }
    // Er.130: disabled virtual inputs first, then enabled ones. The alarm's record shows the voltage, and what is left
    // of it.
    void same_input_twice() {
        namespace c = servobus::c630s;
        constexpr in harmless = in::gain_selection;
        if (is_assigned(harmless)) return;
        set(c::selected_fault_record, 0);
        set(c::virtual_inputs_enable, 0);
        set(address_of_function(13), static_cast<u16>(harmless));
        set(address_of_function(14), static_cast<u16>(harmless));
        wait();
        const bool counts_disabled = read(c::recorded_alarm) == 0x130 && read(c::servo_status) == in_fault;
        found("disabled_inputs_count", counts_disabled);
        set(c::virtual_inputs_enable, 1);
        wait();
        const bool is_raised = read(c::recorded_alarm) == 0x130 && read(c::servo_status) == in_fault;
        const u16 recorded = read(c::recorded_bus_voltage), present = read(c::bus_voltage);
        set(address_of_function(14), 0);
        set(address_of_function(13), 0);
        wait();
        reset_alarm();
        if (is_raised && present > 100) {
            if (recorded > present / 2) found("bus_voltage_in_volts", false);
            if (recorded < present / 5 && recorded > present / 20) found("bus_voltage_in_volts", true);
        }
        if (is_raised && read(c::servo_status) != in_fault)
            found("shows_last_alarm", read(c::recorded_alarm) == 0x130);
        old_.restore_last_first();
    }
};

} // namespace tool
