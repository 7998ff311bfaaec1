// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program and its C630S, and the states in which the commands of c630s_scenes.hpp begin. The drive has hazardous
// values in its EEPROM and follows one interpretation of the manual (tests/support/c630s_interpretations.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/c630s.hpp>
#include <tests/support/c630s_interpretations.hpp>
#include <tests/support/frame_port.hpp>

namespace c630s_scenes {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;

using simulated::mishap;
using port_type = simulated::frame_port<sim::c630s>;
using frame = port_type::frame;
constexpr u16 p31 = virtual_input_levels.address;

using c630s_interpretation = c630s_interpretations::interpretation;
/// The interpretation of the manual that the simulated drives of this scene follow.
inline const c630s_interpretation* now_read = &c630s_interpretations::all().front();
inline const sim::c630s_options& present() { return now_read->options; }

/// False if the brake output shows nothing, or is hidden because a wired output has the same function. Then
/// no enable is confirmed, and so each one is refused or undone [errata C77, C78].
inline bool shows_enabling() {
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

inline void keep_in_model(sim::c630s& model, u16 address, u16 value) {
    std::array<std::uint8_t, 2> word{};
    store_word(word, 0, value);
    REQUIRE(model.write(address, words_view{word}) == 0);
}

/// True if an output can show that the motor is energised: otherwise an enable ends `not_reached` [errata C77, C78].
inline bool can_enable(const sim::c630s_options& how) {
    return how.brake == sim::c630s_brake::follows_servo ||
           (how.brake == sim::c630s_brake::wired_only && !how.first_output_shows);
}

/// A drive that is set up, with short delays. Its EEPROM has hazardous values: non-zero targets, in speed
/// mode.
inline sim::c630s make_ready(const sim::c630s_options& options) {
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
/// A drive of the present interpretation, made when it is first needed.
class made_once {
  public:
    const sim::c630s& get(const sim::c630s_options& options) {
        if (made_for_ != now_read) model_ = make_ready(options);
        made_for_ = now_read;
        return model_;
    }

  private:
    const c630s_interpretation* made_for_ = nullptr;
    sim::c630s model_{};
};
inline const sim::c630s& ready_drive() {
    static made_once drive;
    return drive.get(present());
}
/// A drive whose P0C-13 is 1 again after a restart.
inline const sim::c630s& keeping_drive() {
    static made_once drive;
    sim::c630s_options forgets = present();
    forgets.stores_eeprom_off = false;
    return drive.get(forgets);
}
inline const sim::c630s& factory_drive() {
    static sim::c630s model;
    model = sim::c630s{present()};
    return model;
}

/// Brings the drive to the state in which a row of the table begins.
using state = bool (*)(rig&);
inline bool unknown(rig&) { return true; }
inline bool disabled(rig& r) { return static_cast<bool>(r.drive.run(init{})); }
inline bool in_speed(rig& r) { return disabled(r) && r.drive.run(enable_in{control_mode::speed}); }
inline bool in_torque(rig& r) { return disabled(r) && r.drive.run(enable_in{control_mode::torque}); }
inline bool turning(rig& r) {
    if (!in_speed(r) || !r.drive.run(velocity{60 * r_per_min})) return false;
    r.port.pass(milliseconds(100));
    return !r.model().stands_still();
}
inline bool pushing(rig& r) {
    if (!in_torque(r) || !r.drive.run(torque_speed_limits{60 * r_per_min, 60 * r_per_min})) return false;
    if (!r.drive.run(torque{20 * percent})) return false;
    r.port.pass(milliseconds(50));
    return !r.model().stands_still();
}
inline bool jogging(rig& r) { return in_speed(r) && r.drive.run(jog{60 * r_per_min}); }
inline bool in_position(rig& r) {
    return disabled(r) && r.drive.run(position_segments{}) &&
           r.drive.run(enable_in{control_mode::position}) &&
           r.drive.run(segment{2, 300 * reference_unit, 60 * r_per_min});
}
inline bool moving(rig& r) { return in_position(r) && r.drive.run(start_segment{2}); }
inline bool in_steps(rig& r) {
    return disabled(r) && r.drive.run(step_size{300 * reference_unit}) &&
           r.drive.run(enable_in{control_mode::position, position_source::step});
}
inline bool before_run(rig& r) {
    return disabled(r) && r.drive.run(position_segments{}) &&
           r.drive.run(segment{1, 300 * reference_unit, 60 * r_per_min}) &&
           r.drive.run(
               enable_in{control_mode::position, position_source::segments, segment_mode::sequential});
}
inline bool in_run(rig& r) { return before_run(r) && r.drive.run(start_segments{}); }
inline bool in_segments(rig& r) {
    return disabled(r) && r.drive.run(speed_segment{1, 60 * r_per_min, 5 * second}) &&
           r.drive.run(speed_segment{2, 30 * r_per_min, 5 * second}) && r.drive.run(run_speed_segments{});
}
/// A drive that the start does not move has not come to its target.
inline bool moved(rig& r) {
    return moving(r) && static_cast<bool>(r.drive.run(wait_standstill{})) != present().segment_start_is_level;
}
inline bool before_home(rig& r) {
    return disabled(r) &&
           r.drive.run(homing_by{homing_mode::forward_home_switch, 100 * r_per_min, 30 * r_per_min,
                                 10 * millisecond}) &&
           r.drive.run(enable_in{control_mode::position});
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

} // namespace c630s_scenes
