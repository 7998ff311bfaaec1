// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The scenes of a run of lives. Each brings the drive into a state, plans what happens to it, and goes on as a
// program would.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "life.hpp"

namespace trial {

class life_scenes : public life {
  public:
    using life::life;

    void any_scene() {
        end_plans();
        on().log->remark(now(), "-- a new scene");
        switch (on().random.below(16)) {
        case 0:
        case 1:
        case 2:
        case 3:
        case 4: return moves();
        case 5:
        case 6: return homes();
        case 7:
        case 8: return commands();
        case 9:
        case 10: return turns();
        case 11: return restarts_while_due();
        case 12: return is_away();
        case 13: return writes_a_register();
        case 14: return commands_in_time();
        default: return is_ill_before_init();
        }
    }
    /// The last scene is over.
    void end() {
        heal();
        (void)disabled();
    }

  private:
    // A move, and a wait for its end.
    void moves() {
        if (!enabled(false)) return;
        if (kind() == drive_kind::c630s) (void)carry(doing::setting);
        const bool is_disturbed = !on().one_in(4);
        if (is_disturbed && now() % 4 == 0)
            restarts_near_zero_ = true;
        else if (is_disturbed)
            plan_any(900'000);
        if (!on().one_in(3)) (void)carry(doing::move); // else the one before
        if (on().one_in(8)) poll(on().random.below(300'000));
        if (of_.has_goal() || on().one_in(8))
            (void)carry(on().one_in(3) ? doing::standstill : doing::arrival);
        poll(on().random.below(400'000));
        if (on().one_in(4)) (void)carry(on().one_in(2) ? doing::standstill : doing::arrival);
    }
    void homes() {
        if (!enabled(false)) return;
        if (kind() == drive_kind::yako && !of_.can(doing::homing)) (void)carry(doing::setting);
        if (!of_.can(doing::homing)) return;
        if (!on().one_in(4)) plan_any(on().one_in(2) ? 400'000 : 2'500'000);
        (void)carry(doing::homing);
        poll(on().random.below(700'000));
    }
    // A command that something happens to from its first frame on.
    void commands() {
        static constexpr doing kinds[] = {doing::init, doing::enable,  doing::stop,    doing::save,
                                          doing::move, doing::setting, doing::reading, doing::nothing};
        const doing what = kinds[on().random.below(8)];
        const bool is_at_rest = what == doing::enable || what == doing::save;
        if (is_at_rest ? !disabled() : !enabled(false)) return;
        if (what == doing::stop && on().one_in(2)) (void)carry(doing::move);
        if (on().one_in(3))
            plan_any(on().one_in(2) ? 30'000 : 120'000);
        else
            plan_restart_at_frame(frames_of(what));
        if (what == doing::nothing)
            poll(200'000);
        else
            (void)carry(what);
        poll(on().random.below(900'000));
    }
    // About as many as the longest of the three drives' commands sends.
    static std::uint32_t frames_of(doing what) {
        switch (what) {
        case doing::init: return 16;
        case doing::enable: return 30;
        case doing::stop: return 6;
        case doing::save: return 12;
        case doing::move:
        case doing::setting: return 10;
        case doing::reading: return 4;
        default: return 2;
        }
    }
    // A motion without an end, of which the program reads the position.
    void turns() {
        if (!enabled(true) || !carry_setpoint()) return;
        poll(on().between(200'000, 900'000));
        if (on().one_in(3)) plan_loss(500'000);
        if (!on().one_in(3)) plan_restart(500'000);
        const std::uint64_t end = now() + on().between(700'000, 5'000'000);
        const bool is_commanding = kind() != drive_kind::yako && on().one_in(2);
        std::uint64_t next = now();
        while (now() < end && of_.says_enabled()) {
            if (is_commanding && of_.is_idle() && now() >= next) {
                next = now() + 50'000;
                if (!carry_setpoint()) break;
            }
            turn();
        }
        if (!of_.needs_init()) (void)carry(doing::stop);
    }
    // A request gets no response, so that the witness is due; before it is read the drive restarts.
    void restarts_while_due() {
        const bool is_turning = on().one_in(2);
        if (!enabled(is_turning) || (is_turning && !carry_setpoint())) return;
        poll(on().random.below(100'000));
        judge_.disturbed();
        device().lose_next(on().one_in(2));
        const std::uint64_t end = now() + 1'000'000;
        while (!in_.court().is_troubled() && now() < end) turn();
        if (now() >= end) return device().lose_nothing();
        restart(on().one_in(2) ? 0 : boot_time(), true);
        static constexpr doing kinds[] = {doing::stop, doing::stop, doing::move, doing::reading,
                                          doing::nothing};
        const doing what = kinds[on().random.below(5)];
        if (what != doing::nothing && of_.can(what)) (void)carry(what);
        if (on().one_in(2) && !of_.needs_init() && !of_.says_enabled()) (void)carry(doing::enable);
        poll(on().random.below(2'500'000));
    }

    // The drive is away for a time, with its power on: its plug is out.
    void is_away() {
        const bool is_turning = on().one_in(2);
        if (!enabled(is_turning) || (is_turning && !carry_setpoint())) return;
        const std::uint32_t off = on().between(300'000, 4'500'000);
        constexpr std::uint32_t surely_missed = 2'600'000;
        judge_.disturbed();
        on().strikes(strike::absent_drive);
        device().be_off(now() + off);
        if (off > surely_missed) ++count().outages[kind_index()];
        const std::uint64_t gone = now();
        const bool was_polled = of_.oldest().us < 400'000 || kind() == drive_kind::c630s;
        while (device().is_off()) {
            if (is_turning && kind() != drive_kind::yako && of_.is_idle() && !of_.needs_init()) {
                (void)carry_setpoint();
                if (device().is_off()) poll(20'000);
            } else {
                turn();
            }
            if (was_polled && device().is_off() && now() - gone > surely_missed && !of_.needs_init() &&
                !of_.is_absent())
                throw broken{"G38: the drive has not responded for 2.6 s, but the facade does not notice it"};
        }
        judge_.disturbed();
        if (!of_.has_watchdog() || off < surely_missed) return poll(500'000);
        // Its watchdog has stopped it long ago.
        const places before = of_.shaft();
        const std::uint64_t end = now() + 1'000'000;
        while (now() < end) {
            if (is_turning && of_.is_idle() && !of_.needs_init()) (void)carry_setpoint();
            turn();
        }
        const places after = of_.shaft();
        for (std::size_t i = 0; i < after.size(); ++i) {
            if (after[i] - before[i] > 300 || before[i] - after[i] > 300)
                throw broken{
                    "G20: the drive was away until its watchdog had stopped it, and its wheels turn again "
                    "although it has not been initialised"};
        }
    }
    // A client of the same line writes one register.
    void writes_a_register() {
        if (!enabled(false)) return;
        if (!of_.is_idle()) until_idle();
        for (int i = 0; i < 4; ++i) {
            poll(on().random.below(60'000));
            if (!of_.is_idle()) until_idle();
            auto& executed = of_.place().executed();
            executed.clear();
            judge_.disturbed();
            if (!on().one_in(4)) device().lose_next(on().one_in(2));
            const std::uint64_t before = in_.between().sent();
            const std::uint16_t address = of_.harmless_register();
            const auto value = static_cast<std::uint16_t>(on().between(100, 140));
            on().log->remark(now(), "a client writes");
            const servobus::status s = of_.place().write(address, value);
            on().log->remark(now(), "   ended: " + std::string{servobus::text(s.error())} + ", " +
                                        servobus::text(s.outcome()));
            device().lose_nothing();
            unsigned written = 0;
            for (const execution& e : executed)
                if (e.is_write && e.address == address && e.refusal == 0) ++written;
            if (in_.between().sent() != before)
                ++count().gateway[played::at(last_case_)][static_cast<std::size_t>(s.outcome())];
            using servobus::outcome;
            if (written != 0 && (s.outcome() == outcome::refused || s.outcome() == outcome::not_sent))
                throw broken{std::string{"G16: a write is reported "} + servobus::text(s.outcome()) +
                             " although the drive has executed it"};
            if (written == 0 && s.outcome() == outcome::done)
                throw broken{"G16: a write is reported done although the drive has not executed it"};
        }
        poll(300'000);
    }

    // A program with a command timeout that commands in time, on a line that loses frames; then it hangs.
    void commands_in_time() {
        if (!enabled(true)) return;
        const std::uint32_t one = in_.longest_exchange().us;
        const std::uint32_t limit = on().between(100'000, one + 300'000);
        const bool has_setpoints = kind() != drive_kind::yako;
        of_.set_command_timeout(servobus::duration{limit});
        if (has_setpoints) {
            loss_per_mille_ = on().between(10, 80);
            const std::uint64_t end = now() + 3'000'000;
            std::uint64_t next = now();
            while (now() < end && of_.says_enabled()) {
                if (!of_.is_idle()) until_idle();
                if (now() < next) {
                    turn();
                    continue;
                }
                next = now() + 20'000;
                if (of_.begin_setpoint(on()) != errc::ok) break;
                note_begun(doing::turning);
                ++count().setpoints[kind_index()];
                const unsigned losses = device().losses();
                until_idle();
                judge_.ended();
                // A setpoint that meets more losses may exceed its bound.
                const errc why = of_.last().error();
                const bool is_stopped = why == errc::command_timeout || why == errc::preempted;
                if (is_stopped && device().losses() - losses <= 3)
                    throw broken{"G40: the command timeout stops a program that commands in time"};
            }
            loss_per_mille_ = 0;
            device().lose_nothing();
        } else if (!carry_setpoint()) {
            return of_.set_command_timeout({});
        }
        hang(limit, one);
        of_.set_command_timeout({});
    }
    // The program steps its drive and commands nothing.
    void hang(std::uint32_t limit, std::uint32_t one_exchange) {
        if (!of_.says_enabled() || of_.stands() || of_.needs_init()) return;
        ++count().hung[kind_index()];
        const std::uint64_t hung = now();
        last_stop_ = 0;
        while (last_stop_ == 0) {
            turn();
            if (now() - hung > std::uint64_t{limit} + 2 * one_exchange + 20'000)
                throw broken{"G40: a program has hung for " + std::to_string(now() - hung) +
                             " us, its command timeout is " + std::to_string(limit) +
                             ", and no stop has been sent"};
        }
        until_idle();
    }

    // A fault or an input acts on a drive before its program initialises it.
    void is_ill_before_init() {
        if (on().one_in(2) && !enabled(on().one_in(2))) return;
        if (!of_.is_idle()) until_idle();
        judge_.disturbed();
        on().strikes(strike::plight, false);
        ++on().count->plights;
        of_.fall_ill(on());
        if (on().one_in(2)) poll(on().random.below(200'000));
        if (on().one_in(2)) restart(boot_time(), false);
        if (on().one_in(2)) poll(on().random.below(100'000));
        while (device().is_off()) turn();
        if (!carry(doing::init)) return heal();
        ++count().ill[kind_index()];
        if (of_.has_fault() && of_.shows_faults() && !of_.says_faulted())
            throw broken{
                "G35: an init is reported done on a drive with a fault, but the facade does not say that "
                "it is faulted"};
        if (!of_.has_power() && of_.says_enabled())
            throw broken{
                "G35: an init is reported done on a drive that a fault or an input keeps without power, "
                "but the facade says that it is enabled"};
        heal();
    }
};

} // namespace trial
