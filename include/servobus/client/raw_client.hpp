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

#include <servobus/client/node.hpp>
#include <servobus/client/ram_only.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/line/line.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
template <class Raw> class stepped_request; // client/detail/stepped_request.hpp
} // namespace detail

/// What a `client` is without its device's rows. Every call returns within `line::bound` for each request it
/// makes; reads are retried, writes never.
template <class Line, device_class Device, class Node> class raw_client {
    static_assert(!is_fixed<Node> || Line::is_small,
                  "a fixed_node is for a blocking_line; on a line the figures of a node can be changed");
    static_assert(Device::facts.max_read <= modbus::max_read && Device::facts.max_write <= modbus::max_write,
                  "a frame has room for 125 registers that are read, and for 123 that are written");

  public:
    using line_type = Line;
    using calls_by_address = raw_client; ///< the base of a client, as stepped calls name it

    constexpr Line& line() { return *line_; }
    constexpr Node& node() {
        drop_stale_word_order(); // first, so that a word order that the caller sets remains
        return node_;
    }
    constexpr const Node& node() const { return node_; }

    /// Reads `words.size()` raw registers from `address` on, function 03 or 04; for what a map does not have.
    /// On failure `words` is as it was.
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
    constexpr status write_word(u16 address, u16 value) { return write_one(address, value); }
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
        return write_words_in(byte_buffer{frame}.first(9 + 2 * words.size()), address, words);
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
    /// Errors: as `read_words`, and `bad_argument` for an empty PDU, one that is too long, or no room for a
    /// response. On a `blocking_line`, whose frames have at most 255 bytes, a PDU has at most 252.
    constexpr status transact(bytes pdu, byte_buffer response_pdu) {
        constexpr std::size_t longest_pdu = Line::longest_frame - 3;
        if (!node_.is_valid() || pdu.empty() || pdu.size() > longest_pdu || response_pdu.size() < 2 ||
            response_pdu.size() > longest_pdu)
            return errc::bad_argument;
        std::uint8_t request[modbus::max_frame]{};
        std::uint8_t response[modbus::max_frame]{};
        request[0] = node_.address;
        for (std::size_t i = 0; i < pdu.size(); ++i) request[i + 1] = pdu[i];
        const std::size_t size = modbus::close_frame<crc>(request, pdu.size());
        const bytes sent = bytes{request}.first(size);
        const byte_buffer room = byte_buffer{response}.first(response_pdu.size() + 3);
        exchange_for<false, true> x{sent, room, line_->timing(), node_.limits};
        if (x.response_size() != room.size()) return errc::bad_argument;
        const status w = run(x);
        if (w.was_sent() && !modbus::is_read(pdu[0])) invalidate<>({true, true}); // it may write anything
        if (!w) return w;
        if (!line_->is_echo_ruled_out() && same_bytes(room, sent)) return status::sent(errc::own_echo);
        for (std::size_t i = 0; i < response_pdu.size(); ++i) response_pdu[i] = room[i + 1];
        return w;
    }

  protected:
    using crc = typename Line::crc; // of every frame, as the line checks the responses

    constexpr raw_client(Line& on, Node at) : line_{&on}, node_{at}, learned_{on, at} {}

    /// Reads with retries. `frame` has room for the response.
    constexpr status read_some(byte_buffer frame, u16 address, slice<u16> words,
                               modbus::function code = modbus::function::read_holding_registers) {
        const modbus::frame<8> request =
            modbus::read_frame<crc>(node_.address, address, static_cast<u16>(words.size()), code);
        if (!node_.is_valid() || request.size == 0) return errc::bad_argument;
        return ask(request, frame, words);
    }

    /// The same for a request that is made. Inline: nearly all of its arguments are constants.
    [[gnu::always_inline]] constexpr status ask(bytes request, byte_buffer frame, slice<u16> words) {
        status why{errc::bad_argument};
        const byte_buffer response = frame.first(5 + 2 * words.size());
        for (unsigned attempt = 0; attempt <= node_.read_retries; ++attempt) {
            why = carried(request, response);
            if (why.error() == errc::ok) words_view{bytes{response}.subspan(3)}.copy_to(words);
            if (!is_worth_a_retry(why)) break;
        }
        return why;
    }

    /// True if the node gives a response that is no echo: to a read, whatever its value, or an exception.
    [[gnu::cold, gnu::noinline]] constexpr bool answers(u16 address) {
        const modbus::frame<8> request = modbus::read_frame<crc>(node_.address, address, 1);
        for (unsigned attempt = 0; attempt <= node_.read_retries && !line_->is_echo_ruled_out(); ++attempt) {
            std::uint8_t response[7];
            (void)carried(request, response);
        }
        return line_->is_echo_ruled_out();
    }

    /// Until an echo is ruled out, the response to function 06 may be one: then the write, which may be a stop,
    /// is followed by a read.
    template <bool IsBroadcast = false> constexpr status write_one(u16 address, u16 value) {
        modbus::frame<8> f =
            modbus::write_frame<crc>(IsBroadcast ? modbus::broadcast : node_.address, address, value);
        const status w = send_write<IsBroadcast>(f.data, true);
        if (IsBroadcast || line_->is_echo_ruled_out() || !w || answers(address)) return w;
        return status::sent(errc::own_echo);
    }

    /// The words are in their place already.
    template <bool IsBroadcast = false>
    [[gnu::noinline]] constexpr status write_many(byte_buffer frame, u16 address) {
        complete_block(IsBroadcast ? modbus::broadcast : node_.address, frame, address);
        return send_write<IsBroadcast>(frame);
    }
    /// A frame of function 10h around its words.
    static constexpr void complete_block(std::uint8_t node_address, byte_buffer frame, u16 address) {
        const std::size_t payload = frame.size() - 9;
        frame[0] = node_address;
        frame[1] = static_cast<std::uint8_t>(modbus::function::write_multiple_registers);
        store_word(frame, 2, address);
        frame[4] = 0;
        frame[5] = static_cast<std::uint8_t>(payload / 2);
        frame[6] = static_cast<std::uint8_t>(payload);
        const byte_buffer tail = frame.last(2);
        const u16 check = modbus::crc16<crc>(bytes{frame}.first(frame.size() - 2));
        tail[0] = static_cast<std::uint8_t>(check & 0xFFu);
        tail[1] = static_cast<std::uint8_t>(check >> 8);
    }

    /// To be called after the read of the switch: attempts of that read without a response begin an epoch.
    constexpr servobus::ram_only new_token() { return {node_.address, line_->epoch(node_.address)}; }
    constexpr bool is_good(servobus::ram_only token) { return token.holds(node_.address, current_epoch()); }
    static constexpr bool has_tokens = Device::facts.eeprom_switch != 0;
    /// Whether a word order can become stale, also during a read.
    static constexpr bool loses_word_order = Device::facts.word_order_register != 0 && !is_fixed<Node>;
    /// The node's; unknown if it is stale.
    constexpr word_order current_word_order() {
        if constexpr (loses_word_order) (void)current_epoch();
        drop_stale_word_order();
        return node_.word_order;
    }

    Line* line_;
    [[no_unique_address]] Node node_;

  private:
    friend class detail::stepped_request<raw_client>;

    template <std::size_t N>
    constexpr status read_array(u16 address, slice<u16> words, modbus::function code) {
        std::uint8_t frame[5 + 2 * N];
        return read_some(frame, address, words, code);
    }
    template <std::size_t N> constexpr status write_array(u16 address, slice<const u16> words) {
        if (!modbus::fits_address_space(address, N)) return errc::bad_argument;
        std::uint8_t frame[9 + 2 * N];
        return write_words_in(frame, address, words);
    }
    constexpr status write_words_in(byte_buffer frame, u16 address, slice<const u16> words) {
        for (std::size_t i = 0; i < words.size(); ++i) store_word(frame, 7 + 2 * i, words[i]);
        return write_many(frame, address);
    }

    template <bool IsBroadcast, bool IsAnyFunction = false>
    using exchange_for = typename Line::template exchange_for<std::remove_cvref_t<decltype(Node::limits)>,
                                                              IsBroadcast, IsAnyFunction>;
    using exchange = exchange_for<false>;

    // Unchecked, since request and response are made here.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr status carried(bytes request, byte_buffer response,
                                                    [[maybe_unused]] bool is_single = false) {
        if constexpr (Line::is_small) {
            return run<IsBroadcast>(
                exchange_for<IsBroadcast>::trusted(request, response, node_.limits, is_single));
        } else {
            constexpr bool is_host = sizeof(std::size_t) >= 8;
            if constexpr (is_host)
                return run<IsBroadcast>(exchange::trusted(request, response, line_->timing(), node_.limits));
            return carried_once(request.data(), response.data(),
                                static_cast<std::uint32_t>(request.size()) |
                                    static_cast<std::uint32_t>(response.size()) << 16);
        }
    }

    // One copy on a small core, with both sizes in one register.
    [[gnu::noinline]] constexpr status carried_once(const std::uint8_t* request, std::uint8_t* response,
                                                    std::uint32_t sizes) {
        const bytes sent{request, static_cast<std::size_t>(sizes & 0xFFFFu)};
        const byte_buffer room{response, static_cast<std::size_t>(sizes >> 16)};
        return run(exchange::trusted(sent, room, line_->timing(), node_.limits));
    }

    // A line counts the requests without a valid response. A blocking line is told of them here, so that a
    // program that learns nothing of its nodes has no code for it.
    template <bool IsBroadcast = false, class X> [[gnu::always_inline]] constexpr status run(X&& x) {
        if constexpr (Line::is_small) {
            const status w = line_->run(x, node_.gaps);
            if constexpr (learns && !IsBroadcast) {
                if (w.was_sent() && !w.has_response()) line_->begin_epoch(node_.address);
            }
            return w;
        } else {
            line_->run(x, node_.gaps);
            return x.status();
        }
    }

    // What becomes invalid by a write.
    struct invalidated {
        bool tokens;
        bool word_order;
    };
    [[gnu::always_inline]] static constexpr invalidated invalidated_by(bytes request) {
        return {Device::facts.eeprom_switch != 0 && writes(Device::facts.eeprom_switch, request),
                loses_word_order && writes(Device::facts.word_order_register, request)};
    }
    // Before the write leaves. A broadcast reaches all nodes.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr void invalidate(const invalidated& what) {
        if constexpr (has_tokens) {
            if (what.tokens) line_->begin_epoch(IsBroadcast ? modbus::broadcast : node_.address);
        }
        if constexpr (loses_word_order) {
            if (what.word_order) learned_.stated = node_.word_order = word_order::unknown;
        }
    }

    constexpr bool is_worth_a_retry(const status& why) const {
        if (why.error() == errc::exception)
            return why.exception() != 0 && why.exception() == node_.limits.corrupted_request;
        return why.error() >= errc::timeout &&
               why.error() < errc::exception; // not of a device that works on it
    }

    template <bool IsBroadcast>
    [[gnu::always_inline]] constexpr status send_write(byte_buffer request, bool is_single = false) {
        if (!IsBroadcast && !node_.is_valid()) return errc::bad_argument;
        invalidate<IsBroadcast>(invalidated_by(request));
        return carried<IsBroadcast>(request, request.first(8), is_single); // its response's memory too
    }

    static constexpr bool writes(u16 wanted, bytes request) {
        const u16 address = load_word(request, 2);
        const u16 words = request[1] == 0x10 ? load_word(request, 4) : u16{1};
        const u16 distance = static_cast<u16>(wanted - address);
        return distance < words;
    }

    // Whether anything is learned of the node that a restart would change.
    static constexpr bool learns = loses_word_order || has_tokens;

    // An exchange that was not stepped to its end counts from here on.
    [[gnu::noinline]] constexpr epoch current_epoch() {
        if constexpr (!Line::is_small) (void)line_->is_free();
        return line_->epoch(node_.address);
    }
    // A word order that was read from the drive is valid in its epoch; the one that the node was made with
    // remains. It asks for the epoch only: `node()` is a look, and must not free the line of an exchange.
    constexpr void drop_stale_word_order() {
        if constexpr (loses_word_order) {
            const epoch now = line_->epoch(node_.address);
            if (learned_.at == now) return;
            learned_.at = now;
            node_.word_order = learned_.stated;
        }
    }

    // The word order that the node was made with, and the epoch in which another one was read. Empty where it
    // never changes.
    struct learned_order {
        constexpr learned_order(const Line& on, const Node& of)
            : stated{of.word_order}, at{on.epoch(of.address)} {}
        word_order stated;
        epoch at;
    };
    struct nothing_learned {
        constexpr nothing_learned(const Line&, const Node&) {}
    };
    [[no_unique_address]] std::conditional_t<loses_word_order, learned_order, nothing_learned> learned_;
};

} // namespace servobus
