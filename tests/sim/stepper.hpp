// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of the closed-loop YAKOTEC with random commands.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/yako.hpp>
#include <servobus/sim/yako.hpp>

#include <tests/support/seen_machines.hpp>

#include "expected_end.hpp"
#include "facade.hpp"

namespace trial {

using stepper_participant =
    participant_of<plain_line, servobus::yako::closed_loop::device, servobus::sim::yako_closed_loop>;

class stepper final : public facade_of<stepper_participant, servobus::yako::closed_loop::drive<plain_line>> {
    using view = seen::stepper;

  public:
    using facade_of::facade_of;

    servobus::errc begin_any(scene& on) override {
        using namespace servobus::yako;
        if (drive.state() == drive_state::needs_init && !on.one_in(4)) return initialise();
        switch (on.random.below(drive.state() == drive_state::enabled || needs_init() ? 10 : 5)) {
        case 0: return initialise();
        case 1: return begin_stop(on);
        case 2: return begin(servobus::read_feedback{}, {.name = "read feedback"});
        case 3: return begin(servobus::fault_reset{}, {.name = "fault reset"});
        case 4: return energise();
        default: return move(on);
        }
    }
    servobus::errc begin_move_or_wait(scene& on) override {
        using namespace servobus::yako;
        if (drive.state() != drive_state::enabled) return begin_any(on);
        if (on.one_in(12)) return begin_stop(on);
        if (on.one_in(2)) return move(on);
        if (on.one_in(3))
            return begin(servobus::wait_standstill{servobus::milliseconds(5'000)},
                         {.name = "wait for standstill", .has_arrived = [this] {
                              return stands() && (!expected_end_.is_certain() || is_at_goal());
                          }});
        return begin(servobus::wait_reached{servobus::milliseconds(5'000)},
                     {.name = "wait for arrival", .has_arrived = [this] {
                          return stands() && (!expected_end_.is_known() || is_at_goal());
                      }});
    }
    servobus::errc begin_motion(scene& on) override {
        using servobus::yako::drive_state;
        if (needs_init()) return initialise();
        return drive.state() == drive_state::enabled ? move(on) : energise();
    }
    servobus::errc begin_stop(scene& on) override {
        switch (on.random.below(3)) {
        case 0: return stop("stop", servobus::halt{});
        case 1: return stop("quick stop", servobus::quick_stop{});
        default: return begin_end();
        }
    }
    servobus::errc begin_end() override {
        return begin(servobus::disable{}, {.name = "release", .is_stop = true, .is_carried_out = [this] {
                                               return !model().enabled() && stands();
                                           }});
    }

    bool stands() override { return !view::is_turning(model()); }
    std::uint32_t starts() override { return view::starts(model()); }
    std::uint32_t enables() override { return 0; }
    std::uint64_t motion() override { return std::uint64_t{1} + starts(); }

    bool has_witness() const override { return true; }
    bool shows_restarts() const override {
        return chosen<servobus::sim::yako_options>().kept != servobus::sim::yako_kept::written;
    }

    bool is_able() override { return view::is_energised(model()) && !view::has_fault(model()); }
    bool has_targets() const override { return false; }
    bool has_goal() const override { return expected_end_.is_known(); }
    bool is_at_goal() override {
        constexpr std::int64_t window = 5;
        return expected_end_.is_end(view::place(model()), window);
    }
    void note_start() override { expected_end_.start(view::place(model()), 0); }
    void note_end(bool is_done) override { expected_end_.end(is_done); }
    bool is_feedback(servobus::bytes frame) const override {
        return is_read_of(frame, servobus::yako::error_code.address);
    }
    bool is_enable(servobus::bytes frame) const override {
        using servobus::yako::auxiliary;
        return word_written(frame, servobus::yako::auxiliary_command.address, 0) ==
               static_cast<std::uint16_t>(auxiliary::enable);
    }
    bool is_start(servobus::bytes frame) const override {
        using namespace servobus::yako;
        return motion_code::from_word(word_written(frame, motion_command.address, 0)).is_start();
    }
    void suffer(scene& on) override {
        using servobus::yako::input_function;
        switch (on.random.below(3)) {
        case 0: return model().raise_alarm(static_cast<std::uint16_t>(on.between(1, 5)));
        case 1: return press(input_function::motor_free);
        default: return press(input_function::stop);
        }
    }
    void recover() override {
        view::end_fault(model());
        view::release_stop(model());
    }

    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::yako::routines;
        static constexpr servobus::step stops[] = {stop_now, quick_stop_now, release_now};
        return is_one_of(stops, frame);
    }
    bool is_trigger(servobus::bytes frame) const override {
        using namespace servobus::yako;
        const std::uint16_t help = word_written(frame, auxiliary_command.address, 0);
        return motion_code::from_word(word_written(frame, motion_command.address, 0)).is_start() ||
               (help != 0 && help != static_cast<std::uint16_t>(auxiliary::release));
    }

  private:
    // Wires the input X3 and closes its contact.
    void press(servobus::yako::input_function what) {
        const std::array<std::uint8_t, 2> word{0, static_cast<std::uint8_t>(what)};
        (void)model().write(servobus::yako::x3_function.address, servobus::words_view{word});
        model().set_input(3, true);
    }

    servobus::errc initialise() {
        expected_end_.forget();
        return begin(servobus::init{},
                     {.name = "init", .is_init = true, .is_carried_out = [this] { return stands(); }});
    }
    servobus::errc energise() {
        return begin(servobus::enable{}, {.name = "enable", .enables = true, .is_carried_out = [this] {
                                              return model().enabled();
                                          }});
    }
    servobus::errc move(scene& on) {
        using namespace servobus::yako;
        using namespace servobus::units;
        const std::uint32_t before = starts();
        const auto size = static_cast<std::int32_t>(on.between(20, 300));
        const std::int32_t way = on.one_in(2) ? size : -size;
        const auto has_begun = [this, before] { return starts() == before + 1; };
        if (on.one_in(4)) {
            const servobus::errc refusal = begin(servobus::velocity{way * r_per_min},
                                                 {.name = "jog", .moves = true, .is_carried_out = has_begun});
            if (refusal == servobus::errc::ok) expected_end_.command_endless();
            return refusal;
        }
        const motion_profile by{20 * r_per_min, 50 * millisecond, 50 * millisecond, 120 * r_per_min};
        const std::int32_t pulses = on.one_in(4) ? way / 20 : 50 * way;
        const servobus::errc refusal = begin(servobus::move_by{pulses * pulse, by},
                                             {.name = "move", .moves = true, .is_carried_out = has_begun});
        if (refusal == servobus::errc::ok) expected_end_.command(pulses);
        return refusal;
    }

    expected_end expected_end_;
};

} // namespace trial
