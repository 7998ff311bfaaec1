// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Positions that wrap: counts and micrometres over many wraps, forward and mirrored, against 64 bits.
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/unwrapped.hpp>

namespace unwrapped_tests {

using namespace servobus;
using std::int32_t;
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

void wander(count_direction direction) {
    constexpr scale um_of_count = scale::of(163'075, 4096);
    const int sign = direction == count_direction::forward ? 1 : -1;
    std::mt19937 random{43};
    unwrapped p{direction};
    unwrapped_length length{um_of_count, direction};
    uint32_t raw = 0xFFFF'0000;
    p.start(raw);
    length.start(raw);
    int64_t counts = 0;
    bool are_equal = true;
    // 20 wraps and more: 9000 counts a feedback on average.
    for (int i = 0; i < 10'000'000; ++i) {
        const auto step = static_cast<int32_t>(random() % 100'001) - 41'000;
        raw += static_cast<uint32_t>(step);
        counts += step;
        are_equal &= p.update(raw) == sign * step && static_cast<bool>(length.update(raw));
        // The nearest um; both products are exact.
        const int64_t off =
            length.length().count() * um_of_count.denominator() - sign * counts * um_of_count.numerator();
        are_equal &= 2 * off <= um_of_count.denominator() && -2 * off <= um_of_count.denominator();
    }
    CHECK(are_equal);
    CHECK(counts > 20 * (int64_t{1} << 32));
    CHECK(p.counts() == sign * counts);
    CHECK(length.counts() == sign * counts);
}

TEST_CASE("ten million feedbacks over 20 wraps: no count and no micrometre is lost") {
    wander(count_direction::forward);
    wander(count_direction::mirrored);
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
