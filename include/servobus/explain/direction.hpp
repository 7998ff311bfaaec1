// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Tells requests from responses among captured frames: most are well-formed in one direction only.
// explain/explain.hpp includes it; programs include it that pair captured frames.
//
//     static_assert(is_request(hex("01 00 13 00 13")) && !is_response(hex("01 00 13 00 13")));
//     static_assert(is_request(hex("05 00 AC FF 00")) && is_response(hex("05 00 AC FF 00"))); // a response repeats it
//
// Source: Modbus Application Protocol V1.1b3, section 6.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/functions.hpp>

namespace servobus {

/// The direction of a frame.
enum class direction : std::uint8_t {
    unknown, ///< not known: the frame is parsed as both
    request,
    response,
};

/// True if the PDU belongs to a function whose content is known: one of the standard but 14h and 15h, for 08 with a
/// sub-function of the standard, for 2Bh with the MEI type 0Eh. The PDU is not empty, and no exception.
constexpr bool is_of_known_function(bytes pdu) {
    using modbus::function;
    switch (static_cast<function>(pdu[0])) {
    case function::read_coils:
    case function::read_discrete_inputs:
    case function::read_holding_registers:
    case function::read_input_registers:
    case function::write_single_coil:
    case function::write_single_register:
    case function::read_exception_status:
    case function::get_event_counter:
    case function::get_event_log:
    case function::write_multiple_coils:
    case function::write_multiple_registers:
    case function::report_server_id:
    case function::mask_write_register:
    case function::read_write_registers:
    case function::read_fifo_queue: return true;
    case function::diagnostics: {
        const bool is_short = pdu.size() < 5;
        return is_short || modbus::parse_diagnostic_request(pdu).error() != errc::wrong_function;
    }
    case function::encapsulated_interface: return pdu.size() < 2 || pdu[1] == modbus::mei_identification;
    }
    return false;
}

namespace detail {

// A response to a request of function 08: it repeats the request, or has what was read in place of the data 0000.
constexpr errc check_lone_diagnostic(bytes pdu) {
    if (pdu.size() < 5) return errc::too_short;
    const result<modbus::diagnostic_request> same = modbus::parse_diagnostic_request(pdu);
    if (same && same->what == modbus::diagnostic::listen_only)
        return errc::unexpected_value; // it has no response
    if (same.error() != errc::wrong_value) return same.error();
    constexpr std::uint8_t zero[2]{};
    const modbus::diagnostic_request asked{static_cast<modbus::diagnostic>(load_word(pdu, 1)),
                                           words_view{bytes{zero, sizeof zero}}};
    return modbus::parse_diagnostic_response(asked, pdu).error();
}

constexpr errc check_lone_identification(bytes pdu) {
    if (pdu.size() < 9) return errc::too_short;
    const modbus::identification_request asked{static_cast<modbus::identification>(pdu[2]), pdu[7]};
    const bool has_kind = pdu[2] >= 1 && pdu[2] <= 4;
    return has_kind ? modbus::parse_identification_response(asked, pdu).error() : errc::wrong_value;
}

} // namespace detail

/// True for a write of a coil (05), or the response that repeats it, with another value than the standard's FF00h and
/// 0000h: there are relay modules that toggle at 5500h, or switch for a time.
constexpr bool is_unusual_coil_write(bytes pdu) {
    return pdu.size() == 5 && modbus::parse_bits_request(pdu).error() == errc::wrong_value;
}

/// Checks a request as it is seen on a line, where a coil may be written with any value.
constexpr errc check_seen_request(bytes pdu) {
    return is_unusual_coil_write(pdu) ? errc::ok : modbus::check_request(pdu).error();
}
/// Checks a response against such a request, as `modbus::check_response` does.
constexpr status check_seen_response(bytes request, bytes pdu) {
    if (!is_unusual_coil_write(request)) return modbus::check_response(request, pdu);
    const std::uint8_t usual[5]{0x05, request[1], request[2], 0xFF, 0x00};
    if (pdu.size() != 5 || pdu[0] != 0x05) return modbus::check_response(bytes{usual, 5}, pdu);
    const bool is_same = load_word(pdu, 3) == load_word(request, 3);
    const std::uint8_t answer[5]{0x05, pdu[1], pdu[2], is_same ? std::uint8_t{0xFF} : std::uint8_t{0}, 0x00};
    return modbus::check_response(bytes{usual, 5}, bytes{answer, 5});
}

/// Checks a response without its request.
/// Errors: `wrong_function` for a function that `is_of_known_function` does not know, or those of the parser of the
/// function.
constexpr errc check_lone_response(bytes pdu) {
    using modbus::function;
    if (pdu.size() < 2) return errc::too_short;
    const auto code = static_cast<function>(pdu[0]);
    switch (code) {
    case function::read_coils:
    case function::read_discrete_inputs: {
        if (pdu[1] == 0 || pdu[1] > modbus::bytes_of_bits(modbus::max_read_bits))
            return errc::wrong_byte_count;
        const auto bits = static_cast<std::uint16_t>(8 * pdu[1]); // which leaves no padding
        return modbus::parse_bits_response({.code = code, .quantity = bits}, pdu).error();
    }
    case function::write_single_coil: return check_seen_request(pdu);
    case function::write_multiple_coils: {
        if (pdu.size() != 5) return pdu.size() < 5 ? errc::too_short : errc::too_long;
        const std::uint16_t quantity = load_word(pdu, 3);
        if (quantity == 0 || quantity > modbus::max_write_bits) return errc::wrong_quantity;
        return modbus::fits_address_space(load_word(pdu, 1), quantity) ? errc::ok : errc::wrong_address;
    }
    case function::read_exception_status: return modbus::parse_exception_status(pdu).error();
    case function::diagnostics: return detail::check_lone_diagnostic(pdu);
    case function::get_event_counter: return modbus::parse_event_counter(pdu).error();
    case function::get_event_log: return modbus::parse_event_log(pdu).error();
    case function::report_server_id: return modbus::parse_server_id(pdu).error();
    case function::mask_write_register: return modbus::parse_mask_write_request(pdu).error();
    case function::read_write_registers: {
        const bool is_of_words = pdu[1] != 0 && pdu[1] % 2 == 0 && pdu[1] <= 2 * modbus::max_read;
        if (!is_of_words) return errc::wrong_byte_count;
        return modbus::parse_read_write_response(pdu[1] / 2, pdu).error();
    }
    case function::read_fifo_queue: return modbus::parse_fifo_response(pdu).error();
    case function::encapsulated_interface: return detail::check_lone_identification(pdu);
    default: return modbus::parse_response(pdu).error(); // registers, and exceptions
    }
}

/// True for a well-formed request of a function whose content is known.
constexpr bool is_request(bytes pdu) { return check_seen_request(pdu) == errc::ok; }
/// True for a well-formed response of such a function, or for an exception.
constexpr bool is_response(bytes pdu) { return check_lone_response(pdu) == errc::ok; }

} // namespace servobus
