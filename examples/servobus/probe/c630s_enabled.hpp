// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles what a C630S shows while a virtual input enables it: in speed mode, then in position mode. It turns at 20
// r/min at most.
#pragma once

#include <cstdint>

#include "c630s_hands.hpp"

namespace tool {

class c630s_enabled : public c630s_hands {
  protected:
    using c630s_hands::c630s_hands;

    void prepare_enable(servobus::c630s::control_mode mode) {
        namespace c = servobus::c630s;
        set(c::target_speed, 0);
        set(c::jog_speed, 0);
        set(c::acceleration_time, 100);
        set(c::deceleration_time, 100);
        set(c::mode_of_operation, mode);
        set(c::main_speed_source, c::speed_source::digital);
        set(c::speed_command_selection, c::command_selection::main);
        set(c::virtual_inputs_enable, 1);
        set(c::virtual_outputs_enable, 1);
        for (const unsigned n : {brake_out, home_out}) {
            set(address_of_output(n), static_cast<u16>(n == brake_out ? out::brake : out::home_attained));
            set(static_cast<u16>(address_of_output(n) + 1), 0);
        }
        wait();
    }
    void in_speed_mode() {
        namespace c = servobus::c630s;
        prepare_enable(c::control_mode::speed);
        const bool is_wired = is_output_assigned(out::brake);
        const bool is_released_off = shows(brake_out);
        constexpr u16 most_delay = 500;
        set(c::brake_on_to_command_delay, most_delay);
        set(c::target_speed, slow);
        inputs(servo_on);
        on_->wait(servobus::milliseconds(300));
        const bool turns_early = speed() > 0;
        if (!until([&] { return speed() >= slow - 2; }, most)) return servo_off();
        if (!is_wired) {
            found("virtual_brake_delays", !turns_early);
            found("brake", is_released_off    ? "always_released"
                           : shows(brake_out) ? "follows_servo"
                                              : "wired_only");
        }
        found("resets_while_enabled", on_->write(c::alarm_reset.address, 1));
        (void)on_->write(c::alarm_reset.address, 0);
        bus_stop();
        servo_off();
        reset_alarm(); // the warning Er.900
    }
    // P0D-05 of a motor that turns: it stops, and then it is released in one of three ways.
    void bus_stop() {
        namespace c = servobus::c630s;
        (void)on_->write(c::emergency_stop.address, 1);
        if (!until([&] { return speed() == 0 || read(c::emergency_stop) == 0; }, most)) return;
        on_->wait(servobus::milliseconds(300));
        const bool has_reset = read(c::emergency_stop) == 0;
        (void)on_->write(c::emergency_stop.address, 0);
        const bool turns_again = until([&] { return speed() >= slow - 2; }, 40);
        found("bus_stop", has_reset ? "resets" : turns_again ? "lasts" : "frees_shaft");
    }

    void in_position_mode() {
        namespace c = servobus::c630s;
        prepare_enable(c::control_mode::position);
        set(c::position_command_source, c::position_source::segments);
        set(c::position_segment_mode, c::segment_mode::by_input);
        set(c::position_segment_type, c::displacement_type::relative);
        set(c::position_segment_speeds[0].address, slow);
        set(c::position_segment_acceleration_times[0].address, 10);
        set(c::position_segment_wait_times[0].address, 0);
        set(c::brake_on_to_command_delay, 0);
        set(address_of_function(1), static_cast<u16>(in::position_segment_start));
        set(static_cast<u16>(address_of_function(1) + 1), 1); // an edge
        set(address_of_function(2), static_cast<u16>(in::jog_forward));
        set(static_cast<u16>(address_of_function(2) + 1), 0);
        wait();
        set_pair(c::position_segment_displacements[0], 100);
        inputs(servo_on);
        on_->wait(servobus::milliseconds(1000));
        segment_start();
        rest_of_a_displacement();
        jog();
        homing_output();
        servo_off();
    }
    void start() {
        inputs(servo_on | starts);
        wait();
        inputs(servo_on);
    }
    // By an edge, or not; then by a level.
    void segment_start() {
        namespace c = servobus::c630s;
        const std::int32_t before = read_number(c::feedback_pulses);
        const auto has_moved = [&] { return read_number(c::feedback_pulses) - before > 200; };
        start();
        if (until(has_moved, 40)) return found("segment_start_is_level", false);
        inputs(0);
        (void)stands();
        on_->wait(servobus::milliseconds(1500));
        set(static_cast<u16>(address_of_function(1) + 1), 0); // a level
        wait();
        inputs(servo_on);
        on_->wait(servobus::milliseconds(1000));
        start();
        if (until(has_moved, 40)) found("segment_start_is_level", true);
    }
    // A long displacement says how many counts of the encoder a unit has; many short ones, whether their rest is kept.
    void rest_of_a_displacement() {
        namespace c = servobus::c630s;
        constexpr std::int32_t many = 1000, enough = 20, most_starts = 250;
        (void)stands();
        const std::int32_t whole = counts_of(many, 1);
        const std::int32_t unit = whole / many; // whole counts of a unit
        const std::int32_t rest = whole - unit * many;
        if (unit < 2 || rest * most_starts < enough * many) return; // too little is cut
        const std::int32_t few = enough * many / rest + 1;
        const std::int32_t sum = counts_of(1, few);
        const auto kept = static_cast<std::int32_t>(std::int64_t{whole} * few / many);
        const auto is_near = [&](std::int32_t to) {
            return sum >= to - enough / 4 && sum <= to + enough / 4;
        };
        if (is_near(unit * few)) found("gear_keeps_rest", false);
        if (is_near(kept)) found("gear_keeps_rest", true);
    }
    // Returns the counts that these starts turn in all.
    std::int32_t counts_of(std::int32_t displacement, int times) {
        namespace c = servobus::c630s;
        set_pair(c::position_segment_displacements[0], displacement);
        const std::int32_t before = read_number(c::feedback_pulses);
        for (int i = 0; i < times && !on_->has_failed(); ++i) {
            start();
            wait();
            (void)stands();
        }
        std::int32_t last = before;
        (void)until(
            [&] {
                const std::int32_t now = read_number(c::feedback_pulses);
                const bool is_still = now == last && now != before;
                last = now;
                return is_still;
            },
            most);
        return last - before;
    }
    void jog() {
        namespace c = servobus::c630s;
        set(c::jog_speed, slow);
        set(c::target_speed, twice);
        inputs(servo_on | jogs);
        if (until([&] { return speed() >= slow - 2; }, most)) {
            on_->wait(servobus::milliseconds(500));
            found("jog_follows_command", speed() > slow + slow / 2);
        }
        inputs(servo_on);
        (void)stands();
        set(c::target_speed, 0);
        set(c::jog_speed, 0);
    }
    // Home is declared; then a slow search for the encoder's index begins, and is given up.
    void homing_output() {
        namespace c = servobus::c630s;
        set(c::homing_method, 2);
        set(c::homing_high_speed, slow);
        set(c::homing_low_speed, slow);
        set(c::homing_acceleration_time, 100);
        (void)on_->write(c::homing_control.address, 0);
        (void)on_->write(c::homing_control.address, static_cast<u16>(c::homing::set_home));
        if (!until([&] { return shows(out::home_attained, home_out); }, 10)) return;
        (void)on_->write(c::homing_control.address, 0);
        (void)on_->write(c::homing_control.address, static_cast<u16>(c::homing::start));
        if (until([&] { return speed() > 0; }, 20))
            found("home_output_falls", !shows(out::home_attained, home_out));
        (void)on_->write(c::homing_control.address, 0);
        (void)stands();
    }
};

} // namespace tool
