// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device's registers and its profile as text: CSV with a header line, and lines `# key = value` in front of it.
// `servobus map` prints it; device_file.hpp reads it back. It needs nothing else of the tool, so that a test can print
// the map of any catalogue.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <servobus/registers/catalogue.hpp>

namespace tool {

/// The columns of a map, in their order.
enum class map_column : std::uint8_t {
    address,
    name,
    words,
    type,
    access,
    saved,
    when,
    effective,
    modes,
    min,
    max,
    initial, ///< `default`
    scale,
    unit,
    description, ///< only in a long map
    flags,
    names,
    word_order,
    table,
    bits,
    offset,
    none,
    factor,
    byte_order,
};
inline constexpr std::string_view map_columns[] = {
    "address", "name",       "words", "type",    "access", "saved", "when",        "effective",
    "modes",   "min",        "max",   "default", "scale",  "unit",  "description", "flags",
    "names",   "word_order", "table", "bits",    "offset", "none",  "factor",      "byte_order"};

/// Ends a complaint about a word that a newer version of the form may have.
inline constexpr const char* later_version = "; a newer version of servobus may have written the file";

/// The words of the key `writes_blocks_only`, in the order of `block_writes`.
inline constexpr std::string_view names_of_block_writes[] = {"no", "registers", "coils", "yes"};

/// A word of the column `flags`.
struct flag_word {
    std::string_view word;
    servobus::flag of;
};
/// The flags that no other column shows.
inline constexpr flag_word flag_words[] = {
    {"saved_on_write", servobus::flag::saved_on_write},
    {"trigger", servobus::flag::trigger},
    {"motion", servobus::flag::motion},
    {"communication", servobus::flag::communication},
    {"scaled_elsewhere", servobus::flag::scaled_elsewhere},
    {"zero_by_name", servobus::flag::zero_by_name},
};

/// The version of the form of these files, `# file_format = 1`.
inline constexpr int map_format = 1;

/// A table as its rows have it, `coil` or `input`.
const char* table_text(servobus::table of);
constexpr bool is_of_bits(servobus::table t) { return t <= servobus::table::discrete_inputs; }
/// `u16`; `bool` for a bit.
const char* type_text(const servobus::entry& e, servobus::table t);

/// How a word order is written: `high`, `low`; `selectable` for `unknown`.
const char* word_order_text(servobus::word_order order);

/// Returns what one count is worth, without the symbol: `0.1`, `1/3`.
std::string scale_text(servobus::unit u);

/// The header line, without its end.
std::string map_header(bool is_long);
/// The name of the row that scales `e`, which is one of `rows`; null if none does, or it is not there.
const char* scaling_name(const servobus::entry& e, std::span<const servobus::entry> rows);
/// The line of a row, without its end. `sentence`: null if the map is not long. `scaled_by`: the name of the row that
/// scales it; null: its address.
std::string map_row(const servobus::entry& e, const servobus::profile& of, const char* sentence,
                    servobus::table in = servobus::table::holding_registers, const char* scaled_by = nullptr);
/// The profile, a line `# key = value` for each property.
std::string profile_lines(const servobus::profile& of);

} // namespace tool
