// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// CRC-16/MODBUS, low byte first at the end of each RTU frame. Modbus over Serial Line V1.02, 6.2.2, fixes the
// polynomial, x^16 + x^15 + x^2 + 1, the start value, FFFFh, and the order of the bits, lowest first. The CRC
// of a frame with its own CRC is 0, also with more zero bytes behind it: it does not find the end of a frame.
//
// The engines called trinomial need no table. Over GF(2) the polynomial is (x + 1) T with T = x^15 + x + 1,
// and the remainders modulo the two factors give the one modulo the product:
//
//   modulo x + 1   the parity of the message, taken once, at the end, from the xor of its words; FFFFh has 0.
//   modulo T       x^16 = x^2 + x, so by squaring x^32 = x^4 + x^2 and x^64 = x^8 + x^4: a few shifts move a
//                  remainder up by a word, whatever the size of the word.
//   joined         a remainder r modulo T of degree <= 15 is the CRC if its parity is that of the message;
//                  otherwise the CRC is r + T, and T is C001h, lowest bit first.
//
// "Lowest bit first" turns polynomials round: bit 0 of a word is its highest power, a shift right multiplies.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <servobus/core/slice.hpp>

namespace servobus::modbus {

/// A way to compute the CRC, in constant expressions too: `end(update(update(begin(), a), b))` is the CRC of
/// a followed by b, wherever a message is cut.
template <class Engine>
concept crc_engine = requires(typename Engine::state s, slice<const std::uint8_t> bytes) {
    { Engine::begin() } -> std::same_as<typename Engine::state>;
    { Engine::update(s, bytes) } -> std::same_as<typename Engine::state>;
    { Engine::update(s, std::uint8_t{}) } -> std::same_as<typename Engine::state>;
    { Engine::end(s) } -> std::same_as<std::uint16_t>;
};

namespace detail {

/// All of an engine that goes byte by byte but its step from one CRC to the next, `Step::next`.
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

/// Row n holds what each index turns into when its own bits and n more bytes are shifted out.
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

// Templates, so that a compiler computes no table that a program does not use: that takes it longer than all
// the rest of this library's core.
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
// Its base is no fixed one, whose table clang would compute for every program.
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

/// The CRC from a remainder modulo T, of degree <= 15, and a word whose low 16 bits have the message's
/// parity. Most 64-bit hosts have an instruction for a parity; elsewhere looking it up in a constant is best.
template <class Word> constexpr std::uint16_t crc_joined(Word remainder, Word parity) noexcept {
    auto differ = static_cast<std::uint_fast16_t>(remainder ^ parity);
    if constexpr (sizeof(std::size_t) >= 8) {
        differ = static_cast<unsigned>(std::popcount(static_cast<std::uint16_t>(differ))) & 1U;
    } else {
        differ ^= differ >> 8;
        differ ^= differ >> 4;
        differ = (0x6996U >> (differ & 0xFU)) & 1U;
    }
    return static_cast<std::uint16_t>(remainder ^ (differ * 0xC001U));
}

#if defined(__ARM_FEATURE_UNALIGNED) || defined(__x86_64__) || defined(__i386__)
inline constexpr bool crc_loads_anywhere = true;
#else
inline constexpr bool crc_loads_anywhere = false;
#endif
/// Whether the word at this address can be had with one load.
template <std::unsigned_integral Word> constexpr bool crc_aligned(const std::uint8_t* p) noexcept {
    return crc_loads_anywhere || std::is_constant_evaluated() ||
           std::bit_cast<std::uintptr_t>(p) % sizeof(Word) == 0;
}

/// Bytes, lowest first, as a word. GCC and clang make it one load wherever the target can; on a Cortex-M0+
/// they do for the caller that has asked `crc_aligned` and says so.
template <class Word, bool Aligned = false> constexpr Word crc_load(const std::uint8_t* p) noexcept {
    if (Aligned && !crc_loads_anywhere && !std::is_constant_evaluated())
        p = static_cast<const std::uint8_t*>(__builtin_assume_aligned(p, sizeof(Word)));
    return [p]<std::size_t... I>(std::index_sequence<I...>) {
        return static_cast<Word>((... | static_cast<Word>(static_cast<Word>(p[I]) << (8 * I))));
    }
    (std::make_index_sequence<sizeof(Word)>{});
}

} // namespace detail

/// The reference, bit by bit, and the usual ones: two look-ups a byte in 32 bytes of table, one in 512 bytes.
struct crc_bitwise : detail::crc_by_bytes<detail::crc_bit_step> {};
struct crc_table16 : detail::crc_by_bytes<detail::crc_table_step<16>> {};
struct crc_table256 : detail::crc_by_bytes<detail::crc_table_step<256>> {};

/// Eight independent look-ups for eight bytes, in 4 KB of table: fast while the table stays in the cache.
struct crc_slicing8 : detail::crc_by_slices<8, 256> {};

/// No table, `Bits` bits of the message a step, the rest in shorter steps. The state is the xor of all words
/// and a remainder r modulo T, a word wide, not yet multiplied by the x^16 that makes room for the CRC.
template <unsigned Bits>
requires(Bits == 8 || Bits == 16 || Bits == 32 || Bits == 64) struct crc_trinomial {
    using word = std::conditional_t<Bits == 64, std::uint64_t, std::uint32_t>;
    using unit = std::conditional_t<Bits == 16, std::uint16_t, word>;
    static constexpr unsigned width = 8 * sizeof(word);
    static constexpr unsigned k = width / 16; // x^width = x^(2k) + x^k
    struct state {
        word remainder, parity;
    };
    static constexpr state begin() noexcept { return {word{0xD556} << (width - 16), 0}; } // FFFFh / x^16
    static constexpr state update(state s, std::uint8_t byte) noexcept { return step(s, byte); }
    static constexpr state update(state s, slice<const std::uint8_t> bytes) noexcept {
        const std::uint8_t* p = bytes.data();
        const std::uint8_t* const stop = p + bytes.size();
        while (p != stop) {
            if (static_cast<std::size_t>(stop - p) >= sizeof(unit) && detail::crc_aligned<unit>(p)) {
                do {
                    s = step(s, detail::crc_load<unit, true>(p));
                    p += sizeof(unit);
                } while (static_cast<std::size_t>(stop - p) >= sizeof(unit));
            } else {
                s = step(s, *p++);
            }
        }
        return s;
    }
    /// Inline, with the first word apart: after begin() the compiler knows r and drops most of the step.
    [[gnu::always_inline]] static constexpr state update(state s, slice<const std::uint8_t> in) noexcept
        requires(Bits == 64) {
        const std::uint8_t* p = in.data();
        const std::uint8_t* const stop = p + in.size();
        if (stop - p >= 8) s = step(s, detail::crc_load<std::uint64_t>(p)), p += 8;
        for (; stop - p >= 8; p += 8) s = step(s, detail::crc_load<std::uint64_t>(p));
        if ((in.size() & 4) != 0) s = step(s, detail::crc_load<std::uint32_t>(p)), p += 4;
        if ((in.size() & 2) != 0) s = step(s, detail::crc_load<std::uint16_t>(p)), p += 2;
        return (in.size() & 1) != 0 ? step(s, *p) : s;
    }
    /// r x^16, of degree <= 15: from 63 to 35 by x^32, to 23 by x^32 and x^16, to 15 by x^16 once more.
    static constexpr std::uint16_t end(state s) noexcept {
        constexpr unsigned extra = Bits == 64 ? 4 : 0; // bit 31 + extra is x^0
        word r = s.remainder;
        if constexpr (Bits == 64) {
            r = ((r >> 32) << 4) ^ (r & 0xFFFFFFFFU) ^ ((r & 0xFFFFFFFFU) << 2);
            s.parity ^= s.parity >> 32;
        }
        s.parity ^= s.parity >> 16;
        const word high = r & ((word{1} << (16 + extra)) - 1), low = r >> (16 + extra);
        r = high ^ (high << 2) ^ (low << (2 + extra)) ^ (low << (3 + extra));
        const word over = r & ((word{1} << (4 + extra)) - 1);
        r = (r >> (4 + extra)) ^ (over << (10 - extra)) ^ (over << (11 - extra));
        return detail::crc_joined(r, s.parity);
    }

  private:
    /// The lowest N bits, which are the highest powers, moved up to bit `At`.
    template <unsigned N, unsigned At> static constexpr word lowest(word w) noexcept {
        if constexpr (width == 64)
            return (w & ((word{1} << N) - 1)) << At;   // fewest moves between registers on x86
        return (w << (width - N)) >> (width - N - At); // no masks to be loaded on ARM
    }
    /// r x^n + bytes, where bytes has n bits. The n bits that leave r come back multiplied by x^(2k) + x^k;
    /// if they are the whole word, 2k and k of them leave again and come back once more.
    template <std::unsigned_integral Unit> static constexpr state step(state s, Unit bytes) noexcept {
        constexpr unsigned n = 8 * sizeof(Unit);
        const word r = s.remainder, parity = s.parity ^ bytes;
        if constexpr (n == width) {
            const word y = r ^ (r >> k);
            return {(y >> k) ^ lowest<k, width - 2 * k>(y) ^ lowest<2 * k, width - 4 * k>(r) ^ bytes, parity};
        } else {
            const word y = r << (width - n);
            return {(r >> n) ^ ((y ^ (y >> k)) >> k) ^ (word{bytes} << (width - n)), parity};
        }
    }
};

/// Byte by byte, the remainder already multiplied by x^16. It is the 256-entry table in closed form.
template <> struct crc_trinomial<8> {
    struct state {
        std::uint_fast16_t remainder, parity;
    };
    static constexpr state begin() noexcept { return {0xFFFF, 0}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept {
        const std::uint_fast16_t high = (s.remainder ^ byte) & 0xFFU;
        return {static_cast<std::uint_fast16_t>((s.remainder >> 8) ^ (high << 6) ^ (high << 7)),
                static_cast<std::uint_fast16_t>(s.parity ^ byte)};
    }
    static constexpr state update(state s, slice<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept { return detail::crc_joined(s.remainder, s.parity); }
};

/// 64-bit steps on a 64-bit target: with g++ 12 -O2 on x86-64 they take 0.6 of the time of the 256-entry
/// table at 8 bytes, 0.25 at 25, 0.1 at 253, and load no table. Byte steps on others: 72 bytes of code on a
/// Cortex-M4, 80 on an M0+ (GCC 12 -Os). 32-bit steps take 148 and 156; they would save 42 of 97 and 57 of
/// 136 instructions on 8 bytes, 1 us at 48 MHz, which take 700 us on a line at 115200 Bd.
using default_crc = std::conditional_t<(sizeof(std::size_t) >= 8), crc_trinomial<64>, crc_trinomial<8>>;

namespace detail {
// A pointer and a size come in registers; a span would go over the stack of a small core.
template <crc_engine Engine>
constexpr std::uint16_t crc_of(const std::uint8_t* data, std::size_t size) noexcept {
    return Engine::end(Engine::update(Engine::begin(), slice<const std::uint8_t>{data, size}));
}
} // namespace detail

/// The CRC of these bytes; 0 if they end with their own.
template <crc_engine Engine = default_crc>
[[gnu::always_inline]] constexpr std::uint16_t crc16(slice<const std::uint8_t> bytes) noexcept {
    return detail::crc_of<Engine>(bytes.data(), bytes.size());
}

} // namespace servobus::modbus
