// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the state machine of the simulated C630S: S-ON, the kinds of stop, faults and warnings, and a
// tick of the control loop. sim/c630s/options.hpp lists the assumptions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/sim/c630s/detail/outputs.hpp>

namespace servobus::sim::detail {

class c630s_core : protected c630s_outputs {
  protected:
    using c630s_outputs::c630s_outputs;

    constexpr bool is_stopped() const { return state_ == state::off && motor_.stands(); }

    // Power

    constexpr void switch_on() {
        state_ = state::off;
        is_enabled_ = false;
        is_free_until_off_ = false;
        is_home_ = false;
        is_electrically_home_ = false;
        is_brake_open_ = false;
        is_jogging_ = false;
        wanted_speed_ = 0;
        is_idle_ = false;
        interrupt();
        forget_remainder();
        const bool keeps_more = keeps(c630s_restart::alarms_and_position) && has_run_;
        if (!memory_.is_on(coolmay::encoder_type) && !keeps_more) zero_ = motor_.position();
        has_run_ = true;
        powered_at_ = motor_.position();
        alarms_.switch_on([&](std::uint16_t code) { return (keeps_more && code != 0x941) || lasts(code); });
        move_machine();
        inputs_.switch_on(memory_);
        prepare_homing();
        check_assignments();
        update_functions();
    }

    // Alarms

    constexpr void raise(std::uint16_t code) {
        if (code == 0x735 && memory_.is_on(coolmay::multiturn_overflow_masking)) return;
        is_idle_ = false;
        if (alarms_.is_present(code)) return;
        const auto volts = static_cast<std::uint16_t>(bus_voltage_);
        const auto amperes = static_cast<std::int16_t>(current());
        const c630s_record what{code,
                                seconds(),
                                static_cast<std::int16_t>(motor_.speed() / shaft::r_per_min),
                                amperes,
                                static_cast<std::int16_t>(-amperes / 2),
                                volts,
                                inputs_.levels(memory_),
                                outputs()};
        if (!alarms_.set(what)) return;
        if (alarms_.has_fault()) cut_power();
        update_functions();
    }
    constexpr void reset_alarms() {
        alarms_.reset(given(function::servo_on), [this](std::uint16_t code) { return lasts(code); });
        is_idle_ = false;
    }
    /// True while the cause of this alarm is present.
    constexpr bool lasts(std::uint16_t code) const {
        switch (code) {
        case 0x130: return c630s_inputs::has_duplicates(memory_, options_.disabled_inputs_count);
        case 0x400: return bus_voltage_ > highest_voltage;
        case 0x410: return bus_voltage_ < lowest_voltage;
        case 0x900: return is_emergency();
        case 0x950: return given(function::positive_overtravel);
        case 0x952: return given(function::negative_overtravel);
        default: return (lasting_ & bit_of(code)) != 0;
        }
    }
    static constexpr std::uint64_t bit_of(std::uint16_t code) {
        for (std::size_t n = 0; n < std::size(coolmay::alarms); ++n) {
            if (coolmay::alarms[n].code == code) return std::uint64_t{1} << n;
        }
        return 0;
    }
    /// Applies the parameters that waited for a stopped motor.
    constexpr void apply_at_stop() {
        if (!memory_.apply_at_stop_if(is_stopped())) return;
        inputs_.restart(memory_);
        check_assignments();
    }
    constexpr void check_assignments() {
        if (c630s_inputs::has_duplicates(memory_, options_.disabled_inputs_count)) raise(0x130);
    }
    constexpr bool is_emergency() const {
        return given(function::emergency_stop) || memory_.is_on(coolmay::emergency_stop);
    }

    // A tick

    constexpr void tick() {
        ++ms_;
        move_machine();
        watch_inputs();
        follow_servo_on();
        run();
        if (state_ != state::on) inputs_.drop_edges();
        apply_at_stop();
        look_for_faults();
        update_functions();
        is_idle_ = is_stopped() && !given(function::servo_on);
    }

    static constexpr std::int64_t lowest_voltage = 2000;
    static constexpr std::int64_t highest_voltage = 4200;

    std::uint64_t lasting_ = 0; // causes that last; a bit for each alarm, by its place in the table
    std::int64_t bus_voltage_ = 3100;
    std::int64_t powered_at_ = 0; // encoder counts
    std::uint32_t enables_ = 0;
    bool is_idle_ = false;
    bool has_run_ = false; // it has been switched on before

  private:
    constexpr void watch_inputs() {
        inputs_.refresh(memory_);
        if (inputs_.take_edge(function::alarm_reset)) reset_alarms();
        watch_homing_inputs();
        if (is_emergency()) raise(0x900);
        watch_limit(function::positive_overtravel, 0x950);
        watch_limit(function::negative_overtravel, 0x952);
    }
    constexpr void watch_limit(function f, std::uint16_t code) {
        if (!given(f)) {
            alarms_.end(code);
        } else if (!is_homing()) {
            raise(code);
        }
    }

    // S-ON

    constexpr void follow_servo_on() {
        const bool wanted = given(function::servo_on);
        if (!wanted) is_free_until_off_ = false;
        if (wanted && state_ != state::on && !is_free_until_off_ && !alarms_.has_fault()) {
            enable();
        } else if (!wanted && state_ == state::on) {
            stop(memory_.get(coolmay::stop_at_servo_off) == coolmay::stop_mode::zero_speed);
        }
    }
    constexpr void enable() {
        state_ = state::on;
        is_enabled_ = true;
        ++enables_;
        inputs_.drop_edges();
        begin_positioning();
        begin_speed();
        is_locking_ = !motor_.stands();
        wait_ = has_brake() ? value(coolmay::brake_on_to_command_delay) : 0;
        is_brake_open_ = true;
    }
    // Ends the enabled state by a controlled stop.
    constexpr void stop(bool at_zero_speed) {
        abort_homing();
        interrupt();
        off_for_ = 0;
        is_enabled_ = false;
        is_stopping_at_zero_ = at_zero_speed;
        wait_ = 0;
        if (motor_.stands() && has_brake()) {
            is_brake_open_ = false;
            wait_ = value(coolmay::brake_off_to_power_off_delay);
        }
        const bool is_done = wait_ == 0 && (!at_zero_speed || motor_.stands());
        state_ = is_done ? state::off : state::stopping;
    }
    constexpr void cut_power() {
        if (state_ == state::off) return;
        abort_homing();
        interrupt();
        state_ = state::off;
        is_enabled_ = false;
        off_for_ = 0;
    }

    // Motion

    constexpr void run() {
        if (state_ == state::on)
            run_enabled();
        else
            run_disabled();
    }

    constexpr void run_disabled() {
        wanted_speed_ = 0;
        is_speed_limited_ = false;
        if (state_ == state::stopping) {
            if (is_stopping_at_zero_ && !motor_.stands()) {
                stop_and_hold();
            } else if (wait_ > 0) {
                --wait_;
                stop_and_hold();
            } else {
                state_ = state::off;
            }
        }
        ++off_for_;
        const bool is_slow =
            shaft::size(motor_.speed()) <= value(coolmay::brake_off_speed) * shaft::r_per_min;
        if (is_slow || off_for_ >= value(coolmay::servo_off_to_brake_off_delay)) is_brake_open_ = false;
        if (state_ != state::off) return;
        motor_.coast(has_brake() && !is_brake_open_ ? 20 : 1);
        command_.place(motor_.position());
    }

    constexpr void run_enabled() {
        set_torque_limits();
        if (is_emergency()) {
            abort_homing();
            interrupt();
            inputs_.drop_edges();
            if (wait_ > 0) --wait_; // the brake takes no longer
            wanted_speed_ = 0;
            stop_and_hold();
            return end_bus_stop();
        }
        if (wait_ > 0) {
            --wait_;
            inputs_.drop_edges();
            return stop_and_hold();
        }
        const std::int64_t speed = motor_.speed();
        if (!is_homing() && !is_locking_ && is_barred(speed > 0 ? 1 : speed < 0 ? -1 : 0)) overtravel();
        if (state_ != state::on) return run_disabled();
        if (is_locking_) {
            stop_and_hold();
            is_locking_ = !motor_.stands();
            return;
        }
        obey();
    }
    // Ends a stop by P0D-05 once the motor is at rest.
    constexpr void end_bus_stop() {
        if (!memory_.is_on(coolmay::emergency_stop) || !motor_.stands()) return;
        if (options_.bus_stop == c630s_bus_stop::resets) memory_.set(coolmay::emergency_stop.address, 0);
        if (options_.bus_stop != c630s_bus_stop::frees_shaft) return;
        is_free_until_off_ = true;
        stop(false);
    }
    constexpr void overtravel() {
        const auto how = memory_.get(coolmay::stop_at_overtravel);
        interrupt();
        if (how == coolmay::overtravel_stop::zero_speed_and_lock) {
            is_locking_ = true;
            return;
        }
        is_free_until_off_ = true;
        stop(how == coolmay::overtravel_stop::zero_speed);
    }
    constexpr void obey() {
        const coolmay::control_mode now = control();
        if (now != last_control_) {
            interrupt();
            abort_homing();
            begin_speed();
            last_control_ = now;
            is_locking_ = now == coolmay::control_mode::position && !motor_.stands();
            if (is_locking_) return stop_and_hold();
        }
        if (jog() != 0 || is_jogging_) {
            interrupt();
            abort_homing();
            run_jog();
            is_jogging_ = jog() != 0 || !motor_.stands();
        } else if (now == coolmay::control_mode::speed) {
            run_speed();
        } else if (now == coolmay::control_mode::torque) {
            run_torque();
        } else {
            position();
        }
    }
    constexpr void position() {
        is_speed_limited_ = false;
        start_commanded_homing();
        if (is_homing()) {
            if (!run_homing()) {
                raise(0x601);
                is_locking_ = true;
            }
        } else if (!run_position()) {
            interrupt();
            is_locking_ = true;
        }
        wanted_speed_ = command_.speed();
    }

    // Faults that the drive detects

    constexpr void look_for_faults() {
        if (bus_voltage_ < lowest_voltage) raise(0x410);
        if (bus_voltage_ > highest_voltage) raise(0x400);
        if (shaft::size(analogue_[0]) > 11'500 || shaft::size(analogue_[1]) > 11'500) raise(0x834);
        const std::int64_t speed = shaft::size(motor_.speed());
        const std::int64_t overspeed = value(coolmay::overspeed_threshold) * shaft::r_per_min;
        if (overspeed != 0 && speed > overspeed) raise(0x500);
        if (state_ != state::on) {
            stalled_ = 0;
            return;
        }
        const bool is_stalled = motor_.is_limited() && speed < 10 * shaft::r_per_min;
        stalled_ = is_stalled ? stalled_ + 1 : 0;
        if (memory_.is_on(coolmay::stall_protection) && stalled_ > value(coolmay::stall_protection_time))
            raise(0x630);
        const std::int64_t limit = value(coolmay::following_error_limit);
        const std::int64_t allowed = memory_.is_on(coolmay::position_setting_unit) ? to_counts(limit) : limit;
        if (control() == coolmay::control_mode::position && shaft::size(deviation()) > allowed) raise(0xB00);
    }

    std::int64_t wait_ = 0;    // ms until commands are carried out, or until the power is cut
    std::int64_t off_for_ = 0; // ms since S-ON became inactive
    std::int64_t stalled_ = 0; // ms
    coolmay::control_mode last_control_ = coolmay::control_mode::position;
    bool is_locking_ = false; // stops at zero speed first
    bool is_jogging_ = false;
    bool is_free_until_off_ = false; // released by a limit switch or P0D-05: S-ON must become inactive first
    bool is_stopping_at_zero_ = false;
};

} // namespace servobus::sim::detail
