// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real ZLAC8015D what its manual leaves open: each step brings it into a state in which the readings show
// which way it follows. Both wheels must be free to turn. Registers that a step changes hold their old words at the
// end.
#pragma once

#include <cstdint>
#include <string>

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/device/zlac8015d/values.hpp>

#include "probe_steps.hpp"

namespace tool {

/// The drive is at rest, not enabled and without a fault.
class zlac8015d_probe : probe_steps {
  public:
    zlac8015d_probe(probe_bench& on, findings& found) : probe_steps{on, found, servobus::milliseconds(100)} {}

    void run() {
        note_old_words();
        if (is_in_alarm()) return on_->give_up("a wheel is in alarm: reset its fault, and probe again");
        brake();
        fault_code();
        option_code();
        if (on_->may("The wheels are held, and turn at 5 r/min, some seconds at a time. They are lifted or "
                     "free to turn.")) {
            resolution_in_force();
            at_standstill();
            at_low_speed();
            in_torque_mode();
            after_a_silence();
            without_a_watchdog();
            one_wheel_at_fault();
            without_a_mode();
            with_changing_targets();
            with_another_resolution();
            in_position_mode();
        }
        stop();
        old_.restore();
        what_is_saved();
        if (!on_->has_failed()) return;
        stop();
        if (!on_->is_back(servobus::zlac8015d::status_word.address)) return;
        stop();
        end_alarm();
        save_again();
        old_.restore();
    }

  private:
    using mode = servobus::zlac8015d::operating_mode;
    using control = servobus::zlac8015d::control_code;
    using shaft = servobus::zlac8015d::shaft_state;

    static constexpr int slow = 5;                 // r/min
    static constexpr int turning = 2;              // r/min, from which on a wheel turns
    static constexpr u16 watchdog = 5000;          // ms, while nothing is asked of it
    static constexpr u16 short_watchdog = 300;     // ms
    static constexpr u16 ramp = 200;               // ms
    static constexpr u16 long_ramp = 2000;         // ms
    static constexpr std::int32_t distance = 1000; // counts of a move; a tenth shows that a wheel moves
    static constexpr int most = 50;                // readings

    void note_old_words() {
        namespace z = servobus::zlac8015d;
        for (const u16 address : {z::host_timeout.address,
                                  z::mode_of_operation.address,
                                  z::disable_option_code.address,
                                  z::quick_stop_option_code.address,
                                  z::max_motor_speed.address,
                                  z::left_acceleration_time.address,
                                  z::right_acceleration_time.address,
                                  z::left_deceleration_time.address,
                                  z::right_deceleration_time.address,
                                  z::left_target_speed.address,
                                  z::right_target_speed.address,
                                  z::left_target_torque.address,
                                  z::right_target_torque.address,
                                  z::left_brake.address,
                                  z::right_brake.address,
                                  z::halt_option_code.address,
                                  z::position_synchronisation.address,
                                  z::speed_resolution.address,
                                  z::left_max_speed.address,
                                  z::right_max_speed.address})
            old_.note(address);
        old_.note_pair(z::left_target_position.address);
        old_.note_pair(z::right_target_position.address);
        resolution_ = on_->read(z::speed_resolution.address);
        if (resolution_ == 0) resolution_ = 1;
        const u16 lines = on_->read(z::left_encoder_lines.address);
        turn_ = 4 * (lines == 0 ? 1024 : lines);
    }
    // --- What the steps are made of

    void command(control c) {
        (void)on_->write(servobus::zlac8015d::control_word.address, static_cast<u16>(c));
    }
    void set_targets(int left, int right) {
        (void)on_->write(servobus::zlac8015d::left_target_speed.address,
                         static_cast<u16>(left * resolution_));
        (void)on_->write(servobus::zlac8015d::right_target_speed.address,
                         static_cast<u16>(right * resolution_));
    }
    servobus::zlac8015d::axis_status left() { return status().left; }
    servobus::zlac8015d::status_flags status() {
        return servobus::zlac8015d::status_flags::from_word(
            on_->read(servobus::zlac8015d::status_word.address));
    }
    // Whole r/min, without a sign.
    int speed_of(u16 address) {
        const int tenths = static_cast<std::int16_t>(on_->read(address));
        return (tenths < 0 ? -tenths : tenths) / 10;
    }
    int left_speed() { return speed_of(servobus::zlac8015d::left_actual_speed.address); }
    int right_speed() { return speed_of(servobus::zlac8015d::right_actual_speed.address); }
    bool stands() {
        return until([&] { return left_speed() == 0 && right_speed() == 0; }, most);
    }
    // The end of an S-shaped ramp reads as 0 already, and a mode is not taken before the wheels stand.
    void come_to_rest() {
        (void)stands();
        wait();
    }
    void keep_asking(int times) {
        for (int i = 0; i < times; ++i) {
            (void)left();
            wait();
        }
    }
    bool is_in_alarm() { return left().shaft == shaft::alarm || status().right.shaft == shaft::alarm; }
    // That of a step which did not come to its end.
    void end_alarm() {
        if (is_in_alarm()) command(control::fault_reset);
        (void)until([&] { return !is_in_alarm(); }, 5);
    }
    // Not enabled, at standstill, targets 0. Also after a failure.
    void stop() {
        namespace z = servobus::zlac8015d;
        on_->write_safely(z::left_target_speed.address, 0);
        on_->write_safely(z::right_target_speed.address, 0);
        on_->write_safely(z::control_word.address, static_cast<u16>(control::stop));
        come_to_rest();
    }
    // Enabled in velocity mode with targets 0.
    void enable(mode in = mode::velocity) {
        namespace z = servobus::zlac8015d;
        stop();
        (void)on_->write(z::host_timeout.address, watchdog);
        (void)on_->write(z::left_target_torque.address, 0);
        (void)on_->write(z::right_target_torque.address, 0);
        (void)on_->write(z::mode_of_operation.address, static_cast<u16>(in));
        speed_up_in(ramp);
        (void)on_->write(z::left_deceleration_time.address, ramp);
        (void)on_->write(z::right_deceleration_time.address, ramp);
        command(control::enable);
        wait();
    }
    void speed_up_in(u16 time) {
        namespace z = servobus::zlac8015d;
        (void)on_->write(z::left_acceleration_time.address, time);
        (void)on_->write(z::right_acceleration_time.address, time);
    }
    // In 0.001 r/min, by the way of the left wheel in two seconds. 0 if it hardly turns, or the drive is lost.
    std::int64_t speed_at(int counts) {
        namespace z = servobus::zlac8015d;
        enable();
        (void)on_->write(z::left_target_speed.address, static_cast<u16>(counts));
        keep_asking(10); // the ramp
        const servobus::instant begun = on_->now();
        const std::int64_t from = read_number(z::left_actual_position.address);
        keep_asking(20);
        const std::int64_t way = read_number(z::left_actual_position.address) - from;
        const std::int64_t took = servobus::since(begun, on_->now()).us;
        stop();
        const std::int64_t counted = way < 0 ? -way : way;
        constexpr std::int64_t least = 20; // counts: a wheel at rest trembles
        return on_->has_failed() || counted < least || took == 0 ? 0
                                                                 : counted * 60'000'000 / turn_ * 1000 / took;
    }
    bool turns_slowly() {
        set_targets(slow, slow);
        return until([&] { return left_speed() >= turning && right_speed() >= turning; }, most);
    }

    // --- The steps

    // A target above 2008h is the fault 2000h of a drive that is not enabled too, or it is not, and then nothing shows.
    void fault_code() {
        namespace z = servobus::zlac8015d;
        (void)on_->write(z::mode_of_operation.address, static_cast<u16>(mode::velocity));
        (void)on_->write(z::max_motor_speed.address, 1);
        (void)on_->write(z::left_target_speed.address, static_cast<u16>(slow * resolution_));
        const bool has_fault = until([&] { return left().shaft == shaft::alarm; }, 5);
        (void)on_->write(z::left_target_speed.address, 0);
        command(control::fault_reset);
        const bool is_over = until([&] { return left().shaft != shaft::alarm; }, 5);
        const bool has_code = on_->read(z::left_faults.address) != 0;
        if (has_fault && is_over) found("code", has_code ? "until_restart" : "until_reset");
        old_.put_back(z::max_motor_speed.address);
    }

    // 2022h counts from a power-on. A few counts are slow whatever they are worth.
    void resolution_in_force() {
        const std::int64_t meant = 1000 * slow / resolution_;
        const std::int64_t speed = speed_at(slow);
        if (speed == 0 || (2 * speed < 3 * meant && 3 * speed > 2 * meant)) return;
        on_->give_up("speed_resolution is " + std::to_string(resolution_) +
                     ", and the wheels turn as with another: switch the drive off and on, and probe again");
    }
    // Another 2022h, which is not saved: the same counts are worth something else, or not.
    void with_another_resolution() {
        namespace z = servobus::zlac8015d;
        const bool is_coarse = resolution_ <= 5;
        const int other = is_coarse ? 2 * resolution_ : resolution_ / 2;
        stop();
        (void)on_->write(z::speed_resolution.address, static_cast<u16>(other));
        const std::int64_t speed = speed_at(slow * (is_coarse ? resolution_ : other));
        const bool is_whole = 4 * speed > 3 * 1000 * slow; // or half as fast
        if (speed != 0) found("rescales_immediately", is_whole != is_coarse);
        old_.put_back(z::speed_resolution.address);
    }

    // Bits 0 and 8 of a drive that holds its wheels; then the shaft's bits after a quick stop.
    void at_standstill() {
        enable();
        is_running_at_rest_ = left().is_running;
        command(control::quick_stop);
        wait();
        const shaft after = left().shaft;
        if (after == shaft::emergency_stop || after == shaft::locked)
            found("after_quick_stop", after == shaft::emergency_stop ? "emergency" : "locked");
        stop();
        const shaft idle = left().shaft;
        if (idle == shaft::emergency_stop || idle == shaft::released)
            found("idle_shaft", idle == shaft::emergency_stop ? "emergency" : "released");
    }

    // The shaft's bits of a wheel that turns; then the running bit of one that rolls without power.
    void at_low_speed() {
        namespace z = servobus::zlac8015d;
        (void)on_->write(z::disable_option_code.address, 0); // 07h lets the wheels roll
        enable();
        if (!turns_slowly()) return stop();
        const servobus::zlac8015d::axis_status driven = left();
        found("while_turning", driven.shaft == shaft::released ? "released" : "locked");
        command(control::stop);
        const servobus::zlac8015d::axis_status rolling = left();
        const bool rolls = left_speed() >= 1; // read later than the bit, so it did roll then
        if (is_running_at_rest_)
            found("bit", "enabled");
        else if (driven.is_running && rolls)
            found("bit", rolling.is_running ? "turns" : "driven");
        stop();
        old_.put_back(z::disable_option_code.address);
    }

    // The shaft's bits where nothing holds a position: torque 0.
    void in_torque_mode() {
        enable(mode::torque);
        const shaft now = left().shaft;
        if (now == shaft::released || now == shaft::locked)
            found("in_torque_mode", now == shaft::released ? "released" : "locked");
        stop();
    }

    // The wheels turn, nothing is asked for longer than the watchdog's time, and then it is asked again.
    void after_a_silence() {
        namespace z = servobus::zlac8015d;
        enable();
        if (!turns_slowly()) return stop();
        (void)on_->write(z::host_timeout.address, short_watchdog);
        on_->wait(servobus::milliseconds(2000));
        const bool has_stopped = left_speed() < turning;
        const bool turns_again = until([&] { return left_speed() >= turning; }, 20);
        if (has_stopped) found("resumes_after_watchdog", turns_again ? "yes" : "no");
        stop();
    }

    // With a time of 0 the wheels turn, or they do not.
    void without_a_watchdog() {
        namespace z = servobus::zlac8015d;
        enable();
        const bool is_taken = on_->write(z::host_timeout.address, 0);
        const bool turn = turns_slowly();
        if (is_taken) found("host_timeout", turn ? "off" : "stops");
        (void)on_->write(z::host_timeout.address, watchdog);
        stop();
    }

    // A target of the left wheel above 2008h, which is low; the right one turns below it.
    void one_wheel_at_fault() {
        namespace z = servobus::zlac8015d;
        (void)on_->write(z::max_motor_speed.address, slow + 1);
        enable();
        if (!turns_slowly()) return stop();
        (void)on_->write(z::left_target_speed.address, static_cast<u16>(2 * slow * resolution_));
        const bool has_fault = until([&] { return left().shaft == shaft::alarm; }, 5);
        keep_asking(30);
        const bool right_turns = right_speed() >= turning;
        if (has_fault) found("by_fault", right_turns ? "its_wheel" : "both_wheels");
        stop();
        command(control::fault_reset);
        (void)until([&] { return left().shaft != shaft::alarm; }, 5);
        old_.put_back(z::max_motor_speed.address);
    }

    // 2014h, on which nothing depends, takes a word that the manual does not print, or refuses it.
    void option_code() {
        namespace z = servobus::zlac8015d;
        const bool is_taken = on_->write(z::halt_option_code.address, 500);
        const bool is_held = on_->read(z::halt_option_code.address) == 500;
        if (is_taken == is_held) found("checks_option_codes", is_taken ? "no" : "yes");
        old_.put_back(z::halt_option_code.address);
    }

    // Enabled first, and then in velocity mode: the wheels turn, or they do not.
    void without_a_mode() {
        namespace z = servobus::zlac8015d;
        stop();
        (void)on_->write(z::mode_of_operation.address, 0);
        command(control::enable);
        wait();
        (void)on_->write(z::mode_of_operation.address, static_cast<u16>(mode::velocity));
        const bool turn = turns_slowly();
        const bool has_mode = on_->read(z::mode_of_operation.address) == static_cast<u16>(mode::velocity);
        if (turn || has_mode) found("enables_without_mode", turn ? "yes" : "no");
        stop();
    }

    // Two targets in turn, for as long as a ramp takes: its speed is reached, or it begins anew each time.
    void with_changing_targets() {
        enable();
        speed_up_in(long_ramp); // and slow down in the short one, if the line is lost now
        for (int i = 0; i < 20; ++i) {
            set_targets(slow + i % 2, slow + i % 2);
            wait();
        }
        const bool is_reached = left_speed() >= turning;
        const bool turns = until([&] { return left_speed() >= turning; }, most);
        if (turns) found("speed_ramp", is_reached ? "linear" : "begins_anew");
        stop();
    }

    // A move of both wheels by 10h while 200Fh is 0; else of the left one by 11h. What the speeds show of it.
    void in_position_mode() {
        namespace z = servobus::zlac8015d;
        stop();
        (void)on_->write(z::position_synchronisation.address, 0);
        (void)on_->write(z::left_max_speed.address, slow);
        (void)on_->write(z::right_max_speed.address, slow);
        enable(mode::relative_position);
        (void)write_number(z::left_target_position.address, distance);
        (void)write_number(z::right_target_position.address, distance);
        const std::int32_t left_from = read_number(z::left_actual_position.address);
        const std::int32_t right_from = read_number(z::right_actual_position.address);
        const auto has_moved = [&](u16 address, std::int32_t from) {
            const std::int32_t gone = read_number(address) - from;
            return gone > distance / 10 || gone < -distance / 10;
        };
        bool shows_speed = false;
        const auto left_moves = [&] {
            shows_speed = shows_speed || left_speed() >= turning;
            return has_moved(z::left_actual_position.address, left_from);
        };
        command(control::start_both);
        const bool starts_both =
            until(left_moves, 15) && has_moved(z::right_actual_position.address, right_from);
        if (!starts_both) command(control::start_left);
        if (until(left_moves, 15)) {
            found("position_start", starts_both ? "any" : "by_200F");
            found("shows_speed_of_moves", shows_speed ? "yes" : "no");
        }
        stop();
        keep_asking(10); // the speeds may not show whether the wheels stand
    }

    // Both are released for what follows, if it is known how.
    void brake() {
        namespace z = servobus::zlac8015d;
        if (!on_->may("The outputs of the brakes, B0 and B1, are switched. The machine cannot roll away."))
            return;
        (void)on_->write(z::left_brake.address, 1);
        const seen is_closed =
            on_->ask("Is the brake of the left wheel closed now? It was switched to 1 (? if there is none)");
        if (is_closed != seen::unknown) found("code_1", is_closed == seen::yes ? "engages" : "releases");
        const u16 released = is_closed == seen::no ? 1 : 0;
        (void)on_->write(z::left_brake.address, released);
        (void)on_->write(z::right_brake.address, released);
    }

    // A row that is not marked: kept over a power cycle or not. It costs a save, and another one if it was kept.
    void what_is_saved() {
        namespace z = servobus::zlac8015d;
        const u16 time = z::left_acceleration_time.address;
        const u16 other = old_.word(time) == 700 ? 800 : 700;
        (void)on_->write(z::mode_of_operation.address, 0); // else the mode may be saved too [errata B11]
        (void)on_->write(time, other);
        on_->set_saved(!on_->has_failed());
        (void)on_->write(z::save_parameters.address, 1);
        if (!on_->switch_off_and_on()) return save_again();
        const bool is_kept = on_->read(time) == other;
        found("save", is_kept ? "all" : "marked");
        on_->set_saved(is_kept || on_->has_failed());
        save_again();
        old_.restore();
    }
    // The owner's time, where the other one may be in the EEPROM.
    void save_again() {
        namespace z = servobus::zlac8015d;
        old_.put_back(z::left_acceleration_time.address);
        if (!on_->has_saved()) return;
        (void)on_->write(z::mode_of_operation.address, 0);
        (void)on_->write(z::save_parameters.address, 1);
        on_->set_saved(on_->has_failed());
        old_.put_back(z::mode_of_operation.address);
    }

    int resolution_ = 1;
    std::int64_t turn_ = 4096; // counts of the left wheel
    bool is_running_at_rest_ = false;
};

} // namespace tool
