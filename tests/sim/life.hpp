// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of a run of lives: it steps its drive in a loop, carries out commands, brings the drive into a state,
// and plans what happens to it meanwhile. The scenes are made of these.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "life_judge.hpp"

namespace trial {

class life {
  public:
    explicit life(life_place& in) : in_{in}, of_{in.program()}, judge_{in, of_} {
        in_.on_frame = [this](servobus::bytes frame) { look_at(frame); };
        in_.between().on_exception = [this] { note_exception(); };
    }

  protected:
    using errc = servobus::errc;

    scene& on() { return in_.state(); }
    std::uint64_t now() { return on().now(); }
    hostile_device& device() { return of_.place().device(); }
    played& count() { return on().count->lives; }
    drive_kind kind() { return of_.place().kind(); }
    std::size_t kind_index() { return static_cast<std::size_t>(kind()); }

    // --- The program's loop

    void turn() {
        in_.port().begin_turn();
        const servobus::duration idle = of_.step();
        if (restarts_near_zero_) look_for_zero();
        judge_.look();
        // At least each millisecond, so that the shaft is known at all times.
        const servobus::duration most = servobus::milliseconds(2);
        in_.sleep(idle.us == 0 ? servobus::microseconds(1) : idle < most ? idle : most);
        in_.port().look();
    }
    void poll(std::uint64_t us) {
        const std::uint64_t end = now() + us;
        while (now() < end) turn();
    }
    void until_idle() {
        const std::uint64_t begun = now();
        while (!of_.is_idle()) {
            turn();
            if (now() - begun > 200'000'000) throw broken{"G29: a command does not end"};
        }
    }
    /// Begins a command. False if it is refused.
    bool begin(doing what) {
        if (!of_.is_idle()) until_idle(); // a stop of the facade itself
        if (const errc refusal = of_.begin(what, on()); refusal != errc::ok) {
            on().log->remark(now(), std::string{text(what)} + " is refused: " + servobus::text(refusal));
            return false;
        }
        note_begun(what);
        return true;
    }
    void note_begun(doing what) {
        on().log->remark(now(), text(what));
        ++on().count->operations;
        if (what != doing::reading && what != doing::setting) judge_.is_turning = what == doing::turning;
        judge_.begun(what);
    }
    bool carry(doing what) {
        if (!begin(what)) return false;
        until_idle();
        judge_.ended();
        return static_cast<bool>(of_.last());
    }
    bool carry_setpoint() {
        if (!of_.is_idle()) until_idle();
        if (of_.begin_setpoint(on()) != errc::ok) return false;
        note_begun(doing::turning);
        until_idle();
        judge_.ended();
        return static_cast<bool>(of_.last());
    }

    // --- Bringing the drive into a state

    /// The causes of faults end, and the drive's power is switched off and on.
    void heal() {
        end_plans();
        of_.recover();
        in_.rest(500'000);
        if (!of_.has_fault() && !of_.says_faulted()) return;
        restart(0, false);
        poll(10'000);
    }
    /// The drive is initialised and disabled.
    bool disabled() {
        for (int i = 0; i < 6; ++i) {
            if (of_.needs_init() || of_.says_faulted()) {
                if (!carry(doing::init)) heal();
            } else if (of_.can(doing::save) && !of_.says_enabled()) {
                return true;
            } else if (!carry(doing::stop)) {
                heal();
            }
        }
        return false;
    }
    /// The drive is enabled for moves, or for a motion without an end.
    bool enabled(bool is_for_turning) {
        for (int i = 0; i < 8; ++i) {
            if (of_.needs_init() || of_.says_faulted()) {
                if (!carry(doing::init)) heal();
            } else if (of_.says_enabled() && of_.can(is_for_turning ? doing::turning : doing::move)) {
                if (of_.stands()) return true;
                (void)carry(doing::stop);
            } else if (of_.says_enabled()) {
                (void)carry(doing::stop);
            } else if (!energise(is_for_turning) && !carry(doing::init)) {
                heal();
            }
        }
        return false;
    }
    bool energise(bool is_for_turning) {
        if (!is_for_turning || kind() == drive_kind::yako) return carry(doing::enable);
        if (!of_.is_idle()) until_idle();
        if (of_.begin_turning_mode() != errc::ok) return false;
        note_begun(doing::enable);
        until_idle();
        judge_.ended();
        return static_cast<bool>(of_.last());
    }

    // --- What happens to it

    void end_plans() {
        in_.port().forget_plans();
        device().lose_nothing();
        loss_per_mille_ = frames_to_restart_ = 0;
        restarts_near_zero_ = false;
    }
    void restart(std::uint32_t off_us, bool is_due) {
        on().strikes(strike::reboot);
        const std::uint64_t up_at = now() + off_us;
        judge_.restarted(up_at, is_due);
        of_.place().reboot(up_at);
    }
    std::uint32_t boot_time() { return on().one_in(3) ? 0 : 1000 * on().between(1, 300); }
    void plan_restart(std::uint32_t within_us) {
        const std::uint32_t off = boot_time();
        in_.port().plan(now() + on().random.below(within_us), [this, off] { restart(off, false); });
    }
    void plan_loss(std::uint32_t within_us) {
        const bool is_response = on().one_in(2);
        in_.port().plan(now() + on().random.below(within_us), [this, is_response] {
            judge_.disturbed();
            device().lose_next(is_response);
        });
    }
    /// Plans a restart near one of the next `frames` requests.
    void plan_restart_at_frame(std::uint32_t frames) { frames_to_restart_ = 1 + on().random.below(frames); }
    /// Perhaps plans a restart, perhaps losses.
    void plan_any(std::uint32_t within_us) {
        if (on().one_in(2)) plan_restart(within_us);
        while (on().one_in(3)) plan_loss(within_us);
    }

    life_place& in_;
    pilot& of_;
    life_judge judge_;
    std::uint32_t loss_per_mille_ = 0; ///< of all requests and responses
    std::uint64_t last_stop_ = 0;      ///< when a stop began to leave
    /// The drive restarts during a wait, at a place from which it could soon be where it counts from then on.
    bool restarts_near_zero_ = false;

  private:
    void look_for_zero() {
        const bool is_wait = judge_.under_way() == doing::arrival || judge_.under_way() == doing::standstill;
        const std::int64_t place = of_.shown()[0];
        if (!is_wait || of_.stands() || place > 60 || place < -60) return;
        restarts_near_zero_ = false;
        restart(0, false);
    }
    void look_at(servobus::bytes frame) {
        if (of_.is_stop(frame)) last_stop_ = now();
        if (frames_to_restart_ != 0 && --frames_to_restart_ == 0) plan_restart(5'000);
        if (loss_per_mille_ == 0 || on().random.below(1000) >= loss_per_mille_) return;
        judge_.disturbed();
        device().lose_next(on().one_in(2));
    }
    void note_exception() {
        const gateway_case why = device().is_off()                               ? gateway_case::absent_drive
                                 : device().last_loss() == strike::lost_response ? gateway_case::lost_response
                                                                                 : gateway_case::lost_request;
        ++(in_.is_tcp() ? count().over_tcp : count().over_rtu)[played::at(why)];
        last_case_ = why;
        judge_.disturbed();
    }

    std::uint32_t frames_to_restart_ = 0;

  protected:
    gateway_case last_case_ = gateway_case::lost_request;
};

} // namespace trial
