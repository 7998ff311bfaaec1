// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Registers of a device without a map: `coil:12`, `input:0x30:4`, `0x10:f32:lo`. Their table, the type of their values,
// and these values as people write them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/registers/tables.hpp>
#include <servobus/registers/wire.hpp>

namespace tool {

using servobus::u16;
using servobus::u32;

/// The type of a value in words without a map.
enum class raw_type : std::uint8_t {
    bit,  ///< a coil or a discrete input; a word of the tool's own has 0 or 1
    word, ///< no type was given: a number of 16 bits, to be written with a sign or without
    unsigned_word,
    signed_word,
    unsigned_pair,
    signed_pair,
    float_pair, ///< IEEE 754, single precision
};

/// The place and the type of values without a map.
struct raw_form {
    servobus::table table = servobus::table::holding_registers;
    raw_type type = raw_type::word;
    servobus::word_order order = servobus::word_order::high_first;
    bool has_table = false; ///< the command line names it

    bool is_bit() const { return type == raw_type::bit; }
    /// Words of a value.
    std::size_t width() const { return type >= raw_type::unsigned_pair ? 2 : 1; }
    bool is_writable() const {
        return table == servobus::table::coils || table == servobus::table::holding_registers;
    }
};

struct chosen;

/// `[TABLE:]ADDRESS[:COUNT][:TYPE][:hi|lo]`. Complains by itself.
std::optional<chosen> parse_raw_register(std::string_view text);
/// `VALUE[,VALUE...]` for them. Complains by itself if one does not fit its type.
std::optional<std::vector<u16>> parse_raw_values(const chosen& what, std::string_view text);

/// The number of values.
std::size_t raw_count(const chosen& what);
/// `0x2088`, `coil:0x000C`: the value at `index`.
std::string raw_name(const chosen& what, std::size_t index);
/// All of them: `0x2088:2`.
std::string raw_name(const chosen& what);
/// The value in `words` for people, `2400 (0x0960)` or `on`, and for programs: a number, `nan` for a float without a
/// finite value.
std::string raw_text(const raw_form& form, std::span<const u16> words);
std::string raw_number(const raw_form& form, std::span<const u16> words);

/// The tables as the command line names them, `coil:` and the others.
std::vector<std::string> raw_tables(bool writable_only);

} // namespace tool
