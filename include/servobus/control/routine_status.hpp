// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a routine ended, and at which of its steps. Facades return it.
//
//     const routine_status moved = wheels.run(zlac8015d::move_by{4096 * pulse, 4096 * pulse});
//     if (moved.outcome() == outcome::unknown) std::printf("lost at step %d\n", moved.step);
#pragma once

#include <cstdint>

#include <servobus/core/status.hpp>

namespace servobus {

/// How a routine ended. `done`: every step. `refused`: an exception at `step`, which was not done, nor any
/// after it. `not_sent`: it ended before anything that changes the drive was sent. `unknown`: something was
/// sent that is not known to have worked, or a later step failed.
struct [[nodiscard]] routine_status {
    servobus::status status{};
    std::uint8_t step = 0;    ///< the step where it ended
    bool has_changed = false; ///< a step before that one has written something

    constexpr explicit operator bool() const { return static_cast<bool>(status); }
    constexpr servobus::outcome outcome() const { return status.outcome(); }
    constexpr errc error() const { return status.error(); }
    constexpr std::uint8_t exception() const { return status.exception(); }
};

} // namespace servobus
