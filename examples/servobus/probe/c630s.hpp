// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real C630S what its manual leaves open: first what shows at rest, then what a power cycle shows, then what
// shows while it is enabled by a virtual input. A terminal of S-ON takes effect at power-on [errata C15], so the person
// switches the drive off and on twice: with the probe's terminals, and with the owner's again. The shaft must be free to turn.
// Registers that a step changes hold their old words at the end, also in the EEPROM.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <servobus/device/c630s/registers.hpp>

#include "bench.hpp"
#include "findings.hpp"

namespace tool {

/// The drive is at rest, not enabled and without an alarm.
class c630s_probe {
  public:
    c630s_probe(probe_bench& on, findings& found) : on_{&on}, found_{&found} {}

    void run() {
        namespace c = servobus::c630s;
        is_low_first_ = on_->read(c::pair_word_order.address) != 0;
        if (on_->read(c::servo_status.address) == in_fault) return; // nothing shows then
        keeps_ = on_->read(c::eeprom_update.address);
        if (on_->has_failed()) return;
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
    using u16 = std::uint16_t;
    using in = servobus::c630s::input_function;
    using out = servobus::c630s::output_function;

    static constexpr u16 in_fault = 3; // P30-00, an assumption: only a drive that does not say so is probed
    static constexpr u16 slow = 10;    // r/min
    static constexpr u16 twice = 2 * slow; // r/min
    static constexpr auto a_while = servobus::milliseconds(50);
    // The virtual inputs that the probe uses, and the outputs.
    static constexpr u16 servo_on = 1u << 0, starts = 1u << 1, jogs = 1u << 2, marker = 1u << 15;
    static constexpr unsigned brake_out = 12, home_out = 13, ready_out = 14, again_out = 15;

    struct old_word {
        u16 address;
        u16 word;
    };
    struct old_pair {
        u16 address;
        std::array<u16, 2> words;
    };

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
        for (const old_word& o : old_) {
            if (o.address == address) return on_->write(address, word);
        }
        const u16 before = on_->read(address);
        if (!on_->has_failed()) old_.push_back({address, before});
        return on_->write(address, word);
    }
    bool set(const auto& row, auto value) requires requires { row.address; }
    { return set(row.address, static_cast<u16>(value)); }
    bool set_pair(const auto& row, std::int32_t value) {
        bool is_noted = false;
        for (const old_pair& o : old_pairs_) is_noted = is_noted || o.address == row.address;
        const std::array<u16, 2> before = on_->read_pair(row.address);
        if (!is_noted && !on_->has_failed()) old_pairs_.push_back({row.address, before});
        const auto high = static_cast<u16>(static_cast<std::uint32_t>(value) >> 16);
        const auto low = static_cast<u16>(static_cast<std::uint32_t>(value) & 0xFFFFu);
        return on_->write_pair(row.address, is_low_first_ ? std::array{low, high} : std::array{high, low});
    }
    std::int32_t read_pair(const auto& row) {
        const std::array<u16, 2> words = on_->read_pair(row.address);
        const std::uint32_t high = words[is_low_first_ ? 1 : 0], low = words[is_low_first_ ? 0 : 1];
        return static_cast<std::int32_t>(high << 16 | low);
    }
    // In reverse, so that no function is on two terminals.
    void restore() {
        for (auto o = old_.rbegin(); o != old_.rend(); ++o) (void)on_->write(o->address, o->word);
        for (const old_pair& o : old_pairs_) (void)on_->write_pair(o.address, o.words);
    }
    // Whether what is written is kept over a power cycle.
    void keep(bool is_so) { (void)on_->write(servobus::c630s::eeprom_update.address, is_so ? 1 : 0); }

    // --- What the steps are made of

    bool shows(unsigned output) {
        return (on_->read(servobus::c630s::virtual_output_levels.address) >> output & 1u) != 0;
    }
    // On a virtual output or, where only the first of several shows it, on a wired one.
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
    template <class Condition> bool until(Condition is_so, int times = 100) {
        for (int i = 0; i < times && !on_->has_failed(); ++i) {
            if (is_so()) return true;
            on_->wait(a_while);
        }
        return false;
    }
    bool stands() {
        return until([&] { return speed() == 0; });
    }
    void make_safe() {
        on_->write_safely(servobus::c630s::virtual_input_levels.address, 0);
        on_->write_safely(servobus::c630s::emergency_stop.address, 0);
        (void)stands();
    }
    // Not enabled, at standstill.
    void servo_off() {
        inputs(0);
        (void)stands();
        on_->wait(servobus::milliseconds(1500)); // the brake closes, the power goes
    }
    void reset_alarm() {
        (void)on_->write(servobus::c630s::alarm_reset.address, 0); // a drive that keeps it takes 1 once
        (void)on_->write(servobus::c630s::alarm_reset.address, 1);
        on_->wait(a_while);
        (void)on_->write(servobus::c630s::alarm_reset.address, 0);
    }
    void found(const char* name, bool is_so) {
        if (!on_->has_failed()) found_->set(name, is_so ? "yes" : "no");
    }
    void found(const char* name, const char* way) {
        if (!on_->has_failed()) found_->set(name, way);
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

    // --- At rest, without power and without a motion

    void at_rest() {
        namespace c = servobus::c630s;
        response_to_10h();
        own_delay();
        (void)on_->write(c::alarm_reset.address, 1);
        on_->wait(a_while);
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
    // P0C-25 is read with its smallest value and with 100 ms. Only a drive that needs time of its own tells.
    void own_delay() {
        namespace c = servobus::c630s;
        const auto time_of_read = [&] {
            const servobus::instant begun = on_->now();
            (void)read(c::response_delay);
            return since(begun, on_->now());
        };
        set(c::response_delay, 0);
        (void)time_of_read();
        const servobus::duration own = time_of_read();
        set(c::response_delay, 100);
        (void)time_of_read();
        const servobus::duration both = time_of_read();
        restore();
        const bool is_told = own > servobus::milliseconds(15);
        if (is_told)
            found("delay_is_additional", both > servobus::milliseconds(100) + servobus::duration{own.us / 2});
    }
    // Two outputs show "servo ready", or a wired one and a virtual one do: the last of them shows it, or it does not.
    void same_output_twice() {
        namespace c = servobus::c630s;
        set(c::virtual_outputs_enable, 1);
        set(address_of_output(ready_out), static_cast<u16>(out::servo_ready));
        set(address_of_output(again_out), static_cast<u16>(out::servo_ready));
        set(static_cast<u16>(address_of_output(ready_out) + 1), 0); // not inverted
        set(static_cast<u16>(address_of_output(again_out) + 1), 0);
        on_->wait(a_while);
        found("first_output_shows", !shows(again_out));
        restore();
    }
    // Er.130: disabled virtual inputs first, then enabled ones. The alarm's record shows the voltage, and what is left of it.
    void same_input_twice() {
        namespace c = servobus::c630s;
        constexpr in harmless = in::gain_selection;
        if (is_assigned(harmless)) return;
        set(c::selected_fault_record, 0);
        set(c::virtual_inputs_enable, 0);
        set(address_of_function(13), static_cast<u16>(harmless));
        set(address_of_function(14), static_cast<u16>(harmless));
        on_->wait(a_while);
        const bool counts_disabled = read(c::recorded_alarm) == 0x130 && read(c::servo_status) == in_fault;
        found("disabled_inputs_count", counts_disabled);
        set(c::virtual_inputs_enable, 1);
        on_->wait(a_while);
        const bool is_raised = read(c::recorded_alarm) == 0x130 && read(c::servo_status) == in_fault;
        const u16 recorded = read(c::recorded_bus_voltage), present = read(c::bus_voltage);
        set(address_of_function(14), 0);
        set(address_of_function(13), 0);
        on_->wait(a_while);
        reset_alarm();
        if (is_raised && present > 100) {
            if (recorded > present / 2) found("bus_voltage_in_volts", false);
            if (recorded < present / 5 && recorded > present / 20) found("bus_voltage_in_volts", true);
        }
        if (is_raised && read(c::servo_status) != in_fault)
            found("shows_last_alarm", read(c::recorded_alarm) == 0x130);
        restore();
    }

    // --- A power cycle

    // S-ON becomes the first virtual input, and what may survive a power cycle is stored.
    void prepare() {
        namespace c = servobus::c630s;
        old_.clear();
        old_pairs_.clear();
        has_stored_ = true;
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
        on_->wait(a_while);
        place_ = read_pair(c::absolute_position);
        set_pair(c::home_offset, 3000);
        inputs(marker);
        keep(false); // stored, or not
    }
    void after_power_cycle() {
        namespace c = servobus::c630s;
        found("stores_eeprom_off", read(c::eeprom_update) == 0);
        keep(false);
        const bool keeps_levels = (read(c::virtual_input_levels) & marker) != 0;
        const std::int32_t place = read_pair(c::absolute_position);
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

    // --- Enabled

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
        on_->wait(a_while);
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
        if (!until([&] { return speed() >= slow - 2; })) return servo_off();
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
        if (!until([&] { return speed() == 0 || read(c::emergency_stop) == 0; })) return;
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
        on_->wait(a_while);
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
        on_->wait(a_while);
        inputs(servo_on);
    }
    // By an edge, or not; then by a level.
    void segment_start() {
        namespace c = servobus::c630s;
        const std::int32_t before = read_pair(c::feedback_pulses);
        const auto has_moved = [&] { return read_pair(c::feedback_pulses) - before > 200; };
        start();
        if (until(has_moved, 40)) return found("segment_start_is_level", false);
        inputs(0);
        (void)stands();
        on_->wait(servobus::milliseconds(1500));
        set(static_cast<u16>(address_of_function(1) + 1), 0); // a level
        on_->wait(a_while);
        inputs(servo_on);
        on_->wait(servobus::milliseconds(1000));
        start();
        if (until(has_moved, 40)) found("segment_start_is_level", true);
    }
    // A long displacement says how many counts of the encoder a unit has; many short ones, whether their rest is kept.
    void rest_of_a_displacement() {
        namespace c = servobus::c630s;
        constexpr std::int32_t many = 1000, enough = 20, most = 250;
        (void)stands();
        const std::int32_t whole = counts_of(many, 1);
        const std::int32_t unit = whole / many; // whole counts of a unit
        const std::int32_t rest = whole - unit * many;
        if (unit < 2 || rest * most < enough * many) return; // too little is cut
        const std::int32_t few = enough * many / rest + 1;
        const std::int32_t sum = counts_of(1, few);
        const auto kept = static_cast<std::int32_t>(std::int64_t{whole} * few / many);
        const auto is_near = [&](std::int32_t to) {
            return sum >= to - enough / 4 && sum <= to + enough / 4;
        };
        if (is_near(unit * few)) found("gear_keeps_rest", false);
        if (is_near(kept)) found("gear_keeps_rest", true);
    }
    // What these starts turn in all.
    std::int32_t counts_of(std::int32_t displacement, int times) {
        namespace c = servobus::c630s;
        set_pair(c::position_segment_displacements[0], displacement);
        const std::int32_t before = read_pair(c::feedback_pulses);
        for (int i = 0; i < times && !on_->has_failed(); ++i) {
            start();
            on_->wait(a_while);
            (void)stands();
        }
        std::int32_t last = before;
        (void)until([&] {
            const std::int32_t now = read_pair(c::feedback_pulses);
            const bool is_still = now == last && now != before;
            last = now;
            return is_still;
        });
        return last - before;
    }
    void jog() {
        namespace c = servobus::c630s;
        set(c::jog_speed, slow);
        set(c::target_speed, twice);
        inputs(servo_on | jogs);
        if (until([&] { return speed() >= slow - 2; })) {
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
            if (has_stored_) keep(true);
            restore();
            (void)on_->write(c::homing_control.address, 0);
            inputs(0);
            keep(true); // a 0 may have been stored, and a 1 is while it is 1
            (void)on_->write(c::eeprom_update.address, keeps_);
            if (!on_->has_failed()) return;
        }
    }

    probe_bench* on_;
    findings* found_;
    std::vector<old_word> old_{};
    std::vector<old_pair> old_pairs_{};
    std::int32_t place_ = 0; // as home was set before the power cycle
    u16 keeps_ = 1;          // P0C-13
    bool has_stored_ = false;
    bool is_low_first_ = false;
};

} // namespace tool
