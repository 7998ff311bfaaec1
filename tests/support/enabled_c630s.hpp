// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Initialises, sets up and enables a simulated C630S in one of its control modes.
#pragma once

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/servobus.hpp>

#include "driven_c630s.hpp"

namespace enabled_c630s {

using namespace servobus;
using namespace servobus::c630s;

/// P31-00, the levels of the virtual inputs.
inline constexpr u16 p31 = virtual_input_levels.address;

inline void be_enabled_in(simulated::driven_c630s& r, control_mode mode,
                          position_source from = position_source::segments) {
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{mode, from}));
    REQUIRE(r.model.enabled());
    REQUIRE(r.drive.state() == drive_state::enabled);
}

} // namespace enabled_c630s
