// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of a facade with one drive: random commands on a faulty line. Some are preempted by a stop. Some
// meet a restart of the drive, a fault, a wired stop, a loss of the port or a jump of the clock. What is reported done
// is done (G16), no trigger is sent twice (G15), and only an initialisation writes to a drive whose cached state is
// invalid (G21).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "facade_world.hpp"
#include "mishaps.hpp"
#include "return_watch.hpp"
#include "truth_watch.hpp"

namespace trial {

class facade_run {
  public:
    facade_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)}, driven_{&make()}, mishaps_{in_},
          watch_{in_.state(), *driven_}, truth_{in_.state(), *driven_} {
        in_.on_frame = [this](servobus::bytes frame, facade*, bool) {
            watch_.begins(frame);
            truth_.begins(frame);
            look_at(frame);
        };
        in_.on_response = [this](servobus::bytes frame, facade&) { truth_.answered(frame); };
        mishaps_.on_port_back = [this] { watch_.lose("the port's return"); };
    }

    world& place() { return in_; }

    void go() {
        constexpr int commands = 40;
        scene& on = in_.state();
        if (!driven_->make_ready()) throw broken{"G9: a drive could not be set up on a line without faults"};
        on.chance = in_.hostility;
        mishaps_.begin();
        note_unknown();
        is_of_moves_ = on.one_in(2);
        is_patient_ = on.one_in(2);
        for (int i = 0; i < commands; ++i) one();
        on.log->remark(on.now(), "all faults end");
        on.chance = 0;
        mishaps_.heal();
        driven_->recover();
        in_.rest(2'000'000);
        calls_.clear();
        if (driven_->begin_end() != servobus::errc::ok) throw broken{"G25: a stop is refused"};
        note_command();
        carry_on(false);
        judge_command("at the end ");
        if (!driven_->last()) throw broken{"G26: after all faults have ended a stop has not been confirmed"};
        if (!driven_->stands())
            throw broken{"G26: after all faults have ended the drive moves although it was stopped"};
    }

  private:
    using errc = servobus::errc;

    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        while (c.wire.baud < 9600) c = draw_conditions(random); // a run would last an hour
        return c;
    }

    facade& make() {
        scene& on = in_.state();
        facade* f = nullptr;
        const auto node_address = static_cast<std::uint8_t>(on.between(1, 120));
        switch (on.random.below(3)) {
        case 0:
            f = &in_.drive<wheels>(settled(
                in_.hang_on<wheels_participant>(servobus::zlac8015d::catalogue, node_address,
                                                on.manuals.draw<servobus::sim::zlac8015d_options>())));
            break;
        case 1:
            f = &in_.drive<stepper>(
                settled(in_.hang_on<stepper_participant>(servobus::yako::closed_loop::catalogue, node_address,
                                                         on.manuals.draw<servobus::sim::yako_options>())));
            break;
        default:
            f = &in_.drive<servo>(settled(in_.hang_on<servo_participant>(
                servobus::c630s::catalogue, node_address, on.manuals.draw<servobus::sim::c630s_options>())));
        }
        return *f;
    }
    template <class Seat> Seat& settled(Seat& s) {
        settle(in_, s);
        return s;
    }

    void one() {
        scene& on = in_.state();
        if (!on.one_in(3)) in_.rest(on.one_in(10) ? on.random.below(2'500'000) : on.random.below(100'000));
        if (on.one_in(100)) babble();
        look();
        mishaps_.draw();
        on.is_struck = on.now() < off_until_ || on.now() < on.sounding_until || mishaps_.is_near();
        was_restarted_ = false;
        has_suffered_ = truth_.is_plight_hidden();
        if (on.one_in(30)) plan_restart();
        if (on.one_in(is_of_moves_ ? 6 : 15)) plan_plight();
        if (on.one_in(4)) poll(on.between(1'000, 600'000));
        const std::uint64_t sent = on.transaction;
        calls_.clear();
        const bool was_unknown = driven_->needs_init();
        if (is_unknown_ && has_moved())
            throw broken{"G21: a drive that needs an init has been started or enabled"};
        const errc refusal =
            on.one_in(is_of_moves_ ? 8 : 2) ? driven_->begin_any(on) : driven_->begin_move_or_wait(on);
        ++on.count->operations;
        if (refusal != errc::ok) {
            on.log->remark(on.now(), std::string{"a command is refused: "} + servobus::text(refusal));
            if (on.transaction != sent) throw broken{"G16: a refused command has sent a frame"};
            if (was_unknown && refusal != errc::needs_init && refusal != errc::busy)
                throw broken{"G21: a command to a drive that needs an init is refused for another reason"};
            return;
        }
        if (was_unknown && !driven_->wanted().is_init && !driven_->wanted().is_stop)
            throw broken{"G21: " + driven_->wanted().name + " is begun on a drive that needs an init"};
        on.log->remark(on.now(), driven_->wanted().name);
        note_command();
        carry_on(true);
        judge_command("");
    }

    // The program steps its drive and commands nothing.
    void poll(std::uint32_t us) {
        const std::uint64_t end = in_.state().now() + us;
        while (in_.state().now() < end || !driven_->is_idle()) {
            in_.port().begin_turn();
            const servobus::duration idle = driven_->step();
            look();
            in_.line().sleep(idle.us == 0 ? servobus::microseconds(1) : idle);
        }
    }
    void carry_on(bool may_be_cut_short) {
        scene& on = in_.state();
        const std::uint64_t begun = on.now() - on.stalled_us;
        auto guard = in_.line().new_stall_detector();
        while (!driven_->is_idle()) {
            in_.port().begin_turn();
            const servobus::duration idle = driven_->step();
            if (may_be_cut_short && on.one_in(is_patient_ ? 8'000 : 400) && !driven_->is_idle()) preempted();
            const bool does_clock_fail = guard.has_failed(in_.line().now());
            if ((does_clock_fail && !on.does_clock_lie) || on.now() - on.stalled_us - begun > 400'000'000)
                throw broken{"G29: a command does not end"};
            if (does_clock_fail) guard = in_.line().new_stall_detector(); // the loop goes on
            if (idle != servobus::duration{}) in_.line().sleep(idle);
            look();
        }
    }
    void look() {
        mishaps_.look();
        watch_.look();
        truth_.look();
    }
    void preempted() {
        scene& on = in_.state();
        if (driven_->begin_stop(on) != errc::ok) return;
        calls_.clear();
        on.log->remark(on.now(), "preempted by: " + driven_->wanted().name);
        note_command();
    }
    void note_command() {
        watch_.ordered();
        truth_.ordered();
    }

    void judge_command(const std::string& when) {
        scene& on = in_.state();
        const servobus::command_status& r = driven_->last();
        const errand& wanted = driven_->wanted();
        on.log->remark(on.now(), "   ended: " + std::string{servobus::text(r.error())});
        on.log->mix(static_cast<std::uint64_t>(r.error()));
        if (r) ++on.count->succeeded;
        truth_.ended();
        if (r && !was_restarted_ && !has_suffered_ && !truth_.is_plight_hidden() && wanted.is_carried_out &&
            !wanted.is_carried_out())
            in_.court().by_chance_or("G16: " + when + wanted.name +
                                     " is reported done, but the drive is in another state");
        const bool is_of_line = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        // An error that the drive's own state has shown, such as `not_executed`, leaves the cached state
        // valid.
        if (r.outcome() == servobus::outcome::unknown && is_of_line && !driven_->needs_init())
            throw broken{"G21: after the unknown outcome of " + wanted.name +
                         " the cached drive state is still valid"};
        if (!on.is_struck && !was_restarted_) ++on.count->had_to_succeed;
        // A drive that is off or restarts excuses a failure. An exception from the drive is no fault of the
        // line.
        const bool is_exception = !r && servobus::status{r}.has_response();
        if (!r && is_of_line && !is_exception && !on.is_struck)
            throw broken{"G9: the line had no fault, but " + wanted.name +
                         " ended: " + servobus::text(r.error())};
        note_unknown();
    }
    void note_unknown() {
        const bool was_unknown = is_unknown_;
        is_unknown_ = driven_->needs_init();
        if (was_unknown) return;
        starts_ = driven_->starts();
        enables_ = driven_->enables();
        // The rest of a request that began to leave before still leaves, and may start or enable once.
        cut_ = in_.port().is_leaving() ? 1 : 0;
    }
    bool has_moved() { return driven_->starts() - starts_ > cut_ || driven_->enables() - enables_ > cut_; }

    // Checks each frame as it begins to leave.
    void look_at(servobus::bytes frame) {
        if (!servobus::modbus::is_write(frame[1]) || driven_ == nullptr || driven_->is_stop(frame)) return;
        const byte_list key{frame.begin(), frame.end()};
        if (driven_->is_trigger(frame) && ++calls_[key] > 1)
            throw broken{"G15: " + driven_->wanted().name + " has sent a trigger twice"};
        if (!is_unknown_ || driven_->wanted().is_init) return;
        throw broken{"G21: " + driven_->wanted().name + " writes to a drive that needs an init"};
    }

    void babble() {
        scene& on = in_.state();
        on.strikes(strike::rubbish);
        byte_list b = random_bytes(on, on.between(1, 40));
        b[0] = 0xF9; // the address of no device
        const std::uint64_t end = in_.others().sender.send_at(on.now() + 1, b);
        in_.rest(1); // the line reads the schedule of the new bytes
        in_.rest(end - on.now() + 2);
    }
    void plan_restart() {
        scene& on = in_.state();
        const std::uint64_t when = on.now() + on.random.below(400'000);
        const std::uint32_t off = 1000u * on.between(1, 400);
        in_.port().plan(when, [this, off] {
            in_.state().strikes(strike::reboot);
            was_restarted_ = true;
            off_until_ = in_.state().now() + off;
            driven_->place().reboot(off_until_);
            watch_.restarted();
            truth_.restarted(off_until_);
        });
    }
    // A fault or an input acts on the drive soon, and ends later.
    void plan_plight() {
        scene& on = in_.state();
        const std::uint64_t when = on.now() + on.random.below(400'000);
        in_.port().plan(when, [this] {
            in_.state().strikes(strike::plight, false);
            has_suffered_ = true;
            driven_->suffer(in_.state());
            truth_.suffers();
        });
        in_.port().plan(when + on.between(1'000, 1'500'000), [this] { driven_->recover(); });
    }

    facade_world in_;
    facade* driven_ = nullptr;
    mishaps mishaps_;
    return_watch watch_;
    truth_watch truth_;
    std::map<byte_list, unsigned> calls_; ///< triggers of the command in progress
    std::uint64_t off_until_ = 0;
    std::uint32_t starts_ = 0;
    std::uint32_t enables_ = 0;
    std::uint32_t cut_ = 0; ///< requests that were given up while they left
    bool is_unknown_ = false;
    bool is_of_moves_ = false; ///< most commands are moves and waits for their ends
    bool is_patient_ = false;  ///< few commands are preempted
    bool was_restarted_ = false;
    bool has_suffered_ = false; ///< by a fault or an input during the command, or by a hidden one before it
};

} // namespace trial
