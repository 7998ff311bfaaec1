// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real C630S what its manual leaves open: first what shows at rest, then what a power cycle shows, then
// what shows while it is enabled by a virtual input. A terminal of S-ON takes effect at power-on [errata C15], so the
// person switches the drive off and on twice: with the probe's terminals, and with the owner's again. The shaft must be
// free to turn. Registers that a step changes hold their old words at the end, also in the EEPROM.
#pragma once

#include <cstdint>
#include <optional>
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

    // --- At rest, without consent

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
