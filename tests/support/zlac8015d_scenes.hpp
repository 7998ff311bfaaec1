// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every command of the ZLAC8015D facade, for tests that play it with an event at each of its frames: the states in
// which commands begin, how the drive is when they are done, and what a command may have done that failed.
#pragma once

#include <array>
#include <functional>
#include <string>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/zlac8015d_interpretations.hpp>

namespace zlac8015d_scenes {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using rig = simulated::driven_zlac8015d;

using enum operating_mode;
using enum synchronisation;
using drive_type = zlac8015d::drive<rig::line_type>;
using zlac8015d_interpretations::options;

constexpr auto zero_targets = modbus::write_frame(1, 0x2088, std::array<u16, 2>{0, 0});
constexpr auto zero_torques = modbus::write_frame(1, 0x2090, std::array<u16, 2>{0, 0});
constexpr auto stop_frame = modbus::write_frame(1, 0x200E, 0x07);
constexpr auto quick_stop_frame = modbus::write_frame(1, 0x200E, 0x05);

inline bool is_stop(bytes f) {
    return same_bytes(f, zero_targets) || same_bytes(f, zero_torques) || same_bytes(f, stop_frame) ||
           same_bytes(f, quick_stop_frame);
}
inline bool is_write(bytes f) { return modbus::is_write(f[1]); }

// The states in which commands begin.

inline void take(rig& r) {
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(ramps{40 * millisecond, 40 * millisecond}));
    REQUIRE(r.drive.run(quick_stop_ramp{40 * millisecond}));
    REQUIRE(r.drive.run(torque_slope{30'000 * milliampere_per_second}));
}
inline void take_finer(rig& r) {
    r.have_resolution(10);
    take(r);
    REQUIRE(r.drive.run(watchdog{800 * millisecond}));
}
template <operating_mode Mode, synchronisation Starts = synchronous> void enabled_in(rig& r) {
    take(r);
    REQUIRE(r.drive.run(enable_in{checked(Mode), Starts}));
}
inline void run_at_speed(rig& r) {
    enabled_in<operating_mode::velocity>(r);
    REQUIRE(r.drive.run(servobus::velocity{90 * r_per_min, -90 * r_per_min}));
    r.wire.pass(milliseconds(60));
}
inline void run_by_torque(rig& r) {
    enabled_in<operating_mode::torque>(r);
    REQUIRE(r.drive.run(zlac8015d::torque{500 * milliampere, 500 * milliampere}));
    r.wire.pass(milliseconds(60));
}
inline void run_to_a_place(rig& r) {
    enabled_in<relative_position>(r);
    REQUIRE(r.drive.run(move_by{100 * pulse, 100 * pulse}));
}
inline void run_left_alone(rig& r) {
    enabled_in<relative_position, asynchronous>(r);
    REQUIRE(r.drive.run(move_left_by{100 * pulse}));
}
inline void stand_away_from_zero(rig& r) {
    run_to_a_place(r);
    REQUIRE(r.drive.run(wait_standstill{}));
}
// An earlier program left the wheels turning. The facade has not been initialised.
inline void run_unknown(rig& r) {
    drive_type earlier{r.line, 1, unsupervised};
    REQUIRE(earlier.run(init{}));
    REQUIRE(earlier.run(ramps{40 * millisecond, 40 * millisecond}));
    REQUIRE(earlier.run(quick_stop_ramp{40 * millisecond}));
    REQUIRE(earlier.run(enable{}));
    REQUIRE(earlier.run(servobus::velocity{90 * r_per_min, -90 * r_per_min}));
    r.wire.pass(milliseconds(60));
}
inline void look_late(rig& r) {
    enabled_in<operating_mode::velocity>(r);
    r.wire.pass(milliseconds(550));
}
inline void have_a_fault(rig& r) {
    run_at_speed(r);
    r.model.raise(fault::overcurrent, {});
    r.model.end_faults();
}
inline void have_had_a_fault(rig& r) {
    have_a_fault(r);
    r.wire.pass(milliseconds(3000));
    REQUIRE(r.drive.run(init{}));
}

// Checks of the drive for when a command is done.

// If the running bits do not show every turning wheel, the speeds do, down to 2 r/min.
inline bool is_still(const rig& r) {
    if (r.interpretations.bit == options::running::turns) return r.model.stands_still();
    const auto is_slow = [](const sim::wheel_view& w) {
        return w.speed <= 2'050'000 && w.speed >= -2'050'000;
    };
    return is_slow(r.model.left()) && is_slow(r.model.right());
}
inline bool rests(rig& r) { return is_still(r) && !r.model.enabled(); }
template <u16 Address> bool has_halted(rig& r) {
    return is_still(r) && r.model.peek(Address) == 0 && r.model.peek(Address + 1) == 0;
}
inline bool stands(rig& r) { return is_still(r); }
inline bool is_held(rig& r) {
    return is_still(r) && r.model.peek(0x20A2) == status_flags::both_stopped_in_emergency;
}
template <operating_mode Mode> bool is_in(rig& r) {
    return r.model.enabled() && r.model.mode() == Mode &&
           r.drive.cached().resolution == r.model.resolution() &&
           r.drive.cached().host_timeout == r.model.peek(0x2000) &&
           (Mode == operating_mode::velocity || Mode == operating_mode::torque || r.model.peek(0x200F) == 1);
}
inline bool has_started(rig& r) { return r.model.starts() == 1; }
inline bool has_started_again(rig& r) { return r.model.starts() == 2; }
inline bool has_arrived(rig& r) {
    return is_still(r) && r.model.left().position == 100 && r.model.right().position == 100;
}
inline bool has_arrived_left(rig& r) { return is_still(r) && r.model.left().position == 100; }
inline bool is_healthy(rig& r) { return r.model.peek(0x20A5) == 0 && r.model.peek(0x20A6) == 0; }
inline bool is_off(rig& r) { return !r.model.enabled(); }
inline bool is_kept(rig& r) { return r.model.saves() == r.saves + 1; }
inline bool always(rig&) { return true; }
template <u16 Address, u16 Value> bool has(rig& r) { return r.model.peek(Address) == Value; }
template <u16 Address, u16 Left, u16 Right> bool has_pair(rig& r) {
    return has<Address, Left>(r) && has<Address + 1, Right>(r);
}

struct row {
    std::string name;
    void (*prepare)(rig&);
    std::function<command_status(drive_type&)> begin;
    bool (*is_done)(rig&);
};
template <class Command> auto command_to(Command wanted) {
    return [wanted](drive_type& d) { return d.begin(wanted); };
}

// clang-format off
const row commands[] = {
    {"init",                 run_unknown,                                 command_to(init{}),                             rests},
    {"enable, velocity",     take,                                        command_to(enable_in{operating_mode::velocity}),   is_in<operating_mode::velocity>},
    {"enable, finer",        take_finer,                                  command_to(enable_in{operating_mode::velocity}),   is_in<operating_mode::velocity>},
    {"enable, torque",       take,                                        command_to(enable_in{operating_mode::torque}),     is_in<operating_mode::torque>},
    {"enable, relative",     take,                                        command_to(enable_in{relative_position}),          is_in<relative_position>},
    {"enable, absolute",     take,                                        command_to(enable_in{absolute_position}),          is_in<absolute_position>},
    {"disable",              run_at_speed,                                command_to(disable{}),                          rests},
    {"disable, unknown",     run_unknown,                                 command_to(disable{}),                          rests},
    {"halt, velocity",       run_at_speed,                                command_to(halt{}),                             has_halted<0x2088>},
    {"halt, torque",         run_by_torque,                               command_to(halt{}),                             has_halted<0x2090>},
    {"halt, unknown",        run_unknown,                                 command_to(halt{}),                             rests},
    {"quick_stop",           run_at_speed,                                command_to(quick_stop{}),                       is_held},
    {"quick_stop, unknown",  run_unknown,                                 command_to(quick_stop{}),                       is_held},
    {"quick_stop, disabled", take,                                        command_to(quick_stop{}),                       rests},
    {"fault_reset",          have_had_a_fault,                            command_to(fault_reset{}),                      is_healthy},
    {"velocity",             enabled_in<operating_mode::velocity>,        command_to(servobus::velocity{50 * r_per_min, 70 * r_per_min}), has_pair<0x2088, 50, 70>},
    {"left_velocity",        enabled_in<operating_mode::velocity>,        command_to(left_velocity{50 * r_per_min}),      has<0x2088, 50>},
    {"right_velocity",       enabled_in<operating_mode::velocity>,        command_to(right_velocity{70 * r_per_min}),     has<0x2089, 70>},
    {"clamped_velocity",     enabled_in<operating_mode::velocity>,        command_to(clamped_velocity{50 * r_per_min, 70 * r_per_min}), has_pair<0x2088, 50, 70>},
    {"torque",               enabled_in<operating_mode::torque>,          command_to(zlac8015d::torque{300 * milliampere, 200 * milliampere}), has_pair<0x2090, 300, 200>},
    {"left_torque",          enabled_in<operating_mode::torque>,          command_to(left_torque{300 * milliampere}),     has<0x2090, 300>},
    {"right_torque",         enabled_in<operating_mode::torque>,          command_to(right_torque{200 * milliampere}),    has<0x2091, 200>},
    {"move_by",              enabled_in<relative_position>,               command_to(move_by{60 * pulse, 60 * pulse}),    has_started},
    {"move_by, from there",  stand_away_from_zero,                        command_to(move_by{60 * pulse, 60 * pulse}),    has_started_again},
    {"move_left_by",         enabled_in<relative_position, asynchronous>, command_to(move_left_by{60 * pulse}),           has_started},
    {"move_right_by",        enabled_in<relative_position, asynchronous>, command_to(move_right_by{60 * pulse}),          has_started},
    {"move_to",              enabled_in<absolute_position>,               command_to(move_to{60 * pulse, 60 * pulse}),    has_started},
    {"move_left_to",         enabled_in<absolute_position, asynchronous>, command_to(move_left_to{60 * pulse}),           has_started},
    {"move_right_to",        enabled_in<absolute_position, asynchronous>, command_to(move_right_to{60 * pulse}),          has_started},
    {"stand",                run_to_a_place,                              command_to(wait_standstill{}),                            stands},
    {"wait_reached",         run_to_a_place,                              command_to(wait_reached{milliseconds(5'000)}), has_arrived},
    {"wait_reached, left",   run_left_alone,                              command_to(wait_wheels_reached{wheels::left, milliseconds(5'000)}), has_arrived_left},
    {"read_feedback",        enabled_in<operating_mode::velocity>,        command_to(read_feedback{}),                    always},
    {"read_feedback, mode",  look_late,                                   command_to(read_feedback{}),                    always},
    {"read_feedback, fault", have_a_fault,                                command_to(read_feedback{}),                    is_off},
    {"ramps",                take,                                        command_to(ramps{70 * millisecond, 80 * millisecond}), has_pair<0x2080, 70, 70>},
    {"quick_stop_ramp",      take,                                        command_to(quick_stop_ramp{15 * millisecond}),  has_pair<0x2084, 15, 15>},
    {"quick_stop_by",        take,                                        command_to(quick_stop_by{quick_stop_option::immediate}), has<0x2011, 7>},
    {"torque_slope",         take,                                        command_to(torque_slope{20'000 * milliampere_per_second}), has_pair<0x2086, 20'000, 20'000>},
    {"position_speed",       take,                                        command_to(position_speed{77 * r_per_min, 78 * r_per_min}), has_pair<0x208E, 77, 78>},
    {"brakes",               take,                                        command_to(brakes{brake::code_1, brake::code_1}), has_pair<0x201A, 1, 1>},
    {"on_input_stop",        take,                                        command_to(on_input_stop{static_cast<input_stop_action>(1)}), has<0x2021, 1>},
    {"park",                 take,                                        command_to(park{static_cast<off_on>(1)}),       has<0x200C, 1>},
    {"clear_position",       take,                                        command_to(clear_position{}),                   always},
    {"save",                 take,                                        command_to(save{}),                             is_kept},
    {"factory_reset",        take,                                        command_to(factory_reset{sole_drive_on_the_line{}}), has_pair<0x2080, 500, 500>},
    {"watchdog",             take,                                        command_to(watchdog{700 * millisecond}),        has<0x2000, 700>},
    {"resolution",           take,                                        command_to(resolution{10}),                     has<0x2022, 10>},
};
// clang-format on

// Commands that cannot succeed under an interpretation of the manual, and report it [errata B30 to B32].

inline bool has(const std::string& name, const char* part) { return name.find(part) != name.npos; }
/// True if the preparation of the command can succeed under this interpretation.
inline bool can_begin(const row& o, const options& of) {
    if (of.in_torque_mode == options::shaft::released && has(o.name, "torque") && o.prepare != take)
        return false;
    return of.bit != options::running::enabled ||
           (o.prepare != run_to_a_place && o.prepare != run_left_alone && o.prepare != stand_away_from_zero);
}
inline bool ends_well(const row& o, const options& of) {
    if (of.in_torque_mode == options::shaft::released && o.name == "enable, torque") return false;
    if (of.after_quick_stop == options::stopped::locked && o.is_done == is_held) return false;
    if (of.code == options::fault_code::until_restart && o.name == "fault_reset") return false;
    const bool needs_standstill = has(o.name, "move_") || has(o.name, "stand") ||
                                  has(o.name, "wait_reached") || has(o.name, "halt, velocity") ||
                                  has(o.name, "halt, torque");
    return of.bit != options::running::enabled || !needs_standstill;
}

/// A command in progress.
struct scene : rig {
    const row& of;
    std::size_t first; // frame of the command
    std::uint32_t asked;
    std::uint32_t starts;
    std::uint32_t enables;

    explicit scene(const row& wanted, bool locks_at_power_on = false, const options& chosen = {})
        : rig{chosen}, of{wanted} {
        if (locks_at_power_on) {
            set_by_hand(0x2007, 1);
            save_by_hand();
        }
        of.prepare(*this);
        first = log.frames.size();
        asked = wire.requests();
        starts = model.starts();
        enables = model.enables();
        REQUIRE(of.begin(drive) == errc::ok);
    }

    std::size_t frames() const { return log.frames.size() - first; }
    /// The number of frames of which the first byte has been sent.
    std::size_t begun() const { return wire.requests() - asked; }
    /// The command ended before the event: it is done.
    bool is_over() {
        CHECK(static_cast<bool>(drive.last()) == ends_well(of, interpretations));
        if (drive.last()) CHECK(of.is_done(*this));
        return false;
    }
    /// The longest time that the call may take after the line is lost: three stops of three tries, or the
    /// read after a start.
    std::uint64_t longest_end_us() const { return 10u * line.bound(24, 64, {}, {{}, milliseconds(100)}).us; }

    void turn() {
        const duration idle = drive.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    template <class Before> void play(Before before_each_turn) {
        const std::uint64_t end =
            wire.time_us() + (ends_well(of, interpretations) ? 5'000'000u : 70'000'000u);
        for (tests::loop_bound left{"the end of a command"}; !drive.is_idle(); left.use()) {
            before_each_turn();
            turn();
            if (wire.time_us() > end) FAIL("it does not end");
        }
    }
    void reconnect() {
        wire.set_connected(0, true);
        wire.faults() = {};
    }

    /// G15: no write but a stop was sent twice.
    void check_once() {
        for (std::size_t i = first; i < log.frames.size(); ++i) {
            if (is_write(log.frames[i]) && !is_stop(log.frames[i]))
                for (std::size_t j = first; j < i; ++j) CHECK_FALSE(log.frames[i] == log.frames[j]);
        }
        CHECK(model.starts() <= starts + 1);
        CHECK(model.enables() <= enables + 1);
    }
    /// G16, G21: a command that was not sent wrote nothing, a setpoint that was not executed is not in the
    /// drive, and any other unknown outcome invalidates the cached state.
    void check_failure() {
        const command_status r = drive.last();
        CHECK((r.outcome() == outcome::not_sent || r.outcome() == outcome::unknown || model.refused != 0));
        if (r.error() == errc::not_executed) {
            CHECK_FALSE(of.is_done(*this));
            return;
        }
        if (r.outcome() == outcome::unknown) CHECK(drive.state() == drive_state::needs_init);
        if (r.outcome() != outcome::not_sent) return;
        for (std::size_t i = first; i < log.frames.size(); ++i) CHECK_FALSE(is_write(log.frames[i]));
    }
    /// What the facade says of the drive is so.
    void check_cache() {
        const cached_settings& known = drive.cached();
        if (known.state == drive_state::needs_init) return;
        if (of.prepare != have_a_fault) // which only a response shows
            CHECK((known.state == drive_state::enabled) == model.enabled());
        if (known.state != drive_state::needs_power_cycle) CHECK(known.resolution == model.resolution());
        CHECK(known.host_timeout == model.peek(0x2000));
        if (known.state == drive_state::enabled) CHECK(known.mode == model.mode());
    }
    void check_motion() {
        if (drive.motion() == motion_check::seen) CHECK(model.starts() == starts + 1);
        if (model.starts() == starts) CHECK(drive.motion() != motion_check::seen);
    }
};

/// Plays `scene_at(row, n)` for n = 0, 1, 2 .. as long as it returns that its event has occurred. Returns the
/// number of scenes. A command that cannot succeed is long, so only its beginning is played.
template <class Scene> std::size_t at_every_frame(const options& of, Scene scene_at) {
    std::size_t scenes = 0;
    for (const row& o : commands) {
        if (!can_begin(o, of)) continue;
        CAPTURE(o.name);
        const std::size_t most = ends_well(o, of) ? 1000 : 30;
        std::size_t n = 0;
        while (n < most && scene_at(o, n)) ++n;
        CHECK(n > 0);
        scenes += n;
    }
    return scenes;
}
/// `servobus::commands` is a namespace, visible to the tests.
constexpr const auto& command_rows = commands;

template <class Scene> std::size_t at_every_frame(Scene scene_at) { return at_every_frame({}, scene_at); }

} // namespace zlac8015d_scenes
