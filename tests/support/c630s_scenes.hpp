// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every command of the C630S facade as a row of one table, for tests that disturb it at each of its frames: the state
// in which it begins (c630s_states.hpp), how the drive is when it is done, and what it may send once. A port that
// transfers whole frames counts them, so that no frame is left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/c630s_states.hpp>

namespace c630s_scenes {

struct command {
    std::function<command_status(d&)> run;
    std::function<command_status(d&)> begin;
};
template <class Wanted> command command_to(Wanted wanted) {
    return {[wanted](d& x) { return x.run(wanted); }, [wanted](d& x) { return x.begin(wanted); }};
}

/// A command, the state in which it begins, and a check of the drive for when it is done.
struct row {
    std::string name;
    state from;
    command asked;
    bool (*is_done)(rig&) = [](rig&) { return true; };
    const sim::c630s& (*model)() = ready_drive;
};

inline bool is_off(rig& r) { return !r.model().enabled() && r.model().stands_still(); }
template <control_mode Mode> bool is_enabled_in(rig& r) {
    return r.model().enabled() && r.held(mode_of_operation.address) == static_cast<int>(Mode);
}
template <const auto& R, int Value> bool holds(rig& r) { return r.held(R.address) == Value; }
template <const auto& R, int Value> bool is_stored(rig& r) { return r.model().stored(R.address) == Value; }
template <const auto& R, int Value> bool is_kept(rig& r) {
    return r.model().stored(R.address) == Value && r.held(eeprom_update.address) == 0;
}
inline bool is_healthy(rig& r) { return is_off(r) && !r.model().has_fault(); }
inline bool stands(rig& r) { return r.model().stands_still(); }
inline bool makes_a_move(rig& r) { return r.model().starts() == 1 && r.model().enabled(); }
inline bool makes_a_segment(rig& r) { return present().segment_start_is_level ? stands(r) : makes_a_move(r); }
// 300 reference units from where the preparation began: 3932 encoder counts, within P05-21 and the rounding.
inline bool has_arrived(rig& r) {
    const std::int64_t missing = 3932 - r.model().position();
    const std::int64_t near = r.held(positioning_completed_threshold.address) + 2;
    return stands(r) && missing <= near && -missing <= near;
}
template <output_function F> bool is_home(rig& r) { return r.model().is_active(F) && stands(r); }
constexpr auto third_way = position_segment_displacements[2];
constexpr auto third_speed = speed_segment_speeds[2];

// clang-format off
const row command_rows[] = {
    {"init",                unknown,     command_to(init{}), is_off},
    {"init, turning",       turning,     command_to(init{}), is_off},
    {"init, factory",       unknown,     command_to(init{}), is_off, factory_drive},
    {"set_up",              disabled,    command_to(set_up{}), is_kept<virtual_inputs_enable, 1>, factory_drive},
    {"set_up, again",       disabled,    command_to(set_up{}), is_stored<virtual_inputs_enable, 1>},
    {"enable, speed",       disabled,    command_to(enable_in{control_mode::speed}), is_enabled_in<control_mode::speed>},
    {"enable, torque",      disabled,    command_to(enable_in{control_mode::torque}), is_enabled_in<control_mode::torque>},
    {"enable, position",    disabled,    command_to(enable_in{control_mode::position}), is_enabled_in<control_mode::position>},
    {"run_speed_segments",  disabled,    command_to(run_speed_segments{}), is_enabled_in<control_mode::speed>},
    {"disable",             turning,     command_to(disable{}), is_off},
    {"disable, moving",     moving,      command_to(disable{}), is_off},
    {"disable, unknown",    unknown,     command_to(disable{}), is_off},
    {"halt, speed",         turning,     command_to(halt{}), stands},
    {"halt, torque",        pushing,     command_to(halt{}), holds<target_torque, 0>},
    {"halt, jog",           jogging,     command_to(halt{}), stands},
    {"halt, unknown",       unknown,     command_to(halt{}), is_off},
    {"quick_stop",          turning,     command_to(quick_stop{}), stands},
    {"quick_stop, moving",  moving,      command_to(quick_stop{}), stands},
    {"quick_stop, run",     in_run,      command_to(quick_stop{}), is_off},
    {"quick_stop, speeds",  in_segments, command_to(quick_stop{}), is_off},
    {"fault_reset",         with_fault,  command_to(fault_reset{}), is_healthy},
    {"fault_reset, on",     turning,     command_to(fault_reset{}), is_off},
    {"fault_reset, factory", with_fault, command_to(fault_reset{}), is_healthy, factory_drive},
    {"reset_encoder",       with_battery_fault, command_to(reset_encoder{}), is_healthy},
    {"reset_encoder, factory", with_battery_fault, command_to(reset_encoder{}), is_healthy, factory_drive},
    {"restart",             disabled,    command_to(restart{}), is_off},
    {"factory_reset",       disabled,    command_to(factory_reset{sole_drive_on_the_line{}}), holds<max_speed, 5000>},
    {"change_address",      disabled,    command_to(c630s::change_address{9, sole_drive_on_the_line{}}), holds<node_address, 9>},
    {"change_line",         disabled,    command_to(change_line{baud_rate::baud_19200}), holds<rs485_baud_rate, 3>},
    {"clear_fault_history", disabled,    command_to(clear_fault_history{})},
    {"velocity",            in_speed,    command_to(velocity{60 * r_per_min}), holds<target_speed, 60>},
    {"velocity, reading",   long_in<in_speed>, command_to(velocity{60 * r_per_min}), holds<target_speed, 60>},
    {"torque",              in_torque,   command_to(torque{5 * percent}), holds<target_torque, 50>},
    {"torque, reading",     long_in<in_torque>, command_to(torque{5 * percent}), holds<target_torque, 50>},
    {"jog",                 in_speed,    command_to(jog{-60 * r_per_min}), holds<virtual_input_levels, terminal::servo_on | terminal::jog_reverse | terminal::marker>},
    {"select_speed_segment", in_segments, command_to(select_speed_segment{2}), holds<virtual_input_levels, terminal::servo_on | terminal::for_segment(1) | terminal::marker>},
    {"start_segment",       in_position, command_to(start_segment{2}), makes_a_segment},
    {"start_segments",      before_run,  command_to(start_segments{}), makes_a_segment},
    {"make_step",           in_steps,    command_to(make_step{}), makes_a_move},
    {"wait_standstill",     moving,      command_to(wait_standstill{}), stands},
    {"wait_reached",       moving,      command_to(wait_reached{}), has_arrived},
    {"wait_standstill, speed", in_speed,    command_to(wait_standstill{}), stands},
    {"home",                before_home, command_to(home{5 * second}), is_home<output_function::home_attained>},
    {"home_electrically",   moved,       command_to(home_electrically{5 * second}), is_home<output_function::electrical_home_attained>},
    {"set_home",            moved,       command_to(set_home{}), holds<absolute_position, 0>},
    {"segment",             in_position, command_to(segment{3, 70'000 * reference_unit, 60 * r_per_min}), holds<third_way, 70'000>},
    {"position_segments",   disabled,    command_to(position_segments{.last = 4}), holds<last_position_segment, 4>},
    {"speed_segment",       disabled,    command_to(speed_segment{3, 70 * r_per_min, 1 * second}), holds<third_speed, 70>},
    {"segment_ramp_times",  disabled,    command_to(segment_ramp_times{segment_ramp::ramp_1, 20 * millisecond, 30 * millisecond}), holds<segment_deceleration_time_1, 30>},
    {"step_size",           disabled,    command_to(step_size{50 * reference_unit}), holds<position_step, 50>},
    {"homing_by",           disabled,    command_to(homing_by{homing_mode::forward_z}), holds<homing_method, 2>},
    {"ramps",               turning,     command_to(ramps{70 * millisecond, 80 * millisecond}), holds<deceleration_time, 80>},
    {"torque_limits",       pushing,     command_to(torque_limits{30 * percent, 40 * percent}), holds<negative_internal_torque_limit, 400>},
    {"torque_speed_limits", pushing,     command_to(torque_speed_limits{70 * r_per_min, 80 * r_per_min}), holds<reverse_speed_limit, 80>},
    {"top_speeds",          turning,     command_to(top_speeds{900 * r_per_min, 800 * r_per_min, 700 * r_per_min}), holds<max_reverse_speed, 700>},
    {"gear",                in_position, command_to(gear{131'072, 3600, 2}), holds<gear_2_denominator, 3600>},
    {"set, one word",       in_position, command_to(set<positioning_completed_threshold>{500}), holds<positioning_completed_threshold, 500>},
    {"set, two words",      disabled,    command_to(set<home_offset>{-70'000}), holds<home_offset, -70'000>},
    {"keep, one word",      disabled,    command_to(keep<max_speed>{1500}), is_kept<max_speed, 1500>},
    {"keep, two words",     disabled,    command_to(keep<home_offset>{-70'000}), is_kept<home_offset, -70'000>},
    {"keep, terminal",      disabled,    command_to(keep<di1_function>{input_function::zero_clamp}), is_kept<di1_function, 12>},
    {"keep, later",         disabled,    command_to(keep<pulses_per_revolution>{0}), is_kept<pulses_per_revolution, 0>},
    {"read_feedback",       turning,     command_to(read_feedback{})},
    {"read_feedback, later", long_in<turning>, command_to(read_feedback{})},
    {"read_wide_position",  moving,      command_to(read_wide_position{wide_position::mechanical})},
    {"read_status",         turning,     command_to(read_status{})},
    {"read_fault",          disabled,    command_to(read_fault{3})},
};
// clang-format on

inline bool takes(const row& o) { return now_read->takes_row(static_cast<std::size_t>(&o - command_rows)); }

/// A trigger that a command may send once, as bits of a register: G15.
struct trigger {
    u16 address;
    u16 bits;
};
constexpr trigger triggers[] = {
    {p31, terminal::segment_start},   {p31, terminal::step_start},
    {homing_control.address, 0xFFFF}, {alarm_reset.address, 0xFFFF},
    {software_reset.address, 0xFFFF}, {initialise_parameters.address, 0xFFFF},
    {node_address.address, 0xFFFF},   {reset_absolute_encoder.address, 0xFFFF},
};

/// How often words with these bits were written, in the frames from number `first` on.
inline unsigned times(const std::vector<frame>& requests, std::size_t first, const trigger& what) {
    unsigned n = 0;
    for (std::size_t i = first; i < requests.size(); ++i) {
        const frame& f = requests[i];
        if (!modbus::is_write(f[1])) continue;
        const unsigned begin = load_word(f, 2);
        const unsigned count = f[1] == 0x06 ? 1u : load_word(f, 4);
        if (what.address < begin || what.address >= begin + count) continue;
        const unsigned word = load_word(f, f[1] == 0x06 ? 4u : 7u + 2u * (what.address - begin));
        n += (word & what.bits) != 0 ? 1u : 0u;
    }
    return n;
}
/// The bits of P31-00 that have a function.
constexpr u16 functions = 0xFFFF & ~terminal::marker;
/// Frames that set one of these, a target or homing.
inline unsigned motions(const std::vector<frame>& requests) {
    unsigned n = times(requests, 0, {p31, functions});
    for (const u16 address :
         {target_speed.address, target_torque.address, jog_speed.address, homing_control.address})
        n += times(requests, 0, {address, 0xFFFF});
    return n;
}

/// True if the frames from number `first` on write nothing but what stops the drive.
inline bool only_stop(const std::vector<frame>& requests, std::size_t first) {
    if (requests.empty()) return true;
    const std::uint8_t node_address = requests[0][0];
    for (std::size_t i = first; i < requests.size(); ++i) {
        const frame& f = requests[i];
        // P0C-13 = 0, after a stop: those that follow are not kept in the EEPROM.
        if (i != first && same_bytes(f, modbus::write_frame(node_address, eeprom_update.address, u16{0})))
            continue;
        if (modbus::is_write(f[1]) && !same_bytes(f, modbus::write_frame(node_address, p31, u16{0})) &&
            !same_bytes(f, modbus::write_frame(node_address, p31, terminal::marker)) &&
            !same_bytes(f, modbus::write_frame(node_address, emergency_stop.address, u16{1})) &&
            !same_bytes(f, modbus::write_frame(node_address, target_torque.address, u16{0})) &&
            !same_bytes(f, modbus::write_frame(node_address, target_speed.address, std::array<u16, 2>{0, 0})))
            return false;
    }
    return true;
}

/// Brings the drive to the state in which a command begins. False if no enable works under this interpretation. Then
/// the motor is at standstill and its power is off.
inline bool begins(const row& o, rig& r) {
    if (o.from(r)) return true;
    CHECK_FALSE(shows_enabling());
    CHECK(is_off(r));
    CHECK(r.drive.state() != drive_state::enabled);
    return false;
}
/// Checks the end of a command without a fault.
inline void check_end(const row& o, rig& r, const command_status& got) {
    if (got) CHECK(o.is_done(r));
    if (got) return;
    if (o.from == moving && present().segment_start_is_level) {
        CHECK(got.error() == errc::stopped_short);
        return;
    }
    // Before the set-up only P0B-34 shows a fault, and it may still show one that is gone [errata C17].
    const bool is_judged_by_code = o.model == factory_drive && present().shows_last_alarm;
    CHECK((is_judged_by_code ? got.error() == errc::faulted : !shows_enabling()));
    CHECK(is_off(r));
    CHECK(r.drive.state() != drive_state::enabled);
}

/// Runs a command repeatedly, with the fault at another frame each time, until each frame has had it. `judge`
/// gets the rig, the report, the drive as it was before, and the number of frames up to the fault.
template <class Judge>
inline std::size_t disturb_each_frame(const row& o, mishap what, const sim::c630s& model, Judge judge) {
    CAPTURE(o.name);
    CAPTURE(static_cast<int>(what));
    std::size_t scenes = 0;
    for (std::size_t k = 0;; ++k) {
        if (!now_read->takes(k)) continue;
        CAPTURE(k);
        rig r{model};
        ++scenes;
        if (!begins(o, r)) return scenes;
        const sim::c630s before = r.model();
        const std::size_t first = r.port.requests.size();
        r.port.plan(what, k);
        const command_status got = o.asked.run(r.drive);
        if (!r.port.has_struck()) {
            CHECK(k != 0);
            check_end(o, r, got);
            return scenes;
        }
        for (const trigger& t : triggers) CHECK(times(r.port.requests, first, t) <= 1);
        CHECK(r.model().starts() - before.starts() <= 1);
        CHECK(r.model().homings() - before.homings() <= 1);
        if (!before.enabled()) CHECK(times(r.port.requests, first, {p31, terminal::servo_on}) <= 1);
        if (got.outcome() == outcome::not_sent) CHECK(only_stop(r.port.requests, first));
        judge(r, got, before, first + k + 1);
    }
}

/// S1: init of a new program first stops the drive, and leaves it at standstill.
inline void take_over(const sim::c630s& left) {
    rig r{left, left.address()};
    r.port.pass(milliseconds(300));
    const command_status got = r.drive.run(init{});
    const auto stop = modbus::write_frame(left.address(), target_speed.address, std::array<u16, 2>{0, 0});
    CHECK(same_bytes(r.port.requests[0], stop));
    CHECK(motions(r.port.requests) == 0);
    CHECK(got);
    CHECK(is_off(r));
    CHECK(r.drive.state() != drive_state::needs_init);
}

/// S5: after a power cycle nothing in the EEPROM energises the motor.
inline void stays_off_at_power_on(const sim::c630s& left) {
    port_type alone{left};
    alone.model.power_cycle();
    alone.pass(milliseconds(100));
    CHECK_FALSE(alone.model.enabled());
    CHECK((alone.model.stored(p31) & functions) == 0);
}

/// Plays scenes under each interpretation.
template <class Scenes> void under_each(const Scenes& scenes) {
    c630s_interpretations::under([&](const c630s_interpretation& r) {
        now_read = &r;
        return scenes();
    });
    now_read = &c630s_interpretations::all().front();
}

} // namespace c630s_scenes
