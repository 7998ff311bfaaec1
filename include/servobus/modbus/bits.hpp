// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs of coils and discrete inputs: functions 01, 02, 05 and 0Fh, built and parsed at compile time or at run time.
// Programs include it that read or write the bits of a device.
//
//     constexpr auto request = *modbus::parse_bits_request(hex("01 00 13 00 13"));
//     constexpr auto response = hex("01 03 CD 6B 05");
//     static_assert((*modbus::parse_bits_response(request, response))[2]); // coil 15h is on
//
// Source: Modbus Application Protocol V1.1b3, sections 6.1, 6.2, 6.5 and 6.11.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/modbus/detail/response_checks.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

inline constexpr std::uint16_t max_read_bits = 2000;  ///< coils or inputs in a read
inline constexpr std::uint16_t max_write_bits = 1968; ///< coils in a multiple write
inline constexpr std::uint16_t coil_on = 0xFF00; ///< the value of function 05; `coil_off` is the only other
inline constexpr std::uint16_t coil_off = 0x0000;

/// The bytes that hold `bits` packed bits.
constexpr std::size_t bytes_of_bits(std::size_t bits) { return bits / 8 + (bits % 8 != 0 ? 1 : 0); }

/// A view of packed bits in a PDU. The first bit is the lowest of the first byte. It copies nothing.
class bits_view {
  public:
    constexpr bits_view() = default;
    /// `packed` holds at least `bytes_of_bits(count)` bytes.
    constexpr bits_view(bytes packed, std::uint16_t count) : packed_{packed}, count_{count} {}

    constexpr std::size_t size() const { return count_; }
    constexpr bool operator[](std::size_t i) const { return (packed_[i / 8] >> i % 8 & 1u) != 0; }
    /// The bytes with the bits; those after the last bit are padding.
    constexpr bytes packed() const { return packed_; }
    /// True if the bits after the last one are 0, as the standard demands in a response.
    constexpr bool has_zero_padding() const {
        return count_ % 8 == 0 || packed_[count_ / 8u] >> count_ % 8 == 0;
    }

  private:
    bytes packed_{};
    std::uint16_t count_ = 0;
};

namespace detail {
// Not constexpr on purpose, as in pdu.hpp: the error of a constant request names the rule.
inline void a_read_of_bits_asks_for_1_to_2000_inside_the_address_space() {}
inline void a_read_of_bits_is_function_01_or_02() {}
inline void a_write_of_coils_has_1_to_1968_inside_the_address_space() {}
inline void packed_coils_fill_their_bytes_and_no_other() {}

constexpr bool is_read_of_bits(function code) {
    return code == function::read_coils || code == function::read_discrete_inputs;
}
constexpr bool is_writable(std::uint16_t address, std::size_t coils) {
    const bool is = coils >= 1 && coils <= max_write_bits &&
                    fits_address_space(address, static_cast<std::uint16_t>(coils));
    if (!is) a_write_of_coils_has_1_to_1968_inside_the_address_space();
    return is;
}
/// The first six bytes of a request of function 0Fh, whose coils fill `count` bytes.
constexpr void put_coils_head(byte_buffer out, std::uint16_t address, std::size_t coils, std::size_t count) {
    put_trusted_request(out, function::write_multiple_coils, address, static_cast<std::uint16_t>(coils));
    out[5] = static_cast<std::uint8_t>(count);
}
} // namespace detail

/// Builds a request of function 01 or 02 into `out`. Returns its length, 5; 0 for another function, if `quantity` is
/// not 1..2000, the bits do not fit the address space, or `out` is too small.
constexpr std::size_t put_read_bits_request(byte_buffer out, function code, std::uint16_t address,
                                            std::uint16_t quantity) {
    if (!detail::is_read_of_bits(code)) {
        detail::a_read_of_bits_is_function_01_or_02();
        return 0;
    }
    if (quantity == 0 || quantity > max_read_bits || !fits_address_space(address, quantity)) {
        detail::a_read_of_bits_asks_for_1_to_2000_inside_the_address_space();
        return 0;
    }
    if (out.size() < 5) return 0;
    put_trusted_request(out, code, address, quantity);
    return 5;
}

/// Builds a request of function 05 into `out`, and its response, which is the same. Returns its length, 5; 0 if `out`
/// is too small.
constexpr std::size_t put_write_coil_request(byte_buffer out, std::uint16_t address, bool is_on) {
    if (out.size() < 5) return 0;
    put_trusted_request(out, function::write_single_coil, address, is_on ? coil_on : coil_off);
    return 5;
}
/// A number for a coil does not compile: 1 and FF00h would both be on.
template <class Number> constexpr void put_write_coil_request(byte_buffer, std::uint16_t, Number) {
    static_assert(std::is_same_v<Number, bool>, "a coil is written as true or false, not as a number");
}

/// Builds a request of function 0Fh into `out`, with zeros as padding. Returns its length, 6 and the bytes of the
/// coils; 0 if there are not 1..1968 coils, they do not fit the address space, the view has another number of bytes
/// than its coils need, or `out` is too small. The coils may lie where they are sent.
constexpr std::size_t put_write_coils_request(byte_buffer out, std::uint16_t address, bits_view coils) {
    if (!detail::is_writable(address, coils.size())) return 0;
    const std::size_t count = bytes_of_bits(coils.size());
    if (coils.packed().size() != count) {
        detail::packed_coils_fill_their_bytes_and_no_other();
        return 0;
    }
    if (out.size() < 6 + count) return 0;
    detail::put_coils_head(out, address, coils.size(), count);
    for (std::size_t i = 0; i < count; ++i) out[6 + i] = coils.packed()[i];
    const std::size_t used = coils.size() % 8;
    if (used != 0) out[5 + count] = static_cast<std::uint8_t>(out[5 + count] & ((1u << used) - 1));
    return 6 + count;
}
/// The same with a bool for each coil.
constexpr std::size_t put_write_coils_request(byte_buffer out, std::uint16_t address,
                                              slice<const bool> coils) {
    if (!detail::is_writable(address, coils.size())) return 0;
    const std::size_t count = bytes_of_bits(coils.size());
    const std::size_t length = 6 + count;
    if (out.size() < length) return 0;
    detail::put_coils_head(out, address, coils.size(), count);
    for (std::size_t i = 6; i < length; ++i) out[i] = 0;
    for (std::size_t i = 0; i < coils.size(); ++i) {
        if (coils[i]) out[6 + i / 8] = static_cast<std::uint8_t>(out[6 + i / 8] | 1u << i % 8);
    }
    return length;
}

/// A parsed request of function 01, 02, 05 or 0Fh. Function 05 has a quantity of 1.
struct bits_request {
    function code = function::read_coils;
    std::uint16_t address = 0;
    std::uint16_t quantity = 0;
    bytes packed{}; ///< of a write; its padding is ignored

    constexpr bool is_read() const { return detail::is_read_of_bits(code); }
    /// The coils that a write sets.
    constexpr bits_view coils() const { return {packed, quantity}; }
};

/// Parses a request of function 01, 02, 05 or 0Fh. The padding of 0Fh is ignored.
/// Errors, in this order: `too_short` (empty), `wrong_function`, `too_short`, `too_long`, `wrong_value` (05: neither
/// FF00 nor 0000), `wrong_byte_count` (0Fh: not the bytes that follow), `wrong_quantity` (not within 1..2000 for a
/// read, 1..1968 for a write), `wrong_byte_count` (0Fh: not what the quantity needs), `wrong_address` (the bits do not
/// fit the address space).
constexpr result<bits_request> parse_bits_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    bits_request r{.code = static_cast<function>(pdu[0])};
    const bool is_block = r.code == function::write_multiple_coils;
    if (!r.is_read() && !is_block && r.code != function::write_single_coil) return errc::wrong_function;
    if (pdu.size() < (is_block ? 6u : 5u)) return errc::too_short;
    if (!is_block && pdu.size() > 5) return errc::too_long;
    r.address = load_word(pdu, 1);
    r.quantity = load_word(pdu, 3);
    if (r.code == function::write_single_coil) {
        if (r.quantity != coil_on && r.quantity != coil_off) return errc::wrong_value;
        r.quantity = 1;
        r.packed = pdu.subspan(3, 1); // FF or 00: its lowest bit is the coil
        return r;
    }
    if (is_block && pdu[5] != pdu.size() - 6) return errc::wrong_byte_count;
    if (r.quantity == 0 || r.quantity > (is_block ? max_write_bits : max_read_bits))
        return errc::wrong_quantity;
    if (is_block && pdu[5] != bytes_of_bits(r.quantity)) return errc::wrong_byte_count;
    if (!fits_address_space(r.address, r.quantity)) return errc::wrong_address;
    if (is_block) r.packed = pdu.subspan(6);
    return r;
}

/// Parses the response to `request`, a valid one. Returns the bits that were read; for a write those that it set.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long`, `wrong_byte_count` (a read: not the bytes that the
/// quantity needs), `unexpected_value` (a read: padding that is not 0), `wrong_address`, `wrong_value` (05: not the
/// request's), `wrong_quantity` (0Fh: not the request's).
constexpr result<bits_view> parse_bits_response(const bits_request& request, bytes pdu) {
    if (request.is_read()) {
        const std::size_t count = bytes_of_bits(request.quantity);
        const status head = detail::check_counted(request.code, pdu, count, count);
        if (!head) return head;
        const bits_view bits{pdu.subspan(2), request.quantity};
        return bits.has_zero_padding() ? result<bits_view>{bits} : errc::unexpected_value;
    }
    const status head = detail::check_fixed(request.code, pdu, 5);
    if (!head) return head;
    if (load_word(pdu, 1) != request.address) return errc::wrong_address;
    const bool is_single = request.code == function::write_single_coil;
    const std::uint16_t value = request.coils()[0] ? coil_on : coil_off;
    if (load_word(pdu, 3) == (is_single ? value : request.quantity)) return request.coils();
    return is_single ? errc::wrong_value : errc::wrong_quantity;
}

} // namespace servobus::modbus
