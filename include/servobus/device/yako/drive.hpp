// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the facades of the two variants, `closed_loop::drive` and `open_loop::drive`.
// servobus/device/yako.hpp includes it.
//
//     yako::closed_loop::drive lift{wire, 1};
//     yako::open_loop::drive feeder{wire, 2};
//     if (!lift.run(init{}) || !feeder.run(init{})) return 1;
//     const auto seen = lift.read(); // a yako::closed_loop::feedback
//     if (seen && !seen->state.is_homed()) std::puts("home the lift");
#pragma once

#include <cstdint>

#include <servobus/device/yako/basic_drive.hpp>

namespace servobus::yako {

namespace closed_loop {
/// One closed loop drive (ESS242-, ESS257-, ESS286-Rx1) on a line.
template <class Line> class drive : public basic_drive<device, Line> {
    using basic_drive<device, Line>::basic_drive; // C++20 deduces no `Line` from them: the guides do
};
template <class Line> drive(Line&, std::uint8_t = 1, const supervision& = without_watchdog) -> drive<Line>;
template <class Line>
drive(Line&, const servobus::node<device>&, const supervision& = without_watchdog) -> drive<Line>;
} // namespace closed_loop

namespace open_loop {
/// One open loop drive (ESD2205PR, ESD2505PR, YKE2405PR, YKE2608PR) on a line.
template <class Line> class drive : public basic_drive<device, Line> {
    using basic_drive<device, Line>::basic_drive;
};
template <class Line> drive(Line&, std::uint8_t = 1, const supervision& = without_watchdog) -> drive<Line>;
template <class Line>
drive(Line&, const servobus::node<device>&, const supervision& = without_watchdog) -> drive<Line>;
} // namespace open_loop

} // namespace servobus::yako
