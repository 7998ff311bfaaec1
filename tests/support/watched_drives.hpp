// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A C630S and a ZLAC8015D whose frames are compared as text, each with its facade (frames_of_commands.hpp).
#pragma once

#include <string>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/frames_of_commands.hpp>
#include <tests/support/simulated_c630s.hpp>

namespace frames_of_commands {

namespace sim = servobus::sim;

/// A C630S as from the factory.
struct new_servo : simulated::simulated_model<watched<sim::c630s>, sim::c630s_options, 57600> {
    servobus::c630s::drive<line_type> drive{line, 1, servobus::unsupervised};
    new_servo() = default;
};
/// A C630S that is set up.
struct servo : new_servo {
    servo() {
        REQUIRE(drive.run(servobus::init{}));
        REQUIRE(drive.run(servobus::c630s::set_up{}));
        model.power_cycle();
    }
};
struct dual_servo : simulated::simulated_model<watched<sim::zlac8015d>, sim::zlac8015d_options, 115200> {
    servobus::zlac8015d::drive<line_type> drive{line, 1, servobus::unsupervised};
};

inline void expect(const std::string& frames, const char* wanted) { CHECK(frames == wanted); }

} // namespace frames_of_commands
