// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Geometries that are known at run time only: the same ratios as those of constants, or refused. What is left of a
// refused one moves nothing.
#include <cstdint>
#include <initializer_list>
#include <numeric>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/axis.hpp>
#include <servobus/axis/axis_place.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>

namespace geometry_tests {

using namespace servobus;
using namespace servobus::literals;
__extension__ using wide = __int128;

namespace {

constexpr nanometres nm(std::int64_t n) { return nanometres{n}; }

// Numbers of any size, as many small ones as large ones.
std::uint64_t any(std::mt19937_64& random, unsigned bits) {
    return random() >> (64 - 1 - random() % bits) >> (random() % 8 == 0 ? 8 : 0);
}
std::int32_t any_count(std::mt19937_64& random) {
    return static_cast<std::int32_t>(random()) >> random() % 32;
}
std::int64_t floor_of(wide a, wide b) {
    return static_cast<std::int64_t>(a >= 0 ? a / b : -((-a + b - 1) / b));
}

} // namespace

TEST_CASE("a scale is made of any two numbers as far as they fit, and converts exactly") {
    std::mt19937_64 random{17};
    int made = 0, refused = 0, converted = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::uint64_t factor = any(random, 24) + 1;
        const std::uint64_t a = any(random, 36) * factor;
        const std::uint64_t b = any(random, 33) * factor;
        CAPTURE(a);
        CAPTURE(b);
        const result<scale> s = scale::checked(a, b);
        const std::uint64_t common = std::gcd(a, b);
        const bool fits = a != 0 && b != 0 && a / common < 1ull << 32 && b / common <= 1ull << 29;
        REQUIRE(static_cast<bool>(s) == fits);
        (fits ? made : refused) += 1;
        if (!fits) {
            CHECK(s.error() == errc::out_of_range);
            continue;
        }
        CHECK(s->numerator() == a / common);
        CHECK(static_cast<std::uint64_t>(s->denominator()) == b / common);
        const auto x = any_count(random);
        const result<std::int32_t> y = s->nearest(x);
        const wide n = s->numerator(), d = s->denominator();
        if (!y) {
            CHECK((x < 0 ? -wide{x} : wide{x}) > wide{s->most()});
            continue;
        }
        ++converted;
        CHECK(*y == floor_of(2 * wide{x} * n + d, 2 * d));
    }
    MESSAGE(made, " made, ", refused, " refused, ", converted, " converted");
    CHECK(made > 5000);
    CHECK(refused > 2000);
    CHECK(converted > 2000);
}

TEST_CASE("a scale that is close to a ratio differs from it by as little as it says, or is refused") {
    std::mt19937_64 random{18};
    int made = 0, rounded = 0, refused = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::uint64_t a = any(random, 63);
        const std::uint64_t b = i % 8 == 0 ? random() | std::uint64_t{1} << 63 : any(random, 63);
        CAPTURE(a);
        CAPTURE(b);
        const result<scale> s = scale::checked_close_to(a, b);
        const long double ratio = b == 0 ? 0 : static_cast<long double>(a) / static_cast<long double>(b);
        const long double least = 1.0L / (1 << 30);
        if (!s) {
            ++refused;
            CHECK((b == 0 || ratio < least || ratio > 4'294'967'295.4L));
            continue;
        }
        ++made;
        CHECK(ratio >= least);
        const long double is =
            static_cast<long double>(s->numerator()) / static_cast<long double>(s->denominator());
        const long double off = is < ratio ? ratio - is : is - ratio;
        rounded += off > 1e-18L * ratio ? 1 : 0;
        CHECK((off <= least * 1.000'001L || off <= ratio / 4e9L));
    }
    MESSAGE(made, " made, ", rounded, " of them rounded, ", refused, " refused");
    CHECK(rounded > 1000);
    CHECK(refused > 1000);
}

TEST_CASE("a feed takes what `rolling` takes, up to the last number") {
    CHECK(feed::checked(nm(1), counts_per_turn{1}));
    CHECK(feed::checked(nm(0xFFFF'FFFF), counts_per_turn{1u << 28}, gear_ratio{0xFFFF, 0xFFFF}));
    for (const result<feed>& wrong : {
             feed::checked(nm(0), counts_per_turn{16384}),
             feed::checked(nm(-652'300'000), counts_per_turn{16384}),
             feed::checked(nm(0x1'0000'0000), counts_per_turn{16384}),
             feed::checked(652.3_mm, counts_per_turn{0}),
             feed::checked(652.3_mm, counts_per_turn{(1u << 28) + 1}),
             feed::checked(652.3_mm, counts_per_turn{16384}, gear_ratio{0, 1}),
             feed::checked(652.3_mm, counts_per_turn{16384}, gear_ratio{1, 0}),
             feed::checked(652.3_mm, counts_per_turn{16384}, gear_ratio{0x1'0000, 1}),
             feed::checked(652.3_mm, counts_per_turn{16384}, gear_ratio{1, 0x1'0000}),
         }) {
        CHECK(wrong.error() == errc::out_of_range);
        CHECK(axis::checked(wrong).error() == errc::out_of_range);
        CHECK(axis::checked(*wrong).error() == errc::out_of_range);
        CHECK(axle::checked({.left = *wrong, .right = *wrong, .track = 500_mm}).error() ==
              errc::out_of_range);
    }
    CHECK(checked_diameter(207.6_mm).value() == diameter(207.6_mm));
    CHECK(checked_diameter(nm(1'360'000'000)).value() == diameter(1.36_m));
    for (const std::int64_t wrong : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1'360'000'001}})
        CHECK(checked_diameter(nm(wrong)).error() == errc::out_of_range);
}

TEST_CASE("an axis of run-time numbers converts like the constant") {
    constexpr auto constant = axis::of(mirrored(lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10})));
    const result<feed> by = feed::checked(nm(5'080'000), counts_per_turn{1000}, gear_ratio{37, 10});
    REQUIRE(by);
    const result<axis> made = axis::checked(mirrored(*by));
    REQUIRE(made);
    CHECK(made->is_mirrored());
    CHECK(made->counts_of_motor_turn() == 1000);
    CHECK(made->most_counts() == constant.most_counts());
    std::mt19937_64 random{19};
    for (int i = 0; i < 10'000; ++i) {
        const auto x = any_count(random);
        const micrometres um{x};
        CHECK(made->counts_of(um).error() == constant.counts_of(um).error());
        CHECK(made->counts_of(um).value_or(0) == constant.counts_of(um).value_or(0));
        CHECK(made->length_of(x).value_or(micrometres{}) == constant.length_of(x).value_or(micrometres{}));
        const micrometres_per_second v{x};
        CHECK(made->motor_speed_of(v).value_or(motor_speed{}) ==
              constant.motor_speed_of(v).value_or(motor_speed{}));
        CHECK(made->speed_of(motor_speed{x}) == constant.speed_of(motor_speed{x}));
        for (const std::int32_t per : {1, 4, 10}) {
            const result<std::int32_t> counts = made->motor_counts_of(v, per);
            const long double exact = -x * 60.0L * 3.7L / 5080 * per;
            const bool is_beyond = x > 214'748'364 || x < -214'748'364;
            CHECK(static_cast<bool>(counts) == !is_beyond);
            if (counts) CHECK(static_cast<long double>(*counts) - exact <= 0.5001L);
            if (counts) CHECK(exact - static_cast<long double>(*counts) <= 0.5001L);
        }
    }
    // Each of the two exact scales may be too fine.
    CHECK(axis::checked(feed::checked(nm(536'870'909), counts_per_turn{1})));
    CHECK(axis::checked(feed::checked(nm(536'870'923), counts_per_turn{1})).error() == errc::out_of_range);
    CHECK(axis::checked(feed::checked(nm(999'983), counts_per_turn{536'870})));
    CHECK(axis::checked(feed::checked(nm(999'983), counts_per_turn{536'871})).error() == errc::out_of_range);
    // Or either of those of its speeds: a um/s of too many turns, and a turn of too few um.
    CHECK(axis::checked(feed::checked(nm(1), counts_per_turn{1}, gear_ratio{7000, 1})).error() ==
          errc::out_of_range);
    CHECK(axis::checked(feed::checked(nm(1), counts_per_turn{1}, gear_ratio{0xFFFF, 1})).error() ==
          errc::out_of_range);
    CHECK(axis::checked(feed::checked(nm(1), counts_per_turn{1}, gear_ratio{1, 1})));
    const feed once = mirrored(*by);
    CHECK(mirrored(once).direction() == count_direction::forward);
}

TEST_CASE("two wheels of run-time numbers are as those of constants") {
    constexpr feed left = rolling(534.2_mm, counts_per_turn{16384});
    constexpr feed right = mirrored(rolling(533.6_mm, counts_per_turn{16384}));
    constexpr auto constant = differential::of({.left = left, .right = right, .track = 412.5_mm});
    const result<feed> l = feed::checked(nm(534'200'000), counts_per_turn{16384});
    const result<feed> r = feed::checked(nm(533'600'000), counts_per_turn{16384});
    REQUIRE(l);
    REQUIRE(r);
    const result<differential> made =
        differential::checked({.left = *l, .right = mirrored(*r), .track = nm(412'500'000)});
    REQUIRE(made);
    const detail::axle_ratios &is = made->base().ratios(), &of = constant.base().ratios();
    CHECK(is.left_turn == of.left_turn);
    CHECK(is.right_turn == of.right_turn);
    CHECK(is.left_arc == of.left_arc);
    CHECK(is.right_arc == of.right_arc);
    CHECK(is.most_counts == of.most_counts);
    CHECK(is.most_difference == of.most_difference);
    CHECK(is.half_track == of.half_track);
    std::mt19937_64 random{20};
    for (int i = 0; i < 10'000; ++i) {
        const std::int32_t um_per_s = any_count(random), urad_per_s = any_count(random);
        const twist t{um_per_s * units::micrometre_per_second, urad_per_s * units::microradian_per_second};
        CHECK(made->wheels(t, 10, 3000) == constant.wheels(t, 10, 3000));
    }

    const auto with = [&](feed a, feed b, nanometres track) {
        return differential::checked({.left = a, .right = b, .track = track}).error();
    };
    CHECK(with(*l, *r, nm(1'000'000)) == errc::ok);
    CHECK(with(*l, *r, nm(15'999'999'999)) == errc::ok);
    CHECK(with(*l, *r, nm(16'000'000'000)) == errc::out_of_range);
    CHECK(with(*l, *r, nm(999'999)) == errc::out_of_range);
    CHECK(with(*l, *r, nm(0)) == errc::out_of_range);
    CHECK(with(*l, *r, nm(-412'500'000)) == errc::out_of_range);
    CHECK(with(*l, {}, nm(412'500'000)) == errc::out_of_range);
    CHECK(with({}, *r, nm(412'500'000)) == errc::out_of_range);
    const result<feed> coarse = feed::checked(nm(534'200'000), counts_per_turn{100});
    CHECK(with(*coarse, *coarse, nm(14'000'000)) == errc::ok);           // 5.342 mm a count: 0.38 rad
    CHECK(with(*coarse, *coarse, nm(13'000'000)) == errc::out_of_range); // 0.41 rad
    CHECK(with(*coarse, *r, nm(13'000'000)) == errc::out_of_range);
    CHECK(with(*l, *coarse, nm(13'000'000)) == errc::out_of_range);
    const result<feed> fine = feed::checked(nm(652'301'000), counts_per_turn{1u << 28}, gear_ratio{65521, 1});
    REQUIRE(fine);
    CHECK(with(*fine, *r, nm(499'999'000)) == errc::out_of_range);
    CHECK(with(*l, *fine, nm(499'999'000)) == errc::out_of_range);
    // The axle itself refuses it: odometry needs no differential.
    CHECK(axle::checked({.left = *fine, .right = *r, .track = nm(499'999'000)}).error() ==
          errc::out_of_range);
    CHECK(axle::checked({.left = *l, .right = *fine, .track = nm(499'999'000)}).error() ==
          errc::out_of_range);
    // A turn of the motor travels less than 10 um, or more than 4.3 m.
    const result<feed> large = feed::checked(nm(2'150'000'000), counts_per_turn{4096}, gear_ratio{1, 2});
    const result<feed> larger = feed::checked(nm(2'150'000'001), counts_per_turn{4096}, gear_ratio{1, 2});
    CHECK(with(*large, *large, nm(412'500'000)) == errc::ok);
    CHECK(with(*larger, *large, nm(412'500'000)) == errc::out_of_range);
    CHECK(with(*large, *larger, nm(412'500'000)) == errc::out_of_range);
    const result<feed> small = feed::checked(nm(9'999), counts_per_turn{4096});
    const result<feed> enough = feed::checked(nm(30'000), counts_per_turn{4096}, gear_ratio{3, 1});
    const result<feed> tiny = feed::checked(nm(1), counts_per_turn{1}, gear_ratio{0xFFFF, 1});
    REQUIRE(tiny);
    CHECK(with(*enough, *enough, nm(412'500'000)) == errc::ok);
    CHECK(with(*small, *enough, nm(412'500'000)) == errc::out_of_range);
    CHECK(with(*enough, *small, nm(412'500'000)) == errc::out_of_range);
    CHECK(with(*tiny, *l, nm(412'500'000)) == errc::out_of_range);
    CHECK(with(*l, *tiny, nm(412'500'000)) == errc::out_of_range);
}

TEST_CASE("what is left of a refused geometry moves nothing") {
    constexpr axis none;
    CHECK(none.counts_of_motor_turn() == 0);
    CHECK(none.counts_of(1_um).error() == errc::out_of_range);
    CHECK(none.counts_of(-5_m).error() == errc::out_of_range);
    CHECK(none.motor_speed_of(micrometres_per_second{1}).error() == errc::out_of_range);
    CHECK(none.length_of(1'000'000).value() == 0_um);
    CHECK(none.speed_of(motor_speed{30'000}).count() == 0);
    axis_place place{none};
    place.follow(0x7FFF'FFFF, 1);
    place.follow(0xFFFF'FFFF, 1);
    CHECK(place.length() == 0_um);
    std::int32_t rest = 7;
    CHECK(place.plan(1_mm, rest).error() == errc::out_of_range);

    constexpr differential base;
    for (const twist& t : {twist{1_m_per_s, 1_rad_per_s}, twist{2147_m_per_s, 2147_rad_per_s},
                           twist{-2147_m_per_s, -2147_rad_per_s}, twist{0_m_per_s, 2147_rad_per_s}}) {
        const wheel_speeds both = base.wheels(t, 10, 3000);
        CHECK(both.left == 0);
        CHECK(both.right == 0);
    }
    odometry o{base.base()};
    o.start(0, 0);
    CHECK_FALSE(o.update(1, 0, {}));
    CHECK(o.pose().x() == 0_um);
}

TEST_CASE("any two wheels that are taken have speeds within the bound") {
    std::mt19937_64 random{21};
    int made = 0, refused = 0;
    for (int i = 0; i < 30'000; ++i) {
        const std::uint64_t travel = any(random, 33), times = 1 + random() % 8;
        const auto lines = static_cast<std::uint32_t>(any(random, 29));
        const auto turns = static_cast<std::uint32_t>(any(random, 17));
        const auto of_output = static_cast<std::uint32_t>(any(random, 17));
        const auto track = nm(static_cast<std::int64_t>(any(random, 35)));
        const gear_ratio gear{turns, of_output};
        const auto around = static_cast<std::int64_t>(travel);
        const auto farther = static_cast<std::int64_t>(travel * times);
        const result<feed> one = feed::checked(nm(around), counts_per_turn{lines}, gear);
        const result<feed> other = feed::checked(nm(farther), counts_per_turn{lines}, gear);
        const result<feed>& left = times % 2 == 0 ? one : other;
        const result<feed>& right = times % 2 == 0 ? other : one;
        const auto base = differential::checked({.left = *left, .right = *right, .track = track});
        if (!base) {
            ++refused;
            continue;
        }
        ++made;
        const std::int32_t um_per_s = any_count(random), urad_per_s = any_count(random);
        const twist t{um_per_s * units::micrometre_per_second, urad_per_s * units::microradian_per_second};
        const std::int32_t limit = i % 2 == 0 ? 3000 : 32'767;
        const std::int32_t per = i % 3 == 0 ? 1 : 10;
        const wheel_speeds both =
            base->wheels(t, static_cast<std::uint32_t>(per), static_cast<std::uint32_t>(limit));
        const auto exact = [&](const feed& w, int sign) {
            const long double turn =
                static_cast<long double>(urad_per_s) / 1e6L * static_cast<long double>(track.count()) / 2000;
            const long double both_um_per_s = static_cast<long double>(um_per_s) + sign * turn;
            return both_um_per_s * 60 * 1000 * w.ratio().motor_turns / static_cast<long double>(w.travel()) *
                   per;
        };
        long double l = exact(*left, -1), r = exact(*right, 1);
        const auto size = [](long double v) { return v < 0 ? -v : v; };
        const long double most = size(l) > size(r) ? size(l) : size(r);
        if (most > static_cast<long double>(limit)) {
            l *= static_cast<long double>(limit) / most;
            r *= static_cast<long double>(limit) / most;
        }
        CAPTURE(left->travel());
        CAPTURE(right->travel());
        CAPTURE(track.count());
        CAPTURE(um_per_s);
        CAPTURE(urad_per_s);
        // Half a um/s is lost, too.
        const auto bound = [per](const feed& w) {
            return 1.5L + 0.5L * 60'000 * per * w.ratio().motor_turns / static_cast<long double>(w.travel());
        };
        CHECK(size(static_cast<long double>(both.left) - l) <= bound(*left));
        CHECK(size(static_cast<long double>(both.right) - r) <= bound(*right));
        CHECK(both.left <= limit);
        CHECK(both.left >= -limit);
        CHECK(both.right <= limit);
        CHECK(both.right >= -limit);
    }
    MESSAGE(made, " made, ", refused, " refused");
    CHECK(made > 200);
    CHECK(refused > 200);
}

} // namespace geometry_tests
