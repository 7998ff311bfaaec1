// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Blocking access to the registers of one node by their addresses, for registers without a row, and any
// other PDU. It is the base of a client, which has these calls too; there is one copy of each in the
// program, however many registers it uses. client/client.hpp includes it.
//
//     std::uint16_t words[4]{};
//     if (!servo.read_words(0x0B00, words)) return 1;
//     if (!servo.write_word(0x0D01, 1)) return 1; // P0D-01: reset the alarm
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/client/detail/node_link.hpp>
#include <servobus/client/node.hpp>
#include <servobus/client/ram_only.hpp>
#include <servobus/client/request_machine.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/small_core.hpp>
#include <servobus/line/line.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
template <class Client> struct open_responses {
    static_assert(sizeof(Client) == 0,
                  "for responses as long as a rule says include servobus/client/open_responses.hpp");
};
} // namespace detail

/// The calls of a `client` that need no rows; no program makes one. Every call returns within `line::bound` for each
/// request that it makes; reads are retried, writes never.
template <class Line, device_class Device, class Node>
class raw_client : protected detail::node_link<Line, Device, Node> {
    using link = detail::node_link<Line, Device, Node>;
    friend struct detail::open_responses<raw_client>;

  public:
    using link::line;
    using link::node;
    using typename link::line_type;
    using link_type = link;
    /// The base of the client, for stepped calls; only they have a key.
    constexpr link& link_for(detail::stepped_key) { return *this; }

    /// Reads `words.size()` raw registers from `address` on, function 03 or 04; for what a map does not have.
    /// A failure leaves `words` as it was.
    /// Errors: `bad_argument` (the node's address, or more registers than one response has), the
    /// transport's, the response's, `exception`.
    constexpr status read_words(u16 address, slice<u16> words,
                                modbus::function code = modbus::function::read_holding_registers) {
        if (words.empty() || words.size() > Device::facts.max_read) return errc::bad_argument;
        std::uint8_t frame[modbus::max_frame];
        return read_some(frame, address, words, code);
    }

    /// The same for an array, with a buffer of its size in place of one for the longest frame.
    template <std::size_t N>
    requires(N <= Device::facts.max_read) constexpr status
        read_words(u16 address, u16 (&words)[N],
                   modbus::function code = modbus::function::read_holding_registers) {
        return read_array<N>(address, slice<u16>{words, N}, code);
    }
    template <template <class, std::size_t> class Array, std::size_t N>
    requires(N >= 1 && N <= Device::facts.max_read) // the N of a std::span may be "any"
        constexpr status read_words(u16 address, Array<u16, N>& words,
                                    modbus::function code = modbus::function::read_holding_registers) {
        return read_array<N>(address, slice<u16>{words.data(), N}, code);
    }

    /// Writes one raw register, function 06.
    constexpr status write_word(u16 address, u16 value) {
        return link::written(address, 1, write_one(address, value));
    }
    /// A bool and a character are no numbers: they do not compile.
    template <class N>
    requires detail::is_bool_or_character<N>
    constexpr status write_word(u16, N) {
        check_count<N>();
        return {};
    }

    /// Writes raw adjacent registers, function 10h.
    constexpr status write_words(u16 address, slice<const u16> words) {
        if (words.empty() || words.size() > Device::facts.max_write ||
            !modbus::fits_address_space(address, static_cast<u16>(words.size())))
            return errc::bad_argument;
        std::uint8_t frame[modbus::max_frame];
        const byte_buffer part = byte_buffer{frame}.first(9 + 2 * words.size());
        return link::written(address, words.size(), write_words_in(part, address, words));
    }

    /// The same for an array, with a buffer of its size in place of one for the longest frame.
    template <std::size_t N>
    requires(N <= Device::facts.max_write) constexpr status write_words(u16 address, const u16 (&words)[N]) {
        return write_array<N>(address, slice<const u16>{words, N});
    }
    template <template <class, std::size_t> class Array, std::size_t N>
    requires(N >= 1 && N <= Device::facts.max_write) constexpr status
        write_words(u16 address, const Array<u16, N>& words) {
        return write_array<N>(address, slice<const u16>{words.data(), N});
    }

    /// Sends any PDU; the response's PDU must fill `response_pdu` exactly, or be an exception. Never retried.
    /// A response of one byte is the function alone.
    /// Errors: as `read_words`, and `bad_argument` for an empty PDU, one that is too long, or no room for a
    /// response. On a `blocking_line`, whose frames have at most 255 bytes, a PDU has at most 252.
    constexpr status transact(bytes pdu, byte_buffer response_pdu) {
        constexpr std::size_t longest_pdu = Line::longest_frame - 3;
        if (!node_.is_valid() || pdu.empty() || pdu.size() > longest_pdu || response_pdu.empty() ||
            response_pdu.size() > longest_pdu)
            return errc::bad_argument;
        std::uint8_t request[modbus::max_frame]{};
        std::uint8_t response[modbus::max_frame]{};
        request[0] = node_.address;
        for (std::size_t i = 0; i < pdu.size(); ++i) request[i + 1] = pdu[i];
        const std::size_t size = modbus::close_frame<crc>(request, pdu.size());
        const bytes sent = bytes{request}.first(size);
        const byte_buffer room = byte_buffer{response}.first(response_pdu.size() + 3);
        const u16 expected = modbus::expected_response(sent);
        if (expected != modbus::any_length && expected != room.size()) return errc::bad_argument;
        const std::size_t with_exception = room.size() < 5 ? std::size_t{5} : room.size();
        exchange_for<false, true> x{sent, byte_buffer{response}.first(with_exception), line_->timing(),
                                    node_.limits, node_.priority};
        if (room.size() < with_exception) x.expect_function_alone();
        if (x.response_size() != room.size()) return errc::bad_argument;
        request_machine call = request_machine::transaction();
        status why = run(x);
        if (why.was_sent() && !modbus::only_reads(pdu)) { // any register may be written
            link::invalidate(link::all());
            if constexpr (link::may_have_facade) link::note_change();
        }
        if (why && modbus::is_return_query_data(sent) && !same_bytes(room, sent))
            why = status::sent(errc::wrong_value);
        (void)call.goes_on(why, node_, same_bytes(room, sent), line_->is_echo_ruled_out(node_.address));
        if (!why) return why;
        for (std::size_t i = 0; i < response_pdu.size(); ++i) response_pdu[i] = room[i + 1];
        return why;
    }

    /// Sends any PDU, whose response is as long as `rule` says (client/open_responses.hpp) where the function does not.
    /// Never retried. Returns the response's PDU, which lies in `response_pdu`.
    /// Errors: as of the other `transact`; `too_long` if `response_pdu` has too little room; `bad_argument` for a rule
    /// that is none.
    template <class Rule>
    constexpr result<bytes> transact(bytes pdu, byte_buffer response_pdu, const Rule& rule) {
        return detail::open_responses<raw_client>::transact(*this, pdu, response_pdu, rule);
    }

  protected:
    using link::line_;
    using link::loses_word_order;
    using link::node_;
    using typename link::crc;

    constexpr raw_client(Line& on, Node at) : link{on, at} {
        if constexpr (requires { Node::is_peer; })
            static_assert(has_gateway<typename Line::port_type>, "a peer_node is for a line on Modbus TCP");
    }

    /// Reads with retries. `frame` has room for the response.
    constexpr status read_some(byte_buffer frame, u16 address, slice<u16> words,
                               modbus::function code = modbus::function::read_holding_registers) {
        const modbus::frame<8> request =
            modbus::read_frame<crc>(node_.address, address, static_cast<u16>(words.size()), code);
        if (!node_.is_valid() || request.size == 0) return errc::bad_argument;
        return read_by(request, frame, words);
    }

    /// Reads with retries, by a request that is made already. Inline: nearly all arguments are constants.
    [[gnu::always_inline]] constexpr status read_by(bytes request, byte_buffer frame, slice<u16> words) {
        status why;
        const byte_buffer response = frame.first(5 + 2 * words.size());
        request_machine call = request_machine::read();
        do {
            why = carried(request, response);
            if (why.error() == errc::ok) words_view{bytes{response}.subspan(3)}.copy_to(words);
        } while (call.goes_on(why, node_, false, false));
        return why;
    }

    /// Writes one register. `AsksFirst`: an echo must be ruled out before the write leaves, not after it.
    template <bool IsBroadcast = false, bool AsksFirst = false>
    constexpr status write_one(u16 address, u16 value, const typename link::condition& on = {}) {
        if constexpr (Device::facts.refuses_function_06()) {
            std::uint8_t frame[11];
            store_word(frame, 7, value);
            return write_many<IsBroadcast, AsksFirst>(frame, address, on);
        }
        modbus::frame<8> f =
            modbus::write_frame<crc>(IsBroadcast ? modbus::broadcast : node_.address, address, value);
        return write_framed<IsBroadcast, AsksFirst>(f.data, address, true, on);
    }

    /// Writes registers whose words are in `frame` already.
    template <bool IsBroadcast = false, bool AsksFirst = false>
    [[gnu::noinline]] constexpr status write_many(byte_buffer frame, u16 address,
                                                  const typename link::condition& on = {}) {
        link::complete_block(IsBroadcast ? modbus::broadcast : node_.address, frame, address);
        return write_framed<IsBroadcast, AsksFirst>(frame, address, false, on);
    }
    /// Called after the read of the switch, since a lost attempt of that read begins an epoch.
    constexpr servobus::ram_only new_token() { return {node_.address, line_->epoch(node_.address)}; }

  private:
    template <std::size_t N>
    constexpr status read_array(u16 address, slice<u16> words, modbus::function code) {
        std::uint8_t frame[5 + 2 * N];
        return read_some(frame, address, words, code);
    }
    template <std::size_t N> constexpr status write_array(u16 address, slice<const u16> words) {
        if (!modbus::fits_address_space(address, N)) return errc::bad_argument;
        std::uint8_t frame[9 + 2 * N];
        return link::written(address, N, write_words_in(frame, address, words));
    }
    constexpr status write_words_in(byte_buffer frame, u16 address, slice<const u16> words) {
        for (std::size_t i = 0; i < words.size(); ++i) store_word(frame, 7 + 2 * i, words[i]);
        return write_many(frame, address);
    }

    template <bool IsBroadcast, bool IsAnyFunction = false>
    using exchange_for =
        typename Line::template exchange_for<std::remove_cvref_t<decltype(Node::limits)>, IsBroadcast,
                                             IsAnyFunction, std::remove_cvref_t<decltype(Node::priority)>>;
    using exchange = exchange_for<false>;

  protected:
    // Unchecked, since request and response are made here.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr status carried(bytes request, byte_buffer response,
                                                    [[maybe_unused]] bool is_single = false) {
        if constexpr (Line::is_small) {
            return run<IsBroadcast>(exchange_for<IsBroadcast>::trusted(request, response, node_.limits,
                                                                       is_single, node_.priority));
        } else if constexpr (is_fixed<Node>) {
            return errc::bad_argument; // the assertion of the client is the only error
        } else {
            constexpr bool is_host = !detail::is_small_core;
            if constexpr (is_host)
                return run<IsBroadcast>(
                    exchange::trusted(request, response, line_->timing(), node_.limits, node_.priority));
            return carried_once(request.data(), response.data(),
                                static_cast<std::uint32_t>(request.size()) |
                                    static_cast<std::uint32_t>(response.size()) << 16);
        }
    }

    /// The same for function 17h, whose response is judged as that to function 03.
    constexpr status carried_both(bytes request, byte_buffer response) {
        if constexpr (Line::is_small) {
            return run(
                exchange_for<false, true>::trusted(request, response, node_.limits, false, node_.priority));
        } else {
            exchange x = exchange::trusted(request, response, line_->timing(), node_.limits, node_.priority);
            x.judge_like(modbus::like(request[1]));
            return run(x);
        }
    }

  private:
    // One copy on a small core, with both sizes in one register.
    [[gnu::noinline]] constexpr status carried_once(const std::uint8_t* request, std::uint8_t* response,
                                                    std::uint32_t sizes) {
        const bytes sent{request, static_cast<std::size_t>(sizes & 0xFFFFu)};
        const byte_buffer room{response, static_cast<std::size_t>(sizes >> 16)};
        return run(exchange::trusted(sent, room, line_->timing(), node_.limits, node_.priority));
    }

    // A line counts the requests without a valid response. A blocking line is told of them here, so that a
    // program that learns nothing of its nodes has no code for it.
    template <bool IsBroadcast = false, class X> [[gnu::always_inline]] constexpr status run(X&& x) {
        if constexpr (Line::is_small) {
            const status w = line_->run(x, node_.gaps);
            if constexpr (link::learns && !IsBroadcast) {
                if (w.was_sent() && !w.has_response()) line_->begin_epoch(node_.address);
            }
            return w;
        } else {
            line_->run(x, node_.gaps);
            return x.status();
        }
    }

    // A write, and the reads that rule out an echo. `is_single`: it has function 06.
    template <bool IsBroadcast, bool AsksFirst>
    [[gnu::always_inline]] constexpr status write_framed(byte_buffer frame, u16 address, bool is_single,
                                                         const typename link::condition& on) {
        if (!IsBroadcast && !node_.is_valid()) return errc::bad_argument;
        if (AsksFirst && !line_->is_echo_ruled_out(node_.address)) {
            if (const errc no = ask<true>(address); no != errc::ok) return no;
        }
        if (const errc no = link::refusal(on); no != errc::ok) return no;
        link::template invalidate<IsBroadcast>(link::invalidated_by(frame));
        status why = carried<IsBroadcast>(frame, frame.first(8), is_single); // its response's memory too
        request_machine call = request_machine::write();
        const bool goes_on =
            !IsBroadcast && call.goes_on(why, node_, is_single, line_->is_echo_ruled_out(node_.address));
        return goes_on ? status::sent(ask<false>(address)) : why;
    }

  protected:
    // The reads before a write, or after it. Neither a response nor an exception is an echo, whatever the value. The
    // error is that of the write, sent or not, so that a small core returns one byte.
    template <bool IsFirst, modbus::function Code = modbus::function::read_holding_registers>
    [[gnu::cold, gnu::noinline]] constexpr errc ask(u16 address) {
        request_machine call = IsFirst ? request_machine::write(true) : request_machine::check();
        constexpr bool is_bit = Code == modbus::function::read_coils;
        const modbus::frame<8> request = [&] {
            if constexpr (is_bit) { // less code than `read_frame`, which programs with registers have
                modbus::frame<8> r;
                r.data[0] = node_.address;
                modbus::put_trusted_request(byte_buffer{r.data}.subspan(1), Code, address, 1);
                r.size = modbus::close_trusted<crc>(r.data, 5).size();
                return r;
            } else {
                return modbus::read_frame<crc>(node_.address, address, 1);
            }
        }();
        for (;;) {
            std::uint8_t response[is_bit ? 6 : 7];
            (void)carried(request, response);
            status why;
            if (!call.goes_on(why, node_, false, line_->is_echo_ruled_out(node_.address)) ||
                !call.is_asking())
                return why.error();
        }
    }
};

} // namespace servobus
