// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The calls of a client beyond holding registers: rows of the other tables, and functions 16h and 17h. The code is by
// address and quantity, one copy for each type of client; the rows stay in client/client.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/raw_client.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/registers/table_readings.hpp>

namespace servobus::detail {

template <class Line, device_class Device, class Node>
class table_client : public raw_client<Line, Device, Node> {
    using raw = raw_client<Line, Device, Node>;
    using typename raw::crc;

  protected:
    using raw::line_;
    using raw::node_;

    constexpr table_client(Line& on, Node at) : raw{on, at} {}

    /// One request with retries. `response` is as long as the whole response.
    [[gnu::noinline]] constexpr status read_part(const table_extent& part, byte_buffer response) {
        if (!node_.is_valid()) return errc::bad_argument;
        modbus::frame<8> request;
        request.data[0] = node_.address;
        modbus::put_trusted_request(byte_buffer{request.data}.subspan(1),
                                    static_cast<modbus::function>(part.code()), part.address, part.quantity);
        (void)modbus::close_trusted<crc>(request.data, 5);
        status why;
        request_machine call = request_machine::read();
        do why = raw::carried(bytes{request.data, 8}, response);
        while (call.goes_on(why, node_, false, false));
        return why;
    }

    /// Reads rows of any tables. If one request fails there is no value at all.
    template <class Values> constexpr result<Values> read_tables() {
        constexpr const auto& plan = Values::plan;
        result<Values> values{status{}};
        word_order order = Values::has_pairs ? raw::current_word_order() : word_order::high_first;
        status why{order == word_order::unknown ? errc::needs_word_order : errc::ok};
        std::uint8_t frame[plan.longest_response];
        for (std::size_t i = 0; i < plan.count && why.error() == errc::ok; ++i) {
            const table_extent& part = plan.requests[i];
            const byte_buffer response = byte_buffer{frame}.first(part.response_size());
            why = read_part(part, response);
            if (why.error() != errc::ok) break;
            if (!values->take(i, bytes{response}.subspan(3, part.size())))
                why = status::sent(errc::unexpected_value);
            if constexpr (raw::loses_word_order && Values::has_pairs) { // an attempt had no response
                const word_order now = raw::current_word_order();
                if (!raw::is_one_order(i, order, now) || now == word_order::unknown)
                    why = errc::needs_word_order;
                order = now;
            }
        }
        values->set_word_order(order);
        if (why.error() != errc::ok) {
            values->clear();
            values.fail(why);
        }
        return values;
    }

    /// Writes one coil, function 05. The response repeats the request: where it may be an echo, the coil is read.
    template <bool IsBroadcast = false>
    [[gnu::noinline]] constexpr status write_coil(u16 address, bool is_on) {
        if (!IsBroadcast && !node_.is_valid()) return errc::bad_argument;
        std::uint8_t frame[8];
        frame[0] = IsBroadcast ? modbus::broadcast : node_.address;
        modbus::put_trusted_request(byte_buffer{frame}.subspan(1), modbus::function::write_single_coil,
                                    address, is_on ? modbus::coil_on : modbus::coil_off);
        (void)modbus::close_trusted<crc>(frame, 5);
        const status why = raw::template carried<IsBroadcast>(frame, frame, true);
        return IsBroadcast ? why : rules_out_echo<modbus::function::read_coils>(why, address);
    }
    /// Writes adjacent coils, function 0Fh, whose packed bits lie in `frame` from its byte 7 on.
    [[gnu::noinline]] constexpr status write_coils(byte_buffer frame, u16 address, u16 count) {
        if (!node_.is_valid()) return errc::bad_argument;
        frame[0] = node_.address;
        modbus::put_trusted_request(frame.subspan(1), modbus::function::write_multiple_coils, address, count);
        frame[6] = static_cast<std::uint8_t>(frame.size() - 9);
        (void)modbus::close_trusted<crc>(frame, frame.size() - 3);
        return raw::carried(frame, frame.first(8));
    }

    /// Changes some bits of a register, function 16h.
    [[gnu::noinline]] constexpr status write_masked(u16 address, u16 and_mask, u16 or_mask) {
        if (!node_.is_valid()) return errc::bad_argument;
        std::uint8_t frame[10];
        frame[0] = node_.address;
        modbus::put_trusted_request(byte_buffer{frame}.subspan(1), modbus::function::mask_write_register,
                                    address, and_mask);
        store_word(frame, 6, or_mask);
        (void)modbus::close_trusted<crc>(frame, 7);
        const status why = raw::template carried_as<modbus::function::mask_write_register>(frame, frame);
        return rules_out_echo<modbus::function::read_holding_registers>(why, address);
    }

    /// Writes and then reads registers, function 17h. The values to write lie in `request` from its byte 11 on.
    [[gnu::noinline]] constexpr status write_and_read(byte_buffer request, u16 write_address, extent read,
                                                      byte_buffer response) {
        if (!node_.is_valid()) return errc::bad_argument;
        const std::size_t written = request.size() - 13; // bytes
        request[0] = node_.address;
        modbus::put_trusted_request(request.subspan(1), modbus::function::read_write_registers, read.address,
                                    read.words);
        store_word(request, 6, write_address);
        store_word(request, 8, static_cast<u16>(written / 2));
        request[10] = static_cast<std::uint8_t>(written);
        (void)modbus::close_trusted<crc>(request, request.size() - 3);
        return raw::template carried_as<modbus::function::read_write_registers>(request, response);
    }

  private:
    template <modbus::function Asks> constexpr status rules_out_echo(status why, u16 address) {
        request_machine call = request_machine::write();
        const bool goes_on = call.goes_on(why, node_, true, line_->is_echo_ruled_out());
        return goes_on ? status::sent(raw::template ask<false, Asks>(address)) : why;
    }
};

} // namespace servobus::detail
