// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register map without frames: units and quantities, values that go into a register (constants, checked,
// clamped, raw), values that were read, arrays of rows, plans for several registers, the catalogue.
#include <doctest/doctest.h>

#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/meter_units.hpp>
#include <servobus/registers/register_value.hpp>

namespace registers_tests {

namespace {

// A device for these tests.
namespace fixture {

using namespace servobus;

struct device {
    static constexpr profile facts{.name = "fixture", .max_read = 5, .max_write = 4};
};
enum class colour : std::uint16_t { red = 1, green = 2, infrared = 0x0102 };

template <wire_value T> using rw = reg<T, access::rw, device>;
using units::ampere, units::milliampere, units::millisecond, units::pulse, units::r_per_min, units::second;

inline constexpr rw<u16> plain{0x10, {5, 5000}, no_unit, 10};
inline constexpr rw<i16> speed{0x11, {-300, 300}, r_per_min, 0};
inline constexpr rw<u16> current{0x12, {0, 300}, ampere / 10, 0};
inline constexpr rw<i16> signed_current{0x13, {-300, 300}, ampere / 10, 0};
inline constexpr rw<u16> slow{0x14, {0, 6000}, multiple<10>(millisecond), 0};
inline constexpr rw<u16> seconds{0x15, {0, 100}, second, 0};
inline constexpr rw<i32> position{0x16, full<i32>, pulse, 0};
inline constexpr rw<u32> wide{0x18, full<u32>, no_unit, 0};
inline constexpr rw<i16> word{0x1A, full<i16>, no_unit, 0};
inline constexpr rw<colour> lamp{0x1B, {1, 2}, no_unit, 1};
inline constexpr rw<left_right<std::int8_t>> heat{0x1C, unstated, no_unit, 0};
inline constexpr rw<i16> rescaled{0x1D, {-3000, 3000}, r_per_min, 0, scaled_elsewhere | motion};
inline constexpr rw<i16> tenths{0x1E, full<i16>, r_per_min / 10, 0};
inline constexpr reg_array<rw<i16>, 4> steps{{0x0300, {-100, 100}, r_per_min, 0}, 6};

} // namespace fixture

using namespace servobus;

template <const auto& R> constexpr errc error_of(register_value<R> s) { return s.error(); }
template <const auto& R> constexpr u32 bits_of(register_value<R> s) { return s.bits(); }

// Units.
static_assert(units::r_per_min.value == unit{measure::r_per_min, 1, 1});
static_assert(units::ampere / 10 == unit{measure::ampere, 1, 10});
static_assert(multiple<10>(units::millisecond).value == unit{measure::millisecond, 10, 1});
static_assert(part<100>(units::volt).value == unit{measure::volt, 1, 100});
static_assert(no_unit == unit{});

// Quantities are exact in a finer unit, and rounded in a coarser one by name.
static_assert((30 * units::r_per_min).in(part<10>(units::r_per_min)) == 300);
static_assert((1500 * units::milliampere).rounded(units::ampere) == 2);
static_assert((-1500 * units::milliampere).rounded(units::ampere) == -2);
static_assert((1499 * units::milliampere).rounded(units::ampere) == 1);
static_assert((-1499 * units::milliampere).rounded(units::ampere) == -1);
static_assert((2 * units::second).in(units::millisecond) == 2000);
static_assert(2 * units::second == 2000 * units::millisecond);
static_assert(2 * units::second < 2001 * units::millisecond);
static_assert(2 * units::second > 1999 * units::millisecond);
static_assert(2 * units::second != 2001 * units::millisecond);
static_assert(125 * part<10>(units::r_per_min) > 12 * units::r_per_min);
static_assert(5 * units::pulse + 2 * units::pulse == 7 * units::pulse);
static_assert(5 * units::pulse - 2 * units::pulse == 3 * units::pulse);
static_assert(-(5 * units::pulse) == -5 * units::pulse);

template <class A, class B>
concept comparable = requires(A a, B b) {
    a == b;
    a < b;
};
using amperes = quantity<unit{measure::ampere}>;
using volts = quantity<unit{measure::volt}>;
static_assert(comparable<amperes, quantity<unit{measure::milliampere}>>);
static_assert(!comparable<amperes, volts>);

// The count of a reading is asked for in one way, whatever its kind; raw() takes it back.
template <const auto& R> constexpr auto count_read(u32 bits) { return count_of(reading_of<R>(bits)); }
static_assert(count_read<fixture::plain>(5000) == 5000, "without a unit");
static_assert(count_read<fixture::speed>(0xFED4) == -300, "with a unit");
static_assert(count_read<fixture::current>(15) == 15, "1.5 A");
static_assert(count_read<fixture::position>(0xFFFF'FFFF) == -1);
static_assert(count_read<fixture::wide>(0xFFFF'FFFF) == 0xFFFF'FFFF);
static_assert(count_read<fixture::rescaled>(0xFFFF) == -1, "another register sets the scale");
static_assert(count_read<fixture::lamp>(0x0102) == 0x0102, "a code");
static_assert(count_read<fixture::lamp>(7) == 7, "a code without a name");
static_assert(count_read<fixture::heat>(0x24FF) == 0x24FF, "two values in one word");
static_assert(count_of(true) == 1 && count_of(false) == 0, "a coil");
static_assert(count_of(30 * units::r_per_min) == 30);
static_assert(bits_of<fixture::speed>(raw(count_of(reading_of<fixture::speed>(0xFED4)))) == 0xFFFF'FED4);
template <class T>
concept has_count = requires(T v) {
    count_of(v);
};
static_assert(has_count<reading<fixture::speed>> && !has_count<double> && !has_count<char>);
static_assert(!has_count<readings<fixture::plain, fixture::speed>>, "of several rows each has its own");

// A constant in range becomes its raw bits; the invalid ones are in tests/fail.
static_assert(bits_of<fixture::plain>(5) == 5);
static_assert(bits_of<fixture::plain>(5000) == 5000);
static_assert(bits_of<fixture::speed>(-300) == 0xFFFF'FED4);
static_assert(bits_of<fixture::speed>(30 * units::r_per_min) == 30);
static_assert(bits_of<fixture::current>(15 * units::ampere) == 150);
static_assert(bits_of<fixture::current>(1500 * units::milliampere) == 15);
static_assert(bits_of<fixture::signed_current>(-1500 * units::milliampere) == 0xFFFF'FFF1);
static_assert(bits_of<fixture::current>(raw(15)) == 15);
static_assert(bits_of<fixture::slow>(500 * units::millisecond) == 50);
static_assert(bits_of<fixture::slow>(2 * units::second) == 200);
static_assert(bits_of<fixture::position>(-2'147'483'647 - 1) == 0x8000'0000);
static_assert(bits_of<fixture::wide>(0xFFFF'FFFFu) == 0xFFFF'FFFF);
static_assert(bits_of<fixture::lamp>(fixture::colour::green) == 2);
static_assert(bits_of<fixture::heat>(left_right<std::int8_t>{-10, 30}) == 0xF61E);
static_assert(bits_of<fixture::rescaled>(raw(-3000)) == 0xFFFF'F448);

// The type of a reading.
static_assert(std::same_as<reading<fixture::plain>, u16>);
static_assert(std::same_as<reading<fixture::speed>, quantity<unit{measure::r_per_min}, i16>>);
static_assert(std::same_as<reading<fixture::lamp>, fixture::colour>);
static_assert(std::same_as<reading<fixture::rescaled>, i16>);

// Plans are sorted and merged, never across an address that was not asked for, and never longer than the
// device allows.
constexpr auto& merged = read_plan<fixture::speed, fixture::plain, fixture::current>;
static_assert(merged.count == 1 && merged.requests[0].address == 0x10 && merged.requests[0].words == 3);
constexpr auto& apart = read_plan<fixture::current, fixture::plain>;
static_assert(apart.count == 2 && apart.words == 2);
static_assert(apart.requests[0].address == 0x10 && apart.requests[0].words == 1);
static_assert(apart.requests[1].address == 0x12 && apart.requests[1].words == 1);
constexpr auto& long_one =
    read_plan<fixture::plain, fixture::speed, fixture::current, fixture::signed_current, fixture::slow,
              fixture::seconds, fixture::position>;
static_assert(long_one.count == 2 && long_one.words == 8);
static_assert(long_one.requests[0].words == 5 && long_one.requests[1].address == 0x15 &&
              long_one.requests[1].words == 3);
// A 32-bit value is never split: it begins a request of its own if it does not fit.
constexpr auto& whole_pair =
    read_plan<fixture::current, fixture::signed_current, fixture::slow, fixture::seconds, fixture::position>;
static_assert(whole_pair.count == 2 && whole_pair.requests[0].words == 4 &&
              whole_pair.requests[1].address == 0x16 && whole_pair.requests[1].words == 2);
static_assert(readings<fixture::speed, fixture::plain>::is_one_frame);
static_assert(!readings<fixture::current, fixture::plain>::is_one_frame);
static_assert(read_plan<fixture::plain, fixture::plain>.overlaps);
static_assert(!merged.overlaps && !apart.overlaps && !long_one.overlaps && !whole_pair.overlaps);
static_assert(write_plan<fixture::slow, fixture::seconds, fixture::position>::words == 4);

// Arrays of rows.
static_assert(at<fixture::steps, 0>.address == 0x0300 && at<fixture::steps, 3>.address == 0x0312);
static_assert(at<fixture::steps, 3>.limits == range{-100, 100});
static_assert(is_register<at<fixture::steps, 1>> && !is_register<fixture::steps>);
static_assert(is_register_array<fixture::steps> && !is_register_array<fixture::plain>);

} // namespace

TEST_CASE("the meanings of a device's exceptions may be made at run time") {
    std::vector<exception_meaning> made{{2, "no such row"}};
    made.push_back({7, "too hot"});
    const profile facts{.name = "made",
                        .exceptions = exception_table{made.data(), made.data() + made.size()}};
    CHECK(std::string_view{facts.meaning(7)} == "too hot");
    CHECK(std::string_view{facts.meaning(2)} == "no such row");
    CHECK(std::string_view{facts.meaning(3)} == "unknown exception");
}

TEST_CASE("a checked value is accepted up to the ends of its range and refused beyond") {
    for (int v = -70'000; v <= 70'000; ++v) {
        const register_value<fixture::speed> s = checked(v);
        const bool fits = v >= -300 && v <= 300;
        REQUIRE(s.error() == (fits ? errc::ok : errc::out_of_range));
        if (fits) REQUIRE(static_cast<int>(s.bits()) == v);
        const register_value<fixture::plain> p = checked(v);
        REQUIRE(p.error() == (v >= 5 && v <= 5000 ? errc::ok : errc::out_of_range));
    }
}

TEST_CASE("a clamped value becomes the nearest value in range") {
    for (int v = -70'000; v <= 70'000; ++v) {
        const register_value<fixture::speed> s = clamped(v);
        REQUIRE(s.error() == errc::ok);
        REQUIRE(static_cast<int>(s.bits()) == (v < -300 ? -300 : v > 300 ? 300 : v));
    }
}

TEST_CASE("a value wider than the register is never taken for the number in its low bits") {
    const auto most = (std::numeric_limits<std::uint64_t>::max)();
    for (const std::uint64_t v :
         {most, most - 100, std::uint64_t{1} << 32, std::uint64_t{1} << 63, std::uint64_t{1} << 16,
          (std::uint64_t{1} << 32) + 100, (std::uint64_t{1} << 48) + 7}) {
        CAPTURE(v);
        CHECK(register_value<fixture::speed>{checked(v)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::word>{checked(v)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::plain>{checked(v)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::plain>{clamped(v)}.bits() == 5000);
        CHECK(register_value<fixture::speed>{clamped(v)}.bits() == 300);
        CHECK(register_value<fixture::current>{checked(raw(static_cast<std::int64_t>(v >> 1)))}.error() ==
              errc::out_of_range);
    }
    for (const std::int64_t v : {std::int64_t{-1} << 32, (std::int64_t{-1} << 32) + 5,
                                 (std::int64_t{-1} << 48) + 5, (std::numeric_limits<std::int64_t>::min)()}) {
        CHECK(register_value<fixture::speed>{checked(v)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::speed>{clamped(v)}.bits() == 0xFFFF'FED4);
    }
}

TEST_CASE("a quantity of a wide number is never taken for the number in its low bits") {
    for (const std::int64_t v :
         {std::int64_t{1} << 32, (std::int64_t{1} << 32) + 100, (std::int64_t{1} << 40) + 1,
          std::int64_t{3'000'000'000}, (std::numeric_limits<std::int64_t>::max)()}) {
        CAPTURE(v);
        CHECK(register_value<fixture::speed>{checked(v * units::r_per_min)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::position>{checked(v * units::pulse)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::position>{checked(-v * units::pulse)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::current>{checked(v * units::ampere)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::speed>{clamped(v * units::r_per_min)}.bits() == 300);
    }
    for (const std::uint32_t v : {0xFFFF'FFFFu, 0xFFFF'FF9Cu, 0x8000'0000u, 3'000'000'000u}) {
        CAPTURE(v);
        CHECK(register_value<fixture::speed>{checked(v * units::r_per_min)}.error() == errc::out_of_range);
        CHECK(register_value<fixture::signed_current>{checked(v * units::milliampere)}.error() != errc::ok);
        const quantity<unit{measure::milliampere}, u32> read{v};
        CHECK(register_value<fixture::signed_current>{checked(read)}.error() != errc::ok);
    }
}

TEST_CASE("a quantity of a wide number keeps its value, where it fits") {
    CHECK(register_value<fixture::speed>{checked(std::int64_t{-250} * units::r_per_min)}.bits() ==
          static_cast<u32>(-250));
    CHECK(register_value<fixture::current>{checked(std::size_t{12} * units::ampere)}.bits() == 120);
    CHECK(register_value<fixture::current>{checked(std::uint32_t{12'300} * units::milliampere)}.bits() ==
          123);
    CHECK(register_value<fixture::current>{checked(std::int64_t{12'350} * units::milliampere)}.error() ==
          errc::inexact);
}

TEST_CASE("a quantity is exact in the register's counts, or inexact and never sent") {
    for (std::int32_t milliamperes = -40'000; milliamperes <= 40'000; ++milliamperes) {
        const register_value<fixture::signed_current> s = checked(milliamperes * units::milliampere);
        const bool whole = milliamperes % 100 == 0;
        const bool fits = milliamperes / 100 >= -300 && milliamperes / 100 <= 300;
        REQUIRE(s.error() == (!whole ? errc::inexact : fits ? errc::ok : errc::out_of_range));
        if (s.error() == errc::ok) REQUIRE(static_cast<std::int32_t>(s.bits()) == milliamperes / 100);
    }
    CHECK(register_value<fixture::seconds>{checked(1500 * units::millisecond)}.error() == errc::inexact);
    CHECK(register_value<fixture::seconds>{checked(3000 * units::millisecond)}.bits() == 3);
    CHECK(register_value<fixture::seconds>{clamped(1500 * units::millisecond)}.error() == errc::inexact);
    CHECK(register_value<fixture::seconds>{clamped(900'000 * units::millisecond)}.bits() == 100);
}

TEST_CASE("a quantity at the ends of 32 bits is converted without wrapping") {
    constexpr std::int32_t most = (std::numeric_limits<std::int32_t>::max)();
    constexpr std::int32_t least = (std::numeric_limits<std::int32_t>::min)();
    CHECK(register_value<fixture::current>{checked(most * units::ampere)}.error() == errc::out_of_range);
    CHECK(register_value<fixture::signed_current>{checked(least * units::ampere)}.error() ==
          errc::out_of_range);
    CHECK(register_value<fixture::slow>{checked(most * units::second)}.error() == errc::out_of_range);
    CHECK((most * units::second).in(units::millisecond) == most);
    CHECK((least * units::second).in(units::millisecond) == least);
    CHECK((most * units::millisecond).rounded(units::second) == 2'147'484);
    CHECK((least * units::millisecond).rounded(units::second) == -2'147'484);
    CHECK((most * units::second).rounded(units::second) == most);
    CHECK((1 * units::hour).rounded(units::microsecond) == most);
    CHECK((-1 * units::hour).rounded(units::nanosecond) == least);
    CHECK((1'800'000'000 * units::microsecond).rounded(units::hour) == 1);
    CHECK((1'799'999'999 * units::microsecond).rounded(units::hour) == 0);
    CHECK((-1'800'000'000 * units::microsecond).rounded(units::hour) == -1);
    CHECK((most * units::nanosecond).rounded(units::hour) == 0);
    CHECK(most * units::second > most * units::millisecond);
    CHECK(least * units::second < least * units::millisecond);
}

TEST_CASE("rounding takes the nearest number, halves away from zero") {
    for (std::int32_t v = -5000; v <= 5000; ++v) {
        const double exact = v / 1000.0;
        const auto expected = static_cast<std::int32_t>(exact < 0 ? exact - 0.5 : exact + 0.5);
        REQUIRE((v * units::millisecond).rounded(units::second) == expected);
        REQUIRE((v * part<3>(units::pulse)).rounded(units::pulse) ==
                static_cast<std::int32_t>(v < 0 ? v / 3.0 - 0.5 : v / 3.0 + 0.5));
    }
}

TEST_CASE("a reading compares with a quantity of the same kind, of any width") {
    using reading_of_tenths = reading<fixture::tenths>;
    CHECK(comparable<reading_of_tenths, quantity<unit{measure::r_per_min}>>);
    CHECK(comparable<reading_of_tenths, quantity<unit{measure::r_per_min, 1, 10}>>);
    CHECK(comparable<reading<fixture::speed>, quantity<unit{measure::r_per_min}>>);
    CHECK(comparable<quantity<unit{measure::ampere}, u32>, quantity<unit{measure::ampere}, i16>>);
}

TEST_CASE("every 16-bit word is the same after conversion to any 16-bit type and back") {
    for (unsigned w = 0; w <= 0xFFFF; ++w) {
        REQUIRE(to_bits(from_bits<u16>(w)) == w);
        REQUIRE((to_bits(from_bits<i16>(w)) & 0xFFFFu) == w);
        REQUIRE(to_bits(from_bits<left_right<std::int8_t>>(w)) == w);
        REQUIRE(to_bits(from_bits<left_right<std::uint8_t>>(w)) == w);
        REQUIRE(to_bits(from_bits<fixture::colour>(w)) == w);
        REQUIRE(to_bits(from_bits<zlac8015d::faults>(w)) == w);
    }
    for (const u32 v : {0u, 1u, 0x7FFF'FFFFu, 0x8000'0000u, 0xFFFF'FFFFu, 0x1234'5678u}) {
        CHECK(to_bits(from_bits<u32>(v)) == v);
        CHECK(to_bits(from_bits<i32>(v)) == v);
    }
    CHECK(from_bits<i16>(0xFFFF) == -1);
    CHECK(from_bits<i16>(0x8000) == -32'768);
    CHECK(from_bits<i32>(0xFFFF'FFFF) == -1);
}

TEST_CASE("G2: a word that is no value of an enumeration is not read as one of its values") {
    // 0108h in a register of names: its low byte alone would be "enable".
    CHECK(from_bits<zlac8015d::control_code>(0x0108) != zlac8015d::control_code::enable);
    CHECK(from_bits<zlac8015d::operating_mode>(0x0103) != zlac8015d::operating_mode::velocity);
    CHECK(from_bits<zlac8015d::brake>(0xFF00) != zlac8015d::brake::code_0);
    CHECK(from_bits<fixture::colour>(0x0102) == fixture::colour::infrared);
    enum class narrow : std::uint8_t { one = 1 };
    CHECK_FALSE(wire_value<narrow>);
}

TEST_CASE("G22: words are joined and split in either word order, and back") {
    for (const u32 v : {0u, 1u, 0xFFFFu, 0x1'0000u, 0x1234'5678u, 0x8000'0000u, 0xFFFF'FFFFu}) {
        for (const word_order order : {word_order::high_first, word_order::low_first}) {
            const word_pair p = split_words(v, order);
            CHECK(join_words(p.first, p.second, order) == v);
            CHECK((order == word_order::high_first ? p.first : p.second) == v >> 16);
        }
    }
    static_assert(join_words(0x1234, 0x5678, word_order::high_first) == 0x1234'5678);
    static_assert(join_words(0x5678, 0x1234, word_order::low_first) == 0x1234'5678);
    static_assert(split_words(0x1234'5678, word_order::low_first) == word_pair{0x5678, 0x1234});
}

namespace {
struct switched_device {
    static constexpr profile facts{.name = "switched", .word_order = word_order::unknown};
};
constexpr reg<i32, access::ro, switched_device> turns{0x0010, full<i32>, no_unit, no_default};
constexpr reg<u16, access::ro, switched_device> state{0x0012, full<u16>, no_unit, no_default};
} // namespace

TEST_CASE("a reading is found by its row, wherever it is in the requests") {
    readings<fixture::position, fixture::speed, fixture::current, fixture::wide> v;
    const std::array<u16, 6> words{0xFF38, 155, 0xFFFF, 0xFFFE, 0x1234, 0x5678}; // in address order
    REQUIRE(v.words().size() == 6);
    for (std::size_t i = 0; i < 6; ++i) v.words()[i] = words[i];
    CHECK(v.get<fixture::speed>().count() == -200);
    CHECK(v.get<fixture::current>().count() == 155);
    CHECK(get<fixture::position>(v).count() == -2);
    CHECK(get<fixture::wide>(v) == 0x1234'5678);
    v.set_word_order(word_order::low_first); // the device's word order is fixed
    CHECK(get<fixture::wide>(v) == 0x1234'5678);
    static_assert(has_fixed_word_order<fixture::device> && !has_fixed_word_order<switched_device>);
    for (const bool is_low : {false, true}) {
        readings<turns, state> w{is_low ? word_order::low_first : word_order::high_first};
        w.words()[0] = is_low ? 0xFFFE : 0xFFFF;
        w.words()[1] = is_low ? 0xFFFF : 0xFFFE;
        w.words()[2] = 7;
        CHECK(get<turns>(w) == -2);
        CHECK(get<state>(w) == 7);
    }
}

TEST_CASE("flags are distinct, and combine") {
    const flag all[] = {
        saved,         saved_on_write, when_stopped, trigger, scaled_elsewhere, after_power_cycle,
        communication, motion};
    for (const flag one : all) {
        CHECK_FALSE(has(flag::none, one));
        for (const flag other : all) CHECK(has(one, other) == (one == other));
        CHECK(has(saved | one, one));
    }
}

TEST_CASE("the catalogue finds a register by each of its words, and nothing where there is none") {
    const auto& map = zlac8015d::catalogue;
    std::size_t found = 0;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const entry* expected = nullptr;
        for (const entry& e : map.entries) {
            if (address >= e.address && address < e.address + e.words()) expected = &e;
        }
        REQUIRE(map.find(static_cast<u16>(address)) == expected);
        found += expected != nullptr;
    }
    CHECK(found == 120);
    CHECK(std::string{map.find(0x208B)->name} == "left_target_position");
    CHECK(catalogue{map.device, {}}.find(0x2000) == nullptr);
}

TEST_CASE("a catalogue's entry converts raw bits into their number") {
    const auto entry_of = [](value_kind kind) {
        entry e{};
        e.kind = kind;
        return e;
    };
    CHECK(entry_of(value_kind::unsigned_word).number(0xFFFF) == 0xFFFF);
    CHECK(entry_of(value_kind::signed_word).number(0xFFFF) == -1);
    CHECK(entry_of(value_kind::unsigned_pair).number(0xFFFF'FFFF) == 0xFFFF'FFFF);
    CHECK(entry_of(value_kind::signed_pair).number(0xFFFF'FFFF) == -1);
}

TEST_CASE("is_in_order detects whether the entries of a catalogue are sorted and do not overlap") {
    entry a{};
    a.address = 5;
    a.kind = value_kind::signed_pair;
    entry b{};
    b.address = 7;
    CHECK(is_in_order(std::array<entry, 2>{a, b}));
    CHECK_FALSE(is_in_order(std::array<entry, 2>{b, a}));
    b.address = 6;
    CHECK_FALSE(is_in_order(std::array<entry, 2>{a, b}));
}

TEST_CASE("an exception number has the device's words, or is an unknown exception") {
    CHECK(std::string{zlac8015d::device::facts.meaning(2)} == "illegal data address");
    CHECK(std::string{zlac8015d::device::facts.meaning(0)} == "unknown exception");
    CHECK(std::string{zlac8015d::device::facts.meaning(200)} == "unknown exception");
}

TEST_CASE("G32: sums and differences of quantities end at the range of their number, without overflow") {
    using namespace servobus;
    using tenths = quantity<units::r_per_min / 10, std::int16_t>;
    CHECK((tenths{30'000} + tenths{30'000}).count() == 32'767);
    CHECK((tenths{-30'000} - tenths{30'000}).count() == -32'768);
    CHECK((-tenths{-32'768}).count() == 32'767);
    using pulses = quantity<units::pulse, std::int32_t>;
    CHECK((pulses{2'147'483'647} + pulses{1}).count() == 2'147'483'647);
    CHECK((-pulses{-2'147'483'647 - 1}).count() == 2'147'483'647);
    CHECK((pulses{5} - pulses{7}).count() == -2);
    using wide = quantity<units::pulse, std::int64_t>;
    constexpr std::int64_t most = 0x7FFF'FFFF'FFFF'FFFF;
    CHECK((wide{most} + wide{1}).count() == most);
    CHECK((wide{-most} - wide{5}).count() == -most - 1);
    CHECK((-wide{-most - 1}).count() == most);
    CHECK((wide{0} - wide{-most - 1}).count() == most);
}

TEST_CASE("G32: a quantity of 64 bits in a finer unit ends at the range of its number") {
    using wide_seconds = quantity<units::second, std::int64_t>;
    using wide_milliseconds = quantity<units::millisecond, std::int64_t>;
    constexpr std::int64_t most = 0x7FFF'FFFF'FFFF'FFFF;
    CHECK(wide_milliseconds{wide_seconds{5}}.count() == 5000);
    CHECK(wide_milliseconds{wide_seconds{-5}}.count() == -5000);
    CHECK(wide_milliseconds{wide_seconds{most}}.count() == most);
    CHECK(wide_milliseconds{wide_seconds{-most - 1}}.count() == -most - 1);
    CHECK(wide_seconds{most} > wide_milliseconds{most - 1});
    CHECK(wide_seconds{-most - 1} < wide_milliseconds{-most});
    CHECK((wide_seconds{-most} + wide_seconds{-5}).count() == -most - 1);
    CHECK((wide_seconds{-5} + wide_seconds{-2}).count() == -7);
    CHECK((wide_seconds{5} + wide_seconds{-2}).count() == 3);
    CHECK((wide_seconds{5} + wide_seconds{0}).count() == 5);
}

TEST_CASE("every measure has its own symbol, and only measures of one kind are converted") {
    const auto measure_at = [](unsigned i) { return static_cast<measure>(i); };
    constexpr unsigned count = static_cast<unsigned>(measure::cubic_metre_per_hour) + 1;
    const std::array<const char*, count> symbols{
        "",       "r/min",  "s",     "ms",  "ns",    "A",    "mA",   "mA/s",  "V",     "mV",      "ohm",
        "W",      "kHz",    "Hz",    "%",   "times", "degC", "deg",  "r",     "pulse", "pulse/r", "ref_unit",
        "counts", "us",     "um",    "mm",  "m",     "um/s", "mm/s", "m/s",   "urad",  "mrad",    "rad",
        "urad/s", "mrad/s", "rad/s", "min", "h",     "kW",   "VA",   "var",   "Wh",    "kWh",     "varh",
        "kg",     "N",      "Nm",    "Pa",  "bar",   "l",    "m3",   "l/min", "m3/h"};
    const auto kind = [](measure m) { // the first of its kind
        switch (m) {
        case measure::millisecond:
        case measure::microsecond:
        case measure::nanosecond:
        case measure::minute:
        case measure::hour: return measure::second;
        case measure::milliampere: return measure::ampere;
        case measure::millivolt: return measure::volt;
        case measure::hertz: return measure::kilohertz;
        case measure::revolution: return measure::degree;
        case measure::metre:
        case measure::millimetre: return measure::micrometre;
        case measure::metre_per_second:
        case measure::millimetre_per_second: return measure::micrometre_per_second;
        case measure::radian:
        case measure::milliradian: return measure::microradian;
        case measure::radian_per_second:
        case measure::milliradian_per_second: return measure::microradian_per_second;
        case measure::kilowatt: return measure::watt;
        case measure::kilowatt_hour: return measure::watt_hour;
        case measure::bar: return measure::pascals;
        case measure::cubic_metre: return measure::litre;
        default: return m;
        }
    };
    for (unsigned i = 0; i < count; ++i) {
        CHECK(std::string{symbol(measure_at(i))} == symbols[i]);
        for (unsigned k = 0; k < count; ++k) {
            const unit from{measure_at(i)};
            const unit to{measure_at(k)};
            CHECK(servobus::detail::same_kind(from, to) == (kind(from.of) == kind(to.of)));
            const auto there = servobus::detail::conversion(from, to);
            const auto back = servobus::detail::conversion(to, from);
            CHECK(there.numerator == back.denominator);
            CHECK(there.denominator == back.numerator);
        }
    }
    CHECK(std::string{symbol(measure_at(count))}.empty()); // outside the enumeration
    const auto worth = [](unit from, unit to, std::int64_t numerator, std::int64_t denominator) {
        const auto r = servobus::detail::conversion(from, to);
        return r.numerator == numerator && r.denominator == denominator;
    };
    CHECK(worth(units::second, units::millisecond, 1000, 1));
    CHECK(worth(units::millisecond, units::nanosecond, 1'000'000, 1));
    CHECK(worth(units::nanosecond, units::second, 1, 1'000'000'000));
    CHECK(worth(units::ampere / 10, units::milliampere, 100, 1));
    CHECK(worth(units::millivolt, units::volt / 100, 1, 10));
    CHECK(worth(units::kilohertz, units::hertz, 1000, 1));
    CHECK(worth(units::hour, units::minute, 60, 1));
    CHECK(worth(units::minute, units::millisecond, 60'000, 1));
    CHECK(worth(units::nanosecond, units::hour, 1, 3'600'000'000'000));
    CHECK(worth(units::kilowatt / 10, units::watt, 100, 1));
    CHECK(worth(units::kilowatt_hour / 100, units::watt_hour, 10, 1));
    CHECK(worth(units::bar / 1000, units::pascals, 100, 1));
    CHECK(worth(units::cubic_metre, units::litre, 1000, 1));
    CHECK(worth(multiple<10>(units::millisecond), units::second / 50, 1, 2));
    CHECK(worth(units::revolution, units::degree, 360, 1));
    CHECK(worth(units::degree / 10, units::revolution, 1, 3600));
    CHECK(worth(units::metre, units::micrometre, 1'000'000, 1));
    CHECK(worth(units::millimetre, units::metre, 1, 1000));
    CHECK(worth(units::metre_per_second, units::millimetre_per_second, 1000, 1));
    CHECK(worth(units::microradian, units::milliradian, 1, 1000));
    CHECK(worth(units::radian_per_second, units::microradian_per_second, 1'000'000, 1));
    CHECK(worth(units::microsecond, units::nanosecond, 1000, 1));
}

TEST_CASE("a unit can be multiplied and divided, and differs if any of its parts does") {
    const unit tenth = units::ampere / 10;
    CHECK(tenth == unit{measure::ampere, 1, 10});
    CHECK(25u * tenth == unit{measure::ampere, 25, 10});
    CHECK(tenth / 10u == unit{measure::ampere, 1, 100});
    const unit millisecond = units::millisecond;
    const unit ten_milliseconds = multiple<10>(units::millisecond);
    CHECK(ten_milliseconds == 10u * millisecond);
    CHECK_FALSE(tenth.is_plain());
    CHECK((10u * tenth).is_plain());
    CHECK_FALSE(tenth == unit{measure::volt, 1, 10});
    CHECK_FALSE(tenth == unit{measure::ampere, 3, 10});
    CHECK_FALSE(tenth == unit{measure::ampere, 1, 100});
    CHECK(5 * units::pulse == 5 * units::pulse);
    CHECK_FALSE(5 * units::pulse == 6 * units::pulse);
}

TEST_CASE("ranges, word pairs and halves are equal if all their parts are") {
    CHECK(range{-1, 5} == range{-1, 5});
    CHECK_FALSE(range{-1, 5} == range{0, 5});
    CHECK_FALSE(range{-1, 5} == range{-1, 6});
    CHECK_FALSE(range{-1, 5} == range{-1, 5, false});
    CHECK(word_pair{1, 2} == word_pair{1, 2});
    CHECK_FALSE(word_pair{1, 2} == word_pair{3, 2});
    CHECK_FALSE(word_pair{1, 2} == word_pair{1, 3});
    using halves = left_right<std::int8_t>;
    CHECK(halves{-1, 2} == halves{-1, 2});
    CHECK_FALSE(halves{-1, 2} == halves{1, 2});
    CHECK_FALSE(halves{-1, 2} == halves{-1, -2});
}

TEST_CASE("a plan of any registers reads each of them once, in the fewest requests that the device allows") {
    using servobus::detail::planned;
    std::uint32_t seed = 1;
    const auto roll = [&seed](std::uint32_t sides) {
        seed = seed * 1664525u + 1013904223u;
        return (seed >> 16) % sides;
    };
    for (int round = 0; round < 2000; ++round) {
        CAPTURE(round);
        constexpr std::size_t count = 8;
        const auto most = static_cast<u16>(2 + roll(5));
        planned rows[count]{};
        u16 end = 0x0100;
        for (planned& row : rows) {
            row.address = static_cast<u16>(end + (roll(3) == 0 ? 1 + roll(3) : 0));
            row.words = static_cast<u16>(1 + roll(2));
            end = static_cast<u16>(row.address + row.words);
        }
        planned ordered[count];
        std::copy(std::begin(rows), std::end(rows), ordered);
        for (std::size_t i = count - 1; i > 0; --i) std::swap(rows[i], rows[roll(static_cast<u16>(i + 1))]);
        const auto plan = servobus::detail::plan_reads(rows, most);
        REQUIRE_FALSE(plan.overlaps);
        // A request continues as long as the next register is adjacent and fits.
        std::size_t requests = 0;
        u16 offset = 0;
        extent expected{};
        for (std::size_t i = 0; i < count; ++i) {
            const planned& row = ordered[i];
            REQUIRE(plan.rows[i].address == row.address);
            REQUIRE(plan.offset_of(row.address) == offset);
            offset = static_cast<u16>(offset + row.words);
            const bool joins = requests != 0 && row.address == expected.address + expected.words &&
                               expected.words + row.words <= most;
            if (joins) {
                expected.words = static_cast<u16>(expected.words + row.words);
            } else {
                expected = {row.address, row.words};
                ++requests;
            }
            REQUIRE(plan.requests[requests - 1].address == expected.address);
            REQUIRE(plan.requests[requests - 1].words >= expected.words);
        }
        REQUIRE(plan.requests[requests - 1].words == expected.words);
        REQUIRE(plan.count == requests);
        REQUIRE(plan.words == offset);
        REQUIRE(plan.offset_of(0x0050) == 0); // not in it
        std::array<extent, count> together{};
        for (std::size_t i = 0; i < count; ++i) together[i] = {ordered[i].address, ordered[i].words};
        const std::size_t in_a_row = [&] {
            std::size_t n = 1;
            while (n < count && ordered[n].address == ordered[n - 1].address + ordered[n - 1].words) ++n;
            return n;
        }();
        REQUIRE(servobus::detail::are_adjacent(together.data(), in_a_row));
        REQUIRE(servobus::detail::are_adjacent(together.data(), count) == (in_a_row == count));
        rows[3].address = rows[5].address; // twice the same
        REQUIRE(servobus::detail::plan_reads(rows, most).overlaps);
    }
}

TEST_CASE("a label made of a text that is too long keeps its beginning") {
    const std::string longest(label::longest, 'x');
    CHECK(std::string{label{longest.c_str()}} == longest);
    CHECK(std::string{label{(longest + "y").c_str()}} == longest);
    CHECK(std::string{label{std::string(5000, 'x').c_str()}} == longest);
    CHECK(std::string{label{"segment_", 12, "_speed"}} == "segment_12_speed");
    CHECK(std::string{label{longest.c_str(), 12, "y"}} == longest);
}

} // namespace registers_tests
