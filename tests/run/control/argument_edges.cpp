// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The argument of a command just beyond the limits of its register, in a unit that is finer than a count.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/control/arguments.hpp>
#include <servobus/device/c630s.hpp>

namespace argument_edges_tests {

using namespace servobus;
using namespace servobus::units;

// A target speed in tenths of its count.
constexpr command_argument tenths(std::int32_t count) {
    return commands::argument<c630s::target_speed>(quantity<r_per_min / 10, std::int32_t>{count});
}
constexpr std::int32_t highest =
    static_cast<std::int32_t>(register_value<c630s::target_speed>::writable.high) * 10;

TEST_CASE("an inexact argument is the count below it, and is refused beyond either limit of its register") {
    for (const std::int32_t part : {1, 5, 9}) {
        const command_argument above = tenths(highest + part);
        CHECK(above.count == highest / 10);
        CHECK(above.is_refused());
        const command_argument below = tenths(-highest - part);
        CHECK(below.count == -highest / 10 - 1);
        CHECK(below.is_refused());
        CHECK(tenths(-part).count == -1);
        CHECK(tenths(part).count == 0);
        CHECK_FALSE(tenths(-part).is_exact);
    }
    CHECK_FALSE(tenths(highest).is_refused());
    CHECK_FALSE(tenths(-highest).is_refused());
}

} // namespace argument_edges_tests
