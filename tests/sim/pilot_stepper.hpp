// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of a closed-loop YAKOTEC in a run of lives. Its shaft has a home switch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/device/yako.hpp>
#include <servobus/sim/yako.hpp>

#include <tests/support/seen_machines.hpp>

#include "pilot.hpp"

namespace trial {

template <class Line>
using stepper_place =
    participant_of<Line, servobus::yako::closed_loop::device, servobus::sim::yako_closed_loop>;

template <class Line>
class stepper_pilot final : public pilot_of<Line, stepper_place<Line>, servobus::yako::closed_loop::drive> {
    using base = pilot_of<Line, stepper_place<Line>, servobus::yako::closed_loop::drive>;
    using errc = servobus::errc;
    using view = seen::stepper;

  public:
    stepper_pilot(stepper_place<Line>& at, Line& on, servobus::duration every) : base{at, on, every} {
        this->window = 5;
        this->tolerance = 8;
        servobus::sim::yako_machine machine;
        machine.home_from = -250;
        machine.home_to = 250;
        model().attach(machine);
    }

    errc begin(doing what, scene& on) override {
        using namespace servobus::yako;
        using namespace servobus::units;
        switch (what) {
        case doing::init: return order(servobus::init{});
        case doing::enable: return drive().begin(servobus::enable{}).error();
        case doing::stop: return stop(on);
        case doing::move: return move(on);
        case doing::arrival:
            return drive().begin(servobus::wait_reached{servobus::milliseconds(8'000)}).error();
        case doing::standstill:
            return drive().begin(servobus::wait_standstill{servobus::milliseconds(8'000)}).error();
        case doing::homing: return home();
        case doing::save: return drive().begin(save{}).error();
        case doing::setting: return setting(on);
        case doing::reading: return drive().begin(servobus::read_feedback{}).error();
        default: return errc::bad_argument;
        }
    }
    errc begin_turning_mode() override { return begin_setpoint_at(120); }
    // A jog is refused while the motor moves: there are no setpoints in time.
    errc begin_setpoint(scene& on) override {
        return begin_setpoint_at(static_cast<std::int32_t>(on.between(60, 200)));
    }
    bool can(doing what) const override {
        const bool is_enabled = this->says_enabled();
        if (what == doing::homing) return is_enabled && drive().cached().has_homing_profile;
        return is_enabled || (what != doing::move && what != doing::turning);
    }
    std::uint16_t harmless_register() const override { return servobus::yako::jog_acceleration_time.address; }
    std::optional<places> feedback() const override {
        const auto seen = drive().feedback(this->oldest());
        if (!seen) return std::nullopt;
        return places{seen->position.count(), 0};
    }
    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::yako::routines;
        static constexpr servobus::step stops[] = {stop_now, quick_stop_now, release_now};
        return is_one_of(stops, frame);
    }

    places shaft() override { return {view::place(model()), 0}; }
    places shown() override { return {model().view().position, 0}; }
    bool stands() override { return !view::is_turning(model()) && model().view().speed == 0; }
    bool has_power() override { return view::is_energised(model()) && !has_fault(); }
    bool has_fault() override { return view::has_fault(model()); }
    void fall_ill(scene& on) override {
        using servobus::yako::input_function;
        if (!on.one_in(4)) return model().raise_alarm(static_cast<std::uint16_t>(on.between(1, 5)));
        const auto what = on.one_in(2) ? input_function::motor_free : input_function::stop;
        const std::array<std::uint8_t, 2> word{0, static_cast<std::uint8_t>(what)};
        (void)model().write(servobus::yako::x3_function.address, servobus::words_view{word});
        view::press_stop(model());
    }
    void recover() override {
        view::end_fault(model());
        view::release_stop(model());
    }
    bool shows_restarts() const override {
        return this->template chosen<servobus::sim::yako_options>().kept != servobus::sim::yako_kept::written;
    }

    std::uint16_t marker_register() const override { return marker; }
    bool hides_restart(const std::vector<std::uint16_t>& words) const override {
        return words[0] == 0 && words[1] == 0;
    }
    bool is_marker_cleared() override { return model().peek(marker) == 0 && model().peek(marker + 1) == 0; }

  private:
    static constexpr std::uint16_t marker = 0x00BA;

    auto& drive() { return base::drive; }
    const auto& drive() const { return base::drive; }
    using base::model;

    template <class Command> errc order(const Command& c) {
        const errc refusal = drive().begin(c).error();
        if (refusal == errc::ok) this->forget_goals();
        return refusal;
    }
    errc begin_setpoint_at(std::int32_t speed) {
        using namespace servobus::units;
        return order(servobus::velocity{speed * r_per_min});
    }
    errc stop(scene& on) {
        using namespace servobus::yako;
        switch (on.random.below(3)) {
        case 0: return drive().begin(servobus::halt{}).error();
        case 1: return drive().begin(servobus::quick_stop{}).error();
        default: return drive().begin(servobus::disable{}).error();
        }
    }
    errc home() {
        using namespace servobus::yako;
        using namespace servobus::units;
        return order(closed_loop::home{
            homing::home_24, {}, offset_handling::move_position_zero, servobus::milliseconds(20'000)});
    }
    errc setting(scene& on) {
        using namespace servobus::yako;
        using namespace servobus::units;
        const auto rpm = static_cast<std::int32_t>(on.between(100, 240));
        switch (on.random.below(4)) {
        case 0:
        case 1:
            return drive()
                .begin(set_homing_profile{rpm * r_per_min, 120 * r_per_min, 50 * millisecond})
                .error();
        case 2: return drive().begin(set_position_segment{2, 700 * pulse, rpm * r_per_min}).error();
        default: return order(servobus::yako::clear_position{});
        }
    }
    errc move(scene& on) {
        using namespace servobus::yako;
        using namespace servobus::units;
        const places from = shaft();
        const places count = shown();
        const auto way = static_cast<std::int32_t>(draw_way(on, count[0], 100, 3000));
        const motion_profile by{0 * r_per_min, 50 * millisecond, 50 * millisecond,
                                static_cast<std::int32_t>(on.between(60, 240)) * r_per_min};
        const bool is_place = drive().cached().is_homed && on.one_in(2);
        const errc refusal =
            (is_place
                 ? drive().begin(servobus::move_to{(static_cast<std::int32_t>(count[0]) + way) * pulse, by})
                 : drive().begin(servobus::move_by{way * pulse, by}))
                .error();
        if (refusal == errc::ok) this->goal[0] = from[0] + way;
        return refusal;
    }
};

} // namespace trial
