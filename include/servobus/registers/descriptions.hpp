// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Sentences about registers, for people. Each device has a table of them, device/*/descriptions.hpp, which only its
// catalogue includes.
//
//     constexpr description about[] = {{0x0003, "Opens the valve."}};
//     static_assert(sentence_of(about, 0x0003) == about[0].sentence);
//     static_assert(*sentence_of(about, 0x0004) == '\0');
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <servobus/registers/wire.hpp>

namespace servobus {

/// What a register does, in an English sentence of ASCII characters and at most 20 words, without quotes.
struct description {
    u16 address; ///< of a pair, its first word
    const char* sentence;
};

/// The sentence of the register at `address`; empty if `table`, which is in address order, has none.
constexpr const char* sentence_of(std::span<const description> table, u16 address) {
    std::size_t low = 0;
    std::size_t high = table.size();
    while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        if (table[middle].address == address) return table[middle].sentence;
        if (table[middle].address < address) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return "";
}

/// Joins two tables in address order to one.
template <std::size_t A, std::size_t B>
consteval std::array<description, A + B> joined(const description (&a)[A], const description (&b)[B]) {
    std::array<description, A + B> all{};
    std::size_t from_a = 0;
    std::size_t from_b = 0;
    for (description& next : all) {
        const bool is_of_a = from_b == B || (from_a < A && a[from_a].address < b[from_b].address);
        next = is_of_a ? a[from_a++] : b[from_b++];
    }
    return all;
}

} // namespace servobus
