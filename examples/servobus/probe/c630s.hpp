// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real C630S what its manual leaves open: first what shows at rest, then what a power cycle shows, then
// what shows while it is enabled by a virtual input. A terminal of S-ON takes effect at power-on [errata C15], so the
// person switches the drive off and on twice: with the probe's terminals, and with the owner's again. The shaft must be
// free to turn. Registers that a step changes hold their old words at the end, also in the EEPROM.
#pragma once

#include <cstdint>
#include <span>

#include "c630s_enabled.hpp"

namespace tool {

/// The drive is at rest, not enabled and without an alarm.
class c630s_probe : c630s_enabled {
  public:
    c630s_probe(probe_bench& on, findings& found) : c630s_enabled{on, found} {}

    void run() {
        namespace c = servobus::c630s;
        note_order(c::pair_word_order.address);
        if (on_->read(c::servo_status.address) == in_fault)
            return on_->give_up("the drive has an alarm: reset it, and probe again");
        keeps_ = on_->read(c::eeprom_update.address);
        const u16 homes = on_->read(c::homing_control.address);
        homes_ = is_command(homes) ? 0 : homes;
        if (on_->has_failed()) return;
        on_->put_back_last_first(); // no two inputs may have one function [Er.130]
        on_->note_old(c::eeprom_update.address, std::span{&keeps_, 1});
        on_->note_old(c::homing_control.address, std::span{&homes_, 1});
        keep(false);
        at_rest();
        bool has_prepared = false;
        if (on_->may("The motor is held, and turns at 10 to 20 r/min, some seconds at a time, also forward "
                     "by turns. Its shaft is "
                     "free to turn. S-ON becomes a virtual input until the end: no terminal enables the "
                     "drive meanwhile.")) {
            has_prepared = true;
            prepare();
            if (on_->switch_off_and_on()) {
                after_power_cycle();
                in_speed_mode();
                in_position_mode();
                after_software_reset();
            }
        }
        give_back();
        if (has_prepared) (void)on_->switch_off_and_on(); // the owner's terminals from now on
    }

  private:
    // P05-30 that would be carried out again is no setting of the owner.
    static bool is_command(u16 word) {
        using servobus::c630s::homing;
        return word == static_cast<u16>(homing::start) ||
               word == static_cast<u16>(homing::start_electrical) ||
               word == static_cast<u16>(homing::set_home);
    }

    // --- A power cycle

    // S-ON becomes the first virtual input, and what may survive a power cycle is stored.
    void prepare() {
        namespace c = servobus::c630s;
        old_.forget();
        on_->set_saved(true);
        keep(true);
        for (unsigned n = 0; n < 8; ++n) {
            const auto wired = static_cast<u16>(c::di1_function.address + 2 * n);
            if (on_->read(wired) == static_cast<u16>(in::servo_on)) set(wired, 0);
        }
        for (unsigned n = 1; n < 16; ++n) {
            if (on_->read(address_of_function(n)) != 0) set(address_of_function(n), 0);
        }
        set(address_of_function(0), static_cast<u16>(in::servo_on));
        set(static_cast<u16>(address_of_function(0) + 1), 0); // a level
        set_pair(c::home_offset, 2000);
        (void)on_->write(c::homing_control.address, 0);
        (void)on_->write(c::homing_control.address, static_cast<u16>(c::homing::set_home));
        wait();
        place_ = read_number(c::absolute_position);
        set_pair(c::home_offset, 3000);
        inputs(marker);
        keep(false); // stored, or not
    }
    void after_power_cycle() {
        namespace c = servobus::c630s;
        found("stores_eeprom_off", read(c::eeprom_update) == 0);
        keep(false);
        const bool keeps_levels = (read(c::virtual_input_levels) & marker) != 0;
        const std::int32_t place = read_number(c::absolute_position);
        const auto is_near = [](std::int32_t at, std::int32_t to) { return at >= to - 5 && at <= to + 5; };
        const bool is_home_set = is_near(place, 3000);
        if (is_near(place_, 2000)) {
            found("restart_keeps", keeps_levels && is_home_set ? "everything"
                                   : keeps_levels              ? "levels"
                                   : is_home_set               ? "homing_command"
                                   : is_near(place, 2000)      ? "alarms_and_position"
                                                               : "parameters");
        }
        inputs(0);
        (void)on_->write(c::homing_control.address, 0);
    }

    // --- A software reset

    // A stored change that waits for power-on raises a warning, which P0D-00 ends if it counts as power-on.
    void after_software_reset() {
        namespace c = servobus::c630s;
        const u16 pulses = read(c::encoder_output_pulses);
        keep(true);
        set(c::encoder_output_pulses, pulses == 2500 ? 2501 : 2500);
        keep(false);
        (void)on_->write(c::software_reset.address, 1);
        on_->wait(servobus::milliseconds(1500));
        (void)on_->write(c::virtual_outputs_enable.address, 1);
        (void)on_->write(address_of_output(brake_out), static_cast<u16>(out::warning));
        (void)on_->write(static_cast<u16>(address_of_output(brake_out) + 1), 0);
        on_->wait(servobus::milliseconds(200));
        found("software_reset_is_power_on", !shows(brake_out));
    }

    // The owner's words, in the EEPROM where the probe's are there. Again if the line is lost meanwhile.
    void give_back() {
        namespace c = servobus::c630s;
        for (int i = 0; i < 3; ++i) {
            make_safe();
            if (!on_->is_back(c::servo_status.address)) return;
            (void)on_->write(c::homing_control.address, 0);
            make_safe();
            if (on_->has_saved()) keep(true);
            old_.restore_last_first();
            (void)on_->write(c::homing_control.address, homes_);
            inputs(0);
            if (read(c::servo_status) == in_fault) reset_alarm(); // of a step that did not come to its end
            keep(true); // a 0 may have been stored, and a 1 is while it is 1
            (void)on_->write(c::eeprom_update.address, keeps_);
            if (on_->has_failed()) continue;
            on_->set_saved(false);
            return;
        }
    }

    std::int32_t place_ = 0; // as home was set before the power cycle
    u16 keeps_ = 1;          // P0C-13
    u16 homes_ = 0;          // P05-30
};

} // namespace tool
