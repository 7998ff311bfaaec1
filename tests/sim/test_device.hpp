// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device made for these tests: no live register ever has the value of another one or one of its own earlier
// values, so a late or misdirected response differs from the right one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>

namespace test_device {

struct device {
    static constexpr servobus::exception_meaning exceptions[] = {
        {1, "illegal function"}, {2, "illegal data address"}, {3, "illegal data value"}};
    static constexpr servobus::profile facts{
        .name = "test device", .word_order = servobus::word_order::unknown, .exceptions = exceptions};
};

template <servobus::wire_value T> using ro = servobus::reg<T, servobus::access::ro, device>;
template <servobus::wire_value T> using rw = servobus::reg<T, servobus::access::rw, device>;

using servobus::i32, servobus::u16, servobus::u32;

// clang-format off
/// 0x0000..0x017F are live: their values differ at each read. 0x0200..0x02FF keep what is written.
inline constexpr ro<u16> live_word  {0x0010, servobus::full<u16>, servobus::no_unit, servobus::no_default};
inline constexpr ro<u32> live_pair  {0x0020, servobus::full<u32>, servobus::no_unit, servobus::no_default};
inline constexpr ro<u16> other_word {0x0022, servobus::full<u16>, servobus::no_unit, servobus::no_default};
inline constexpr rw<u16> kept_word  {0x0200, servobus::full<u16>, servobus::no_unit, 0};
inline constexpr rw<u32> kept_pair  {0x0210, servobus::full<u32>, servobus::no_unit, 0};
inline constexpr rw<u16> all_hear   {0x0220, servobus::full<u16>, servobus::no_unit, 0};

inline constexpr servobus::entry entries[] = {
    list("live_word", live_word), list("live_pair", live_pair), list("other_word", other_word),
    list("kept_word", kept_word), list("kept_pair", kept_pair), list("all_hear", all_hear),
};
// clang-format on

inline constexpr servobus::catalogue catalogue{&device::facts, entries};

inline constexpr std::uint16_t live_end = 0x0180;
inline constexpr std::uint16_t kept_begin = 0x0200;
inline constexpr std::uint16_t kept_end = 0x0300;
/// Register 0xE000 + n responds with exception n, 1..255.
inline constexpr std::uint16_t refusing = 0xE000;

/// The registers of a test device.
class registers {
  public:
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        if (const std::uint8_t refusal = refuse(address, to.size(), 0); refusal != 0) return refusal;
        ++reads_;
        for (std::size_t i = 0; i < to.size(); ++i) {
            const std::uint32_t at = address + static_cast<std::uint32_t>(i);
            to[i] = at < live_end ? static_cast<std::uint16_t>(at * 40503u + reads_ * 30011u)
                                  : kept_[at - kept_begin];
        }
        return 0;
    }
    std::uint8_t write(std::uint16_t address, servobus::words_view from) {
        if (const std::uint8_t refusal = refuse(address, from.size(), kept_begin); refusal != 0)
            return refusal;
        for (std::size_t i = 0; i < from.size(); ++i) kept_[address - kept_begin + i] = from[i];
        return 0;
    }
    void power_cycle() { kept_ = {}; }

  private:
    static std::uint8_t refuse(std::uint16_t address, std::size_t count, std::uint16_t lowest) {
        if (address > refusing && address <= refusing + 0xFF)
            return static_cast<std::uint8_t>(address & 0xFFu);
        const std::size_t end = address + count;
        const bool exists = address < kept_begin ? end <= live_end : end <= kept_end;
        return exists && address >= lowest ? 0 : 2;
    }

    std::array<std::uint16_t, kept_end - kept_begin> kept_{};
    std::uint32_t reads_ = 0;
};

} // namespace test_device
