// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of a C630S in a run of lives. Positions count in reference units.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/device/c630s.hpp>
#include <servobus/sim/c630s.hpp>

#include <tests/support/seen_machines.hpp>

#include "pilot.hpp"
#include "servo.hpp"

namespace trial {

template <class Line> using servo_place = participant_of<Line, servobus::c630s::device, servobus::sim::c630s>;

template <class Line>
class servo_pilot final : public pilot_of<Line, servo_place<Line>, servobus::c630s::drive> {
    using base = pilot_of<Line, servo_place<Line>, servobus::c630s::drive>;
    using errc = servobus::errc;
    using view = seen::servo;
    using control = servobus::c630s::control_mode;

  public:
    servo_pilot(servo_place<Line>& at, Line& on, servobus::duration every) : base{at, on, every} {
        this->window = 40;
        this->tolerance = 60;
    }
    // The facade confirms that the drive is enabled by the released brake.
    static servobus::sim::c630s_options workable(servobus::sim::c630s_options drawn) {
        drawn.brake = servobus::sim::c630s_brake::follows_servo;
        drawn.first_output_shows = false;
        return drawn;
    }
    void prepare() override {
        for (const auto& [address, words] : prepared_c630s()) (void)model().write(address, words_of(words));
        using namespace servobus::c630s;
        hold(homing_method.address, static_cast<std::uint16_t>(homing_mode::forward_home_switch));
        hold(homing_high_speed.address, 300);
        hold(homing_low_speed.address, 60);
        hold(homing_acceleration_time.address, 100);
        model().attach({.home_from = 60'000,
                        .home_to = 90'000,
                        .negative_limit = -900'000'000,
                        .positive_limit = 900'000'000});
        model().power_cycle();
    }

    errc begin(doing what, scene& on) override {
        using namespace servobus::c630s;
        switch (what) {
        case doing::init: return order(servobus::init{});
        case doing::enable: return order(enable_in{control::position});
        case doing::stop:
            return (on.one_in(2) ? drive().begin(servobus::quick_stop{}) : drive().begin(servobus::disable{}))
                .error();
        case doing::move: return move(on);
        case doing::arrival:
            return drive().begin(servobus::wait_reached{servobus::milliseconds(8'000)}).error();
        case doing::standstill:
            return drive().begin(servobus::wait_standstill{servobus::milliseconds(8'000)}).error();
        case doing::homing: return order(home{servobus::c630s::time{8'000}});
        case doing::save:
        case doing::setting: return setting(on, what == doing::save);
        case doing::reading: return drive().begin(servobus::read_feedback{}).error();
        default: return errc::bad_argument;
        }
    }
    errc begin_turning_mode() override { return order(servobus::c630s::enable_in{control::speed}); }
    errc begin_setpoint(scene& on) override {
        using namespace servobus::units;
        return order(servobus::velocity{static_cast<std::int32_t>(on.between(60, 400)) * r_per_min});
    }
    bool can(doing what) const override {
        const bool is_enabled = this->says_enabled();
        switch (what) {
        case doing::homing:
        case doing::move: return is_enabled && drive().cached().mode == control::position;
        case doing::turning: return is_enabled && drive().cached().mode == control::speed;
        case doing::save: return drive().state() == servobus::c630s::drive_state::disabled;
        default: return true;
        }
    }
    std::uint16_t harmless_register() const override { return servobus::c630s::jog_speed.address; }
    std::optional<places> feedback() const override {
        const auto seen = drive().feedback(oldest());
        if (!seen) return std::nullopt;
        return places{seen->position.count(), 0};
    }
    // Its position is in a block that is read with every eighth status, with requests of other blocks between.
    servobus::duration oldest() const override { return this->period() * 30 + servobus::milliseconds(500); }
    servobus::duration between_refreshes() const override { return this->period() * 16; }
    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::c630s::routines;
        static constexpr servobus::step stops[] = {stop_by_targets, zero_torque, servo_off, servo_off_marked,
                                                   stop_at_once};
        return is_one_of(stops, frame);
    }

    places shaft() override { return {view::place(model()), 0}; }
    places shown() override {
        return {static_cast<std::int32_t>(model().peek(servobus::c630s::absolute_position.address)), 0};
    }
    bool stands() override { return view::is_slow(model()); }
    bool has_power() override { return view::is_energised(model()) && !has_fault(); }
    bool has_fault() override { return view::has_fault(model()); }
    void fall_ill(scene& on) override {
        if (on.one_in(4)) return view::press_stop(model());
        view::have_fault(model());
    }
    bool shows_restarts_in_stop() const override { return false; }
    std::uint16_t marker_register() const override { return servobus::c630s::virtual_input_levels.address; }
    bool hides_restart(const std::vector<std::uint16_t>& words) const override {
        return words[0] == servobus::c630s::terminal::marker;
    }
    // Before the set-up its outputs have no meaning.
    bool shows_faults() const override {
        return drive().cached().state > servobus::c630s::drive_state::needs_power_cycle;
    }
    void recover() override {
        view::end_fault(model());
        view::release_stop(model());
    }

  private:
    auto& drive() { return base::drive; }
    const auto& drive() const { return base::drive; }
    using base::model;

    static servobus::words_view words_of(const std::vector<std::uint16_t>& words) {
        static std::array<std::uint8_t, 8> raw;
        for (std::size_t i = 0; i < words.size(); ++i) servobus::store_word(raw, 2 * i, words[i]);
        return servobus::words_view{servobus::bytes{raw}.first(2 * words.size())};
    }
    void hold(std::uint16_t address, std::uint16_t word) { (void)model().write(address, words_of({word})); }

    template <class Command> errc order(const Command& c) {
        const errc refusal = drive().begin(c).error();
        if (refusal == errc::ok) this->forget_goals();
        return refusal;
    }
    errc setting(scene& on, bool is_kept) {
        using namespace servobus::c630s;
        using namespace servobus::units;
        const auto ms = static_cast<std::int32_t>(on.between(10, 90));
        if (is_kept) return drive().begin(keep<acceleration_time>{servobus::checked(ms)}).error();
        const auto way = static_cast<std::int32_t>(draw_way(on, shown()[0], 1000, 9000));
        const auto speed = static_cast<std::int32_t>(on.between(60, 300));
        return drive().begin(segment{1, way * reference_unit, speed * r_per_min}).error();
    }
    errc move(scene&) {
        using namespace servobus::c630s;
        const places from = shaft();
        const errc refusal = drive().begin(start_segment{1}).error();
        constexpr auto way = position_segment_displacements[0];
        if (refusal == errc::ok) this->goal[0] = from[0] + model().in_force(way.address);
        return refusal;
    }
};

} // namespace trial
