// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which rows a client takes for which call. What breaks a rule does not compile, and the error names the rule.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/detail/row_checks.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/read_write.hpp>
#include <servobus/registers/tables.hpp>

namespace servobus::detail {

/// True if the register, or the first or second word of it, has the address `setting`; 0: the device has no such
/// setting.
template <const auto& R> constexpr bool covers(u16 setting) {
    return setting != 0 && static_cast<u16>(setting - R.address) < row_type<R>::words;
}
/// True for a register that a client writes only by `write`, since what it has learned of its node depends on it.
template <class Device, const auto& R>
inline constexpr bool
    is_setting = has(R.flags, flag::communication) || covers<R>(Device::facts.word_order_register) ||
                 covers<R>(Device::facts.eeprom_switch);

/// `Wears`: the device may keep the write in its EEPROM.
template <class Device, bool Wears, const auto&... Rs> constexpr void check_coils() {
    check_device<Device, Rs...>();
    static_assert(Wears || !(has(Rs.flags, flag::saved_on_write) || ...),
                  "every write of this coil wears the device's EEPROM: store() it");
    static_assert(!(has(Rs.flags, flag::communication) || ...),
                  "a coil that changes a setting of the line is written by transact()");
}

/// The one frame that writes the coils `Rs`.
template <class Device, const auto&... Rs> struct coils_plan {
    static constexpr bool are_bits = (is_bit<Rs> && ...);
    static_assert(are_bits, "a write has rows of one table");
    static constexpr extent rows[]{{Rs.address, 1}...};
    static constexpr u16 count = sizeof...(Rs);
    static_assert(!are_bits || are_adjacent(rows, count),
                  "a write of several coils is one frame: they must be adjacent and in address order");
    static_assert(sizeof...(Rs) <= modbus::max_write_bits, "a frame has room for 1968 coils");
    static constexpr std::size_t room = 9 + modbus::bytes_of_bits(count);

    /// Stores the bits behind the head of the frame.
    static constexpr void put(std::uint8_t* frame, const register_value<Rs>&... values) {
        for (std::size_t i = 7; i < room; ++i) frame[i] = 0;
        std::size_t i = 0;
        const auto put_one = [&](bool is_on) {
            frame[7 + i / 8] = static_cast<std::uint8_t>(frame[7 + i / 8] | (is_on ? 1u : 0u) << i % 8);
            ++i;
        };
        (put_one(values.bits() != 0), ...);
    }
};

/// The bits of a register that row `R` is a part of.
template <const auto& R> constexpr u16 part_mask() {
    using T = typename row_type<R>::value_type;
    if constexpr (is_part<T>)
        return static_cast<u16>(codec<T>::mask << codec<T>::options.first_bit);
    else
        return 0; // refused by `check_part`
}
template <class Device, const auto& R> constexpr void check_changed() {
    check_device<Device, R>();
    check_wear<R>();
    static_assert(table_of<R> == table::holding_registers && row_type<R>::rights == access::rw,
                  "function 16h changes holding registers that can be read and written");
    static_assert(!is_setting<Device, R>,
                  "a setting of the line, of the word order or of the memory is written "
                  "by write()");
}
template <class Device, const auto& R> constexpr void check_part() {
    static_assert(
        is_part<typename row_type<R>::value_type>,
        "change_bits<R>(value) is for a part of a register: name the bits, change_bits<R, mask>(value)");
    check_changed<Device, R>();
}
template <class Device, const auto& R, u16 Mask> constexpr void check_mask() {
    using row = row_type<R>;
    check_changed<Device, R>();
    static_assert(!is_part<typename row::value_type>,
                  "a part of a register is changed by change_bits<R>(value)");
    static_assert(row::words == 1 && R.limits.low <= shape_of<typename row::value_type>.low &&
                      R.limits.high >= shape_of<typename row::value_type>.high &&
                      !has(R.flags, flag::zero_by_name),
                  "function 16h could take this register out of its range");
    static_assert(Mask != 0, "a change of no bit");
}

/// The adjacent registers of a function 17h.
struct both_extents {
    extent read;
    extent written;
};

/// The one transaction of function 17h that writes `Ws` and then reads `Reads`, which is `rows<Rs...>`.
template <class Device, class Reads, const auto&... Ws> struct both_plan {
    static_assert(sizeof(Reads) == 0, "what is read is rows<...>");
};
template <const auto&... Rs> constexpr u16 words_read() {
    return static_cast<u16>((row_type<Rs>::words + ... + 0)); // all adjacent
}
template <class Device, const auto&... Rs, const auto&... Ws> struct both_plan<Device, rows<Rs...>, Ws...> {
    static constexpr bool are_holding = ((table_of<Ws> == table::holding_registers) && ...) &&
                                        ((table_of<Rs> == table::holding_registers) && ...);
    static_assert(readings<Rs...>::is_one_frame, "function 17h reads adjacent registers");
    static constexpr u16 words_written = write_plan<Ws...>::words;
    static_assert(words_written <= modbus::max_write_of_read_write,
                  "function 17h writes at most 121 registers");

    using values = readings<Rs...>;
    static constexpr extent read{values::plan.requests[0].address, words_read<Rs...>()};
    static constexpr both_extents extents{read, {write_plan<Ws...>::rows[0].address, words_written}};
    static constexpr bool has_pairs = values::has_pairs || (needs_word_order<Ws>() || ...);
    static constexpr std::size_t request = 13 + 2 * words_written;
    static constexpr std::size_t response = 5 + 2 * std::size_t{read.words};
    static constexpr std::size_t room = request < response ? response : request;
    /// True if an echo of the request has the length and the byte count of its response.
    static constexpr bool has_echo_like_response = request == response && read.address >> 8 == 2 * read.words;

    static constexpr void check() {
        check_device<Device, Rs...>();
        check_device<Device, Ws...>();
        (check_wear<Ws>(), ...);
    }
    /// Takes the data of a response.
    static constexpr void take(result<values>& to, bytes data, word_order order) {
        if constexpr (requires { to->words(); })
            words_view{data}.copy_to(to->words());
        else
            (void)to->take(0, data); // registers: no bit is wrong
        to->set_word_order(order);
    }
    /// Stores the words to write behind the head of the request. Returns the first error of the values.
    static constexpr errc put(std::uint8_t* frame, word_order order, const register_value<Ws>&... values) {
        errc wrong = errc::ok;
        std::size_t at = 11;
        const auto put_one = [&](const auto& value, std::size_t words) {
            if (value.error() != errc::ok && wrong == errc::ok) wrong = value.error();
            const byte_buffer to{frame, request};
            if constexpr (stores_words<decltype(value)>) {
                check_whole<std::remove_cvref_t<decltype(value)>>();
                value.store(to, at, order);
            } else if (words == 2) {
                const word_pair pair = split_words(value.bits(), order);
                store_word(to, at, pair.first);
                store_word(to, at + 2, pair.second);
            } else {
                store_word(to, at, static_cast<u16>(value.bits()));
            }
            at += 2 * words;
        };
        (put_one(values, row_type<Ws>::words), ...);
        return wrong;
    }

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(are_holding, "function 17h is for holding registers");
    static_assert(!(is_setting<Device, Ws> || ...),
                  "a setting of the line, of the word order or of the memory is written by write()");
};

} // namespace servobus::detail
