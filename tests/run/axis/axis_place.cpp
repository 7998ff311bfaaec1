// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The place of an axis: relative moves add up to one product, a move that does not begin leaves no trace, positions go
// on over their wraps, and begin anew in another epoch. long_runs.cpp has millions.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/axis/axis_place.hpp>

#include "tests/support/axis_moves.hpp"

namespace axis_place_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {
constexpr auto whole = axis::of(lead(1_mm, counts_per_turn{1000})); // a count is a um
constexpr auto turned = axis::of(mirrored(lead(1_mm, counts_per_turn{1000})));
constexpr auto thirds = axis::of(lead(1_mm, counts_per_turn{3000}));
constexpr auto coarse = axis::of(rolling(4_m, counts_per_turn{1000})); // a count is 4 mm

constexpr result<std::int32_t> planned(const axis& of, micrometres way) {
    std::int32_t rest = 0;
    return axis_place{of}.plan(way, rest);
}
} // namespace

static_assert(*planned(whole, 125.5_mm) == 125'500 && *planned(turned, 125.5_mm) == -125'500);
static_assert(*planned(whole, 3_m) == 3'000'000 && *planned(whole, 0_um) == 0);
static_assert(planned(whole, 2147.5_m).error() == errc::out_of_range, "2^31 um are refused, not limited");
static_assert(*planned(whole, -2'147'483'647_um) == -2'147'483'647);
static_assert(planned(whole, micrometres{-2'147'483'648}).error() == errc::out_of_range);
static_assert(planned(whole, micrometres{std::int64_t{1} << 32}).error() == errc::out_of_range);

TEST_CASE("random moves drift by no count") {
    CHECK(axis_moves::drift(axis_moves::forward, 200'000) == 0);
    CHECK(axis_moves::drift(axis_moves::mirrored, 200'000) == 0);
}

TEST_CASE("a plan changes nothing; what is kept goes into the next one, and another epoch drops it") {
    axis_place place{axis_moves::forward};
    std::int32_t rest = 0;
    CHECK(place.plan(100_um, rest).value() == 3); // 2.51
    CHECK(place.plan(100_um, rest).value() == 3);
    place.keep(rest);
    CHECK(place.plan(100_um, rest).value() == 2); // 5.02 in both
    place.follow(7, 1);
    CHECK(place.plan(100_um, rest).value() == 3);
    place.keep(rest);
    place.follow(9, 1);
    CHECK(place.plan(100_um, rest).value() == 2);
}

TEST_CASE("a position goes on over its wrap, and begins anew in another epoch") {
    axis_place place{whole};
    CHECK(!place.is_known());
    place.follow(0x7FFF'FFF0, 4);
    CHECK(place.length() == micrometres{0x7FFF'FFF0});
    place.follow(0x8000'0010, 4);
    CHECK(place.length() == micrometres{0x8000'0010});
    place.follow(0xFFFF'FFFB, 5);
    CHECK(place.length() == -5_um);
    place.follow(3, 5);
    CHECK(place.length() == 3_um);
    axis_place mirrored{turned};
    mirrored.follow(0xFFFF'FFFB, 5);
    CHECK(mirrored.length() == 5_um);
    axis_place fine{thirds};
    fine.follow(1, 5);
    fine.follow(1, 6);
    CHECK(fine.length() == 0_um); // the third of before is not added to this one
}

TEST_CASE("feedbacks over a wrap: no micrometre is lost") {
    for (const axis* of : {&axis_moves::forward, &axis_moves::mirrored}) {
        const axis_moves::followed f = axis_moves::follow(*of, 600'000);
        CHECK(f.are_equal);
        CHECK(f.wraps >= 1);
    }
}

TEST_CASE("a place is known however far it is, and after a step of any length") {
    axis_place place{coarse};
    place.follow(600'000, 1); // 2400 m from zero
    CHECK(place.is_known());
    CHECK(place.length().count() == 2'400'000'000);
    place.follow(0x8000'0000, 1);
    CHECK(place.length().count() == 0x8000'0000ll * 4000);
    place.follow(0x8000'0000, 2);
    CHECK(place.length().count() == -0x8000'0000ll * 4000);
    place.follow(0, 2);
    CHECK(place.length().count() == -0x1'0000'0000ll * 4000); // half a range may be either way
}

} // namespace axis_place_tests
