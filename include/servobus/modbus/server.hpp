// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The device side of Modbus RTU: a server finds requests in received bytes and executes them on a register
// store. It does no I/O and has no clock. The simulated drives include it; programs include it to act as a
// Modbus device.
//
//     constexpr auto poll = [](auto& server, auto& uart, instant at, bytes arrived) { // `at` was read first
//         arrived.empty() ? server.elapse(at) : server.feed_late(arrived, uart.now());
//         const bytes frame = server.response(uart.now());
//         if (!frame.empty()) uart.send(frame), server.sent(uart.now());
//     };
//
// The checks have the order of the standard: function, quantity and byte count, address range, execution. A
// server sends no response to a frame with a bad CRC (unless its rules give an exception for it), to a frame
// of another address or to a broadcast.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/request_receiver.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::modbus {

/// The registers of a server. `read` and `write` return 0, or one of the device's exception numbers. A write
/// that returns an exception must not have changed any register.
template <class S>
concept register_store = requires(S& s, std::uint16_t address, slice<std::uint16_t> to, words_view from) {
    { s.read(address, to) } -> std::same_as<std::uint8_t>;
    { s.write(address, from) } -> std::same_as<std::uint8_t>;
};

/// Which requests a server executes, and its exception numbers for the others.
struct server_rules {
    std::uint16_t max_read = modbus::max_read;   ///< registers in one read
    std::uint16_t max_write = modbus::max_write; ///< registers in one write
    bool reads_input_registers = false;          ///< function 04 reads the same registers as 03
    std::uint8_t illegal_function = 1;
    std::uint8_t illegal_address = 2;
    std::uint8_t illegal_value = 3;
    std::uint8_t bad_crc = 0;       ///< exception number for a frame with a bad CRC; 0: no response
    bool echoes_byte_count = false; ///< the response to 10h has the byte count in place of the quantity
    std::uint8_t leading_bytes = 4; ///< bytes 00 or FF after a gap that are skipped before a frame
};

/// The rules for a store: the result of its member `rules()` if it has one, otherwise the standard's.
template <register_store Store> constexpr server_rules rules_of(const Store& store) {
    if constexpr (requires { store.rules(); }) {
        return store.rules();
    } else {
        return {};
    }
}

/// Executes a request PDU on a store and builds the response PDU in `out` (at least 253 bytes). Returns the
/// length of the response. `pdu` must not share memory with `out`.
template <register_store Store>
constexpr std::size_t respond(Store& store, bytes pdu, byte_buffer out, const server_rules& rules) {
    const std::uint8_t code = pdu.empty() ? std::uint8_t{0} : pdu[0];
    const bool is_known = code == 0x03 || is_write(code) || (code == 0x04 && rules.reads_input_registers);
    if (!is_known) return put_exception(out, code, rules.illegal_function);
    const result<request> r = parse_request(pdu);
    if (!r) {
        return put_exception(out, code,
                             r.error() == errc::wrong_address ? rules.illegal_address : rules.illegal_value);
    }
    if (r->quantity > (is_read(code) ? rules.max_read : rules.max_write))
        return put_exception(out, code, rules.illegal_value);
    if (is_write(code)) {
        const std::uint8_t refusal = store.write(r->address, r->values());
        if (refusal != 0) return put_exception(out, code, refusal);
        for (std::size_t i = 0; i < 5; ++i) out[i] = pdu[i];
        if (rules.echoes_byte_count && code == 0x10)
            store_word(out, 3, static_cast<std::uint16_t>(2 * r->quantity));
        return 5;
    }
    std::uint16_t words[modbus::max_read]{};
    const slice<std::uint16_t> wanted = slice<std::uint16_t>{words}.first(r->quantity);
    const std::uint8_t refusal = store.read(r->address, wanted);
    if (refusal != 0) return put_exception(out, code, refusal);
    out[0] = code;
    out[1] = static_cast<std::uint8_t>(2 * wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) store_word(out, 2 + 2 * i, wanted[i]);
    return 2 + 2 * wanted.size();
}

/// A server at one address with a store of registers. request_receiver describes which frames it executes, how it is
/// fed with bytes and times, and when its response is sent.
template <register_store Store> class server : public request_receiver<server<Store>> {
    using receiver = request_receiver<server<Store>>;

  public:
    constexpr server(std::uint8_t node_address, Store& store, rtu_timing timing)
        : server{node_address, store, timing, rules_of(store)} {}
    constexpr server(std::uint8_t node_address, Store& store, rtu_timing timing, server_rules rules)
        : receiver{node_address, timing, rules.leading_bytes, rules.bad_crc}, store_{&store}, rules_{rules} {}

  private:
    friend receiver;

    static constexpr bool is_executed(std::uint8_t code) { return is_read(code) || is_write(code); }
    constexpr std::size_t execute(bytes frame, byte_buffer pdu) {
        // A broadcast read has no response and no effect.
        if (frame[0] == broadcast && !is_write(frame[1])) return 0;
        return respond(*store_, frame.subspan(1, frame.size() - 3), pdu, rules_);
    }

    Store* store_;
    server_rules rules_;
};

} // namespace servobus::modbus
