// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The text of quantities with their units, and times of a clock against quantities of time.
#include <doctest/doctest.h>

#include <cstdint>
#include <limits>
#include <string>

#include <servobus/core/time.hpp>
#include <servobus/registers/literals.hpp>
#include <servobus/registers/quantity_text.hpp>

namespace quantity_text_tests {

using namespace servobus;
using namespace servobus::literals;
using units::millisecond;
using units::r_per_min;
using units::volt;

static_assert(text(4820 * part<100>(volt)) == "48.20 V");

TEST_CASE("a quantity has a text with its unit, exact and without a catalogue") {
    CHECK(std::string{text(-125 * part<10>(r_per_min)).c_str()} == "-12.5 r/min");
    CHECK(text(5_ms) == "5 ms");
    CHECK(text(0 * volt) == "0 V");
    CHECK(text(-7 * part<100>(volt)) == "-0.07 V");
    CHECK(text(3 * multiple<10>(millisecond)) == "30 ms");
    CHECK(text(1 * part<3>(units::millimetre)) == "1/3 mm");
    CHECK(text(quantity<no_unit>{12}) == "12");
    CHECK_FALSE(text(5_ms) == "5 m");
    CHECK_FALSE(text(5_ms) == "5 ms ");
    CHECK(text(5_ms).size() == 4);
}

TEST_CASE("the greatest counts have their text too") {
    using wide = quantity<10 * unit{measure::millisecond}, std::int64_t>;
    constexpr auto most = std::numeric_limits<std::int64_t>::max();
    constexpr auto least = std::numeric_limits<std::int64_t>::min();
    CHECK(text(wide{most / 10}) == "9223372036854775800 ms");
    CHECK(text(wide{most / 10 + 1}) == "922337203685477581 * 10 ms");
    CHECK(text(wide{least}) == "-9223372036854775808 * 10 ms");
    CHECK(text(quantity<unit{measure::volt}, std::int64_t>{most}) == "9223372036854775807 V");
}

TEST_CASE("a time of a clock compares with a literal, either side, exactly") {
    constexpr instant began{0xFFFF'FFF0u};
    CHECK(since(began, began + milliseconds(501)) > 500_ms);
    CHECK(since(began, began + milliseconds(500)) <= 500_ms);
    CHECK(500_ms >= since(began, began + milliseconds(500)));
    CHECK(milliseconds(500) == 500_ms);
    CHECK(1_s != milliseconds(2));
    // No quantity is limited to what a duration can hold.
    CHECK(duration{0xFFFF'FFFFu} < 5'000'000 * millisecond);
    CHECK(duration{} > -1 * millisecond);
    CHECK(microseconds(1) > 999 * units::nanosecond);
    CHECK(microseconds(1) < 1001 * units::nanosecond);
}

} // namespace quantity_text_tests
