// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Relative moves: millions of them add up to one product; a move that does not end done leaves no trace.
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/carried_move.hpp>

namespace carried_move_tests {

using namespace servobus;
using namespace servobus::literals;
using std::int32_t;
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

void move_at_random(count_direction direction) {
    const int sign = direction == count_direction::forward ? 1 : -1;
    std::mt19937 random{44};
    carried_move moves{counts_of_um, direction};
    int64_t um = 0;
    int64_t counts = 0;
    for (int i = 0; i < 10'000'000; ++i) {
        const auto distance = static_cast<int32_t>(random() % 20'001) - 10'000;
        const result<planned_move> m = moves.plan(micrometres{distance});
        if (random() % 8 == 0) continue; // it was refused, or stopped on its way
        moves.commit(*m);
        um += distance;
        counts += m->counts;
    }
    CHECK(sign * counts * counts_of_um.denominator() + moves.rest() == um * counts_of_um.numerator());
    CHECK(2 * moves.rest() <= counts_of_um.denominator());
    CHECK(-2 * moves.rest() <= counts_of_um.denominator());
}

TEST_CASE("ten million random moves drift by no count") {
    move_at_random(count_direction::forward);
    move_at_random(count_direction::mirrored);
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
