// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Modbus RTU frames (node address, PDU, CRC with its low byte first; 4..256 bytes) and the gaps t1.5 and t3.5
// that separate them. Every line, exchange and server includes it; programs include it for the timing of a
// line and for frames of their own.
//
//     static_assert(same_bytes(modbus::write_frame(1, 0x200E, 8), hex("01 06 20 0E 00 08 E2 0F")));
//
// Source: Modbus over Serial Line V1.02, section 2.5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

inline constexpr std::size_t min_frame = 4;   ///< bytes
inline constexpr std::size_t max_frame = 256; ///< bytes
inline constexpr std::uint8_t broadcast = 0;  ///< the address of all devices

/// True for an address that a device can have, 1..247 (0 is broadcast, 248..255 are reserved).
constexpr bool is_node_address(std::uint8_t node_address) { return node_address >= 1 && node_address <= 247; }

namespace detail {
/// The CRC of a frame: inlined on hosts; small cores share one copy of its code.
template <crc_engine Crc> [[gnu::always_inline]] constexpr std::uint16_t inline_crc(bytes of) {
    if constexpr (std::is_same_v<Crc, crc_trinomial<64>>) { // nearly every request
        if (of.size() == 6) return Crc::template of_words<3>(of.data());
    }
    if constexpr (sizeof(std::size_t) >= 8) return Crc::end(Crc::update(Crc::begin(), of));
    return crc16<Crc>(of);
}
/// The low byte first.
constexpr void store_crc(byte_buffer to, std::size_t at, std::uint16_t crc) {
    if constexpr (sizeof(std::size_t) >= 8) return store_word(to, at, __builtin_bswap16(crc)); // one store
    to[at] = static_cast<std::uint8_t>(crc & 0xFFu);
    to[at + 1] = static_cast<std::uint8_t>(crc >> 8);
}
} // namespace detail

/// Completes a frame without a check, for who has just made its PDU: `out` begins with a node address and a PDU of
/// `pdu_size` bytes, 1..253, and has room for the CRC after them.
template <crc_engine Crc = default_crc>
[[gnu::always_inline]] constexpr bytes close_trusted(byte_buffer out, std::size_t pdu_size) {
    const bytes all = out.first(pdu_size + 3);
    detail::store_crc(out, pdu_size + 1, detail::inline_crc<Crc>(all.first(pdu_size + 1)));
    return all;
}

/// Completes a frame: `out` begins with a node address and a PDU of `pdu_size` bytes; the CRC is stored after
/// them. Returns the frame's length, `pdu_size + 3`; 0 if `pdu_size` is not 1..253 or the frame does not fit
/// `out`.
template <crc_engine Crc = default_crc>
// Inlined, since the size is mostly a constant: the checks vanish and, on a host, the steps of the CRC are
// unrolled.
[[nodiscard, gnu::always_inline]] constexpr std::size_t close_frame(byte_buffer out, std::size_t pdu_size) {
    if (pdu_size == 0 || pdu_size > max_pdu || out.size() < pdu_size + 3) return 0;
    return close_trusted<Crc>(out, pdu_size).size();
}

/// A frame with its own storage of `Capacity` bytes. Constant frames can be placed in flash.
template <std::size_t Capacity> struct frame {
    std::uint8_t data[Capacity]; // not initialised: a small core would call memset
    std::size_t size = 0;        ///< bytes; 0: the request was invalid, and `data` is meaningless

    constexpr operator bytes() const { return bytes{data, size}; } // NOLINT: a frame is its bytes
};

/// A frame that reads `quantity` registers with function 03 (default) or 04. If the quantity is not 1..125 or
/// the registers do not fit the address space, a constant frame does not compile and the size of others is 0.
template <crc_engine Crc = default_crc>
constexpr frame<8> read_frame(std::uint8_t node_address, std::uint16_t address, std::uint16_t quantity,
                              function code = function::read_holding_registers) {
    frame<8> f;
    f.data[0] = node_address;
    put_trusted_request(byte_buffer{f.data}.subspan(1), code, address, quantity);
    const std::size_t size = close_frame<Crc>(f.data, 5);
    f.size = detail::is_readable(code, address, quantity) ? size : 0;
    return f;
}

/// A frame that writes one register, function 06.
template <crc_engine Crc = default_crc>
constexpr frame<8> write_frame(std::uint8_t node_address, std::uint16_t address, std::uint16_t value) {
    frame<8> f;
    f.data[0] = node_address;
    f.size = close_frame<Crc>(f.data, put_write_request(byte_buffer{f.data}.subspan(1), address, value));
    return f;
}

namespace detail {
template <crc_engine Crc, std::size_t N>
constexpr frame<9 + 2 * N> write_frame_of(std::uint8_t node_address, std::uint16_t address,
                                          slice<const std::uint16_t> values) {
    frame<9 + 2 * N> f;
    f.data[0] = node_address;
    f.size = close_frame<Crc>(f.data, put_write_request(byte_buffer{f.data}.subspan(1), address, values));
    return f;
}
} // namespace detail

/// A frame that writes N adjacent registers, function 10h: `write_frame(1, 0x2088, {100, 100})`. If N is not
/// 1..123 or the registers do not fit the address space, a constant frame does not compile and the size of
/// others is 0.
template <crc_engine Crc = default_crc, std::size_t N>
constexpr frame<9 + 2 * N> write_frame(std::uint8_t node_address, std::uint16_t address,
                                       const std::uint16_t (&values)[N]) {
    return detail::write_frame_of<Crc, N>(node_address, address, values);
}
/// The same with the values in a std::array, or in another class template of type and size.
template <crc_engine Crc = default_crc, template <class, std::size_t> class Array, std::size_t N>
constexpr frame<9 + 2 * N> write_frame(std::uint8_t node_address, std::uint16_t address,
                                       const Array<std::uint16_t, N>& values) {
    return detail::write_frame_of<Crc, N>(node_address, address, values);
}

/// The address and the PDU of a received frame.
struct opened {
    std::uint8_t address = 0;
    bytes pdu{};
};

/// Checks a frame's length and CRC and returns its address and PDU. Errors: `too_short`, `too_long`,
/// `bad_crc`.
template <crc_engine Crc = default_crc> constexpr result<opened> open_frame(bytes adu) {
    if (adu.size() < min_frame) return errc::too_short;
    if (adu.size() > max_frame) return errc::too_long;
    if (crc16<Crc>(adu) != 0) return errc::bad_crc;
    return opened{adu[0], adu.subspan(1, adu.size() - 3)};
}

namespace detail {
/// True if bit `code` of `set` is set.
constexpr bool is_in(std::uint32_t set, std::uint8_t code) { return code < 32 && (set >> code & 1u) != 0; }
inline constexpr std::uint32_t counted_responses =
    0x0080'001E;                                              ///< 01..04, 17h: the third byte is a byte count
inline constexpr std::uint32_t short_responses = 0x0001'8060; ///< 05, 06, 0F, 10h: eight bytes
inline constexpr std::uint32_t short_requests = 0x0000'007E;  ///< 01..06: eight bytes
} // namespace detail

/// The length of a response frame, from its function code and its third byte; 0 if the function is none of
/// 01..06, 0F, 10h, 16h, 17h and the frame is not an exception.
constexpr std::size_t response_length(std::uint8_t code, std::uint8_t third_byte) {
    if ((code & exception_flag) != 0) return 5;
    if (detail::is_in(detail::counted_responses, code)) return std::size_t{third_byte} + 5;
    if (code == 0x16) return 10;
    return detail::is_in(detail::short_responses, code) ? 8 : 0;
}

/// The length of a request frame, from its first bytes. 0 while these are too few, and for functions other
/// than 01..06, 0F, 10h, 16h and 17h.
constexpr std::size_t request_length(bytes begun) {
    if (begun.size() < 2) return 0;
    const std::uint8_t code = begun[1];
    if (detail::is_in(detail::short_requests, code)) return 8;
    if (code == 0x16) return 10;
    const std::size_t count_at = code == 0x17 ? 10 : code == 0x0F || code == 0x10 ? 6 : 0;
    return count_at != 0 && begun.size() > count_at ? begun[count_at] + count_at + 3 : 0;
}

/// How gaps are measured on a line.
enum class timing_mode : std::uint8_t {
    host, ///< bytes arrive in bursts (USB adapter, pseudo-terminal): a frame may have gaps up to `inter_byte`
    strict, ///< each byte has its arrival time: a frame with a gap longer than t1.5 is rejected
};

/// The gaps of a line. A character counts as 11 bits, as in the standard's figures, also for 8N1. All times
/// are rounded up to whole microseconds.
struct rtu_timing {
    std::uint16_t t1_5;      ///< us; the longest gap inside a frame
    std::uint16_t t3_5;      ///< us; the shortest gap between frames
    std::uint16_t character; ///< us; 11 bits
    timing_mode mode;
    duration inter_byte; ///< host mode: the longest gap inside a frame

    /// Lowest baud rate that a timing can have. Below 588 Bd t3.5 would not fit 16 bits.
    static constexpr std::uint32_t lowest_baud = 600;

    constexpr duration wire_time(std::size_t characters) const {
        return duration{static_cast<std::uint32_t>(characters) * character};
    }
    /// The shortest gap that always ends a frame in this mode.
    constexpr duration visible_gap() const {
        return mode == timing_mode::strict ? duration{t3_5} : longer_of(inter_byte, duration{t3_5});
    }
    /// The longest that a device takes for a frame: with pauses of t1.5 each or, with host timing, if that is longer,
    /// of `inter_byte` in all.
    constexpr duration longest_frame(std::size_t characters) const {
        const duration spaced =
            wire_time(characters) + duration{t1_5} * static_cast<std::uint32_t>(characters);
        const duration halted = visible_gap() + wire_time(characters);
        return mode == timing_mode::strict || halted < spaced ? spaced : halted;
    }
    /// The longest time since the previous byte after which `characters` that arrived together still belong
    /// to the same frame.
    constexpr duration longest_gap(std::size_t characters) const {
        return mode == timing_mode::strict ? duration{t1_5} + wire_time(characters) : visible_gap();
    }
};

namespace detail {
constexpr std::uint16_t half_characters(std::uint32_t baud, std::uint32_t halves) {
    return static_cast<std::uint16_t>((halves * 5'500'000u - 1) / baud + 1);
}
} // namespace detail

/// The timing of a line at `baud` bits per second; values below 600 count as 600. Above 19200 Bd t1.5 and
/// t3.5 are the standard's fixed 750 and 1750 us. `inter_byte` applies to host mode; USB adapters need 16 ms
/// or more.
constexpr rtu_timing timing_at(std::uint32_t baud, timing_mode mode = timing_mode::host,
                               duration inter_byte = milliseconds(20)) {
    if (baud < rtu_timing::lowest_baud) baud = rtu_timing::lowest_baud;
    const bool fast = baud > 19200;
    return {
        .t1_5 = fast ? std::uint16_t{750} : detail::half_characters(baud, 3),
        .t3_5 = fast ? std::uint16_t{1750} : detail::half_characters(baud, 7),
        .character = detail::half_characters(baud, 2),
        .mode = mode,
        .inter_byte = inter_byte,
    };
}

} // namespace servobus::modbus
