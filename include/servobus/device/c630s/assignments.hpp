// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: which terminals may not have one function. Two inputs with one function are Er.130, wired
// or virtual (chapter 8); two wired outputs with one function are a conflict (section 6.4.2), of which no
// alarm is documented. An assignment takes effect at the next stop, so a second one of the same function
// is an alarm as soon as the servo is off. `keep` and `set` compare before they write; raw access
// (`client::store`) does not, and `excludes` is for its users. c630s/prepared_command.hpp includes it. Source:
// manual V24.111, sections 6.4.1, 6.4.2, 7.3, 7.4 and 7.16; [errata Cn] are in device/errata_c630s.md.
//
//     using namespace c630s::literals;
//     static_assert(c630s::excludes("P03-02"_p, "P17-00"_p));  // DI1 and VDI1 may not have one function
//     static_assert(!c630s::excludes("P04-00"_p, "P17-33"_p)); // VDO1 may show what DO1 shows
#pragma once

#include <cstdint>

#include <servobus/device/c630s/registers.hpp>

namespace servobus::c630s {

/// Terminals of one kind, by the register of each one's function.
enum class terminal_kind : std::uint8_t {
    none,          ///< the register is no terminal's function
    input,         ///< DI1..8: P03-02, 04 .. 16
    virtual_input, ///< VDI1..16: P17-00, 02 .. 30
    output,        ///< DO1..6: P04-00, 02 .. 10
    virtual_output ///< VDO1..16: P17-33, 35 .. 63
};

/// The kind of terminal whose function the register at `address` holds.
constexpr terminal_kind terminal_kind_of(std::uint16_t address) {
    const unsigned first = di1_function.address;
    const unsigned place = address & 0xFFu;
    switch (address >> 8) {
    case 0x03:
        return address >= first && address <= di8_function.address && place % 2 == 0 ? terminal_kind::input
                                                                                     : terminal_kind::none;
    case 0x04:
        return address <= do6_function.address && place % 2 == 0 ? terminal_kind::output
                                                                 : terminal_kind::none;
    case 0x17:
        if (place < 32) return place % 2 == 0 ? terminal_kind::virtual_input : terminal_kind::none;
        return place % 2 == 1 && place <= 63 ? terminal_kind::virtual_output : terminal_kind::none;
    default: return terminal_kind::none;
    }
}

/// True if the terminals of these two registers may not have one function: any two inputs, wired or virtual,
/// and any two wired outputs. A virtual output may show what another output shows [errata C78]. The function
/// 0, none, is never in conflict.
constexpr bool excludes(std::uint16_t one, std::uint16_t other) {
    const auto is_input = [](std::uint16_t address) {
        const terminal_kind kind = terminal_kind_of(address);
        return kind == terminal_kind::input || kind == terminal_kind::virtual_input;
    };
    if (one == other) return false;
    if (is_input(one)) return is_input(other);
    return terminal_kind_of(one) == terminal_kind::output && terminal_kind_of(other) == terminal_kind::output;
}

namespace detail {

/// The terminals that may not have the function of the one at `assigned` are read by four adjacent registers
/// at a time: a function, its logic, the next function, its logic. Here the first ones begin.
constexpr std::uint16_t first_rivals(std::uint16_t assigned) {
    return terminal_kind_of(assigned) == terminal_kind::output ? do1_function.address : di1_function.address;
}
/// Where the ones after `block` begin; 0 if those were the last.
constexpr std::uint16_t next_rivals(std::uint16_t block) {
    if (block == di7_function.address) return virtual_input_functions.first.address;
    const bool is_last = block == "P17-28"_p || block == do5_function.address;
    return is_last ? std::uint16_t{0} : static_cast<std::uint16_t>(block + 4);
}

} // namespace detail
} // namespace servobus::c630s
