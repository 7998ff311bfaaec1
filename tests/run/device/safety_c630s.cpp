// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every command of the C630S facade with a fault at each of its frames: the program crashes, the line is lost
// for good or for one frame, or the drive restarts. The commands are rows of one table. A port that transfers
// whole frames counts them, so that no frame is left out. All tests run under the readings of the manual:
// tests/support/c630s_readings.hpp.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/device/c630s.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/c630s.hpp>
#include <tests/support/c630s_readings.hpp>
#include <tests/support/frame_port.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

namespace {

using simulated::mishap;
using port_type = simulated::frame_port<sim::c630s>;
using frame = port_type::frame;
constexpr u16 p31 = virtual_input_levels.address;

using c630s_reading = c630s_readings::reading;
/// The reading of the manual that the simulated drives of this scene follow.
const c630s_reading* now_read = &c630s_readings::all().front();
const sim::c630s_options& present() { return now_read->options; }

/// False if the brake output shows nothing, or is hidden because a wired output has the same function. Then
/// no enable is confirmed, and so each one is refused or undone [errata C77, C78].
bool shows_enabling() {
    const bool is_hidden = present().brake == sim::c630s_brake::wired_only && present().first_output_shows;
    return present().brake != sim::c630s_brake::always_released && !is_hidden;
}

/// A program and its drive.
struct rig {
    port_type port;
    servobus::line<port_type> line{port, modbus::timing_at(port.baud)};
    c630s::drive<servobus::line<port_type>> drive;

    explicit rig(const sim::c630s& model, std::uint8_t node_address = 1)
        : port{model}, drive{line, node_address, unsupervised} {}
    sim::c630s& model() { return port.model; }
    std::int64_t held(u16 address) { return port.model.peek(address); }
};
using d = decltype(rig::drive);

void keep_in_model(sim::c630s& model, u16 address, u16 value) {
    std::array<std::uint8_t, 2> word{};
    store_word(word, 0, value);
    REQUIRE(model.write(address, words_view{word}) == 0);
}

/// A drive that is set up, with short delays. Its EEPROM has hazardous values: non-zero targets, in speed
/// mode.
sim::c630s make_ready(const sim::c630s_options& options) {
    rig r{sim::c630s{options}};
    if (options.first_output_shows) { // as erratum C78 describes
        for (u16 n = 0; n < 6; ++n)
            keep_in_model(r.model(), static_cast<u16>(do1_function.address + 2 * n), 0);
    }
    if (options.brake == sim::c630s_brake::wired_only) // as erratum C77 describes
        keep_in_model(r.model(), do2_function.address, static_cast<u16>(output_function::brake));
    r.model().attach(
        {.home_from = 2000, .home_to = 40'000, .negative_limit = -900'000, .positive_limit = 900'000});
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(set_up{}));
    r.model().power_cycle();
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(keep<brake_on_to_command_delay>{20}));
    REQUIRE(r.drive.run(keep<brake_off_to_power_off_delay>{20}));
    REQUIRE(r.drive.run(keep<acceleration_time>{50 * millisecond}));
    REQUIRE(r.drive.run(keep<deceleration_time>{50 * millisecond}));
    REQUIRE(r.drive.run(keep<stop_at_servo_off>{stop_mode::zero_speed}));
    keep_in_model(r.model(), eeprom_update.address, 1);
    keep_in_model(r.model(), mode_of_operation.address, static_cast<u16>(control_mode::speed));
    keep_in_model(r.model(), target_speed.address, 200);
    keep_in_model(r.model(), target_torque.address, 100);
    keep_in_model(r.model(), eeprom_update.address, 0);
    r.model().power_cycle();
    REQUIRE_FALSE(r.model().has_fault());
    return r.model();
}
/// A drive of the present reading, made when it is first needed.
class made_once {
  public:
    const sim::c630s& get(const sim::c630s_options& options) {
        if (made_for_ != now_read) model_ = make_ready(options);
        made_for_ = now_read;
        return model_;
    }

  private:
    const c630s_reading* made_for_ = nullptr;
    sim::c630s model_{};
};
const sim::c630s& ready_drive() {
    static made_once drive;
    return drive.get(present());
}
/// A drive whose P0C-13 is 1 again after a restart.
const sim::c630s& keeping_drive() {
    static made_once drive;
    sim::c630s_options forgets = present();
    forgets.stores_eeprom_off = false;
    return drive.get(forgets);
}
const sim::c630s& factory_drive() {
    static sim::c630s model;
    model = sim::c630s{present()};
    return model;
}

/// Brings the drive to the state in which a row of the table begins.
using state = bool (*)(rig&);
bool unknown(rig&) { return true; }
bool disabled(rig& r) { return static_cast<bool>(r.drive.run(init{})); }
bool in_speed(rig& r) { return disabled(r) && r.drive.run(enable{control_mode::speed}); }
bool in_torque(rig& r) { return disabled(r) && r.drive.run(enable{control_mode::torque}); }
bool turning(rig& r) {
    if (!in_speed(r) || !r.drive.run(velocity{60 * r_per_min})) return false;
    r.port.pass(milliseconds(100));
    return !r.model().stands_still();
}
bool pushing(rig& r) {
    if (!in_torque(r) || !r.drive.run(torque_speed_limits{60 * r_per_min, 60 * r_per_min})) return false;
    if (!r.drive.run(torque{20 * percent})) return false;
    r.port.pass(milliseconds(50));
    return !r.model().stands_still();
}
bool jogging(rig& r) { return in_speed(r) && r.drive.run(jog{60 * r_per_min}); }
bool in_position(rig& r) {
    return disabled(r) && r.drive.run(position_segments{}) && r.drive.run(enable{control_mode::position}) &&
           r.drive.run(segment{2, 300 * reference_unit, 60 * r_per_min});
}
bool moving(rig& r) { return in_position(r) && r.drive.run(start_segment{2}); }
bool in_steps(rig& r) {
    return disabled(r) && r.drive.run(step_size{300 * reference_unit}) &&
           r.drive.run(enable{control_mode::position, position_source::step});
}
bool before_run(rig& r) {
    return disabled(r) && r.drive.run(position_segments{}) &&
           r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}) &&
           r.drive.run(enable{control_mode::position, position_source::segments, segment_mode::sequential});
}
bool in_run(rig& r) { return before_run(r) && r.drive.run(start_segments{}); }
bool in_segments(rig& r) {
    return disabled(r) && r.drive.run(speed_segment{1, 60 * r_per_min, 5 * second}) &&
           r.drive.run(speed_segment{2, 30 * r_per_min, 5 * second}) && r.drive.run(run_speed_segments{});
}
/// A drive that the start does not move has not come to its target.
bool moved(rig& r) {
    return moving(r) && static_cast<bool>(r.drive.run(wait_standstill{})) != present().segment_start_is_level;
}
bool before_home(rig& r) {
    return disabled(r) &&
           r.drive.run(homing_by{homing_mode::forward_home_switch, 100 * r_per_min, 30 * r_per_min,
                                 10 * millisecond}) &&
           r.drive.run(enable{control_mode::position});
}
template <u16 Alarm> bool with(rig& r) {
    if (!disabled(r)) return false;
    r.model().raise(Alarm);
    return true;
}
constexpr state with_fault = with<0x620>;
constexpr state with_battery_fault = with<0x731>;
/// Waits so long that the facade reads the drive before the next command.
template <state From> bool long_in(rig& r) {
    if (!From(r)) return false;
    r.port.pass(milliseconds(600));
    return true;
}

/// A command, the state in which it begins, and a check of the drive for when it is done.
struct row {
    std::string name;
    state from;
    routine_status (*run)(d&);
    bool (*is_done)(rig&) = [](rig&) { return true; };
    const sim::c630s& (*model)() = ready_drive;
};

bool is_off(rig& r) { return !r.model().enabled() && r.model().stands_still(); }
template <control_mode Mode> bool is_enabled_in(rig& r) {
    return r.model().enabled() && r.held(mode_of_operation.address) == static_cast<int>(Mode);
}
template <const auto& R, int Value> bool holds(rig& r) { return r.held(R.address) == Value; }
template <const auto& R, int Value> bool is_stored(rig& r) { return r.model().stored(R.address) == Value; }
template <const auto& R, int Value> bool is_kept(rig& r) {
    return r.model().stored(R.address) == Value && r.held(eeprom_update.address) == 0;
}
bool is_healthy(rig& r) { return is_off(r) && !r.model().has_fault(); }
bool stands(rig& r) { return r.model().stands_still(); }
bool makes_a_move(rig& r) { return r.model().starts() == 1 && r.model().enabled(); }
bool makes_a_segment(rig& r) { return present().segment_start_is_level ? stands(r) : makes_a_move(r); }
// 300 reference units from where the preparation began: 3932 encoder counts, within P05-21 and the rounding.
bool has_arrived(rig& r) {
    const std::int64_t missing = 3932 - r.model().position();
    const std::int64_t near = r.held(positioning_completed_threshold.address) + 2;
    return stands(r) && missing <= near && -missing <= near;
}
template <output_function F> bool is_home(rig& r) { return r.model().is_active(F) && stands(r); }
constexpr auto third_way = position_segment_displacements[2];
constexpr auto third_speed = speed_segment_speeds[2];

// clang-format off
const row command_rows[] = {
    {"init",                unknown,     [](d& x) { return x.run(init{}); }, is_off},
    {"init, turning",       turning,     [](d& x) { return x.run(init{}); }, is_off},
    {"init, factory",       unknown,     [](d& x) { return x.run(init{}); }, is_off, factory_drive},
    {"set_up",              disabled,    [](d& x) { return x.run(set_up{}); }, is_kept<virtual_inputs_enable, 1>, factory_drive},
    {"set_up, again",       disabled,    [](d& x) { return x.run(set_up{}); }, is_stored<virtual_inputs_enable, 1>},
    {"enable, speed",       disabled,    [](d& x) { return x.run(enable{control_mode::speed}); }, is_enabled_in<control_mode::speed>},
    {"enable, torque",      disabled,    [](d& x) { return x.run(enable{control_mode::torque}); }, is_enabled_in<control_mode::torque>},
    {"enable, position",    disabled,    [](d& x) { return x.run(enable{control_mode::position}); }, is_enabled_in<control_mode::position>},
    {"run_speed_segments",  disabled,    [](d& x) { return x.run(run_speed_segments{}); }, is_enabled_in<control_mode::speed>},
    {"disable",             turning,     [](d& x) { return x.run(disable{}); }, is_off},
    {"disable, moving",     moving,      [](d& x) { return x.run(disable{}); }, is_off},
    {"disable, unknown",    unknown,     [](d& x) { return x.run(disable{}); }, is_off},
    {"halt, speed",         turning,     [](d& x) { return x.run(halt{}); }, stands},
    {"halt, torque",        pushing,     [](d& x) { return x.run(halt{}); }, holds<target_torque, 0>},
    {"halt, jog",           jogging,     [](d& x) { return x.run(halt{}); }, stands},
    {"halt, unknown",       unknown,     [](d& x) { return x.run(halt{}); }, is_off},
    {"quick_stop",          turning,     [](d& x) { return x.run(quick_stop{}); }, stands},
    {"quick_stop, moving",  moving,      [](d& x) { return x.run(quick_stop{}); }, stands},
    {"quick_stop, run",     in_run,      [](d& x) { return x.run(quick_stop{}); }, is_off},
    {"quick_stop, speeds",  in_segments, [](d& x) { return x.run(quick_stop{}); }, is_off},
    {"fault_reset",         with_fault,  [](d& x) { return x.run(fault_reset{}); }, is_healthy},
    {"fault_reset, on",     turning,     [](d& x) { return x.run(fault_reset{}); }, is_off},
    {"fault_reset, factory", with_fault, [](d& x) { return x.run(fault_reset{}); }, is_healthy, factory_drive},
    {"reset_encoder",       with_battery_fault, [](d& x) { return x.run(reset_encoder{}); }, is_healthy},
    {"reset_encoder, factory", with_battery_fault, [](d& x) { return x.run(reset_encoder{}); }, is_healthy, factory_drive},
    {"restart",             disabled,    [](d& x) { return x.run(restart{}); }, is_off},
    {"factory_reset",       disabled,    [](d& x) { return x.run(factory_reset{sole_drive_on_the_line{}}); }, holds<max_speed, 5000>},
    {"change_address",      disabled,    [](d& x) { return x.run(change_address{9, sole_drive_on_the_line{}}); }, holds<node_address, 9>},
    {"change_line",         disabled,    [](d& x) { return x.run(change_line{baud_rate::baud_19200}); }, holds<rs485_baud_rate, 3>},
    {"clear_fault_history", disabled,    [](d& x) { return x.run(clear_fault_history{}); }},
    {"velocity",            in_speed,    [](d& x) { return x.run(velocity{60 * r_per_min}); }, holds<target_speed, 60>},
    {"velocity, reading",   long_in<in_speed>, [](d& x) { return x.run(velocity{60 * r_per_min}); }, holds<target_speed, 60>},
    {"torque",              in_torque,   [](d& x) { return x.run(torque{5 * percent}); }, holds<target_torque, 50>},
    {"torque, reading",     long_in<in_torque>, [](d& x) { return x.run(torque{5 * percent}); }, holds<target_torque, 50>},
    {"jog",                 in_speed,    [](d& x) { return x.run(jog{-60 * r_per_min}); }, holds<virtual_input_levels, terminal::servo_on | terminal::jog_reverse | terminal::marker>},
    {"select_speed_segment", in_segments, [](d& x) { return x.run(select_speed_segment{2}); }, holds<virtual_input_levels, terminal::servo_on | terminal::for_segment(1) | terminal::marker>},
    {"start_segment",       in_position, [](d& x) { return x.run(start_segment{2}); }, makes_a_segment},
    {"start_segments",      before_run,  [](d& x) { return x.run(start_segments{}); }, makes_a_segment},
    {"make_step",           in_steps,    [](d& x) { return x.run(make_step{}); }, makes_a_move},
    {"wait_standstill",     moving,      [](d& x) { return x.run(wait_standstill{}); }, stands},
    {"until_arrived",       moving,      [](d& x) { return x.run(until_arrived{}); }, has_arrived},
    {"wait_standstill, speed", in_speed,    [](d& x) { return x.run(wait_standstill{}); }, stands},
    {"home",                before_home, [](d& x) { return x.run(home{5 * second}); }, is_home<output_function::home_attained>},
    {"home_electrically",   moved,       [](d& x) { return x.run(home_electrically{5 * second}); }, is_home<output_function::electrical_home_attained>},
    {"set_home",            moved,       [](d& x) { return x.run(set_home{}); }, holds<absolute_position, 0>},
    {"segment",             in_position, [](d& x) { return x.run(segment{3, 70'000 * reference_unit, 60 * r_per_min}); }, holds<third_way, 70'000>},
    {"position_segments",   disabled,    [](d& x) { return x.run(position_segments{.last = 4}); }, holds<last_position_segment, 4>},
    {"speed_segment",       disabled,    [](d& x) { return x.run(speed_segment{3, 70 * r_per_min, 1 * second}); }, holds<third_speed, 70>},
    {"segment_ramp_times",  disabled,    [](d& x) { return x.run(segment_ramp_times{segment_ramp::ramp_1, 20 * millisecond, 30 * millisecond}); }, holds<segment_deceleration_time_1, 30>},
    {"step_size",           disabled,    [](d& x) { return x.run(step_size{50 * reference_unit}); }, holds<position_step, 50>},
    {"homing_by",           disabled,    [](d& x) { return x.run(homing_by{homing_mode::forward_z}); }, holds<homing_method, 2>},
    {"ramps",               turning,     [](d& x) { return x.run(ramps{70 * millisecond, 80 * millisecond}); }, holds<deceleration_time, 80>},
    {"torque_limits",       pushing,     [](d& x) { return x.run(torque_limits{30 * percent, 40 * percent}); }, holds<negative_internal_torque_limit, 400>},
    {"torque_speed_limits", pushing,     [](d& x) { return x.run(torque_speed_limits{70 * r_per_min, 80 * r_per_min}); }, holds<reverse_speed_limit, 80>},
    {"top_speeds",          turning,     [](d& x) { return x.run(top_speeds{900 * r_per_min, 800 * r_per_min, 700 * r_per_min}); }, holds<max_reverse_speed, 700>},
    {"gear",                in_position, [](d& x) { return x.run(gear{131'072, 3600, 2}); }, holds<gear_2_denominator, 3600>},
    {"set, one word",       in_position, [](d& x) { return x.run(set<positioning_completed_threshold>{500}); }, holds<positioning_completed_threshold, 500>},
    {"set, two words",      disabled,    [](d& x) { return x.run(set<home_offset>{-70'000}); }, holds<home_offset, -70'000>},
    {"keep, one word",      disabled,    [](d& x) { return x.run(keep<max_speed>{1500}); }, is_kept<max_speed, 1500>},
    {"keep, two words",     disabled,    [](d& x) { return x.run(keep<home_offset>{-70'000}); }, is_kept<home_offset, -70'000>},
    {"keep, terminal",      disabled,    [](d& x) { return x.run(keep<di1_function>{input_function::zero_clamp}); }, is_kept<di1_function, 12>},
    {"keep, later",         disabled,    [](d& x) { return x.run(keep<pulses_per_revolution>{0}); }, is_kept<pulses_per_revolution, 0>},
    {"read_feedback",       turning,     [](d& x) { return x.run(read_feedback{}); }},
    {"read_feedback, later", long_in<turning>, [](d& x) { return x.run(read_feedback{}); }},
    {"read_wide_position",  moving,      [](d& x) { return x.run(read_wide_position{wide_position::mechanical}); }},
    {"read_status",         turning,     [](d& x) { return x.run(read_status{}); }},
    {"read_fault",          disabled,    [](d& x) { return x.run(read_fault{3}); }},
};
// clang-format on

bool takes(const row& o) { return now_read->takes_row(static_cast<std::size_t>(&o - command_rows)); }

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
unsigned times(const std::vector<frame>& requests, std::size_t first, const trigger& what) {
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
unsigned motions(const std::vector<frame>& requests) {
    unsigned n = times(requests, 0, {p31, functions});
    for (const u16 address :
         {target_speed.address, target_torque.address, jog_speed.address, homing_control.address})
        n += times(requests, 0, {address, 0xFFFF});
    return n;
}

/// True if the frames from number `first` on write nothing but what stops the drive.
bool only_stop(const std::vector<frame>& requests, std::size_t first) {
    const std::uint8_t node_address = requests[0][0];
    for (std::size_t i = first; i < requests.size(); ++i) {
        const frame& f = requests[i];
        if (modbus::is_write(f[1]) && !same_bytes(f, modbus::write_frame(node_address, p31, u16{0})) &&
            !same_bytes(f, modbus::write_frame(node_address, p31, terminal::marker)) &&
            !same_bytes(f, modbus::write_frame(node_address, target_torque.address, u16{0})) &&
            !same_bytes(f, modbus::write_frame(node_address, target_speed.address, std::array<u16, 2>{0, 0})))
            return false;
    }
    return true;
}

/// Brings the drive to the state in which a command begins. False if no enable works under this reading. Then
/// the motor is at standstill and its power is off.
bool begins(const row& o, rig& r) {
    if (o.from(r)) return true;
    CHECK_FALSE(shows_enabling());
    CHECK(is_off(r));
    CHECK(r.drive.state() != drive_state::enabled);
    return false;
}
/// Checks the end of a command without a fault.
void check_end(const row& o, rig& r, const routine_status& got) {
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
std::size_t hurt_each_frame(const row& o, mishap what, const sim::c630s& model, Judge judge) {
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
        const routine_status got = o.run(r.drive);
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
void take_over(const sim::c630s& left) {
    rig r{left, left.address()};
    r.port.pass(milliseconds(300));
    const routine_status got = r.drive.run(init{});
    const auto stop = modbus::write_frame(left.address(), target_speed.address, std::array<u16, 2>{0, 0});
    CHECK(same_bytes(r.port.requests[0], stop));
    CHECK(motions(r.port.requests) == 0);
    CHECK(got);
    CHECK(is_off(r));
    CHECK(r.drive.state() != drive_state::needs_init);
}

/// S5: after a power cycle nothing in the EEPROM energises the motor.
void stays_off_at_power_on(const sim::c630s& left) {
    port_type alone{left};
    alone.model.power_cycle();
    alone.pass(milliseconds(100));
    CHECK_FALSE(alone.model.enabled());
    CHECK((alone.model.stored(p31) & functions) == 0);
}

/// Plays scenes under each reading.
template <class Scenes> void under_each(const Scenes& scenes) {
    c630s_readings::under([&](const c630s_reading& r) {
        now_read = &r;
        return scenes();
    });
    now_read = &c630s_readings::all().front();
}

} // namespace

TEST_CASE(
    "S1, G37: after a program has crashed at any frame of any command, init of a new program first stops "
    "the drive" *
    doctest::test_suite("readings")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            CAPTURE(o.name);
            rig r{o.model()};
            ++scenes;
            if (!begins(o, r)) continue;
            std::vector<sim::c630s> history;
            r.port.history = &history;
            check_end(o, r, o.run(r.drive));
            CHECK(!history.empty());
            for (std::size_t k = 0; k < history.size(); ++k) {
                if (!now_read->takes(k)) continue;
                CAPTURE(k);
                take_over(history[k]);
                ++scenes;
            }
        }
        return scenes;
    });
}

TEST_CASE("G15, G29: if the line is lost at any frame of any command, the command ends in time, and a stop "
          "works when the line returns" *
          doctest::test_suite("readings")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            const auto judge = [](rig& r, const routine_status& got, const sim::c630s&, std::size_t behind) {
                CHECK_FALSE(got);
                CHECK(got.outcome() != outcome::done);
                CHECK(r.drive.state() == drive_state::needs_init);
                const std::size_t tries = r.port.requests.size() - behind + 1;
                const node<device> n{1};
                CHECK(tries <= 30);
                CHECK(r.port.time_us() - r.port.struck_at() <=
                      tries * r.line.bound(32, 32, n.limits, n.gaps).us);
                CHECK(r.drive.run(velocity{10 * r_per_min}).error() == errc::needs_init);
                CHECK(r.drive.run(start_segment{2}).error() == errc::needs_init);
                r.port.mend();
                if (r.model().address() == 1 && r.model().baud() == r.port.baud)
                    CHECK(r.drive.run(disable{}));
                take_over(r.model());
            };
            scenes += hurt_each_frame(o, mishap::no_more_requests, o.model(), judge);
            scenes += hurt_each_frame(o, mishap::no_more_responses, o.model(), judge);
        }
        return scenes;
    });
}

TEST_CASE("G15, G16: if one frame of any command is lost, a command that is reported as done was done" *
          doctest::test_suite("readings")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            const auto judge = [&o](rig& r, const routine_status& got, const sim::c630s& before,
                                    std::size_t) {
                if (got) CHECK(o.is_done(r));
                CHECK((r.drive.state() != drive_state::enabled || r.model().enabled()));
                r.port.mend();
                if (o.is_done == makes_a_move || o.is_done == makes_a_segment) {
                    r.port.pass(milliseconds(800));
                    const std::int64_t way = r.model().position() - before.position();
                    const std::int64_t once = r.model().starts() == before.starts() ? 0 : 3932;
                    CHECK((way >= once - 2 && way <= once + 2));
                    if (got && o.is_done == makes_a_move) CHECK(once != 0);
                    if (got && o.is_done == makes_a_segment)
                        CHECK((once != 0) != present().segment_start_is_level);
                }
                take_over(r.model());
            };
            scenes += hurt_each_frame(o, mishap::request_lost, o.model(), judge);
            scenes += hurt_each_frame(o, mishap::response_lost, o.model(), judge);
        }
        return scenes;
    });
}

TEST_CASE("S5: if the drive restarts after any frame of any command, no cached word energises it again" *
          doctest::test_suite("readings")) {
    under_each([] {
        std::size_t scenes = 0;
        for (const row& o : command_rows) {
            if (!takes(o)) continue;
            bool may_be_on = false; // an enable may be sent completely after a blink
            const auto judge = [&](rig& r, const routine_status& got, const sim::c630s& before,
                                   std::size_t behind) {
                const bool was_last = r.port.requests.size() == behind;
                const u16 looked_at = load_word(r.port.requests[behind - 1], 2);
                const bool is_believed = r.drive.state() == drive_state::enabled;
                r.port.pass(milliseconds(600));
                (void)r.drive.read();
                const bool is_found = is_believed && r.drive.state() == drive_state::needs_init;
                if (got && !was_last) CHECK((o.is_done(r) || is_found));
                r.port.pass(milliseconds(600));
                CHECK(r.model().enabled() == (r.drive.state() == drive_state::enabled));
                if (may_be_on && r.model().enabled()) {
                    CHECK((got && o.is_done(r)));
                } else {
                    CHECK(is_off(r));
                    CHECK(r.drive.run(start_segment{2}).outcome() == outcome::not_sent);
                }
                // No program can detect a restart between a read of P31-00 and its write.
                if (!may_be_on || (before.enabled() && looked_at != p31))
                    CHECK_FALSE(r.port.has_been_energised());
                stays_off_at_power_on(r.model());
                take_over(r.model());
            };
            scenes += hurt_each_frame(o, mishap::restart, o.model(), judge);
            if (o.model == ready_drive) scenes += hurt_each_frame(o, mishap::restart, keeping_drive(), judge);
            may_be_on = true;
            scenes += hurt_each_frame(o, mishap::blink, o.model(), judge);
        }
        return scenes;
    });
}

// The drive does not store P0C-13 = 0. So P0C-13 shows a restart, and the drive stores what is written after
// it.
TEST_CASE("S5: a drive that a halt has enabled again after a restart is switched off when the restart is "
          "found") {
    static c630s_reading forgets;
    forgets.options.stores_eeprom_off = false;
    now_read = &forgets;
    const auto judge = [](rig& r, const routine_status&, const sim::c630s&, std::size_t) {
        r.port.pass(milliseconds(600));
        (void)r.drive.read();
        const bool is_found = r.drive.state() == drive_state::needs_init;
        r.port.pass(milliseconds(600));
        if (is_found) CHECK_FALSE(r.model().enabled());
        CHECK((r.drive.state() == drive_state::enabled || (r.model().stored(p31) & functions) == 0));
    };
    for (const row& o : command_rows) {
        if (std::string{o.name} == "halt, jog") hurt_each_frame(o, mishap::blink, o.model(), judge);
    }
    now_read = &c630s_readings::all().front();
}
