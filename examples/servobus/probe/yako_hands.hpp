// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Handles a stepper for the steps of its probe: sets registers, commands it, makes it safe.
#pragma once

#include <cstdint>

#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/yako/homing.hpp>

#include "probe_steps.hpp"

namespace tool {

class yako_hands : public probe_steps {
  protected:
    yako_hands(probe_bench& on, findings& found, bool has_encoder)
        : probe_steps{on, found, servobus::milliseconds(50)}, has_encoder_{has_encoder} {}

    using bits = servobus::yako::motion_status;
    using motion = servobus::yako::motion_code;
    using auxiliary = servobus::yako::auxiliary;

    static constexpr u16 slow = 5;        // r/min, the least that a homing takes
    static constexpr u16 short_ramp = 30; // ms, the least that a homing takes
    static constexpr int most = 200;      // readings

    // --- Registers

    void note_old_words() {
        namespace y = servobus::yako;
        namespace c = servobus::yako::closed_loop;
        for (const u16 address :
             {y::pair_word_order.address, y::node_address.address, y::jog_acceleration_time.address,
              y::jog_deceleration_time.address, y::acceleration_time.address, y::deceleration_time.address,
              y::homing_offset_mode.address, y::homing_ramp_time.address, y::in_position_time.address,
              c::jog_speed.address, c::start_speed.address, c::positioning_speed.address,
              c::homing_method.address, c::homing_fast_speed.address, c::homing_slow_speed.address})
            old_.note(address);
        if (has_encoder_) old_.note(c::speed_resolution.address);
        old_.note_pair(y::home_offset.address);
        old_.note_pair(y::target_position.address);
        note_order(y::pair_word_order.address);
    }
    // Sets the speeds and ramps of every motion here.
    void go_slowly() {
        namespace y = servobus::yako;
        namespace c = servobus::yako::closed_loop;
        if (has_encoder_) (void)on_->write(c::speed_resolution.address, 0);
        for (const u16 address : {c::jog_speed.address, c::positioning_speed.address,
                                  c::homing_fast_speed.address, c::homing_slow_speed.address})
            (void)on_->write(address, slow);
        (void)on_->write(c::start_speed.address, 0);
        for (const u16 address :
             {y::jog_acceleration_time.address, y::jog_deceleration_time.address,
              y::acceleration_time.address, y::deceleration_time.address, y::homing_ramp_time.address})
            (void)on_->write(address, short_ramp);
    }
    std::int32_t position() { return read_number(servobus::yako::actual_position.address); }
    u16 status() { return on_->read(servobus::yako::status_word.address); }
    bool has(u16 bit) { return (status() & bit) != 0; }
    int speed() {
        const int counts =
            static_cast<std::int16_t>(on_->read(servobus::yako::closed_loop::actual_speed.address));
        return counts < 0 ? -counts : counts;
    }

    // --- Commands

    bool command(motion c) { return on_->write(servobus::yako::motion_command.address, c.to_word()); }
    bool help(auxiliary a) {
        return on_->write(servobus::yako::auxiliary_command.address, static_cast<u16>(a));
    }
    void save() {
        if (!on_->has_failed()) on_->set_saved(true);
        help(auxiliary::save_parameters);
    }
    void make_safe() {
        on_->write_safely(servobus::yako::motion_command.address, motion::emergency_stop().to_word());
        on_->write_safely(servobus::yako::auxiliary_command.address, static_cast<u16>(auxiliary::release));
    }
    bool rests() {
        return until([&] { return !has(bits::moving_bit); }, most);
    }
    // Enabled, at rest, its parameters slow.
    void enable() {
        go_slowly();
        help(auxiliary::enable);
        wait();
    }
    void stop() {
        command(motion::stop());
        (void)rests();
    }
    // Also what a stop does not end.
    void stop_in_any_case() {
        command(motion::stop());
        if (until([&] { return !has(bits::moving_bit); }, 20)) return;
        help(auxiliary::release);
        (void)rests();
        enable();
    }
    bool moves(std::int32_t way) {
        namespace y = servobus::yako;
        (void)write_number(y::target_position.address, way);
        return command(motion::move(y::positioning::relative));
    }
    bool is_in_motion() {
        return until([&] { return has(bits::moving_bit); }, 20);
    }
    // Takes the present place as home without motion, and keeps the position.
    void home_here() {
        namespace y = servobus::yako;
        (void)write_number(y::home_offset.address, 0);
        (void)on_->write(y::homing_offset_mode.address,
                         static_cast<u16>(y::offset_handling::stay_position_actual));
        (void)on_->write(y::closed_loop::homing_method.address,
                         static_cast<u16>(y::homing::current_position));
        command(motion::home());
        wait();
        (void)rests();
    }
    // A search for a home switch that does not come soon: it turns slowly until it is stopped.
    void search() {
        namespace y = servobus::yako;
        (void)on_->write(y::closed_loop::homing_method.address, 20);
        command(motion::home());
    }
    u16 other_than(u16 address, u16 one, u16 other) const { return old_.word(address) == one ? other : one; }

    bool has_encoder_;
};

} // namespace tool
