// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Relative moves: they add up to one product; a move that does not end done leaves no trace. long_runs.cpp has millions.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/axis/carried_move.hpp>

#include "tests/support/axis_moves.hpp"

namespace carried_move_tests {

using namespace servobus;
using namespace servobus::literals;
using std::int64_t;

constexpr scale counts_of_um = scale::of(16'384, 652'300);

static_assert(carried_move{scale{}}.plan(125.5_mm)->counts == 125'500);
static_assert(carried_move{scale{}, count_direction::mirrored}.plan(125.5_mm)->counts == -125'500);
static_assert(carried_move{scale{}}.plan(3_m)->counts == 3'000'000);
static_assert(carried_move{scale{}}.plan(2147.5_m).error() == errc::out_of_range,
              "2^31 um are refused, not limited");
static_assert(carried_move{scale{}}.plan(-2'147'483'647_um)->counts == -2'147'483'647);
static_assert(carried_move{scale{}}.plan(micrometres{-2'147'483'648}).error() == errc::out_of_range);
static_assert(carried_move{scale{}}.plan(micrometres{int64_t{1} << 32}).error() == errc::out_of_range);
static_assert(carried_move{scale{}}.plan(0_um)->counts == 0);

TEST_CASE("random moves drift by no count") {
    CHECK(axis_moves::drift(count_direction::forward, 200'000) == 0);
    CHECK(axis_moves::drift(count_direction::mirrored, 200'000) == 0);
}

TEST_CASE("a plan changes nothing; commit keeps its rest; reset drops it") {
    carried_move moves{counts_of_um};
    CHECK(moves.plan(100_um)->counts == 3); // 2.51
    CHECK(moves.rest() == 0);
    moves.commit(*moves.plan(100_um));
    CHECK(moves.rest() < 0);
    CHECK(moves.plan(100_um)->counts == 2); // 5.02 in both
    moves.reset();
    CHECK(moves.plan(100_um)->counts == 3);
}

} // namespace carried_move_tests
