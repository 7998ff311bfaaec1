// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of the ZLAC8015D with random commands.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/seen_machines.hpp>

#include "expected_end.hpp"
#include "facade.hpp"

namespace trial {

using wheels_participant = participant_of<plain_line, servobus::zlac8015d::device, servobus::sim::zlac8015d>;

class wheels final : public facade_of<wheels_participant, servobus::zlac8015d::drive<plain_line>> {
  public:
    wheels(wheels_participant& at, plain_line& on) : facade_of{at, on, supervision_of(at)} {}

    servobus::errc begin_any(scene& on) override {
        using namespace servobus::zlac8015d;
        if (drive.state() == drive_state::needs_init && !on.one_in(4)) return initialise();
        if (view::has_fault(model()) && !needs_init() && !on.one_in(4)) return reset_faults();
        const bool is_enabled = drive.state() == drive_state::enabled;
        if (is_enabled && !stands() && on.one_in(3)) return be_enabled_in(on);
        // A disable leaves the targets in their registers, and the next enable meets them.
        if (is_enabled && old_targets() != 0 && on.one_in(3)) return begin_end();
        if (drive.state() == drive_state::disabled && old_targets() != 0) {
            ++on.count->enabled_over_targets;
            return be_enabled_in(on);
        }
        switch (on.random.below(12)) {
        case 0: return initialise();
        case 1: return begin_stop(on);
        case 2: return begin(servobus::read_feedback{}, {.name = "read feedback"});
        case 3:
            if (is_enabled)
                return begin(servobus::wait_standstill{},
                             {.name = "wait for standstill",
                              // Wheels that were given a speed just before stood as they were read.
                              .is_carried_out = [this] { return stands() || motion() != 0; }});
            return reset_faults();
        case 4: return be_enabled_in(on);
        default: return is_enabled || needs_init() ? move(on) : be_enabled_in(on);
        }
    }
    servobus::errc begin_move_or_wait(scene& on) override {
        using namespace servobus::zlac8015d;
        const bool is_well = !needs_init() && !view::has_fault(model());
        if (drive.state() != drive_state::enabled) return is_well ? enable_for_moves(on) : begin_any(on);
        if (is_in_speed() || is_in_torque()) return on.one_in(4) ? begin_end() : begin_any(on);
        if (on.one_in(12)) return begin_stop(on);
        if (on.one_in(2)) return move_in_position(on);
        if (on.one_in(3))
            return begin(servobus::wait_standstill{}, {.name = "wait for standstill", .has_arrived = [this] {
                                                           return stands() && is_at_certain_goals();
                                                       }});
        const unsigned which = on.between(1, 3);
        return begin(wait_wheels_reached{static_cast<servobus::zlac8015d::wheels>(which),
                                         servobus::milliseconds(5'000)},
                     {.name = "wait for arrival", .has_arrived = [this, which] {
                          // A wheel that was not commanded to move has no target.
                          const unsigned moved = which & wheels_with_goal();
                          return is_at_goals(moved) && do_stand(moved);
                      }});
    }
    servobus::errc begin_motion(scene& on) override {
        using servobus::zlac8015d::drive_state;
        if (needs_init()) return initialise();
        return drive.state() == drive_state::enabled ? move(on) : be_enabled_in(on);
    }
    servobus::errc begin_stop(scene& on) override {
        using namespace servobus::zlac8015d;
        const std::uint32_t which = on.random.below(3);
        const bool has_halt = drive.state() != drive_state::enabled || is_in_speed() || is_in_torque();
        if (which == 0 && has_halt) return stop("halt", servobus::halt{});
        if (which == 1) return stop("quick stop", servobus::quick_stop{});
        return begin_end();
    }
    servobus::errc begin_end() override {
        return begin(servobus::disable{}, {.name = "disable", .is_stop = true, .is_carried_out = [this] {
                                               return is_off() && stands();
                                           }});
    }

    bool stands() override {
        if (model().stands_still()) return true;
        // If 20A2h reports "at rest" for a wheel that coasts, the facade can use only the speed, which
        // varies by 2 r/min at rest [errata B31].
        using options = servobus::sim::zlac8015d_options;
        if (chosen<options>().bit == options::running::turns) return false;
        return !view::is_turning(model());
    }
    std::uint32_t starts() override { return view::starts(model()); }
    std::uint32_t enables() override { return model().enables(); }
    std::uint64_t motion() override {
        using namespace servobus::zlac8015d;
        return model().in_watchdog_stop() ? 0 : resumed_motion();
    }
    std::uint64_t resumed_motion() override {
        using namespace servobus::zlac8015d;
        if (!model().enabled()) return 0;
        switch (model().mode()) {
        case mode::velocity: return targets(left_target_speed.address, right_target_speed.address);
        case mode::torque: return targets(left_target_torque.address, right_target_torque.address);
        default: return model().left().is_moving || model().right().is_moving ? model().starts() : 0;
        }
    }
    bool is_stopped_by_watchdog() override { return model().in_watchdog_stop(); }
    bool has_watchdog() const override { return true; }

    bool is_able() override { return view::is_energised(model()) && !has_fault(); }
    bool shows_plight() override {
        using options = servobus::sim::zlac8015d_options;
        return has_fault() || chosen<options>().after_quick_stop == options::stopped::emergency;
    }
    bool shows_restart_while_enabled() const override { return true; }
    bool has_goal() const override { return expected_ends_[0].is_known() || expected_ends_[1].is_known(); }
    bool is_at_goal() override { return is_at_goals(wheels_with_goal()); }
    void note_start() override {
        using namespace servobus::zlac8015d;
        expected_ends_[0].start(model().left().position, shown(left_actual_position.address));
        expected_ends_[1].start(model().right().position, shown(right_actual_position.address));
    }
    void note_end(bool is_done) override {
        for (expected_end& c : expected_ends_) c.end(is_done);
    }
    bool is_feedback(servobus::bytes frame) const override {
        return is_read_of(frame, servobus::zlac8015d::status_word.address);
    }
    bool is_enable(servobus::bytes frame) const override {
        return word_written(frame, servobus::zlac8015d::control_word.address, 0) == 0x08;
    }
    bool is_start(servobus::bytes frame) const override {
        return word_written(frame, servobus::zlac8015d::control_word.address, 0) >= 0x10;
    }
    bool changes_mode(servobus::bytes frame) const override {
        constexpr std::uint16_t none = 0xFFFF;
        return word_written(frame, servobus::zlac8015d::mode_of_operation.address, none) != none;
    }
    void suffer(scene& on) override {
        using servobus::zlac8015d::fault;
        if (on.one_in(2)) return view::press_stop(model());
        const std::uint32_t which = on.between(1, 3);
        model().raise((which & 1) != 0 ? fault::overcurrent : fault::none,
                      (which & 2) != 0 ? fault::overcurrent : fault::none);
    }
    void recover() override {
        view::release_stop(model());
        view::end_fault(model());
    }

    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::zlac8015d::routines;
        static constexpr servobus::step stops[] = {stop_by_targets, stop_by_command, zero_torque,
                                                   quick_stop_now};
        return is_one_of(stops, frame);
    }
    bool is_trigger(servobus::bytes frame) const override {
        using servobus::zlac8015d::control_code, servobus::zlac8015d::control_word;
        const std::uint16_t word = word_written(frame, control_word.address, 0);
        return word != 0 && word != static_cast<std::uint16_t>(control_code::stop) &&
               word != static_cast<std::uint16_t>(control_code::quick_stop);
    }
    bool is_setpoint(
        servobus::bytes frame) const override { // ramps 2080h..2083h, slope 2086h, targets 2088h, 2090h
        const unsigned first = servobus::load_word(frame, 2);
        return servobus::modbus::is_write(frame[1]) &&
               ((first >= 0x2080 && first <= 0x2089) || first == 0x2090 || first == 0x2091);
    }

  private:
    // Half of the programs supervise their commands.
    static servobus::supervision supervision_of(const wheels_participant& at) {
        unsigned sum = 0;
        for (const auto position : at.positions()) sum += static_cast<unsigned>(position);
        using servobus::milliseconds, servobus::no_command_timeout;
        if (sum % 2 == 0) return {.command_timeout = no_command_timeout};
        return {.command_timeout = milliseconds(400)};
    }
    using mode = servobus::zlac8015d::operating_mode;
    using view = seen::wheels;

    bool is_off() { return !model().enabled(); }
    std::uint64_t targets(std::uint16_t left, std::uint16_t right) {
        return std::uint64_t{model().peek(left)} << 16 | model().peek(right);
    }
    bool is_in_speed() const { return drive.cached().mode == mode::velocity; }
    bool is_in_torque() const { return drive.cached().mode == mode::torque; }

    bool has_fault() { return view::has_fault(model()); }
    std::int64_t shown(std::uint16_t address) {
        const std::uint32_t low = model().peek(static_cast<std::uint16_t>(address + 1));
        return static_cast<std::int32_t>(std::uint32_t{model().peek(address)} << 16 | low);
    }
    unsigned wheels_with_goal() const {
        return (expected_ends_[0].is_known() ? 1u : 0u) | (expected_ends_[1].is_known() ? 2u : 0u);
    }
    // `which`: bit 0 for the left wheel, bit 1 for the right one. Each within 20 counts of its target.
    bool is_at_goals(unsigned which) {
        constexpr std::int64_t window = 20;
        return ((which & 1u) == 0 || expected_ends_[0].is_end(model().left().position, window)) &&
               ((which & 2u) == 0 || expected_ends_[1].is_end(model().right().position, window));
    }
    bool is_at_certain_goals() {
        return is_at_goals((expected_ends_[0].is_certain() ? 1u : 0u) |
                           (expected_ends_[1].is_certain() ? 2u : 0u));
    }
    bool do_stand(unsigned which) {
        return ((which & 1u) == 0 || !view::is_turning(model().left())) &&
               ((which & 2u) == 0 || !view::is_turning(model().right()));
    }
    void forget_goals() {
        for (expected_end& c : expected_ends_) c.forget();
    }

    servobus::errc enable_for_moves(scene& on) {
        using servobus::zlac8015d::synchronisation;
        const mode wanted = on.one_in(2) ? mode::relative_position : mode::absolute_position;
        const auto starts = on.one_in(2) ? synchronisation::synchronous : synchronisation::asynchronous;
        const servobus::errc refusal =
            begin(servobus::zlac8015d::enable_in{servobus::checked(wanted), starts},
                  {.name = "enable for moves", .enables = true, .is_carried_out = [this, wanted] {
                       return model().enabled() && model().mode() == wanted;
                   }});
        if (refusal == servobus::errc::ok) forget_goals();
        return refusal;
    }
    template <class Move> servobus::errc begin_move(const Move& m, unsigned which, std::int64_t number) {
        const std::uint32_t before = starts();
        const servobus::errc refusal =
            begin(m, {.name = "move", .moves = true, .is_carried_out = [this, before] {
                          return starts() == before + 1;
                      }});
        const bool is_place = drive.cached().mode == mode::absolute_position;
        for (std::size_t i = 0; i < 2; ++i) {
            if ((which & 1u << i) == 0) continue;
            if (refusal == servobus::errc::ok) expected_ends_[i].command(number, is_place);
            // A move that is refused is the last one all the same.
            else if (refusal != servobus::errc::busy)
                expected_ends_[i].forget();
        }
        return refusal;
    }
    servobus::errc move_in_position(scene& on) {
        using namespace servobus::zlac8015d;
        using namespace servobus::units;
        const auto size = static_cast<std::int32_t>(on.one_in(4) ? on.between(1, 40) : on.between(50, 1500));
        const std::int32_t n = on.one_in(2) ? size : -size;
        const bool is_place = drive.cached().mode == mode::absolute_position;
        if (drive.cached().starts == synchronisation::synchronous) {
            return is_place ? begin_move(servobus::move_to{n * pulse, n * pulse}, 3, n)
                            : begin_move(servobus::move_by{n * pulse, n * pulse}, 3, n);
        }
        if (on.one_in(2))
            return is_place ? begin_move(move_left_to{n * pulse}, 1, n)
                            : begin_move(move_left_by{n * pulse}, 1, n);
        return is_place ? begin_move(move_right_to{n * pulse}, 2, n)
                        : begin_move(move_right_by{n * pulse}, 2, n);
    }

    servobus::errc initialise() {
        forget_goals();
        return begin(servobus::init{}, {.name = "init", .is_init = true, .is_carried_out = [this] {
                                            return is_off() && stands();
                                        }});
    }
    servobus::errc reset_faults() {
        return begin(servobus::fault_reset{},
                     {.name = "fault reset", .is_carried_out = [this] { return is_off(); }});
    }
    std::uint64_t old_targets() {
        using namespace servobus::zlac8015d;
        return targets(left_target_speed.address, right_target_speed.address) |
               targets(left_target_torque.address, right_target_torque.address);
    }
    servobus::errc be_enabled_in(scene& on) {
        static constexpr mode modes[] = {mode::velocity, mode::velocity, mode::torque,
                                         mode::relative_position};
        const mode wanted = modes[on.random.below(4)];
        forget_goals();
        return begin(servobus::zlac8015d::enable_in{servobus::checked(wanted)},
                     {.name = "enable", .enables = true, .is_carried_out = [this, wanted] {
                          return model().enabled() && model().mode() == wanted;
                      }});
    }
    servobus::errc move(scene& on) {
        using namespace servobus::zlac8015d;
        using namespace servobus::units;
        const auto size = static_cast<std::int32_t>(on.between(5, 150));
        const std::int32_t wanted = on.one_in(2) ? size : -size;
        const auto word = static_cast<std::uint16_t>(wanted);
        if (is_in_speed()) {
            return begin(servobus::velocity{wanted * r_per_min, wanted * r_per_min},
                         {.name = "velocity", .moves = true, .is_carried_out = [this, word] {
                              return model().peek(left_target_speed.address) == word &&
                                     model().peek(right_target_speed.address) == word;
                          }});
        }
        if (is_in_torque()) {
            return begin(torque{4 * wanted * milliampere, 4 * wanted * milliampere},
                         {.name = "torque", .moves = true, .is_carried_out = [this, wanted] {
                              return model().peek(left_target_torque.address) ==
                                     static_cast<std::uint16_t>(4 * wanted);
                          }});
        }
        if (drive.cached().mode == mode::absolute_position) return servobus::errc::wrong_state;
        return begin_move(servobus::move_by{10 * wanted * pulse, 10 * wanted * pulse}, 3, 10 * wanted);
    }

    std::array<expected_end, 2> expected_ends_; ///< of the left wheel and of the right one
};

} // namespace trial
