// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Initialises and enables a simulated YAKOTEC axis. Has the frames and the motion profiles that the tests of
// its commands share.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/device/yako.hpp>
#include <servobus/servobus.hpp>

namespace enabled_yako {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;

inline constexpr auto enable_frame = hex("01 06 00 2D 00 12 99 CE");
inline constexpr auto stop_frame = hex("01 06 00 27 01 00 38 51");
inline constexpr auto quick_stop_frame = hex("01 06 00 27 02 00 38 A1");
inline constexpr auto start_relative_frame = hex("01 06 00 27 00 01 F8 01");
inline constexpr auto start_jog_frame = hex("01 06 00 27 00 02 B8 00");
inline constexpr auto start_homing_frame = hex("01 06 00 27 00 10 38 0D");
inline constexpr auto save_frame = hex("01 06 00 2D 00 42 99 F2");

inline const motion_profile gentle{10 * r_per_min, 100 * millisecond, 100 * millisecond, 60 * r_per_min};
inline const motion_profile brisk{10 * r_per_min, 50 * millisecond, 50 * millisecond, 600 * r_per_min};

/// The simulator's micro r/min in r/min, rounded.
inline std::int64_t whole_rpm(std::int64_t micro) {
    return (micro + (micro < 0 ? -500'000 : 500'000)) / 1'000'000;
}

template <class Axis> void take(Axis& a) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.model.enabled());
}
template <class Axis> void take_homed(Axis& a) {
    take(a);
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
}

/// These also check the state that the facade caches.
namespace state_checked {

template <class Axis> void take(Axis& a) {
    enabled_yako::take(a);
    REQUIRE(a.drive.state() == drive_state::enabled);
}
template <class Axis> void take_homed(Axis& a) {
    state_checked::take(a);
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.cached().is_homed);
}

} // namespace state_checked

} // namespace enabled_yako
