// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What holds over a machine's life: millions of moves, feedbacks and twists.
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include "tests/support/axis_moves.hpp"
#include "tests/support/axis_twists.hpp"

namespace long_runs_tests {

TEST_CASE("ten million random relative moves drift by no count") {
    CHECK(axis_moves::drift(axis_moves::forward, 10'000'000) == 0);
    CHECK(axis_moves::drift(axis_moves::mirrored, 10'000'000) == 0);
}

TEST_CASE("ten million feedbacks over 20 wraps: no micrometre is lost") {
    for (const servobus::axis* of : {&axis_moves::forward, &axis_moves::mirrored}) {
        const axis_moves::followed f = axis_moves::follow(*of, 10'000'000);
        CHECK(f.are_equal);
        CHECK(f.wraps >= 20);
    }
}

TEST_CASE("five million twists: no wheel is above its limit, and each is within the bound") {
    std::uint32_t seed = 60;
    for (const axis_twists::subject& s : axis_twists::subjects) {
        const axis_twists::judged all = axis_twists::judge_any(s, ++seed, 750'000);
        CHECK(all.above == 0);
        CHECK(all.wrongly_limited == 0);
        CHECK(all.worst <= 1.5L);
    }
}

} // namespace long_runs_tests
