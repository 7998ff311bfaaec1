// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The usual engines of the CRC: bit by bit, and with tables of 32 bytes, 512 bytes and 4 KB. Programs include
// it to choose one of them for a blocking_line or for frames in place of `default_crc`.
//
//     constexpr unsigned char body[]{0x01, 0x06, 0x20, 0x0E, 0x00, 0x08};
//     static_assert(modbus::crc16<modbus::crc_table256>(body) == 0x0FE2);
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/modbus/crc16.hpp>

namespace servobus::modbus {

namespace detail {

/// An engine that processes one byte at a time; `Step::next` computes the next CRC from the current one.
template <class Step> struct crc_by_bytes {
    struct state {
        std::uint16_t crc;
    };
    static constexpr state begin() noexcept { return {0xFFFF}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept { return {Step::next(s.crc, byte)}; }
    static constexpr state update(state s, slice<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept { return s.crc; }
};

constexpr std::uint16_t crc_shifted(std::uint16_t crc, int bits) noexcept {
    for (; bits != 0; --bits) crc = static_cast<std::uint16_t>((crc >> 1) ^ ((crc & 1U) != 0 ? 0xA001U : 0U));
    return crc;
}

/// Row n holds, for each index, the CRC register after the bits of the index and n more bytes have been
/// shifted out.
template <std::size_t Rows, std::size_t Columns> struct crc_rows { std::uint16_t at[Rows][Columns]; };
template <std::size_t Rows, std::size_t Columns>
inline constexpr auto crc_tables = [] {
    crc_rows<Rows, Columns> rows{};
    for (std::size_t i = 0; i != Columns; ++i) {
        rows.at[0][i] = crc_shifted(static_cast<std::uint16_t>(i), std::countr_zero(Columns));
        for (std::size_t n = 1; n != Rows; ++n) rows.at[n][i] = crc_shifted(rows.at[n - 1][i], 8);
    }
    return rows;
}();

struct crc_bit_step {
    static constexpr std::uint16_t next(std::uint16_t crc, std::uint8_t byte) noexcept {
        return crc_shifted(static_cast<std::uint16_t>(crc ^ byte), 8);
    }
};

// Templates, so that the compiler computes only the tables that a program uses: computing one takes longer
// than compiling the rest of the library's core.
template <std::size_t Columns> struct crc_table_step {
    static constexpr std::uint16_t next(std::uint16_t crc, std::uint8_t byte) noexcept {
        constexpr int bits = std::countr_zero(Columns);
        const auto& table = crc_tables<1, Columns>.at[0];
        crc = static_cast<std::uint16_t>(crc ^ byte);
        for (int done = 0; done != 8; done += bits)
            crc = static_cast<std::uint16_t>((crc >> bits) ^ table[crc & (Columns - 1)]);
        return crc;
    }
};
// The base depends on a template parameter: clang would compute the table of a fixed base in every program.
template <std::size_t Rows, std::size_t Columns>
struct crc_by_slices : crc_by_bytes<crc_table_step<Columns>> {
    using base = crc_by_bytes<crc_table_step<Columns>>;
    using base::update;
    using state = typename base::state;
    static constexpr state update(state s, slice<const std::uint8_t> bytes) noexcept {
        const auto& t = crc_tables<Rows, Columns>.at;
        for (; bytes.size() >= Rows; bytes = bytes.subspan(Rows))
            s.crc = static_cast<std::uint16_t>(
                t[7][(s.crc ^ bytes[0]) & 0xFFU] ^ t[6][(s.crc >> 8) ^ bytes[1]] ^ t[5][bytes[2]] ^
                t[4][bytes[3]] ^ t[3][bytes[4]] ^ t[2][bytes[5]] ^ t[1][bytes[6]] ^ t[0][bytes[7]]);
        return base::update(s, bytes);
    }
};

} // namespace detail

/// The reference engine, bit by bit.
struct crc_bitwise : detail::crc_by_bytes<detail::crc_bit_step> {};
/// Two look-ups per byte, in a table of 32 bytes.
struct crc_table16 : detail::crc_by_bytes<detail::crc_table_step<16>> {};
/// One look-up per byte, in a table of 512 bytes.
struct crc_table256 : detail::crc_by_bytes<detail::crc_table_step<256>> {};

/// Eight independent look-ups for eight bytes, in tables of 4 KB: fast while the tables are in the CPU's
/// cache.
struct crc_slicing8 : detail::crc_by_slices<8, 256> {};

} // namespace servobus::modbus
