// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs of function 18h, which reads the words of a first-in-first-out queue and leaves them in it. Programs include it
// to build or parse these PDUs.
//
//     constexpr auto response = hex("18 00 06 00 02 01 B8 12 84");
//     static_assert((*modbus::parse_fifo_response(response))[1] == 0x1284);
//
// Source: Modbus Application Protocol V1.1b3, section 6.18.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/modbus/detail/response_checks.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

inline constexpr std::uint16_t max_fifo = 31; ///< words of a queue in a response

/// Builds a request of function 18h into `out`. Returns its length, 3; 0 if `out` is too small.
constexpr std::size_t put_fifo_request(byte_buffer out, std::uint16_t address) {
    if (out.size() < 3) return 0;
    out[0] = static_cast<std::uint8_t>(function::read_fifo_queue);
    store_word(out, 1, address);
    return 3;
}

/// Parses a request of function 18h. Returns the address of the queue.
/// Errors: `too_short`, `too_long`, `wrong_function`.
constexpr result<std::uint16_t> parse_fifo_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    if (pdu[0] != static_cast<std::uint8_t>(function::read_fifo_queue)) return errc::wrong_function;
    const errc wrong = detail::check_length(pdu, 3);
    if (wrong != errc::ok) return wrong;
    return load_word(pdu, 1);
}

/// Parses a response of function 18h. Returns the words of the queue, 0..31.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long` (an exception), `wrong_byte_count` (not the bytes
/// that follow), `wrong_quantity` (more than 31 words, or another number than the byte count holds).
constexpr result<words_view> parse_fifo_response(bytes pdu) {
    const status head = detail::check_head(function::read_fifo_queue, pdu);
    if (!head) return head;
    if (pdu.size() < 5) return errc::too_short;
    const std::uint16_t count = load_word(pdu, 1);
    const std::uint16_t words = load_word(pdu, 3);
    if (count != pdu.size() - 3) return errc::wrong_byte_count;
    if (words > max_fifo || count != 2 + 2 * words) return errc::wrong_quantity;
    return words_view{pdu.subspan(5)};
}

} // namespace servobus::modbus
