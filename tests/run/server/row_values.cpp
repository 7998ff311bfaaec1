// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The values of a device's rows: factory defaults, `get` and `set` of each kind of row, arrays, computed rows.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/server/row_values.hpp>

#include <tests/support/served_rows.hpp>

namespace row_values_tests {

using namespace servobus;
using served_rows::values;

namespace {

constexpr i32 run_time(i32 v) { return v; }

constexpr bool begins_with_factory_defaults() {
    const values v;
    return v.get<served_rows::selected>() == served_rows::gear::low &&
           v.get<served_rows::travel>() == -5 * units::pulse && v.get<served_rows::level>().count() == 5 &&
           v.get<served_rows::pairs>(1) == 7 && v.get<at<served_rows::pairs, 0>>() == 7 &&
           v.get<served_rows::pressure>() == -70'000 && v.get<served_rows::valve>() &&
           !v.get<served_rows::pump>() && v.get<served_rows::hatch>() && !v.get<served_rows::door>();
}
static_assert(begins_with_factory_defaults());

// A row without a default begins with 0, or with the lowest value if 0 is out of range.
static_assert(values{}.get<served_rows::command>() == 0 && values{}.get<served_rows::highs>(2) == 100);

constexpr bool keeps_what_is_set() {
    values v;
    v.set<served_rows::selected>(served_rows::gear::high);
    v.set<served_rows::travel>(100'000 * units::pulse);
    v.set<served_rows::level>(raw(1000)); // read-only for clients
    v.set<served_rows::pressure>(run_time(-3));
    v.set<served_rows::last_pair>(raw(run_time(-4)));
    v.set<served_rows::last_word>(clamped(run_time(70'000)));
    v.set<served_rows::pump>(true);
    v.set<served_rows::valve>(false);
    v.set<served_rows::hatch>(false);
    const bool are_kept = v.get<served_rows::selected>() == served_rows::gear::high &&
                          v.get<served_rows::travel>() == 100'000 * units::pulse &&
                          v.get<served_rows::level>().count() == 1000 &&
                          v.get<served_rows::pressure>() == -3 && v.get<served_rows::last_pair>() == -4 &&
                          v.get<served_rows::last_word>() == 0xFFFF && v.get<served_rows::pump>() &&
                          !v.get<served_rows::valve>() && !v.get<served_rows::hatch>();
    v.reset();
    return are_kept && v.get<served_rows::valve>() && v.get<served_rows::travel>() == -5 * units::pulse;
}
static_assert(keeps_what_is_set());

// By reference, else the compiler computes what stores no value.
constexpr bool refuses_values_out_of_range(values& v) {
    const bool are_refused =
        v.set<served_rows::travel>(checked(raw(run_time(100'001)))) == errc::out_of_range &&
        v.set<served_rows::travel>(checked(raw(run_time(-6)))) == errc::out_of_range &&
        v.set<served_rows::lows>(1, checked(raw(101))) == errc::out_of_range &&
        v.set<served_rows::level>(checked(1 * servobus::part<20>(units::percent))) == errc::inexact;
    const bool is_unchanged = v.get<served_rows::travel>() == -5 * units::pulse &&
                              v.get<served_rows::lows>(1) == -100 * units::pulse &&
                              v.get<served_rows::level>().count() == 5;
    const bool are_taken = v.set<served_rows::travel>(checked(raw(run_time(100'000)))) == errc::ok &&
                           v.set<served_rows::lows>(1, checked(raw(100))) == errc::ok;
    v.set<served_rows::highs>(0, clamped(run_time(5)));
    return are_refused && is_unchanged && are_taken && v.get<served_rows::highs>(0) == 100 &&
           v.get<served_rows::lows>(1) == 100 * units::pulse &&
           v.get<served_rows::travel>() == 100'000 * units::pulse;
}
static_assert([] {
    values v;
    return refuses_values_out_of_range(v);
}());

constexpr bool keeps_elements_of_interleaved_arrays_apart() {
    values v;
    for (std::size_t i = 0; i < 3; ++i) {
        v.set<served_rows::lows>(i, clamped(raw(10 + static_cast<int>(i))));
        v.set<served_rows::highs>(i, clamped(110 + static_cast<int>(i)));
    }
    bool are_apart = true;
    for (std::size_t i = 0; i < 3; ++i) {
        are_apart = are_apart && v.get<served_rows::lows>(i).count() == 10 + static_cast<int>(i) &&
                    v.get<served_rows::highs>(i) == 110 + i;
    }
    return are_apart && v.get<at<served_rows::lows, 2>>().count() == 12 &&
           v.get<at<served_rows::highs, 1>>() == 111;
}
static_assert(keeps_elements_of_interleaved_arrays_apart());

#ifdef _GLIBCXX_ASSERTIONS
// An element beyond the end is refused, also if the value of another row follows it.
template <std::size_t I>
concept has_element = requires {
    typename std::bool_constant<(values{}.get<served_rows::highs>(I), true)>;
};
static_assert(has_element<2> && !has_element<3>);
#endif

// Run-time values enter by themselves where each value of the type is in range.
static_assert(detail::holds_every_value<served_rows::last_word> &&
              detail::holds_every_value<served_rows::pressure>);
static_assert(!detail::holds_every_value<served_rows::level> &&
              !detail::holds_every_value<served_rows::travel>);
static_assert(detail::served_row::most_slots == 2048);

// Two words of 32 bits each share an alignment; a bit has a byte.
static_assert(sizeof(row_values<served_rows::travel, served_rows::last_word>) == 8);
static_assert(sizeof(row_values<served_rows::last_word>) == 2);
static_assert(sizeof(row_values<served_rows::valve, served_rows::pump>) == 2);
static_assert(alignof(row_values<served_rows::travel>) == alignof(u32));

} // namespace

TEST_CASE("rows begin with the factory defaults and keep what is set") {
    // The same at run time, where values are stored and loaded as a whole.
    CHECK(begins_with_factory_defaults());
    CHECK(keeps_what_is_set());
    values v;
    CHECK(refuses_values_out_of_range(v));
    CHECK(keeps_elements_of_interleaved_arrays_apart());
}

TEST_CASE("the function of a computed row is called for each value") {
    const values v;
    served_rows::computed_reads = 0;
    CHECK(v.get<served_rows::ticks>() == 0x0001'0002);
    CHECK(v.get<served_rows::ticks>() == 0x0001'0002);
    CHECK(served_rows::computed_reads == 2);
    CHECK(v.get<served_rows::age>().count() == 3);
    CHECK(v.get<served_rows::light>());
    served_rows::is_on = false;
    CHECK(!v.get<served_rows::light>());
    served_rows::is_on = true;
}

TEST_CASE("the free twins of get and set need no `template`") {
    values v;
    set<served_rows::travel>(v, 7 * units::pulse);
    CHECK(get<served_rows::travel>(v) == 7 * units::pulse);
    CHECK(get<served_rows::valve>(v));
}

} // namespace row_values_tests
