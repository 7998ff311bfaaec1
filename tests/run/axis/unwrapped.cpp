// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Positions that wrap: counts and micrometres, forward and mirrored, against 64 bits. long_runs.cpp has 20 wraps.
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <servobus/axis/unwrapped.hpp>

#include "tests/support/axis_moves.hpp"

namespace unwrapped_tests {

using namespace servobus;
using std::int64_t;
using std::uint32_t;

constexpr unwrapped moved(unwrapped p, uint32_t from, uint32_t to) {
    p.start(from);
    (void)p.update(to);
    return p;
}
static_assert(moved({}, 0, 0).counts() == 0);
static_assert(moved({}, 0x7FFF'FFFF, 0x8000'0000).counts() == 1 && moved({}, 0, 0xFFFF'FFFF).counts() == -1);
static_assert(moved({}, 0, 0x7FFF'FFFF).counts() == 0x7FFF'FFFF, "the longest step");
static_assert(moved({}, 0, 0x8000'0000).counts() == -0x8000'0000ll, "2^31 counts may be either");
static_assert(moved(unwrapped{count_direction::mirrored}, 5, 2).counts() == 3);
static_assert(moved(unwrapped{count_direction::mirrored}, 0, 0x8000'0000).counts() == -0x8000'0000ll);

TEST_CASE("counts are kept when the drive changes its register") {
    unwrapped p = moved({}, 100, 200);
    p.start(0);
    CHECK(p.step_to(7) == 7);
    CHECK(p.counts() == 100);
    CHECK(p.update(7) == 7);
    CHECK(p.counts() == 107);
}

TEST_CASE("feedbacks over a wrap: no count and no micrometre is lost") {
    for (const count_direction direction : {count_direction::forward, count_direction::mirrored}) {
        const axis_moves::unwrapping u = axis_moves::unwrap(direction, 600'000);
        CHECK(u.are_equal);
        CHECK(u.wraps >= 1);
    }
}

TEST_CASE("a step that is longer than the micrometres of 32 bits is refused and changes nothing") {
    constexpr scale um_of_count = scale::of(40, 1);
    unwrapped_length p{um_of_count};
    p.start(0);
    REQUIRE(p.update(1000));
    CHECK(p.update(1001 + 53'687'091).error() == errc::out_of_range);
    CHECK(p.update(1000 + 0x8000'0000).error() == errc::out_of_range);
    CHECK(p.length() == micrometres{40'000});
    CHECK(p.counts() == 1000);
    CHECK(p.update(1000 + 53'687'091));
    CHECK(p.length() == micrometres{40'000 + 2'147'483'640ll});
    p.start(5);
    CHECK(p.update(6));
    CHECK(p.length() == micrometres{40'040 + 2'147'483'640ll});
}

} // namespace unwrapped_tests
