// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Strict checks of any request of the standard, and of a response against its request. It includes the headers of all
// functions; programs that have a few functions include those.
//
//     constexpr auto request = hex("16 00 04 00 F2 00 25");
//     static_assert(modbus::check_request(request) == errc::ok);
//     static_assert(modbus::check_response(request, hex("16 00 04 00 F2 00 24")) == errc::wrong_value);
//
// Source: Modbus Application Protocol V1.1b3, section 6.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/detail/response_checks.hpp>
#include <servobus/modbus/diagnostics.hpp>
#include <servobus/modbus/fifo.hpp>
#include <servobus/modbus/identification.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/read_write.hpp>

namespace servobus::modbus {

/// Checks a request as a server must before it looks at its rows: the function, then length, quantity, byte count and
/// value, then that the addresses fit the address space.
/// Errors: those of the parser of its function; `wrong_function` for codes that the standard does not define.
constexpr status check_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    switch (static_cast<function>(pdu[0])) {
    case function::read_coils:
    case function::read_discrete_inputs:
    case function::write_single_coil:
    case function::write_multiple_coils: return parse_bits_request(pdu).error();
    case function::read_holding_registers:
    case function::read_input_registers:
    case function::write_single_register:
    case function::write_multiple_registers: return parse_request(pdu).error();
    case function::read_exception_status:
    case function::get_event_counter:
    case function::get_event_log:
    case function::report_server_id: return parse_bare_request(pdu).error();
    case function::diagnostics: return parse_diagnostic_request(pdu).error();
    case function::mask_write_register: return parse_mask_write_request(pdu).error();
    case function::read_write_registers: return parse_read_write_request(pdu).error();
    case function::read_fifo_queue: return parse_fifo_request(pdu).error();
    case function::encapsulated_interface: return parse_identification_request(pdu).error();
    }
    return errc::wrong_function;
}

namespace detail {
/// The response to a request of function 03, 04, 06 or 10h.
constexpr status check_register_response(const request& asked, bytes pdu) {
    const auto code = static_cast<function>(asked.code);
    const std::size_t count = 2 * std::size_t{asked.quantity};
    if (is_read(asked.code)) return check_counted(code, pdu, count, count);
    const status head = check_fixed(code, pdu, 5);
    if (!head) return head;
    if (load_word(pdu, 1) != asked.address) return status::sent(errc::wrong_address);
    const bool is_single = code == function::write_single_register;
    if (load_word(pdu, 3) == (is_single ? asked.values()[0] : asked.quantity)) return {};
    return status::sent(is_single ? errc::wrong_value : errc::wrong_quantity);
}
} // namespace detail

/// Checks a response against its request: each repeated field, the byte count, zeros as padding. The status of an
/// exception has its number.
/// Errors: `bad_argument` (the request itself is wrong), or those of the parser of its function.
constexpr status check_response(bytes request, bytes pdu) {
    if (check_request(request) != errc::ok) return errc::bad_argument;
    const auto code = static_cast<function>(request[0]);
    switch (code) {
    case function::read_coils:
    case function::read_discrete_inputs:
    case function::write_single_coil:
    case function::write_multiple_coils:
        return parse_bits_response(*parse_bits_request(request), pdu).status();
    case function::read_holding_registers:
    case function::read_input_registers:
    case function::write_single_register:
    case function::write_multiple_registers:
        return detail::check_register_response(*parse_request(request), pdu);
    case function::read_exception_status: return parse_exception_status(pdu).status();
    case function::get_event_counter: return parse_event_counter(pdu).status();
    case function::get_event_log: return parse_event_log(pdu).status();
    case function::report_server_id: return parse_server_id(pdu).status();
    case function::diagnostics:
        return parse_diagnostic_response(*parse_diagnostic_request(request), pdu).status();
    case function::mask_write_register:
        return check_mask_write_response(*parse_mask_write_request(request), pdu);
    case function::read_write_registers:
        return parse_read_write_response(parse_read_write_request(request)->quantity, pdu).status();
    case function::read_fifo_queue: return parse_fifo_response(pdu).status();
    case function::encapsulated_interface:
        return parse_identification_response(*parse_identification_request(request), pdu).status();
    }
    return errc::bad_argument;
}

} // namespace servobus::modbus
