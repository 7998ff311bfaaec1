// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of a ZLAC8015D in a run of lives.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/seen_machines.hpp>

#include "pilot.hpp"

namespace trial {

template <class Line>
using wheels_place = participant_of<Line, servobus::zlac8015d::device, servobus::sim::zlac8015d>;

template <class Line>
class wheels_pilot final : public pilot_of<Line, wheels_place<Line>, servobus::zlac8015d::drive> {
    using base = pilot_of<Line, wheels_place<Line>, servobus::zlac8015d::drive>;
    using errc = servobus::errc;
    using mode = servobus::zlac8015d::operating_mode;
    using view = seen::wheels;

  public:
    wheels_pilot(wheels_place<Line>& at, Line& on, servobus::duration every) : base{at, on, every} {
        this->window = 20;
        this->tolerance = 12;
    }

    errc begin(doing what, scene& on) override {
        using namespace servobus::zlac8015d;
        switch (what) {
        case doing::init: return order(servobus::init{});
        case doing::enable: return enable_for_moves(on);
        case doing::stop: return stop(on);
        case doing::move: return move(on);
        case doing::arrival:
            return drive().begin(servobus::wait_reached{servobus::milliseconds(8'000)}).error();
        case doing::standstill: return drive().begin(servobus::wait_standstill{}).error();
        case doing::save: return drive().begin(save{}).error();
        case doing::setting: return setting(on);
        case doing::reading: return drive().begin(servobus::read_feedback{}).error();
        default: return errc::bad_argument;
        }
    }
    errc begin_turning_mode() override { return order(servobus::zlac8015d::enable_in{mode::velocity}); }
    errc begin_setpoint(scene& on) override {
        using namespace servobus::units;
        const auto speed = static_cast<std::int32_t>(on.between(20, 90));
        return order(servobus::velocity{speed * r_per_min, speed * r_per_min});
    }
    bool can(doing what) const override {
        using servobus::zlac8015d::drive_state;
        const bool is_enabled = this->says_enabled();
        const bool has_moves = drive().cached().mode == mode::relative_position ||
                               drive().cached().mode == mode::absolute_position;
        switch (what) {
        case doing::homing: return false;
        case doing::save: return drive().state() == drive_state::disabled;
        case doing::move: return is_enabled && has_moves;
        case doing::turning: return is_enabled && drive().cached().mode == mode::velocity;
        default: return true;
        }
    }
    std::uint16_t harmless_register() const override { return 0x2034; }
    std::optional<places> feedback() const override {
        const auto seen = drive().feedback(this->oldest());
        if (!seen) return std::nullopt;
        return places{seen->left_position.count(), seen->right_position.count()};
    }
    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::zlac8015d::routines;
        static constexpr servobus::step stops[] = {stop_by_targets, stop_by_command, zero_torque,
                                                   quick_stop_now};
        return is_one_of(stops, frame);
    }

    places shaft() override { return {model().left().position, model().right().position}; }
    places shown() override {
        using namespace servobus::zlac8015d;
        return {pair_at(left_actual_position.address), pair_at(right_actual_position.address)};
    }
    bool stands() override { return !view::is_turning(model()); }
    bool has_power() override { return view::is_energised(model()) && !has_fault(); }
    bool has_fault() override { return view::has_fault(model()); }
    void fall_ill(scene& on) override {
        using servobus::zlac8015d::fault;
        if (on.one_in(4)) return view::press_stop(model());
        model().raise(on.one_in(2) ? fault::overcurrent : fault::none, fault::overcurrent);
    }
    void recover() override {
        view::release_stop(model());
        view::end_fault(model());
    }
    bool shows_restarts_at_rest() const override { return false; }
    bool has_watchdog() const override { return true; }

  private:
    auto& drive() { return base::drive; }
    const auto& drive() const { return base::drive; }
    using base::model;

    std::int64_t pair_at(std::uint16_t address) {
        const std::uint32_t low = model().peek(static_cast<std::uint16_t>(address + 1));
        return static_cast<std::int32_t>(std::uint32_t{model().peek(address)} << 16 | low);
    }
    template <class Command> errc order(const Command& c) {
        const errc refusal = drive().begin(c).error();
        if (refusal == errc::ok) this->forget_goals();
        return refusal;
    }
    errc enable_for_moves(scene& on) {
        using namespace servobus::zlac8015d;
        const mode wanted = on.one_in(2) ? mode::relative_position : mode::absolute_position;
        const auto starts = on.one_in(2) ? synchronisation::synchronous : synchronisation::asynchronous;
        return order(enable_in{servobus::checked(wanted), starts});
    }
    errc stop(scene& on) {
        using namespace servobus::zlac8015d;
        return (on.one_in(2) ? drive().begin(servobus::quick_stop{}) : drive().begin(servobus::disable{}))
            .error();
    }
    errc setting(scene& on) {
        using namespace servobus::zlac8015d;
        using namespace servobus::units;
        const auto ms = static_cast<std::int32_t>(on.between(300, 500));
        return drive().begin(ramps{ms * millisecond, ms * millisecond}).error();
    }
    errc move(scene& on) {
        using namespace servobus::zlac8015d;
        using namespace servobus::units;
        const bool is_place = drive().cached().mode == mode::absolute_position;
        const places from = shaft();
        const places count = shown();
        const bool is_left = on.one_in(2);
        const bool is_pair = drive().cached().starts == synchronisation::synchronous;
        const auto way_of = [&](std::size_t i) {
            return static_cast<std::int32_t>(draw_way(on, count[i], 300, 2500));
        };
        const std::int32_t l = way_of(0);
        const std::int32_t r = way_of(1);
        // An absolute target counts from the zero of the present life, as the feedback does.
        const auto target = [&](std::size_t i, std::int32_t way) {
            return is_place ? static_cast<std::int32_t>(count[i]) + way : way;
        };
        const auto left = target(0, l) * pulse;
        const auto right = target(1, r) * pulse;
        errc refusal = errc::ok;
        if (is_pair)
            refusal = (is_place ? drive().begin(servobus::move_to{left, right})
                                : drive().begin(servobus::move_by{left, right}))
                          .error();
        else if (is_left)
            refusal =
                (is_place ? drive().begin(move_left_to{left}) : drive().begin(move_left_by{left})).error();
        else
            refusal = (is_place ? drive().begin(move_right_to{right}) : drive().begin(move_right_by{right}))
                          .error();
        if (refusal != errc::ok) return refusal;
        if (is_pair || is_left) this->goal[0] = from[0] + l;
        if (is_pair || !is_left) this->goal[1] = from[1] + r;
        return refusal;
    }
};

} // namespace trial
