// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real YAKOTEC stepper what its manual leaves open: each step brings it into a state in which the readings
// show which way it follows. The shaft must be free to turn. Registers that a step changes hold their old words at the
// end. Not probed, since they would cost the owner's parameters or need an alarm: `restores_eeprom`, `alarm`.
#pragma once

#include <cstdint>

#include "yako_motions.hpp"

namespace tool {

/// The drive is at rest, released and without an alarm, and is so at the end. `has_encoder`: closed loop.
class yako_probe : yako_motions {
  public:
    yako_probe(probe_bench& on, findings& found, bool has_encoder) : yako_motions{on, found, has_encoder} {}

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
    // The owner's words, in the EEPROM where the probe's are there. Again if the line is lost meanwhile.
    void give_back() {
        for (int i = 0; i < 3; ++i) {
            make_safe();
            if (!on_->is_back(servobus::yako::status_word.address)) return;
            make_safe();
            old_.restore();
            if (on_->has_saved() && help(auxiliary::save_parameters)) on_->set_saved(false);
            if (!on_->has_failed()) return;
        }
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

    // --- Power cycles

    // Settles what is kept: a row without S, a setting of the line, a row with S that was saved while the motor moved.
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
};

} // namespace tool
