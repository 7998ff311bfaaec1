// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device for tests of a server of rows: each table, each right, both widths, arrays that interleave, computed rows,
// the ends of the address space; and what the model of row_model.hpp is told of it.
#pragma once

#include <cstdint>

#include <servobus/server/computed.hpp>
#include <servobus/server/request_executor.hpp>
#include <servobus/server/row_values.hpp>

#include "row_model.hpp"

namespace served_rows {

using namespace servobus;
using rights = servobus::access; // <unistd.h> has a function of that name

struct device {
    static constexpr profile facts{
        .name = "rows", .max_read = 20, .max_write = 12, .word_order = word_order::low_first};
};

enum class gear : std::uint16_t { neutral, low, high };

template <class T, rights A> using row = reg<T, A, device>;

// clang-format off
inline constexpr row<gear, rights::rw> selected   {0x0010, {0, 2},            no_unit,          1};
inline constexpr row<u16,  rights::wo> command    {0x0011, {0, 9},            no_unit,          no_default};
inline constexpr row<i32,  rights::rw> travel     {0x0012, {-5, 100'000},     units::pulse,     -5};
inline constexpr row<u32,  rights::ro> ticks      {0x0014, full<u32>,         no_unit,          0};
inline constexpr row<u16,  rights::ro> level      {0x0016, {0, 1000},         units::percent / 10, 5};
inline constexpr reg_array<row<i16, rights::rw>, 3> lows  {{0x0017, {-100, 100}, units::pulse,  -100}, 2};
inline constexpr reg_array<row<u16, rights::rw>, 3> highs {{0x0018, {100, 200},  no_unit,       no_default}, 2};
inline constexpr reg_array<row<u32, rights::rw>, 2> pairs {{0x0040, full<u32>,   no_unit,       7}, 2};
inline constexpr row<u16,  rights::rw> last_word  {0xFFFF, full<u16>,         no_unit,          0};
inline constexpr row<i32,  rights::rw> last_pair  {0xFFFD, full<i32>,         no_unit,          -1};
inline constexpr input_reg<i32, device> pressure  {0x0010, full<i32>,         no_unit,          -70'000};
inline constexpr input_reg<u16, device> age       {0x0012, full<u16>,         units::second,    0};
inline constexpr coil<rights::rw, device> valve {0x0000, true}, pump {0x0001}, siren {0x0003}, last_coil {0xFFFF};
// Thirteen in a row: more than a byte.
inline constexpr coil<rights::rw, device> bit_0 {0x0020}, bit_1 {0x0021}, bit_2 {0x0022}, bit_3 {0x0023}, bit_4 {0x0024}, bit_5 {0x0025}, bit_6 {0x0026}, bit_7 {0x0027}, bit_8 {0x0028}, bit_9 {0x0029}, bit_10 {0x002A}, bit_11 {0x002B}, bit_12 {0x002C};
inline constexpr coil<rights::ro, device> is_primed {0x0002, true};
inline constexpr coil<rights::wo, device> reset {0x0004};
inline constexpr discrete_input<device> door {0x0007}, hatch {0x0008, true}, light {0x0009};
// clang-format on

inline unsigned computed_reads = 0; ///< how often a function was called
inline u32 count_ticks() {
    ++computed_reads;
    return 0x0001'0002;
}
inline quantity<unit{measure::second}, u16> count_seconds() {
    return quantity<unit{measure::second}, u16>{3};
}
inline bool is_on = true;
inline bool is_light() { return is_on; }

using values =
    row_values<valve, lows, pump, is_primed, siren, reset, last_coil, bit_0, bit_1, bit_2, bit_3, bit_4,
               bit_5, bit_6, bit_7, bit_8, bit_9, bit_10, bit_11, bit_12, door, hatch,
               computed<light, is_light>, highs, selected, command, travel, computed<ticks, count_ticks>,
               level, pairs, last_word, last_pair, pressure, computed<age, count_seconds>>;

inline constexpr identity about[]{{0x00, "Works"},
                                  {0x01, "R-1"},
                                  {0x02, "1.0"},
                                  {0x04, "Rows of a test"},
                                  {0x80, "first of its own"},
                                  {0x83, ""},
                                  {0xFF, "last of its own"}};
inline constexpr char id[] = "rows";

using executor = request_executor<values, with_mask_write, with_read_write, with_return_query_data,
                                  with_identification<about>, with_server_id<id>>;

inline row_model::device description() {
    row_model::device d;
    d.rows = {{'c', 0, 1, "rw", 0, 1, 1},
              {'c', 1, 1, "rw", 0, 1, 0},
              {'c', 2, 1, "r", 0, 1, 1},
              {'c', 3, 1, "rw", 0, 1, 0},
              {'c', 4, 1, "w", 0, 1, 0},
              {'c', 0xFFFF, 1, "rw", 0, 1, 0},
              {'d', 7, 1, "r", 0, 1, 0},
              {'d', 8, 1, "r", 0, 1, 1},
              {'d', 9, 1, "r", 0, 1, 1},
              {'h', 0x10, 1, "rw", 0, 2, 1},
              {'h', 0x11, 1, "w", 0, 9, 0},
              {'h', 0x12, 2, "rw", -5, 100'000, -5},
              {'h', 0x14, 2, "r", 0, 0xFFFF'FFFF, 0x0001'0002},
              {'h', 0x16, 1, "r", 0, 1000, 5},
              {'h', 0x17, 1, "rw", -100, 100, -100},
              {'h', 0x18, 1, "rw", 100, 200, 100},
              {'h', 0x19, 1, "rw", -100, 100, -100},
              {'h', 0x1A, 1, "rw", 100, 200, 100},
              {'h', 0x1B, 1, "rw", -100, 100, -100},
              {'h', 0x1C, 1, "rw", 100, 200, 100},
              {'h', 0x40, 2, "rw", 0, 0xFFFF'FFFF, 7},
              {'h', 0x42, 2, "rw", 0, 0xFFFF'FFFF, 7},
              {'h', 0xFFFD, 2, "rw", -0x8000'0000LL, 0x7FFF'FFFF, -1},
              {'h', 0xFFFF, 1, "rw", 0, 65535, 0},
              {'i', 0x10, 2, "r", -0x8000'0000LL, 0x7FFF'FFFF, -70'000},
              {'i', 0x12, 1, "r", 0, 65535, 3}};
    for (unsigned i = 0; i < 13; ++i) d.rows.push_back({'c', 0x20 + i, 1, "rw", 0, 1, 0});
    d.is_low_first = true;
    d.most_read = 20;
    d.most_written = 12;
    d.room = executor::buffer_size;
    d.functions = "mwl";
    d.objects = {{0, "Works"},
                 {1, "R-1"},
                 {2, "1.0"},
                 {4, "Rows of a test"},
                 {0x80, "first of its own"},
                 {0x83, ""},
                 {0xFF, "last of its own"}};
    d.id = "rows";
    return d;
}

} // namespace served_rows
