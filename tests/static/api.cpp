// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The constants and sizes on which programs may rely, and the properties of the library's types. Compiling
// this file checks them.
#include <array>
#include <cstdint>
#include <type_traits>

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/servobus.hpp>

namespace api_tests {

namespace {

using namespace servobus;

// The protocol.
static_assert(modbus::min_frame == 4 && modbus::max_frame == 256 && modbus::max_pdu == 253);
static_assert(modbus::max_read == 125 && modbus::max_write == 123);
static_assert(modbus::broadcast == 0);
static_assert(static_cast<int>(modbus::function::read_holding_registers) == 3);
static_assert(static_cast<int>(modbus::function::read_input_registers) == 4);
static_assert(static_cast<int>(modbus::function::write_single_register) == 6);
static_assert(static_cast<int>(modbus::function::write_multiple_registers) == 16);
static_assert(modbus::crc16(hex("31 32 33 34 35 36 37 38 39")) == 0x4B37);

// A fixed command is eight bytes of flash.
static_assert(sizeof(modbus::read_frame(1, 0, 1).data) == 8);
static_assert(sizeof(modbus::write_frame(1, 0, 1).data) == 8);

// Results are small, and none may be overlooked.
static_assert(sizeof(result<i16>) == 4);
static_assert(sizeof(status) == 4);
static_assert(sizeof(errc) == 1 && sizeof(outcome) == 1);
static_assert(status{}.outcome() == outcome::done);
static_assert(!std::is_convertible_v<status, bool> && std::is_constructible_v<bool, status>);
static_assert(!std::is_convertible_v<result<u16>, bool>);
static_assert(result<u16>{errc::timeout}.value_or(7) == 7);
static_assert(result<u16>{u16{5}}.value_or(7) == 5);
static_assert(result<u16>{status::sent(errc::exception, 9)}.exception() == 9);

// No type owns memory.
static_assert(std::is_trivially_destructible_v<modbus::exchange>);
static_assert(std::is_trivially_copyable_v<result<u16>> && std::is_trivially_copyable_v<status>);
static_assert(std::is_trivially_copyable_v<node<zlac8015d::device>>);
static_assert(std::is_trivially_destructible_v<modbus::frame<8>>);

// An exchange is moved, since the request of a copy would be sent again.
static_assert(!std::is_copy_constructible_v<modbus::exchange> &&
              !std::is_copy_assignable_v<modbus::exchange>);
static_assert(std::is_nothrow_move_constructible_v<modbus::exchange>);

// An exchange keeps references to its timing and limits, so temporaries are refused.
template <class Timing, class Limits>
constexpr bool makes_an_exchange =
    std::is_constructible_v<modbus::exchange, bytes, byte_buffer, Timing, Limits>;
static_assert(makes_an_exchange<const modbus::rtu_timing&, const response_limits&>);
static_assert(makes_an_exchange<modbus::rtu_timing&, response_limits&>);
static_assert(!makes_an_exchange<modbus::rtu_timing, const response_limits&>);
static_assert(!makes_an_exchange<const modbus::rtu_timing&, response_limits>);

// Integral types of the language that are no register values. Bytes are register values.
template <class... Types> constexpr bool are_refused = (detail::is_bool_or_character<Types> && ...);
template <class... Types> constexpr bool are_numbers = (!detail::is_bool_or_character<Types> && ...);
static_assert(are_refused<bool, char, wchar_t, char8_t, char16_t, char32_t>);
static_assert(are_refused<raw_value<bool>, raw_value<char>, raw_value<wchar_t>, raw_value<char8_t>>);
static_assert(are_numbers<signed char, unsigned char, short, unsigned short, int, unsigned, long,
                          unsigned long, long long, unsigned long long, raw_value<int>, errc>);
static_assert(register_value<zlac8015d::left_max_speed>{std::int8_t{65}}.bits() == 65);
static_assert(register_value<zlac8015d::left_max_speed>{checked(std::uint8_t{65})}.bits() == 65);
static_assert(register_value<zlac8015d::control_word>{zlac8015d::control_code::enable}.bits() == 8);

// Time wraps at 32 bits.
static_assert(since(instant{0xFFFF'FFF0}, instant{0x10}) == microseconds(0x20));
static_assert(since(instant{0x10}, instant{0x10}) == duration{});
static_assert(went_back(instant{5}, instant{4}) && !went_back(instant{4}, instant{5}));
static_assert(went_back(instant{0}, instant{0x8000'0000}) && !went_back(instant{0}, instant{0x7FFF'FFFF}));
static_assert(went_back(instant{0x10}, instant{0xFFFF'FFF0}) &&
              !went_back(instant{0xFFFF'FFF0}, instant{0x10}));
static_assert(milliseconds(5) == microseconds(5000));
static_assert(longer_of(milliseconds(5), milliseconds(6)) == milliseconds(6));

// Words in bytes.
constexpr std::array<std::uint8_t, 5> five{0x12, 0x34, 0xAB, 0xCD, 0xEF};
static_assert(load_word(five, 0) == 0x1234 && load_word(five, 1) == 0x34AB);
static_assert(words_view{five}.size() == 2 && words_view{five}[1] == 0xABCD);
static_assert(words_view{}.size() == 0);

// The default limits of a client.
static_assert(response_limits{}.leading_bytes == 4 && !response_limits{}.echoes_byte_count);
static_assert(profile{}.max_read == 125 && profile{}.max_write == 123 && profile{}.highest_address == 247);
static_assert(node<zlac8015d::device>{}.address == 1 && node<zlac8015d::device>{127}.is_valid() &&
              !node<zlac8015d::device>{128}.is_valid() && !node<zlac8015d::device>{0}.is_valid());

} // namespace

} // namespace api_tests
