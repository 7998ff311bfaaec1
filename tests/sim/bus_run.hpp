// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of a bus: reads by a plan, orders of its drives' facades between them, drives that go and come back,
// stops at any moment. One run in two has a line without faults, on which the plan's times are promised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "fleet.hpp"
#include "read_watch.hpp"
#include "stop_watch.hpp"

namespace trial {

class bus_run {
  public:
    bus_run(std::uint64_t seed, tally& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)}, bus_{make()}, stops_{in_, *bus_}, reads_{in_, *bus_} {
        if (in_.state().one_in(2)) in_.hostility = 0;
        in_.on_frame = [this](servobus::bytes frame, facade* whose, bool is_urgent) {
            if (whose != nullptr && whose->is_stop(frame)) ++stop_frames_;
            stops_.begins(frame, whose, is_urgent);
            reads_.begins(frame, is_urgent);
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
        const servobus::duration idle = bus_->step();
        stops_.look();
        reads_.look();
        in_.port().wait(idle.us == 0 ? servobus::microseconds(1) : idle);
    }
    void run_for(std::uint64_t us) {
        const std::uint64_t end = in_.state().now() + us;
        while (in_.state().now() < end) turn();
    }

    void happen() {
        scene& on = in_.state();
        on.is_struck = false;
        ++on.count->operations;
        switch (on.random.below(10)) {
        case 0:
        case 1:
            return send_away_or_back(
                *in_.seats()[on.random.below(static_cast<std::uint32_t>(in_.seats().size()))]);
        case 2: return stop(any_facade());
        case 3:
            for (const auto& f : in_.facades()) stop(*f);
            return;
        case 4:
            if (in_.hostility != 0) babble();
            return;
        default: return order(any_facade());
        }
    }
    facade& any_facade() {
        return *in_.facades()[in_.state().random.below(static_cast<std::uint32_t>(in_.facades().size()))];
    }

    void send_away_or_back(seat& s) {
        scene& on = in_.state();
        if (s.device().is_off()) {
            on.log->remark(on.now(), "unit " + std::to_string(s.unit()) + " is back");
            s.device().be_off(0);
            reads_.came_back(s.unit());
        } else {
            on.log->remark(on.now(), "unit " + std::to_string(s.unit()) + " is gone");
            on.count->note(strike::absent_drive);
            s.device().be_off(for_ever);
            reads_.went_off(s.unit());
        }
    }
    void order(facade& f) {
        scene& on = in_.state();
        if (!f.is_idle() || f.begin_any(on) != errc::ok) return;
        on.log->remark(on.now(), "unit " + std::to_string(f.place().unit()) + ": " + f.wanted().name);
        if (f.wanted().is_stop) {
            stops_.ordered(&f);
        } else {
            stops_.ended_by_order(&f);
        }
    }
    void stop(facade& f) {
        scene& on = in_.state();
        if (f.begin_stop(on) != errc::ok) return;
        on.log->remark(on.now(), "unit " + std::to_string(f.place().unit()) + ": stop by " + f.wanted().name);
        stops_.ordered(&f);
    }
    void babble() {
        scene& on = in_.state();
        on.strikes(strike::rubbish);
        byte_list b = random_bytes(on, on.between(1, 40));
        b[0] = 0xF9; // nobody's address
        (void)in_.others().voice.say_at(on.now() + 1, b);
        in_.rest(1);
    }

    // Whatever was going on: all drives are there again, and stop.
    void end() {
        scene& on = in_.state();
        on.log->remark(on.now(), "the line is healed");
        on.chance = 0;
        for (const auto& s : in_.seats()) {
            if (s->device().is_off()) send_away_or_back(*s);
        }
        run_for(1'000'000);
        const std::uint64_t begun = on.now();
        for (const auto& f : in_.facades()) {
            // A more urgent stop may still wait for the standstill.
            while (f->begin_end() != errc::ok && on.now() - begun < 70'000'000) turn();
            stops_.ordered(f.get());
            while (!f->is_idle() && on.now() - begun < 140'000'000) turn();
        }
        run_for(500'000); // and what was repeated
        for (const auto& f : in_.facades()) {
            if (!f->is_idle() || !f->last())
                throw broken{"G26: on a healed line the stop of unit " + std::to_string(f->place().unit()) +
                             " has not been confirmed"};
            if (!f->stands()) throw broken{"G26: after a stop on a healed line a drive moves"};
        }
        const std::uint64_t before = stop_frames_;
        run_for(1'000'000);
        if (stop_frames_ != before) throw broken{"G26: a stop that was confirmed is repeated"};
    }

    facade_world in_;
    std::unique_ptr<fleet> bus_;
    stop_watch stops_;
    read_watch reads_;
    std::uint64_t stop_frames_ = 0;
};

} // namespace trial
