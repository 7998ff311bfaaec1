// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real YAKOTEC stepper what its manual leaves open: each step brings it into a state in which the readings
// show which way it follows. The shaft must be free to turn. Registers that a step changes hold their old words at the
// end. Not probed, since they would cost the owner's parameters or need an alarm: `restores_eeprom`, `alarm`.
#pragma once

#include <cstdint>
#include <optional>

#include <servobus/core/bytes.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/yako/homing.hpp>

#include "probe_steps.hpp"

namespace tool {

/// The drive is at rest and without an alarm. `has_encoder`: closed loop.
class yako_probe : probe_steps {
  public:
    yako_probe(probe_bench& on, findings& found, bool has_encoder)
        : probe_steps{on, found, servobus::milliseconds(50)}, has_encoder_{has_encoder} {}

    void run() {
        note_old_words();
        bad_crc();
        what_commands_read();
        at_another_address();
        if (on_->may("The motor is held and released, and turns at 5 to 20 r/min by less than a turn, both "
                     "ways. Its shaft is "
                     "free to turn.")) {
            start_while_released();
            homed_at_an_offset();
            in_position();
            what_clears_homed();
            stop_while_homing();
            ramp();
            interrupted_move();
            if (has_encoder_) speed_unit();
            after_power_cycles();
        }
        give_back();
    }

  private:
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
        was_enabled_ = !has(bits::released_bit);
    }
    // The owner's words, in the EEPROM where the probe's are there. Again if the line is lost meanwhile.
    void give_back() {
        for (int i = 0; i < 3; ++i) {
            make_safe();
            if (!on_->is_back(servobus::yako::status_word.address)) return;
            make_safe();
            old_.restore();
            help(was_enabled_ ? auxiliary::enable : auxiliary::release);
            if (has_saved_) help(auxiliary::save_parameters);
            if (!on_->has_failed()) return;
        }
    }
    // What every motion here runs with.
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
        has_saved_ = has_saved_ || !on_->has_failed();
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
    // --- Steps without motion

    void bad_crc() { found("answers_bad_crc", on_->answers_bad_crc()); }
    void what_commands_read() {
        command(motion::stop());
        found("commands_read_back", on_->read(servobus::yako::motion_command.address) != 0);
    }
    // Only of a drive whose switches leave its address to 0013h.
    void at_another_address() {
        namespace y = servobus::yako;
        if ((on_->read(y::dip_switches.address) & 0x1Fu) != 0) return;
        const u16 node = old_.word(y::node_address.address);
        const auto other = static_cast<u16>(node == 77 ? 78 : 77);
        (void)on_->write(y::node_address.address, other);
        found("moves_address_immediately", on_->responds_at(static_cast<std::uint8_t>(other)));
        old_.put_back(y::node_address.address);
    }
    void start_while_released() {
        help(auxiliary::release);
        (void)rests();
        const bool is_taken = moves(0);
        found("refuses_unfit", !is_taken);
    }

    // --- Steps with motion

    // Bit 1 while the offset behind home is moved; only of a drive that was not homed before.
    void homed_at_an_offset() {
        namespace y = servobus::yako;
        enable();
        const bool was_homed = has(bits::homed_bit);
        (void)write_number(y::home_offset.address, 40);
        (void)on_->write(y::homing_offset_mode.address,
                         static_cast<u16>(y::offset_handling::move_position_actual));
        (void)on_->write(y::closed_loop::homing_method.address,
                         static_cast<u16>(y::homing::current_position));
        command(motion::home());
        const bool is_moving = is_in_motion();
        const u16 now = status();
        if (is_moving && !was_homed && (now & bits::moving_bit) != 0)
            found("is_homed_before_offset", (now & bits::homed_bit) != 0);
        (void)rests();
    }

    // Bit 0 before any move since power-on is asked after the power cycle; here after a move, a jog, and its stop.
    void in_position() {
        enable();
        moves(20);
        (void)is_in_motion();
        (void)rests();
        on_->wait(servobus::milliseconds(500));
        command(motion::jog());
        const bool is_moving = is_in_motion();
        const u16 in_motion = status();
        stop();
        on_->wait(servobus::milliseconds(500));
        if (!is_moving || (in_motion & bits::moving_bit) == 0) return;
        is_set_in_motion_ = (in_motion & bits::in_position_bit) != 0;
        is_set_after_stop_ = has(bits::in_position_bit);
    }
    void judge_in_position(bool is_set_at_power_on) {
        if (!is_set_in_motion_ || !is_set_after_stop_) return;
        if (*is_set_in_motion_)
            found("in_position", "until_next_move");
        else if (!*is_set_after_stop_)
            found("in_position", "at_target");
        else if (!is_set_at_power_on)
            found("in_position", "after_first_move");
        // `at_rest` or `until_commanded`: they differ for the two milliseconds after a command alone.
    }

    void what_clears_homed() {
        enable();
        home_here();
        if (!has(bits::homed_bit)) return;
        command(motion::emergency_stop());
        wait();
        if (!has(bits::homed_bit)) return found("homed", "until_place_lost");
        search();
        if (is_in_motion()) {
            const u16 now = status();
            if ((now & bits::moving_bit) != 0)
                found("homed", (now & bits::homed_bit) != 0 ? "always" : "until_homing");
        }
        stop_in_any_case();
    }

    void stop_while_homing() {
        enable();
        search();
        if (!is_in_motion()) return;
        command(motion::stop());
        found("stops_homing", until([&] { return !has(bits::moving_bit); }, 20));
        stop_in_any_case();
    }

    // A ramp of 2 s: to 1000 r/min it leads to 5 r/min in a hundredth of it.
    void ramp() {
        namespace y = servobus::yako;
        enable();
        (void)on_->write(y::jog_acceleration_time.address, 2000);
        command(motion::jog());
        if (!is_in_motion()) return;
        on_->wait(servobus::milliseconds(200));
        const int early = speed();
        const bool is_full_later = until([&] { return speed() >= slow; }, 80);
        if (is_full_later) found("ramps_to_1000_r_per_min", early >= slow - 1);
        stop();
    }

    // 200 pulses forward, interrupted soon by 50 more.
    void interrupted_move() {
        namespace y = servobus::yako;
        enable();
        const std::int32_t from = position();
        moves(200);
        if (!is_in_motion()) return;
        (void)write_number(y::target_position.address, 50);
        command(motion::move(y::positioning::relative, y::while_moving::interrupt));
        wait();
        if (!rests()) return stop();
        const std::int32_t way = position() - from;
        if (way > 45 && way < 190) found("interrupts_from_target", false);
        if (way >= 240 && way <= 260) found("interrupts_from_target", true);
    }

    // 20 counts in tenths are 2 r/min, or 20 if only the feedback is in tenths.
    void speed_unit() {
        namespace c = servobus::yako::closed_loop;
        enable();
        (void)on_->write(c::speed_resolution.address, 1);
        (void)on_->write(c::jog_speed.address, 20);
        command(motion::jog());
        if (is_in_motion()) {
            on_->wait(servobus::milliseconds(500));
            const int counts = speed();
            if (counts >= 15 && counts <= 25) found("rescales_feedback_only", false);
            if (counts >= 150 && counts <= 250) found("rescales_feedback_only", true);
        }
        stop();
        (void)on_->write(c::speed_resolution.address, 0);
    }

    // What is kept: a row without S, a setting of the line, a row with S that was saved while the motor moved.
    void after_power_cycles() {
        namespace y = servobus::yako;
        enable();
        home_here();
        const u16 before = status();
        const std::int32_t place = position();
        const u16 time = other_than(y::jog_acceleration_time.address, 700, 800);
        const auto order = static_cast<u16>(old_.word(y::pair_word_order.address) != 0 ? 0 : 1);
        (void)on_->write(y::jog_acceleration_time.address, time);
        (void)on_->write(y::pair_word_order.address, order);
        if (!on_->switch_off_and_on()) return;
        const bool is_time_kept = on_->read(y::jog_acceleration_time.address) == time;
        const bool is_order_kept = on_->read(y::pair_word_order.address) == order;
        old_.put_back(y::pair_word_order.address);
        const u16 after = status();
        found("is_enabled_at_power_on", (after & bits::released_bit) == 0);
        if ((before & bits::homed_bit) != 0) found("restart_keeps_homed", (after & bits::homed_bit) != 0);
        if (place != 0) found("restart_keeps_place", position() == place);
        enable();
        on_->wait(servobus::milliseconds(500));
        judge_in_position(has(bits::in_position_bit));
        if (is_time_kept)
            return found("kept", "written"); // then nothing tells whether a save was carried out
        const bool keeps_line = is_order_kept;
        const bool is_saved = saved_while_moving();
        if (!is_saved) {
            (void)on_->write(y::jog_acceleration_time.address, time);
            save();
            on_->wait(servobus::milliseconds(200));
            if (!on_->switch_off_and_on()) return;
        }
        const bool is_kept_by_save = on_->read(y::jog_acceleration_time.address) == time;
        found("kept", keeps_line ? "line_settings" : is_kept_by_save ? "saved" : "marked");
    }
    // True if it was, and then the row without S has been saved or lost too.
    bool saved_while_moving() {
        namespace y = servobus::yako;
        enable();
        const u16 window = other_than(y::in_position_time.address, 20, 30);
        (void)on_->write(y::in_position_time.address, window);
        command(motion::jog());
        if (!is_in_motion()) return false;
        (void)on_->write(y::jog_acceleration_time.address,
                         other_than(y::jog_acceleration_time.address, 700, 800));
        save();
        const bool was_moving = has(bits::moving_bit);
        on_->wait(servobus::milliseconds(200));
        stop();
        if (!was_moving || !on_->switch_off_and_on()) return false;
        const bool is_saved = on_->read(y::in_position_time.address) == window;
        found("saves_while_moving", is_saved);
        return is_saved;
    }
    u16 other_than(u16 address, u16 one, u16 other) const { return old_.word(address) == one ? other : one; }

    bool has_encoder_;
    bool was_enabled_ = false;
    bool has_saved_ = false;
    std::optional<bool> is_set_in_motion_{}; // bit 0 during a jog
    std::optional<bool> is_set_after_stop_{};
};

} // namespace tool
