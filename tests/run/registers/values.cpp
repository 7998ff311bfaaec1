// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The encodings of values, over all words of one register, and their entries in a catalogue.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

#include <servobus/any_value.hpp>
#include <servobus/registers/row_value.hpp>
#include <servobus/registers/value_forms.hpp>

#include <tests/support/every_value.hpp>

namespace value_format_tests {

using namespace servobus;
using namespace servobus::units;
namespace every_value = tests::every_value;
using device = every_value::device<word_order::high_first>;
using r = every_value::rows<device>;

namespace {
constexpr reg<with<u16, bits<3, 3>>, access::ro, device> one_bit{1, full<u16>, no_unit, no_default};
constexpr reg<with<u16, bits<0, 15>>, access::ro, device> all_bits{1, full<u16>, no_unit, no_default};
constexpr reg<with<i16, bits<2, 6>>, access::ro, device> signed_part{1, full<i16>, no_unit, no_default};
constexpr reg<with<i16, offset<1000>>, access::rw, device> shifted{2, full<i16>, no_unit, no_default};
constexpr reg<with<bcd<1>, bits<8, 14>>, access::ro, device> seconds{3, full<bcd<1>>, no_unit, no_default};
constexpr reg<with<u16, or_none<0xFFFF, 0x8000>>, access::rw, device> two_codes{4, full<u16>, no_unit,
                                                                                no_default};
constexpr reg<with<i16, or_none<-0x8000>>, access::rw, device> one_code{5, full<i16>, ampere, no_default};
constexpr reg<with<u64, or_none<-1>>, access::ro, device> wide_code{6, full<u64>, no_unit, no_default};
} // namespace

TEST_CASE("each word of one register is the number that its encoding states") {
    for (unsigned raw = 0; raw < 0x1'0000; ++raw) {
        CHECK(reading_of<one_bit>(raw) == raw / 8 % 2);
        CHECK(reading_of<all_bits>(raw) == raw);
        const int part = static_cast<int>(raw / 4 % 32);
        CHECK(reading_of<signed_part>(raw) == (part < 16 ? part : part - 32));
        const int number = raw < 0x8000 ? static_cast<int>(raw) : static_cast<int>(raw) - 0x1'0000;
        CHECK(reading_of<shifted>(raw) == number + 1000);
        const int magnitude = static_cast<int>(raw % 0x8000);
        CHECK(reading_of<r::torque>(raw).count() == (raw < 0x8000 ? magnitude : -magnitude));
        const unsigned tens = raw / 4096 % 8, ones = raw / 256 % 16;
        const auto second = reading_of<seconds>(raw);
        CHECK(second.has_value() == (ones < 10));
        if (second) CHECK(*second == 10 * tens + ones);
        const auto code = reading_of<two_codes>(raw);
        CHECK(code.has_value() == (raw != 0xFFFF && raw != 0x8000));
        if (code) CHECK(*code == raw);
        CHECK(reading_of<one_code>(raw).has_value() == (raw != 0x8000));
    }
    for (int wanted = 0; wanted < 10'000; ++wanted) {
        const register_value<r::hour> v = checked(wanted);
        REQUIRE(v.error() == errc::ok);
        CHECK(*reading_of<r::hour>(static_cast<u32>(v.bits())) == wanted);
    }
}

namespace {
// The entry of a row, decoded at run time, against the row's type, decoded by the compiler's choice.
template <const auto& R> void compare_with_entry(unsigned raw, bool has_value, std::int64_t count) {
    const entry row = list("row", R);
    const row_value found = value_of(row, bits_of_words(row, std::array<unsigned, 1>{raw}));
    CAPTURE(raw);
    CHECK((found.is == row_value::state::number) == has_value);
    if (!has_value) return;
    CHECK(found.count() == count);
    const number_bits back = bits_of_number(row, count);
    CHECK(back.fits);
    CHECK(value_of(row, back.bits).count() == count);
}
} // namespace

TEST_CASE("an entry decodes each word as the type of its row does") {
    for (unsigned raw = 0; raw < 0x1'0000; raw += 3) {
        const auto second = reading_of<seconds>(raw);
        compare_with_entry<seconds>(raw, second.has_value(), second ? *second : 0);
        const auto hour = reading_of<r::hour>(raw);
        compare_with_entry<r::hour>(raw, hour.has_value(), hour ? *hour : 0);
        const auto code = reading_of<two_codes>(raw);
        compare_with_entry<two_codes>(raw, code.has_value(), code ? *code : 0);
        compare_with_entry<signed_part>(raw, true, reading_of<signed_part>(raw));
        compare_with_entry<shifted>(raw, true, reading_of<shifted>(raw));
        compare_with_entry<r::torque>(raw, true, reading_of<r::torque>(raw).count());
    }
    const entry row = list("row", seconds);
    CHECK(bits_of_number(row, 79).fits);
    CHECK(!bits_of_number(row, 80).fits); // three bits of tens
}

TEST_CASE("what a row takes is what it reads") {
    for (int wanted = -33'000; wanted < 70'000; wanted += 7) {
        const register_value<shifted> v = checked(wanted);
        CHECK((v.error() == errc::ok) == (wanted >= -0x8000 + 1000 && wanted <= 0x7FFF + 1000));
        if (v.error() == errc::ok) CHECK(reading_of<shifted>(static_cast<u32>(v.bits())) == wanted);
        const register_value<r::torque> t = checked(wanted * percent);
        CHECK((t.error() == errc::ok) == (wanted >= -0x7FFF && wanted <= 0x7FFF));
        if (t.error() == errc::ok) CHECK(reading_of<r::torque>(static_cast<u32>(t.bits())).count() == wanted);
    }
    // What means "no value" is not written as one.
    CHECK(register_value<two_codes>{checked(0xFFFF)}.error() == errc::out_of_range);
    CHECK(register_value<two_codes>{checked(0x8000)}.error() == errc::out_of_range);
    CHECK(register_value<two_codes>{checked(0x7FFF)}.error() == errc::ok);
    CHECK(register_value<one_code>{checked(-0x8000 * ampere)}.error() == errc::out_of_range);
}

TEST_CASE("64 bits have both ends") {
    constexpr auto most = std::numeric_limits<std::uint64_t>::max();
    constexpr auto high = std::numeric_limits<std::int64_t>::max();
    constexpr auto low = std::numeric_limits<std::int64_t>::min();
    CHECK(register_value<r::serial_code>{checked(most)}.bits() == most);
    CHECK(register_value<r::serial_code>{checked(std::uint64_t{high} + 1)}.bits() == std::uint64_t{high} + 1);
    CHECK(register_value<r::serial_code>{checked(low)}.error() == errc::out_of_range);
    CHECK(register_value<r::balance>{checked(raw(low))}.bits() == std::uint64_t{1} << 63);
    CHECK(register_value<r::balance>{checked(raw(high))}.bits() == std::uint64_t{high});
    CHECK(register_value<r::balance>{clamped(raw(most))}.bits() == std::uint64_t{high});
    CHECK(register_value<r::balance>{checked(raw(most))}.error() == errc::out_of_range);
    CHECK(register_value<r::energy>{checked(raw(most))}.bits() == most);
    CHECK(register_value<r::energy>{clamped(raw(most))}.bits() == most);
    CHECK(register_value<r::energy>{checked(quantity<unit{measure::watt_hour}, u64>{most})}.bits() == most);
    CHECK(register_value<r::balance>{checked(quantity<unit{measure::watt_hour}, u64>{most})}.error() ==
          errc::out_of_range);
    // A product beyond 64 bits is no value that was asked for.
    CHECK(register_value<r::energy>{checked(high / 500 * kilowatt_hour)}.error() == errc::out_of_range);
    CHECK(register_value<r::balance>{checked(low / 500 * kilowatt_hour)}.error() == errc::out_of_range);
    CHECK(register_value<r::energy>{checked(high / 1000 * kilowatt_hour)}.error() == errc::ok);
    CHECK(detail::codec<with<u64, or_none<-1>>>::value_of<wide_code>(most).has_value() == false);
    CHECK(*detail::codec<with<u64, or_none<-1>>>::value_of<wide_code>(most - 1) == most - 1);
    CHECK(detail::limited_product(high, 2) == high);
    CHECK(detail::limited_product(low, 2) == low);
    CHECK(detail::limited_product(low, -1) == high);
    CHECK(detail::limited_product(0x7FFF'FFFF'FFFF'FFFF, -1) == -high);
    CHECK(detail::limited_product(4'294'967'295, 4'294'967'295) == high);
    CHECK(detail::limited_product(-3'000'000'000, 3'000'000'000) == -9'000'000'000'000'000'000);
}

TEST_CASE("an entry of a catalogue has the kind and the form of its row") {
    const entry power = list("power", r::power);
    CHECK(power.kind == value_kind::signed_word);
    REQUIRE(power.form != nullptr);
    CHECK(power.form->none.size() == 1);
    CHECK(power.form->none[0] == -0x8000);
    CHECK(power.form->scaled == scaling::exponent);
    CHECK(power.form->scale_address == r::exponent.address);
    CHECK(power.form->scale_table == table::holding_registers);
    CHECK(list("primary", r::primary).form->scaled == scaling::factor);
    CHECK(list("voltage", r::voltage).kind == value_kind::float_pair);
    CHECK(list("voltage", r::voltage).form == nullptr);
    CHECK(list("name", r::name).words() == 4);
    CHECK(list("name", r::name).kind == value_kind::text);
    CHECK(list("level", r::level).form->mask() == 0xFFF0);
    CHECK(list("model", r::model).form->is_low_byte_first);
    CHECK(list("battery", r::battery).form->offset == -1000);
    CHECK(list("low", r::low_word).own_word_order == word_order::low_first);
    CHECK(list("energy", r::energy).kind == value_kind::unsigned_quad);
    CHECK(list("date", r::date).kind == value_kind::bcd_pair);
    CHECK(list("current", r::current).kind == value_kind::sign_magnitude_pair);
    CHECK(list("phase", r::now).kind == value_kind::unsigned_pair);
    const entry parts[] = {list("selector", r::selector), list("level", r::level), list("inside", r::inside)};
    CHECK(is_in_order(parts));
    const entry overlapping[] = {list("selector", r::selector), list("selector", r::selector)};
    CHECK(!is_in_order(overlapping));
}

} // namespace value_format_tests
