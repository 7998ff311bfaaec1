// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Initialises and enables a simulated ZLAC8015D in one of its operating modes. Has the frames of its control
// word that the tests of its commands share.
#pragma once

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

#include "driven_zlac8015d.hpp"

namespace enabled_zlac8015d {

using namespace servobus;
using namespace servobus::zlac8015d;

inline constexpr auto quick_stop_frame = hex("01 06 20 0E 00 05 23 CA");
inline constexpr auto fault_reset_frame = hex("01 06 20 0E 00 06 63 CB");
inline constexpr auto stop_frame = hex("01 06 20 0E 00 07 A2 0B");

inline void be_enabled_in(simulated::driven_zlac8015d& r, operating_mode mode,
                          synchronisation how = synchronisation::synchronous) {
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{checked(mode), how}));
    REQUIRE(r.model.enabled());
    REQUIRE(r.model.mode() == mode);
}

} // namespace enabled_zlac8015d
