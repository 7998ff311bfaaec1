// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of a bus: cyclic reads by a plan, commands of the facades between them, drives that disappear,
// restart and return, and stops at any moment. Half of the runs have a line without faults, on which the
// times of the plan must be kept. In the others the port, the clock and the wire may fail as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fleet.hpp"
#include "mishaps.hpp"
#include "own_request.hpp"
#include "read_watch.hpp"
#include "return_watch.hpp"
#include "stop_watch.hpp"

namespace trial {

class bus_run {
  public:
    bus_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)}, bus_{make()}, stops_{in_, *bus_}, reads_{in_, *bus_},
          own_{in_, *bus_}, mishaps_{in_} {
        if (in_.state().one_in(2)) in_.be_faultless();
        is_patient_ = in_.state().one_in(2);
        is_own_first_ = in_.state().one_in(2);
        for (const auto& f : in_.facades()) returns_.emplace_back(in_.state(), *f);
        in_.on_frame = [this](servobus::bytes frame, facade* whose, bool is_stop) {
            if (whose != nullptr && whose->is_stop(frame)) ++stop_frames_;
            if (whose != nullptr) return_of(*whose).begins(frame);
            stops_.begins(frame, whose, is_stop);
            reads_.begins(frame, whose, is_stop);
            own_.begins(frame);
        };
        mishaps_.on_port_back = [this] {
            for (return_watch& r : returns_) r.lose("the port's return");
            for (const auto& f : in_.facades()) f->note_port_back();
        };
    }

    world& place() { return in_; }

    void go() {
        constexpr int events = 50;
        scene& on = in_.state();
        for (const auto& f : in_.facades()) {
            if (!f->make_ready()) throw broken{"G9: a drive could not be set up on a line without faults"};
        }
        on.chance = in_.hostility;
        mishaps_.begin();
        for (int i = 0; i < events; ++i) {
            run_for(on.one_in(12) ? on.between(1'000'000, 2'500'000) : on.random.below(200'000));
            happen();
        }
        end();
    }

  private:
    using errc = servobus::errc;
    static constexpr std::uint64_t for_ever = ~std::uint64_t{0};

    static bool is_fast(std::uint64_t seed) { return dice_of_conditions(seed).roll() % 2 == 0; }
    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        c.timing = is_fast(seed) ? plans::fast::plan.timing() : plans::slow::plan.timing();
        c.wire.baud = is_fast(seed) ? plans::fast::baud : plans::slow::baud;
        c.resolution_us = 1;
        return c;
    }
    std::unique_ptr<fleet> make() {
        if (in_.state().timing.character == plans::fast::plan.timing().character)
            return std::make_unique<fast_fleet>(in_);
        return std::make_unique<slow_fleet>(in_);
    }

    void turn() {
        in_.port().begin_turn();
        servobus::duration idle = is_own_first_ ? own_.step() : bus_->step();
        idle = servobus::shorter_of(idle, is_own_first_ ? bus_->step() : own_.step());
        stops_.look();
        reads_.look();
        mishaps_.look();
        for (return_watch& r : returns_) r.look();
        in_.port().wait(idle.us == 0 ? servobus::microseconds(1) : idle);
    }
    void run_for(std::uint64_t us) {
        const std::uint64_t end = in_.state().now() + us;
        while (in_.state().now() < end) turn();
    }

    void happen() {
        scene& on = in_.state();
        on.is_struck = false;
        mishaps_.draw();
        ++on.count->operations;
        switch (on.random.below(16)) {
        case 0: return send_away_or_back(in_.any_participant());
        case 1: return send_away_or_back(absent_or_moving());
        case 2: return stop(any_facade());
        case 3:
            for (const auto& f : in_.facades()) stop(*f);
            return;
        case 4:
            if (in_.hostility != 0) babble();
            return;
        case 5: return lose_one_that_runs();
        default:
            for (const auto& f : in_.facades()) command(*f);
        }
    }
    return_watch& return_of(const facade& f) {
        std::size_t i = 0;
        while (in_.facades()[i].get() != &f) ++i;
        return returns_[i];
    }
    facade& any_facade() {
        return *in_.facades()[in_.state().random.below(static_cast<std::uint32_t>(in_.facades().size()))];
    }

    participant& absent_or_moving() {
        for (const auto& s : in_.participants()) {
            if (s->device().is_off()) return *s;
        }
        for (const auto& f : in_.facades()) {
            if (f->motion() != 0) return f->place();
        }
        return in_.any_participant();
    }
    void send_away_or_back(participant& s) {
        scene& on = in_.state();
        if (s.device().is_off()) {
            on.log->remark(on.now(), "node " + std::to_string(s.address()) + " is back");
            s.device().be_off(0);
            if (s.address() == own_.address())
                own_.came_back();
            else
                reads_.came_back(s.address());
        } else {
            go_away(s);
            if (on.one_in(2)) restart(s);
            if (on.one_in(3)) return; // a later event brings it back
            const std::uint32_t ms = on.one_in(2) ? on.between(1, 400) : on.between(400, 4000);
            in_.port().plan(on.now() + 1000 * ms, [this, &s] {
                if (s.device().is_off()) send_away_or_back(s);
            });
        }
    }
    void go_away(participant& s) {
        scene& on = in_.state();
        on.log->remark(on.now(), "node " + std::to_string(s.address()) + " is gone");
        on.count->note(strike::absent_drive);
        s.device().be_off(for_ever);
        if (s.address() == own_.address()) own_.went_off();
        reads_.went_off(s.address());
    }
    // Removes a moving drive for longer than its watchdog allows, while the program commands nothing.
    void lose_one_that_runs() {
        scene& on = in_.state();
        for (int i = 0; i < 4; ++i) {
            for (const auto& f : in_.facades()) {
                if (f->motion() == 0 && f->is_idle() && f->begin_motion(on) == errc::ok) note_command(*f);
            }
            run_for(200'000);
        }
        if (in_.events != 0 && !mishaps_.is_near() && on.one_in(2)) {
            mishaps_.lose_port();
            return run_for(500'000);
        }
        for (const auto& f : in_.facades()) {
            if (f->motion() == 0 || f->place().device().is_off()) continue;
            go_away(f->place());
            run_for(1000 * on.between(900, 2500));
            if (f->place().device().is_off()) send_away_or_back(f->place());
            return run_for(300'000);
        }
    }
    void restart(participant& s) {
        in_.state().strikes(strike::reboot);
        s.reboot(for_ever);
        if (facade* const f = in_.facade_at(s.address()); f != nullptr) return_of(*f).restarted();
    }
    void command(facade& f) {
        scene& on = in_.state();
        if (is_patient_ && (f.place().device().is_off() || in_.port().is_gone())) return;
        if (!f.is_idle() || (on.one_in(2) ? f.begin_any(on) : f.begin_motion(on)) != errc::ok) return;
        note_command(f);
    }
    void note_command(facade& f) {
        scene& on = in_.state();
        on.log->remark(on.now(), "node " + std::to_string(f.place().address()) + ": " + f.wanted().name);
        return_of(f).ordered();
        if (f.wanted().is_stop) {
            stops_.ordered(&f);
        } else {
            stops_.commanded_another(&f);
        }
    }
    void stop(facade& f) {
        scene& on = in_.state();
        if (f.begin_stop(on) != errc::ok) return;
        on.log->remark(on.now(),
                       "node " + std::to_string(f.place().address()) + ": stop by " + f.wanted().name);
        return_of(f).ordered();
        stops_.ordered(&f);
    }
    void babble() {
        scene& on = in_.state();
        on.strikes(strike::rubbish);
        byte_list b = random_bytes(on, on.between(1, 40));
        b[0] = 0xF9; // the address of no device
        (void)in_.others().sender.send_at(on.now() + 1, b);
        in_.rest(1);
    }

    // Ends all faults, brings all drives back and stops them.
    void end() {
        scene& on = in_.state();
        on.log->remark(on.now(), "all faults end");
        on.chance = 0;
        mishaps_.heal();
        for (const auto& s : in_.participants()) {
            if (s->device().is_off()) send_away_or_back(*s);
        }
        run_for(1'000'000);
        find_all();
        const std::uint64_t begun = on.now();
        for (const auto& f : in_.facades()) {
            // A stop of higher priority may still wait for standstill.
            while (f->begin_end() != errc::ok && on.now() - begun < 70'000'000) turn();
            stops_.ordered(f.get());
            return_of(*f).ordered();
            while (!f->is_idle() && on.now() - begun < 140'000'000) turn();
        }
        run_for(500'000); // the repeated stops end too
        for (const auto& f : in_.facades()) {
            if (!f->is_idle() || !f->last())
                throw broken{"G26: after all faults have ended the stop of node " +
                             std::to_string(f->place().address()) + " has not been confirmed"};
            if (!f->stands())
                throw broken{"G26: after all faults have ended a drive moves although it was stopped"};
        }
        const std::uint64_t before = stop_frames_;
        run_for(1'000'000);
        if (stop_frames_ != before) throw broken{"G26: a confirmed stop is repeated"};
    }

    void find_all() {
        const std::uint64_t begun = in_.state().now();
        const std::uint64_t most =
            bus_->found_within_us(static_cast<std::uint32_t>(bus_->polls().size())) + 1'000'000;
        while (!reads_.are_all_asked_since(begun)) {
            turn();
            if (in_.state().now() - begun > most)
                throw broken{"G28: after all faults have ended a cyclic read is no longer sent"};
        }
    }

    facade_world in_;
    std::unique_ptr<fleet> bus_;
    stop_watch stops_;
    read_watch reads_;
    own_request own_;
    mishaps mishaps_;
    std::vector<return_watch> returns_; ///< of the facades, in their order
    std::uint64_t stop_frames_ = 0;
    bool is_own_first_ = false; ///< the program steps its own requests before the bus
    bool is_patient_ = false;   ///< the program commands no absent drive, and none while the port is lost
};

} // namespace trial
