// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Settles on a real ZLAC8015D what its manual leaves open: each step brings it into a state in which the readings show
// which way it follows. Both wheels must be free to turn. Registers that a step changes hold their old words at the end.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/device/zlac8015d/values.hpp>

#include "bench.hpp"
#include "findings.hpp"

namespace tool {

/// The drive is at rest, not enabled and without a fault.
class zlac8015d_probe {
  public:
    zlac8015d_probe(probe_bench& on, findings& found) : on_{&on}, found_{&found} {}

    void run() {
        note_old_words();
        if (left().shaft == shaft::alarm || status().right.shaft == shaft::alarm)
            return; // nothing shows then
        brake();
        fault_code();
        if (on_->may("The wheels are held, and turn at 5 r/min, some seconds at a time. They are lifted or "
                     "free to turn.")) {
            at_standstill();
            at_low_speed();
            in_torque_mode();
            after_a_silence();
            without_a_watchdog();
            one_wheel_at_fault();
        }
        stop();
        restore();
        what_is_saved();
        if (!on_->has_failed()) return;
        stop();
        if (!on_->is_back(servobus::zlac8015d::status_word.address)) return;
        stop();
        restore();
    }

  private:
    using u16 = std::uint16_t;
    using mode = servobus::zlac8015d::operating_mode;
    using control = servobus::zlac8015d::control_code;
    using shaft = servobus::zlac8015d::shaft_state;

    static constexpr int slow = 5;             // r/min
    static constexpr int turning = 2;          // r/min, from which on a wheel turns
    static constexpr u16 watchdog = 5000;      // ms, while nothing is asked of it
    static constexpr u16 short_watchdog = 300; // ms
    static constexpr u16 ramp = 200;           // ms
    static constexpr auto a_while = servobus::milliseconds(100);

    struct old_word {
        u16 address;
        u16 word;
    };

    void note_old_words() {
        namespace z = servobus::zlac8015d;
        for (const u16 address :
             {z::host_timeout.address, z::mode_of_operation.address, z::disable_option_code.address,
              z::quick_stop_option_code.address, z::max_motor_speed.address,
              z::left_acceleration_time.address, z::right_acceleration_time.address,
              z::left_deceleration_time.address, z::right_deceleration_time.address,
              z::left_target_speed.address, z::right_target_speed.address, z::left_target_torque.address,
              z::right_target_torque.address, z::left_brake.address, z::right_brake.address})
            old_.push_back({address, on_->read(address)});
        resolution_ = on_->read(z::speed_resolution.address);
        if (resolution_ == 0) resolution_ = 1;
    }
    void restore() {
        for (const old_word& o : old_) (void)on_->write(o.address, o.word);
    }

    void put_back(u16 address) {
        for (const old_word& o : old_) {
            if (o.address == address) (void)on_->write(o.address, o.word);
        }
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
    // Waits while the drive is asked, so that its watchdog does not act.
    template <class Condition> bool until(Condition is_so, int times = 50) {
        for (int i = 0; i < times && !on_->has_failed(); ++i) {
            if (is_so()) return true;
            on_->wait(a_while);
        }
        return false;
    }
    bool stands() {
        return until([&] { return left_speed() == 0 && right_speed() == 0; });
    }
    void keep_asking(int times) {
        for (int i = 0; i < times; ++i) {
            (void)left();
            on_->wait(a_while);
        }
    }
    // Not enabled, at standstill, targets 0. Also after a failure.
    void stop() {
        namespace z = servobus::zlac8015d;
        on_->write_safely(z::left_target_speed.address, 0);
        on_->write_safely(z::right_target_speed.address, 0);
        on_->write_safely(z::control_word.address, static_cast<u16>(control::stop));
        (void)stands();
    }
    // Enabled in velocity mode with targets 0.
    void enable(mode in = mode::velocity) {
        namespace z = servobus::zlac8015d;
        stop();
        (void)on_->write(z::host_timeout.address, watchdog);
        (void)on_->write(z::left_target_torque.address, 0);
        (void)on_->write(z::right_target_torque.address, 0);
        (void)on_->write(z::mode_of_operation.address, static_cast<u16>(in));
        for (const u16 address : {z::left_acceleration_time.address, z::right_acceleration_time.address,
                                  z::left_deceleration_time.address, z::right_deceleration_time.address})
            (void)on_->write(address, ramp);
        command(control::enable);
        on_->wait(a_while);
    }
    bool turns_slowly() {
        set_targets(slow, slow);
        return until([&] { return left_speed() >= turning && right_speed() >= turning; });
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
        if (!on_->has_failed() && has_fault && is_over)
            found_->set("code", has_code ? "until_restart" : "until_reset");
        put_back(z::max_motor_speed.address);
    }

    // Bits 0 and 8 of a drive that holds its wheels; then the shaft's bits after a quick stop.
    void at_standstill() {
        enable();
        is_running_at_rest_ = left().is_running;
        command(control::quick_stop);
        on_->wait(a_while);
        const shaft after = left().shaft;
        if (!on_->has_failed() && (after == shaft::emergency_stop || after == shaft::locked))
            found_->set("after_quick_stop", after == shaft::emergency_stop ? "emergency" : "locked");
        command(control::stop);
    }

    // The shaft's bits of a wheel that turns; then the running bit of one that rolls without power.
    void at_low_speed() {
        namespace z = servobus::zlac8015d;
        (void)on_->write(z::disable_option_code.address, 0); // 07h lets the wheels roll
        enable();
        if (!turns_slowly()) return stop();
        const servobus::zlac8015d::axis_status driven = left();
        if (!on_->has_failed())
            found_->set("while_turning", driven.shaft == shaft::released ? "released" : "locked");
        command(control::stop);
        const servobus::zlac8015d::axis_status rolling = left();
        const bool rolls = left_speed() >= 1; // read later than the bit, so it did roll then
        if (!on_->has_failed() && is_running_at_rest_)
            found_->set("bit", "enabled");
        else if (!on_->has_failed() && driven.is_running && rolls)
            found_->set("bit", rolling.is_running ? "turns" : "driven");
        stop();
        put_back(z::disable_option_code.address);
    }

    // The shaft's bits where nothing holds a position: torque 0.
    void in_torque_mode() {
        enable(mode::torque);
        const shaft found = left().shaft;
        if (!on_->has_failed() && (found == shaft::released || found == shaft::locked))
            found_->set("in_torque_mode", found == shaft::released ? "released" : "locked");
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
        if (!on_->has_failed() && has_stopped)
            found_->set("resumes_after_watchdog", turns_again ? "yes" : "no");
        stop();
    }

    // With a time of 0 the wheels turn, or they do not.
    void without_a_watchdog() {
        namespace z = servobus::zlac8015d;
        enable();
        const bool is_taken = on_->write(z::host_timeout.address, 0);
        const bool turn = turns_slowly();
        if (!on_->has_failed() && is_taken) found_->set("host_timeout", turn ? "off" : "stops");
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
        if (!on_->has_failed() && has_fault)
            found_->set("by_fault", right_turns ? "its_wheel" : "both_wheels");
        stop();
        command(control::fault_reset);
        (void)until([&] { return left().shaft != shaft::alarm; }, 5);
        put_back(z::max_motor_speed.address);
    }

    // Both are released for what follows, if it is known how.
    void brake() {
        namespace z = servobus::zlac8015d;
        if (!on_->may("The outputs of the brakes, B0 and B1, are switched. The machine cannot roll away."))
            return;
        (void)on_->write(z::left_brake.address, 1);
        const seen is_closed =
            on_->ask("Is the brake of the left wheel closed now? It was switched to 1 (? if there is none)");
        if (is_closed != seen::unknown)
            found_->set("code_1", is_closed == seen::yes ? "engages" : "releases");
        const u16 released = is_closed == seen::no ? 1 : 0;
        (void)on_->write(z::left_brake.address, released);
        (void)on_->write(z::right_brake.address, released);
    }

    // A row that is not marked: kept over a power cycle or not. It costs a save, and another one if it was kept.
    void what_is_saved() {
        namespace z = servobus::zlac8015d;
        const u16 address = z::left_acceleration_time.address;
        const u16 old = on_->read(address);
        const u16 other = old == 700 ? 800 : 700;
        (void)on_->write(z::mode_of_operation.address, 0); // else the mode may be saved too [errata B11]
        (void)on_->write(address, other);
        (void)on_->write(z::save_parameters.address, 1);
        if (!on_->switch_off_and_on()) {
            (void)on_->write(address, old);
            return;
        }
        const bool is_kept = on_->read(address) == other;
        if (!on_->has_failed()) found_->set("save", is_kept ? "all" : "marked");
        (void)on_->write(address, old);
        if (is_kept) (void)on_->write(z::save_parameters.address, 1);
        restore();
    }

    probe_bench* on_;
    findings* found_;
    std::vector<old_word> old_{};
    int resolution_ = 1;
    bool is_running_at_rest_ = false;
};

} // namespace tool
