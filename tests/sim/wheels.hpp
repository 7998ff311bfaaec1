// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of the ZLAC8015D with random commands.
#pragma once

#include <cstdint>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "facade.hpp"

namespace trial {

using wheels_seat = seat_of<plain_line, servobus::zlac8015d::device, servobus::sim::zlac8015d>;

class wheels final : public facade_of<wheels_seat, servobus::zlac8015d::drive<plain_line>> {
  public:
    wheels(wheels_seat& at, plain_line& on) : facade_of{at, on, supervision_of(at)} {}

    servobus::errc begin_any(scene& on) override {
        using namespace servobus::zlac8015d;
        if (drive.state() == drive_state::needs_init && !on.one_in(4)) return initialise();
        const bool is_enabled = drive.state() == drive_state::enabled;
        switch (on.random.below(is_enabled || needs_init() ? 12 : 5)) {
        case 0: return initialise();
        case 1: return begin_stop(on);
        case 2: return begin(read_feedback{}, {.name = "read feedback"});
        case 3:
            if (is_enabled)
                return begin(wait_standstill{},
                             {.name = "wait for standstill", .is_carried_out = [this] { return stands(); }});
            return begin(fault_reset{},
                         {.name = "fault reset", .is_carried_out = [this] { return is_off(); }});
        case 4: return enable_in(on);
        default: return move(on);
        }
    }
    servobus::errc begin_motion(scene& on) override {
        using servobus::zlac8015d::drive_state;
        if (needs_init()) return initialise();
        return drive.state() == drive_state::enabled ? move(on) : enable_in(on);
    }
    servobus::errc begin_stop(scene& on) override {
        using namespace servobus::zlac8015d;
        const std::uint32_t which = on.random.below(3);
        const bool has_halt = drive.state() != drive_state::enabled || is_in_speed() || is_in_torque();
        if (which == 0 && has_halt) return stop("halt", halt{});
        if (which == 1) return stop("quick stop", quick_stop{});
        return begin_end();
    }
    servobus::errc begin_end() override {
        return begin(
            servobus::zlac8015d::disable{},
            {.name = "disable", .is_stop = true, .is_carried_out = [this] { return is_off() && stands(); }});
    }

    bool stands() override {
        if (model().stands_still()) return true;
        // If 20A2h reports "at rest" for a wheel that coasts, the facade can use only the speed, which
        // varies by 2 r/min at rest [errata B31].
        using options = servobus::sim::zlac8015d_options;
        if (chosen<options>().bit == options::running::turns) return false;
        return is_slow(model().left()) && is_slow(model().right());
    }
    std::uint32_t starts() override { return model().starts(); }
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
    bool is_setpoint(servobus::bytes frame) const override { // ramps 2080h..2083h, slope 2086h, targets 2088h, 2090h
        const unsigned first = servobus::load_word(frame, 2);
        return servobus::modbus::is_write(frame[1]) &&
               ((first >= 0x2080 && first <= 0x2089) || first == 0x2090 || first == 0x2091);
    }

  private:
    // Half of the programs supervise their commands.
    static servobus::supervision supervision_of(const wheels_seat& at) {
        unsigned sum = 0;
        for (const auto position : at.positions()) sum += static_cast<unsigned>(position);
        using servobus::milliseconds, servobus::no_command_timeout;
        if (sum % 2 == 0) return {.command_timeout = no_command_timeout};
        return {.command_timeout = milliseconds(400)};
    }
    using mode = servobus::zlac8015d::operating_mode;

    static bool is_slow(const servobus::sim::wheel_view& w) {
        constexpr std::int64_t too_fast = 2'100'000; // 10^-6 r/min; the register rounds down to 0.1 r/min
        return w.speed < too_fast && w.speed > -too_fast && !w.is_moving;
    }
    bool is_off() { return !model().enabled(); }
    std::uint64_t targets(std::uint16_t left, std::uint16_t right) {
        return std::uint64_t{model().peek(left)} << 16 | model().peek(right);
    }
    bool is_in_speed() const { return drive.cached().mode == mode::velocity; }
    bool is_in_torque() const { return drive.cached().mode == mode::torque; }

    servobus::errc initialise() {
        return begin(servobus::zlac8015d::init{}, {.name = "init", .is_init = true, .is_carried_out = [this] {
                                                       return is_off() && stands();
                                                   }});
    }
    servobus::errc enable_in(scene& on) {
        static constexpr mode modes[] = {mode::velocity, mode::velocity, mode::torque,
                                         mode::relative_position};
        const mode wanted = modes[on.random.below(4)];
        return begin(servobus::zlac8015d::enable{servobus::checked(wanted)},
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
            return begin(velocity{wanted * r_per_min, wanted * r_per_min},
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
        const std::uint32_t before = starts();
        return begin(move_by{10 * wanted * pulse, 10 * wanted * pulse},
                     {.name = "move", .moves = true, .is_carried_out = [this, before] {
                          return starts() == before + 1;
                      }});
    }
};

} // namespace trial
