// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// `transact` with a rule, for responses whose length no request tells: identification, server ID, functions of a
// device's own. The line has `modbus::open_lengths`. Programs include it that send such requests.
//
//     line<my_uart, counters, unechoed, modbus::open_lengths> wire{uart, modbus::timing_at(19200)};
//     client io{wire, node<tank::device>{9}};
//     std::uint8_t room[64]{};
//     const auto who = io.transact(hex("11"), room, modbus::length_rule::of_function()); // the server ID
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/raw_client.hpp>
#include <servobus/modbus/response_lengths.hpp>

namespace servobus::detail {

template <class Line, device_class Device, class Node> struct open_responses<raw_client<Line, Device, Node>> {
    using own = raw_client<Line, Device, Node>;

    template <class Rule>
    static constexpr result<bytes> transact(own& of, bytes pdu, byte_buffer response_pdu, const Rule& rule) {
        static_assert(Line::lengths::are_open,
                      "this line has responses of known lengths only: make it with modbus::open_lengths");
        constexpr std::size_t longest_pdu = Line::longest_frame - 3;
        if (!of.node_.is_valid() || pdu.empty() || pdu.size() > longest_pdu || response_pdu.empty())
            return errc::bad_argument;
        std::uint8_t request[modbus::max_frame]{};
        std::uint8_t response[modbus::max_frame]{};
        request[0] = of.node_.address;
        for (std::size_t i = 0; i < pdu.size(); ++i) request[i + 1] = pdu[i];
        const bytes sent = bytes{request}.first(modbus::close_frame<typename Line::crc>(request, pdu.size()));
        // Where the request tells the length, no rule is needed.
        if (const u16 expected = modbus::expected_response(sent); expected != modbus::any_length) {
            if (expected == 0 || response_pdu.size() + 3 < expected) return errc::bad_argument;
            const byte_buffer whole = response_pdu.first(expected - 3u);
            const status why = of.transact(pdu, whole);
            return why ? result<bytes>{bytes{whole}} : why;
        }
        // An exception has two bytes.
        const std::size_t asked = response_pdu.size() < 2 ? std::size_t{2} : response_pdu.size();
        const std::size_t most = asked < longest_pdu ? asked : longest_pdu;
        typename own::template exchange_for<false, true> x{sent,
                                                           byte_buffer{response}.first(most + 3),
                                                           rule,
                                                           of.line_->timing(),
                                                           of.node_.limits,
                                                           of.node_.priority};
        if (x.response_size() == 0) return errc::bad_argument;
        status why = of.run(x);
        if (why.was_sent() && !modbus::only_reads(pdu)) {
            of.invalidate(of.all());
            if constexpr (own::link_type::may_have_facade) of.note_change();
        }
        const std::size_t size = length_of(of, x);
        request_machine call = request_machine::transaction();
        (void)call.goes_on(why, of.node_, same_bytes(bytes{response}.first(size), sent),
                           of.line_->is_echo_ruled_out(of.node_.address));
        if (why && size - 3 > response_pdu.size()) why = status::sent(errc::too_long);
        if (!why) return why;
        for (std::size_t i = 0; i < size - 3; ++i) response_pdu[i] = response[i + 1];
        return bytes{response_pdu}.first(size - 3);
    }

  private:
    template <class X> static constexpr std::size_t length_of(const own& of, const X& x) {
        if constexpr (Line::is_small)
            return of.line_->response_size();
        else
            return x.response_size();
    }
};

} // namespace servobus::detail
