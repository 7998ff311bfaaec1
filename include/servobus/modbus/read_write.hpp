// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs that change registers and read them in one request: function 16h sets some bits of a register, 17h writes
// registers and then reads registers. Programs include it to build or parse these PDUs.
//
//     constexpr auto change = *modbus::parse_mask_write_request(hex("16 00 04 00 F2 00 25"));
//     static_assert(change.address == 4 && change.applied_to(0x12) == 0x17);
//
// Source: Modbus Application Protocol V1.1b3, sections 6.16 and 6.17.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/modbus/detail/response_checks.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

inline constexpr std::uint16_t max_write_of_read_write =
    121; ///< registers that 17h writes; it reads up to `max_read`

namespace detail {
// Not constexpr on purpose, as in pdu.hpp: the error of a constant request names the rule.
inline void a_read_write_reads_1_to_125_registers_inside_the_address_space() {}
inline void a_read_write_writes_1_to_121_registers_inside_the_address_space() {}

/// The first ten bytes of a request of function 17h; the values follow. The parts are checked already.
constexpr void put_read_write_head(byte_buffer out, std::uint16_t read_address, std::uint16_t quantity,
                                   std::uint16_t write_address, std::uint16_t written) {
    put_trusted_request(out, function::read_write_registers, read_address, quantity);
    store_word(out, 5, write_address);
    store_word(out, 7, written);
    out[9] = static_cast<std::uint8_t>(2 * written);
}
} // namespace detail

/// A change of some bits of a register, function 16h.
struct mask_write {
    std::uint16_t address = 0;
    std::uint16_t and_mask = 0xFFFF; ///< bits of the register that stay
    std::uint16_t or_mask = 0;       ///< values of the other bits

    /// The register after the change.
    constexpr std::uint16_t applied_to(std::uint16_t value) const {
        return static_cast<std::uint16_t>((value & and_mask) | (or_mask & ~and_mask));
    }
    friend constexpr bool operator==(const mask_write&, const mask_write&) = default;
};

/// Builds a request of function 16h into `out`, and its response, which is the same. Returns its length, 7; 0 if `out`
/// is too small.
constexpr std::size_t put_mask_write_request(byte_buffer out, mask_write change) {
    if (out.size() < 7) return 0;
    put_trusted_request(out, function::mask_write_register, change.address, change.and_mask);
    store_word(out, 5, change.or_mask);
    return 7;
}

/// Parses a request of function 16h. Errors: `too_short`, `too_long`, `wrong_function`.
constexpr result<mask_write> parse_mask_write_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    if (pdu[0] != static_cast<std::uint8_t>(function::mask_write_register)) return errc::wrong_function;
    const errc wrong = detail::check_length(pdu, 7);
    if (wrong != errc::ok) return wrong;
    return mask_write{load_word(pdu, 1), load_word(pdu, 3), load_word(pdu, 5)};
}

/// Checks the response to a request of function 16h, which repeats it.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long`, `wrong_address`, `wrong_value` (a mask differs).
constexpr status check_mask_write_response(const mask_write& change, bytes pdu) {
    const status head = detail::check_fixed(function::mask_write_register, pdu, 7);
    if (!head) return head;
    if (load_word(pdu, 1) != change.address) return status::sent(errc::wrong_address);
    const bool is = load_word(pdu, 3) == change.and_mask && load_word(pdu, 5) == change.or_mask;
    return is ? status{} : status::sent(errc::wrong_value);
}

/// Builds a request of function 17h into `out`: the device writes `values` from `write_address` on, then reads
/// `quantity` registers from `read_address` on. Returns its length, 10 + 2 * values.size(); 0 if it does not read
/// 1..125 or write 1..121 registers, they do not fit the address space, or `out` is too small.
constexpr std::size_t put_read_write_request(byte_buffer out, std::uint16_t read_address,
                                             std::uint16_t quantity, std::uint16_t write_address,
                                             slice<const std::uint16_t> values) {
    if (quantity == 0 || quantity > max_read || !fits_address_space(read_address, quantity)) {
        detail::a_read_write_reads_1_to_125_registers_inside_the_address_space();
        return 0;
    }
    if (values.empty() || values.size() > max_write_of_read_write ||
        !fits_address_space(write_address, static_cast<std::uint16_t>(values.size()))) {
        detail::a_read_write_writes_1_to_121_registers_inside_the_address_space();
        return 0;
    }
    const std::size_t length = 10 + 2 * values.size();
    if (out.size() < length) return 0;
    detail::put_read_write_head(out, read_address, quantity, write_address,
                                static_cast<std::uint16_t>(values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) store_word(out, 10 + 2 * i, values[i]);
    return length;
}

/// A parsed request of function 17h. A server writes first, so a register in both parts is read as written.
struct read_write {
    std::uint16_t read_address = 0;
    std::uint16_t quantity = 0; ///< registers to read
    std::uint16_t write_address = 0;
    words_view values{}; ///< to write
};

/// Parses a request of function 17h.
/// Errors, in this order: `too_short` (empty), `wrong_function`, `too_short`, `wrong_byte_count` (not the bytes that
/// follow), `wrong_quantity` (it does not read 1..125 or write 1..121 registers), `wrong_byte_count` (not 2 for each
/// value), `wrong_address` (a part does not fit the address space).
constexpr result<read_write> parse_read_write_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    if (pdu[0] != static_cast<std::uint8_t>(function::read_write_registers)) return errc::wrong_function;
    if (pdu.size() < 10) return errc::too_short;
    if (pdu[9] != pdu.size() - 10) return errc::wrong_byte_count;
    const read_write r{load_word(pdu, 1), load_word(pdu, 3), load_word(pdu, 5), words_view{pdu.subspan(10)}};
    const std::uint16_t written = load_word(pdu, 7);
    if (r.quantity == 0 || r.quantity > max_read || written == 0 || written > max_write_of_read_write)
        return errc::wrong_quantity;
    if (pdu[9] != 2 * written) return errc::wrong_byte_count;
    if (!fits_address_space(r.read_address, r.quantity) || !fits_address_space(r.write_address, written))
        return errc::wrong_address;
    return r;
}

/// Parses the response to a request of function 17h that reads `quantity` registers. Returns their words.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long` (an exception), `wrong_byte_count` (not 2 for each
/// register, or not the bytes that follow).
constexpr result<words_view> parse_read_write_response(std::uint16_t quantity, bytes pdu) {
    const std::size_t count = 2 * std::size_t{quantity};
    const status head = detail::check_counted(function::read_write_registers, pdu, count, count);
    if (!head) return head;
    return words_view{pdu.subspan(2)};
}

} // namespace servobus::modbus
