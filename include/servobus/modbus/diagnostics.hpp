// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs that ask how a device and its serial line are doing: functions 07, 08, 0B, 0C and 11h. Programs include it to
// build or parse these PDUs.
//
//     constexpr auto response = hex("0B FF FF 01 08");
//     static_assert(modbus::parse_event_counter(response)->count == 0x108);
//
// Return Query Data (08 with sub-function 0) also passes if an adapter returns the request itself as a local echo.
//
// Source: Modbus Application Protocol V1.1b3, sections 6.7 to 6.10 and 6.13.
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

/// Sub-functions of function 08. All others are reserved.
enum class diagnostic : std::uint16_t {
    return_query_data = 0x00,      ///< returns the request
    restart_communications = 0x01, ///< data FF00 also clears the event log
    diagnostic_register = 0x02,
    change_delimiter = 0x03, ///< of Modbus ASCII; the data is the character and a zero
    listen_only = 0x04,      ///< no response
    clear_counters = 0x0A,
    bus_messages = 0x0B,
    bus_communication_errors = 0x0C,
    bus_exceptions = 0x0D,
    server_messages = 0x0E,
    server_no_responses = 0x0F,
    server_negative_acknowledgements = 0x10,
    server_busy = 0x11,
    bus_character_overruns = 0x12,
    clear_overrun_counter = 0x14,
};

inline constexpr std::size_t max_query_data =
    (max_pdu - 3) / 2;                        ///< words that a Return Query Data request sends
inline constexpr std::size_t max_events = 64; ///< bytes of an event log

namespace detail {
// Not constexpr on purpose, as in pdu.hpp: the error of a constant request names the rule.
inline void a_request_without_data_is_of_function_07_0B_0C_or_11h() {}
inline void return_query_data_has_1_to_125_words() {}
inline void a_diagnostic_without_data_is_sub_function_02_0A_to_12_or_14h() {}

constexpr bool is_bare(function code) {
    return code == function::read_exception_status || code == function::get_event_counter ||
           code == function::get_event_log || code == function::report_server_id;
}
/// True for the sub-functions that read or clear a counter or a register, whose requests have the data 0000.
constexpr bool is_bare(diagnostic what) {
    const auto number = static_cast<std::uint16_t>(what);
    return number == 0x02 || (number >= 0x0A && number <= 0x12) || number == 0x14;
}
/// True if the standard allows this word as the data of a request.
constexpr bool may_have(diagnostic what, std::uint16_t data) {
    if (what == diagnostic::restart_communications) return data == 0 || data == 0xFF00;
    if (what == diagnostic::change_delimiter) return (data & 0xFFu) == 0;
    return data == 0;
}
} // namespace detail

/// Builds a request of function 07, 0B, 0C or 11h into `out`. Returns its length, 1; 0 for another function, or if
/// `out` is empty.
constexpr std::size_t put_bare_request(byte_buffer out, function code) {
    if (!detail::is_bare(code)) {
        detail::a_request_without_data_is_of_function_07_0B_0C_or_11h();
        return 0;
    }
    if (out.empty()) return 0;
    out[0] = static_cast<std::uint8_t>(code);
    return 1;
}

/// Parses a request of function 07, 0B, 0C or 11h. Returns the function.
/// Errors: `too_short` (empty), `wrong_function`, `too_long`.
constexpr result<function> parse_bare_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    const auto code = static_cast<function>(pdu[0]);
    if (!detail::is_bare(code)) return errc::wrong_function;
    if (pdu.size() > 1) return errc::too_long;
    return code;
}

/// Builds a Return Query Data request, function 08 with sub-function 0, and its response, which equals it, into `out`.
/// Returns its length, 3 + 2 * data.size(); 0 if there are not 1..125 words, or `out` is too small.
constexpr std::size_t put_return_query_data_request(byte_buffer out, slice<const std::uint16_t> data) {
    if (data.empty() || data.size() > max_query_data) {
        detail::return_query_data_has_1_to_125_words();
        return 0;
    }
    const std::size_t length = 3 + 2 * data.size();
    if (out.size() < length) return 0;
    out[0] = static_cast<std::uint8_t>(function::diagnostics);
    store_word(out, 1, static_cast<std::uint16_t>(diagnostic::return_query_data));
    for (std::size_t i = 0; i < data.size(); ++i) store_word(out, 3 + 2 * i, data[i]);
    return length;
}

/// Builds a request of function 08 that reads or clears a counter or the diagnostic register into `out`. Returns its
/// length, 5; 0 for another sub-function, or if `out` is too small. Sub-functions 01, 03 and 04 are not built, since
/// they change how a device communicates.
constexpr std::size_t put_diagnostic_request(byte_buffer out, diagnostic what) {
    if (!detail::is_bare(what)) {
        detail::a_diagnostic_without_data_is_sub_function_02_0A_to_12_or_14h();
        return 0;
    }
    if (out.size() < 5) return 0;
    put_trusted_request(out, function::diagnostics, static_cast<std::uint16_t>(what), 0);
    return 5;
}

/// A parsed request of function 08.
struct diagnostic_request {
    diagnostic what = diagnostic::return_query_data;
    words_view data{}; ///< one word, or 1..125 of a Return Query Data request
};

/// Parses a request of function 08.
/// Errors, in this order: `too_short` (empty), `wrong_function`, `too_short`, `wrong_function` (a reserved
/// sub-function), `too_long`, `wrong_byte_count` (Return Query Data of half a word), `wrong_value` (data that the
/// sub-function does not have).
constexpr result<diagnostic_request> parse_diagnostic_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    if (pdu[0] != static_cast<std::uint8_t>(function::diagnostics)) return errc::wrong_function;
    if (pdu.size() < 5) return errc::too_short;
    const diagnostic_request r{static_cast<diagnostic>(load_word(pdu, 1)), words_view{pdu.subspan(3)}};
    if (r.what == diagnostic::return_query_data) {
        if (pdu.size() > max_pdu) return errc::too_long;
        return pdu.size() % 2 != 0 ? result<diagnostic_request>{r} : errc::wrong_byte_count;
    }
    if (load_word(pdu, 1) > 0x04 && !detail::is_bare(r.what)) return errc::wrong_function;
    if (pdu.size() > 5) return errc::too_long;
    return detail::may_have(r.what, r.data[0]) ? result<diagnostic_request>{r} : errc::wrong_value;
}

/// Parses the response to a request of function 08. Returns its data: the request's own words, or what was read.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long`, `wrong_function` (another sub-function),
/// `wrong_value` (data that is not the request's), `unexpected_value` (to a request for listen-only mode, which has no
/// response).
constexpr result<words_view> parse_diagnostic_response(const diagnostic_request& request, bytes pdu) {
    const status head = detail::check_fixed(function::diagnostics, pdu, 3 + 2 * request.data.size());
    if (!head) return head;
    if (load_word(pdu, 1) != static_cast<std::uint16_t>(request.what)) return errc::wrong_function;
    if (request.what == diagnostic::listen_only) return errc::unexpected_value;
    const words_view data{pdu.subspan(3)};
    const auto number = static_cast<std::uint16_t>(request.what);
    const bool is_read = number == 0x02 || (number >= 0x0B && number <= 0x12);
    for (std::size_t i = 0; i < data.size() && !is_read; ++i) {
        if (data[i] != request.data[i]) return errc::wrong_value;
    }
    return data;
}

/// Parses a response of function 07. Returns the eight exception status outputs; the device defines them.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long`.
constexpr result<std::uint8_t> parse_exception_status(bytes pdu) {
    const status head = detail::check_fixed(function::read_exception_status, pdu, 2);
    if (!head) return head;
    return pdu[1];
}

/// A response of function 0Bh.
struct event_counter {
    bool is_busy = false;    ///< a program command is still being processed
    std::uint16_t count = 0; ///< messages completed; neither polls of this counter nor exceptions count
};

/// Parses a response of function 0Bh.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long`, `unexpected_value` (a status that is neither 0000
/// nor FFFF).
constexpr result<event_counter> parse_event_counter(bytes pdu) {
    const status head = detail::check_fixed(function::get_event_counter, pdu, 5);
    if (!head) return head;
    const std::uint16_t state = load_word(pdu, 1);
    if (state != 0 && state != 0xFFFF) return errc::unexpected_value;
    return event_counter{state != 0, load_word(pdu, 3)};
}

/// A response of function 0Ch.
struct event_log {
    bool is_busy = false; ///< a program command is still being processed
    std::uint16_t event_count = 0;
    std::uint16_t message_count = 0;
    bytes events{}; ///< 0..64, the newest first
};

/// Parses a response of function 0Ch. Errors: `too_short`, `exception`, `wrong_function`, `too_long` (an exception),
/// `wrong_byte_count` (not 6..70, or not the bytes that follow), `unexpected_value` (a status that is neither 0000 nor
/// FFFF).
constexpr result<event_log> parse_event_log(bytes pdu) {
    const status head = detail::check_counted(function::get_event_log, pdu, 6, 6 + max_events);
    if (!head) return head;
    const std::uint16_t state = load_word(pdu, 2);
    if (state != 0 && state != 0xFFFF) return errc::unexpected_value;
    return event_log{state != 0, load_word(pdu, 4), load_word(pdu, 6), pdu.subspan(8)};
}

/// Parses a response of function 11h. Returns the server's ID, its run indicator (00 off, FF on) and what else it
/// tells; the device defines how long each part is.
/// Errors: `too_short`, `exception`, `wrong_function`, `too_long` (an exception), `wrong_byte_count` (0, not the bytes
/// that follow, or more than a PDU has).
constexpr result<bytes> parse_server_id(bytes pdu) {
    const status head = detail::check_counted(function::report_server_id, pdu, 1, max_pdu - 2);
    if (!head) return head;
    return pdu.subspan(2);
}

/// A server's ID, and what else it tells.
struct server_id {
    bytes id{};
    bool is_running = false; ///< the run indicator
    bytes additional{};      ///< of the device's own; may be empty
};

/// The same in its parts, for a device whose ID has `id_size` bytes: most have one.
/// Errors: also `wrong_byte_count` (no place for a run indicator after the ID), `unexpected_value` (a run indicator
/// that is neither 00 nor FF).
constexpr result<server_id> parse_server_id(bytes pdu, std::size_t id_size) {
    const result<bytes> all = parse_server_id(pdu);
    if (!all) return all.status();
    if (all->size() <= id_size) return errc::wrong_byte_count;
    const std::uint8_t indicator = (*all)[id_size];
    if (indicator != 0 && indicator != 0xFF) return errc::unexpected_value;
    return server_id{all->first(id_size), indicator != 0, all->subspan(id_size + 1)};
}

} // namespace servobus::modbus
