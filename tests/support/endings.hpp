// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The end of a command, as a test tells a model of it.
//
//     endings told;
//     REQUIRE(m.learn(c, told.done(image), known) == errc::ok);
#pragma once

#include <cstdint>

#include <servobus/control/drive_model.hpp>

struct endings {
    servobus::command_status status{};
    servobus::duration watchdog{};
    servobus::response_limits limits{};

    /// `read`: what the routine has fetched.
    servobus::ending done(servobus::slice<const std::uint16_t> read = {}) {
        status = {};
        return {true, servobus::no_steps, status, read, watchdog, limits};
    }
    servobus::ending failed(const servobus::command_status& how,
                            servobus::routine steps = servobus::no_steps) {
        status = how;
        return {false, steps, status, {}, watchdog, limits};
    }
};
