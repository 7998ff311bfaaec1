// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

namespace servobus::modbus {

/// A way to compute the CRC.
template <class Engine>
concept crc_engine = std::copyable<typename Engine::state> &&
                     requires(typename Engine::state s, std::span<const std::uint8_t> bytes, std::uint8_t byte) {
                         { Engine::begin() } noexcept -> std::same_as<typename Engine::state>;
                         { Engine::update(s, bytes) } noexcept -> std::same_as<typename Engine::state>;
                         { Engine::update(s, byte) } noexcept -> std::same_as<typename Engine::state>;
                         { Engine::end(s) } noexcept -> std::same_as<std::uint16_t>;
                     };

namespace detail {

/// What the engines that go byte by byte have in common: all but the step from one CRC to the `Next`.
template <std::uint16_t (*Next)(std::uint16_t, std::uint8_t) noexcept>
struct crc_by_bytes {
    struct state {
        std::uint16_t crc;
    };
    static constexpr state begin() noexcept { return {0xFFFF}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept { return {Next(s.crc, byte)}; }
    static constexpr state update(state s, std::span<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept { return s.crc; }
};

constexpr std::uint16_t crc_shifted(std::uint16_t crc, int bits) noexcept {
    for (; bits != 0; --bits) crc = static_cast<std::uint16_t>((crc >> 1) ^ ((crc & 1) != 0 ? 0xA001U : 0U));
    return crc;
}

/// Row `zeros` holds the CRC (from zero) of each index followed by that many zero bytes.
template <std::size_t Rows, std::size_t Columns>
constexpr auto crc_tables = [] {
    constexpr int bits = std::countr_zero(Columns);
    std::array<std::array<std::uint16_t, Columns>, Rows> rows{};
    for (std::size_t row = 0; row != Rows; ++row)
        for (std::size_t i = 0; i != Columns; ++i)
            rows[row][i] = row == 0 ? crc_shifted(static_cast<std::uint16_t>(i), bits) : crc_shifted(rows[row - 1][i], 8);
    return rows;
}();

constexpr std::uint16_t crc_next_bitwise(std::uint16_t crc, std::uint8_t byte) noexcept {
    return crc_shifted(static_cast<std::uint16_t>(crc ^ byte), 8);
}

constexpr std::uint16_t crc_next_table16(std::uint16_t crc, std::uint8_t byte) noexcept {
    const auto& table = crc_tables<1, 16>[0];
    crc = static_cast<std::uint16_t>(crc ^ byte);
    crc = static_cast<std::uint16_t>((crc >> 4) ^ table[crc & 0xF]);
    return static_cast<std::uint16_t>((crc >> 4) ^ table[crc & 0xF]);
}

constexpr std::uint16_t crc_next_table256(std::uint16_t crc, std::uint8_t byte) noexcept {
    return static_cast<std::uint16_t>((crc >> 8) ^ crc_tables<1, 256>[0][(crc ^ byte) & 0xFF]);
}

/// The CRC from its residue modulo T and any word with the parity of the message
constexpr std::uint16_t crc_joined(std::uint_fast16_t residue, std::uint_fast16_t parity) noexcept {
    if constexpr (sizeof(std::size_t) >= 8) { return static_cast<std::uint16_t>(residue ^ ((std::popcount(static_cast<std::uint16_t>(residue ^ parity)) & 1) != 0 ? 0xC001U : 0U)); }
    std::uint_fast16_t odd = residue ^ parity;
    odd ^= odd >> 8;
    odd ^= odd >> 4;
    odd = (std::uint_fast16_t{0x6996} >> (odd & 0xF)) & 1;
    return static_cast<std::uint16_t>(residue ^ (odd * 0xC001U));
}

/// Little-endian bytes as a word
template <std::unsigned_integral Word>
constexpr Word crc_load(const std::uint8_t* from) noexcept {
    return [from]<std::size_t... I>(std::index_sequence<I...>) {
        return static_cast<Word>((... | static_cast<Word>(static_cast<Word>(from[I]) << (8 * I))));
    }(std::make_index_sequence<sizeof(Word)>{});
}

} // namespace detail

struct crc_bitwise : detail::crc_by_bytes<detail::crc_next_bitwise> {};
struct crc_table16 : detail::crc_by_bytes<detail::crc_next_table16> {};
struct crc_table256 : detail::crc_by_bytes<detail::crc_next_table256> {};

struct crc_slicing8 : crc_table256 {
    using crc_table256::update;
    static constexpr state update(state s, std::span<const std::uint8_t> bytes) noexcept {
        const auto& table = detail::crc_tables<8, 256>;
        const std::uint8_t* p = bytes.data();
        std::size_t left = bytes.size();
        for (; left >= 8; left -= 8, p += 8)
            s.crc = static_cast<std::uint16_t>(table[7][(s.crc ^ p[0]) & 0xFF] ^ table[6][(s.crc >> 8) ^ p[1]] ^
                                               table[5][p[2]] ^ table[4][p[3]] ^ table[3][p[4]] ^ table[2][p[5]] ^
                                               table[1][p[6]] ^ table[0][p[7]]);
        for (; left != 0; --left) s = {detail::crc_next_table256(s.crc, *p++)};
        return s;
    }
};

template <unsigned Bits>
    requires(Bits == 8 || Bits == 16 || Bits == 32 || Bits == 64)
struct crc_trinomial {
    using word = std::conditional_t<Bits == 64, std::uint64_t, std::uint32_t>;
    static constexpr unsigned width = 8 * sizeof(word);
    struct state {
        word residue;
        word parity;
    };
    static constexpr state begin() noexcept { return {word{0xD556} << (width - 16), 0}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept { return step(s, byte); }
    static constexpr state update(state s, std::span<const std::uint8_t> bytes) noexcept {
        using unit = std::conditional_t<Bits == 16, std::uint16_t, word>;
        const std::uint8_t* p = bytes.data();
        std::size_t left = bytes.size();
        if constexpr (Bits == 64) {
            for (; left >= 8; left -= 8, p += 8) s = step(s, detail::crc_load<unit>(p));
            if ((left & 4) != 0) s = step(s, detail::crc_load<std::uint32_t>(p)), p += 4;
            if ((left & 2) != 0) s = step(s, detail::crc_load<std::uint16_t>(p)), p += 2;
            if ((left & 1) != 0) s = step(s, *p);
        } else {
            const std::uint8_t* const stop = p + left;
            while (p != stop) {
                if (static_cast<std::size_t>(stop - p) >= sizeof(unit) && (!must_align<unit> || is_aligned<unit>(p))) {
                    do {
                        s = step(s, detail::crc_load<unit>(must_align<unit> ? assume<unit>(p) : p));
                        p += sizeof(unit);
                    } while (static_cast<std::size_t>(stop - p) >= sizeof(unit));
                } else {
                    s = step(s, *p++);
                }
            }
        }
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept {
        constexpr unsigned extra = Bits == 64 ? 4 : 0;
        word u = s.residue;
        if constexpr (Bits == 64) {
            const word top = static_cast<std::uint32_t>(u);
            u = ((u >> 32) << 4) ^ top ^ (top << 2);
            s.parity ^= s.parity >> 32;
        }
        s.parity ^= s.parity >> 16;
        const word high = u & ((word{1} << (16 + extra)) - 1);
        const word low = u >> (16 + extra);
        u = high ^ (high << 2) ^ (low << (2 + extra)) ^ (low << (3 + extra));
        const word over = u & ((word{1} << (4 + extra)) - 1);
        u = (u >> (4 + extra)) ^ (over << (10 - extra)) ^ (over << (11 - extra));
        return detail::crc_joined(static_cast<std::uint_fast16_t>(u), static_cast<std::uint_fast16_t>(s.parity));
    }

  private:
    template <class Unit> static constexpr bool is_aligned(const std::uint8_t* p) { if (std::is_constant_evaluated()) return true; return std::bit_cast<std::uintptr_t>(p) % sizeof(Unit) == 0; }
    template <class Unit> static constexpr const std::uint8_t* assume(const std::uint8_t* p) { if (std::is_constant_evaluated()) return p; return static_cast<const std::uint8_t*>(__builtin_assume_aligned(p, sizeof(Unit))); }
    template <class Unit>
    static constexpr bool must_align = 
#if defined(__ARM_FEATURE_UNALIGNED) || defined(__x86_64__)
    false;
#else
    true;
#endif

    /// y * x^N
    template <unsigned N> static constexpr word spread(word y) noexcept { return (y ^ (y >> (N / 16))) >> (N / 16); }
    template <std::unsigned_integral Unit>
    static constexpr state step(state s, Unit bytes) noexcept {
        constexpr unsigned n = 8 * sizeof(Unit);
        if constexpr (n == width) {
            constexpr unsigned k = width / 16;
            const word u = s.residue;
            const word y = u ^ (u >> k);
            return {(y >> k) ^ ((y << (width - k)) >> k) ^ ((u << (width - 2 * k)) >> (2 * k)) ^ bytes, s.parity ^ bytes};
        } else {
            return {(s.residue >> n) ^ spread<width>(s.residue << (width - n)) ^ (word{bytes} << (width - n)),
                    s.parity ^ bytes};
        }
    }
};
template <>
struct crc_trinomial<8> {
    struct state {
        std::uint_fast16_t residue;
        std::uint_fast16_t parity;
    };
    static constexpr state begin() noexcept { return {0xFFFF, 0}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept {
        const std::uint_fast16_t top = (s.residue ^ byte) & 0xFF;
        return {static_cast<std::uint_fast16_t>((s.residue >> 8) ^ (top << 6) ^ (top << 7)),
                static_cast<std::uint_fast16_t>(s.parity ^ byte)};
    }
    static constexpr state update(state s, std::span<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept {
        return detail::crc_joined(s.residue, s.parity);
    }
};
using default_crc = std::conditional_t<(sizeof(std::size_t) >= 8), crc_trinomial<64>, crc_trinomial<8>>;
template <crc_engine Engine = default_crc> constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept { return Engine::end(Engine::update(Engine::begin(), bytes)); }
} // namespace servobus::modbus
