// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Modbus protocol data units (PDU): builds and parses the requests and responses of functions 03, 04, 06 and
// 10h, at compile time or at run time. modbus/rtu.hpp and the server include it; programs include it to parse
// or build PDUs themselves. modbus/functions.hpp has the other functions.
//
//     static_assert(modbus::parse_request(hex("03 20 A1 00 01"))->address == 0x20A1);
//
// Source: Modbus Application Protocol V1.1b3, sections 6.3, 6.4, 6.6, 6.12 and 7.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/slice.hpp>

namespace servobus::modbus {

/// Function codes of the standard. This header has the PDUs of 03, 04, 06 and 10h, modbus/functions.hpp includes those
/// of the others.
enum class function : std::uint8_t {
    read_coils = 0x01,
    read_discrete_inputs = 0x02,
    read_holding_registers = 0x03,
    read_input_registers = 0x04,
    write_single_coil = 0x05,
    write_single_register = 0x06,
    read_exception_status = 0x07,
    diagnostics = 0x08,
    get_event_counter = 0x0B,
    get_event_log = 0x0C,
    write_multiple_coils = 0x0F,
    write_multiple_registers = 0x10,
    report_server_id = 0x11,
    mask_write_register = 0x16,
    read_write_registers = 0x17,
    read_fifo_queue = 0x18,
    encapsulated_interface = 0x2B, ///< with MEI type 0Eh: read device identification
};

/// Exception codes of the standard. Devices may use other numbers (`profile::exceptions`).
enum class exception : std::uint8_t {
    illegal_function = 1,
    illegal_data_address = 2,
    illegal_data_value = 3,
    server_device_failure = 4,
    acknowledge = 5,
    server_device_busy = 6,
    gateway_path_unavailable = 0x0A,
    gateway_target_failed_to_respond = 0x0B,
};

/// True for the two exceptions that a gateway makes in a node's place (Modbus Application Protocol V1.1b3, 7). In a
/// frame of the node itself these numbers mean what the device says.
constexpr bool is_of_gateway(std::uint8_t number) { return (number | 1) == 0x0B; }

/// The address of the device at the other end of a Modbus TCP connection (Modbus Messaging on TCP/IP Implementation
/// Guide V1.0b, 4.4.2). On a serial line it is reserved.
inline constexpr std::uint8_t peer_address = 255;

inline constexpr std::uint8_t exception_flag = 0x80; ///< set in the function code of an exception response
inline constexpr std::size_t max_pdu = 253;          ///< bytes
inline constexpr std::uint16_t max_read = 125;       ///< registers in a read
inline constexpr std::uint16_t max_write = 123;      ///< registers in a multiple write

constexpr bool is_read(std::uint8_t code) { return code == 0x03 || code == 0x04; }
constexpr bool is_write(std::uint8_t code) { return code == 0x06 || code == 0x10; }

/// True if registers `address` .. `address + quantity - 1` exist in the 16-bit address space.
constexpr bool fits_address_space(std::uint16_t address, std::uint16_t quantity) {
    return std::uint32_t{address} + quantity <= 0x1'0000u;
}

namespace detail {
// Not constexpr on purpose: a constant request that breaks a rule does not compile, and the error names the
// rule.
inline void a_read_asks_for_1_to_125_registers_inside_the_address_space() {}
inline void a_write_has_1_to_123_registers_inside_the_address_space() {}
} // namespace detail

namespace detail {
constexpr bool is_readable(function code, std::uint16_t address, std::uint16_t quantity) {
    const bool is = is_read(static_cast<std::uint8_t>(code)) && quantity >= 1 && quantity <= max_read &&
                    fits_address_space(address, quantity);
    if (!is) a_read_asks_for_1_to_125_registers_inside_the_address_space();
    return is;
}
} // namespace detail

/// The first five bytes of a request that needs no check: its function, an address, and a quantity (03, 04, 10h) or a
/// value (06). `out` has room for them.
constexpr void put_trusted_request(byte_buffer out, function code, std::uint16_t address,
                                   std::uint16_t quantity_or_value) {
    out[0] = static_cast<std::uint8_t>(code);
    store_word(out, 1, address);
    store_word(out, 3, quantity_or_value);
}

/// Builds a request of function 03 or 04 into `out`. Returns its length, 5; 0 for another function, if
/// `quantity` is not 1..125, the registers do not fit the address space, or `out` is too small.
constexpr std::size_t put_read_request(byte_buffer out, function code, std::uint16_t address,
                                       std::uint16_t quantity) {
    if (!detail::is_readable(code, address, quantity) || out.size() < 5) return 0;
    put_trusted_request(out, code, address, quantity);
    return 5;
}

/// Builds a request of function 06 into `out`. Returns its length, 5; 0 if `out` is too small.
constexpr std::size_t put_write_request(byte_buffer out, std::uint16_t address, std::uint16_t value) {
    if (out.size() < 5) return 0;
    put_trusted_request(out, function::write_single_register, address, value);
    return 5;
}

/// Builds a request of function 10h into `out`. Returns its length, 6 + 2 * values.size(); 0 if there are not
/// 1..123 values, the registers do not fit the address space, or `out` is too small.
constexpr std::size_t put_write_request(byte_buffer out, std::uint16_t address,
                                        slice<const std::uint16_t> values) {
    if (values.empty() || values.size() > max_write ||
        !fits_address_space(address, static_cast<std::uint16_t>(values.size()))) {
        detail::a_write_has_1_to_123_registers_inside_the_address_space();
        return 0;
    }
    const std::size_t size = 6 + 2 * values.size();
    if (out.size() < size) return 0;
    out[0] = static_cast<std::uint8_t>(function::write_multiple_registers);
    store_word(out, 1, address);
    store_word(out, 3, static_cast<std::uint16_t>(values.size()));
    out[5] = static_cast<std::uint8_t>(2 * values.size());
    for (std::size_t i = 0; i < values.size(); ++i) store_word(out, 6 + 2 * i, values[i]);
    return size;
}

/// Builds an exception response into `out`. Returns its length, 2; 0 if `out` is too small.
constexpr std::size_t put_exception(byte_buffer out, std::uint8_t code, std::uint8_t number) {
    if (out.size() < 2) return 0;
    out[0] = static_cast<std::uint8_t>(code | exception_flag);
    out[1] = number;
    return 2;
}

/// A parsed request. `payload` holds the raw words of a write (06: one, 10h: `quantity`).
struct request {
    std::uint8_t code = 0;
    std::uint16_t address = 0;
    std::uint16_t quantity = 0;
    bytes payload{};

    constexpr words_view values() const { return words_view{payload}; }
};

/// Parses a request PDU.
/// Errors: `too_short`, `too_long`, `wrong_function` (none of 03, 04, 06, 10h), `wrong_quantity` (not within
/// 1..125 for a read, 1..123 for a write), `wrong_byte_count` (10h: not 2 * quantity, or not the bytes that
/// follow), `wrong_address` (the registers do not fit the address space).
constexpr result<request> parse_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    const std::uint8_t code = pdu[0];
    if (!is_read(code) && !is_write(code)) return errc::wrong_function;
    if (pdu.size() < 5) return errc::too_short;
    request r{.code = code, .address = load_word(pdu, 1)};
    if (code == 0x06) {
        if (pdu.size() > 5) return errc::too_long;
        r.quantity = 1;
        r.payload = pdu.subspan(3, 2);
        return r;
    }
    r.quantity = load_word(pdu, 3);
    if (code == 0x10) {
        if (pdu.size() < 6) return errc::too_short;
        if (pdu[5] != pdu.size() - 6) return errc::wrong_byte_count;
        if (r.quantity == 0 || r.quantity > max_write) return errc::wrong_quantity;
        if (pdu[5] != 2 * r.quantity) return errc::wrong_byte_count;
        r.payload = pdu.subspan(6);
    } else {
        if (pdu.size() > 5) return errc::too_long;
        if (r.quantity == 0 || r.quantity > max_read) return errc::wrong_quantity;
    }
    if (!fits_address_space(r.address, r.quantity)) return errc::wrong_address;
    return r;
}

/// A response, parsed without its request. An acknowledgement of 06 has the value in `payload`; one of 10h
/// has the quantity. A read response has its words in `payload` and no address.
struct response {
    std::uint8_t code = 0; ///< without the exception flag
    std::uint16_t address = 0;
    std::uint16_t quantity = 0;
    std::uint8_t exception = 0; ///< meaningful if `is_exception`
    bool is_exception = false;
    bytes payload{};

    constexpr words_view values() const { return words_view{payload}; }
};

/// Parses a response PDU without its request.
/// Errors: `too_short`, `too_long`, `wrong_function`, `wrong_byte_count` (a read's count is zero, odd, above
/// 250 or not the bytes that follow), `wrong_quantity` (10h: not 1..123), `wrong_address` (10h: the registers
/// do not fit the address space).
constexpr result<response> parse_response(bytes pdu) {
    if (pdu.size() < 2) return errc::too_short;
    response r{.code = static_cast<std::uint8_t>(pdu[0] & ~exception_flag & 0xFF)};
    if ((pdu[0] & exception_flag) != 0) {
        if (pdu.size() > 2) return errc::too_long;
        r.is_exception = true;
        r.exception = pdu[1];
        return r;
    }
    if (is_read(r.code)) {
        if (pdu[1] != pdu.size() - 2 || pdu[1] == 0 || pdu[1] % 2 != 0 || pdu[1] > 2 * max_read)
            return errc::wrong_byte_count;
        r.quantity = pdu[1] / 2;
        r.payload = pdu.subspan(2);
        return r;
    }
    if (!is_write(r.code)) return errc::wrong_function;
    if (pdu.size() < 5) return errc::too_short;
    if (pdu.size() > 5) return errc::too_long;
    r.address = load_word(pdu, 1);
    if (r.code == 0x06) {
        r.quantity = 1;
        r.payload = pdu.subspan(3, 2);
    } else {
        r.quantity = load_word(pdu, 3);
        if (r.quantity == 0 || r.quantity > max_write) return errc::wrong_quantity;
        if (!fits_address_space(r.address, r.quantity)) return errc::wrong_address;
    }
    return r;
}

} // namespace servobus::modbus
