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
        drop_stale_settings(); // so that a word order that the caller sets remains
        return node_;
    }
    constexpr const Node& node() const { return node_; }

    /// Reads `words.size()` raw registers from `address` on, function 03 or 04; for what a map does not have.
    /// On failure `words` is as it was.
    /// Errors: `bad_argument` (the node's address, or more registers than the device gives at once), the
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
        status w;
        exchange_for<false, true> x{sent, room, line_->timing(), node_.limits};
        if (x.response_size() != room.size()) return errc::bad_argument;
        if constexpr (Line::is_small) {
            w = line_->run(x, node_.gaps);
        } else {
            line_->run(x, node_.gaps);
            w = x.status();
        }
        if (!w.has_response()) drop_word_order();
        if (w.was_sent() && !modbus::is_read(pdu[0])) { // it may write anything
            if constexpr (Device::facts.eeprom_switch != 0) invalidate_tokens();
            invalidate_word_order();
        }
        if (!w) return w;
        if (!line_->is_echo_ruled_out() && same_bytes(room, sent)) return status::sent(errc::own_echo);
        for (std::size_t i = 0; i < response_pdu.size(); ++i) response_pdu[i] = room[i + 1];
        return w;
    }

  protected:
    using crc = typename Line::crc; // of every frame, as the line checks the responses

    constexpr raw_client(Line& on, Node at) : line_{&on}, node_{at}, stated_word_order_{at.word_order} {}

    /// Reads with retries. `frame` has room for the response.
    constexpr status read_some(byte_buffer frame, u16 address, slice<u16> words,
                               modbus::function code = modbus::function::read_holding_registers) {
        const modbus::frame<8> request =
            modbus::read_frame<crc>(node_.address, address, static_cast<u16>(words.size()), code);
        if (!node_.is_valid() || request.size == 0) return errc::bad_argument;
        return ask(request, frame, words);
    }

    /// The same for a request that is there. Inline: of what it is given, nearly all is constant.
    [[gnu::always_inline]] constexpr status ask(bytes request, byte_buffer frame, slice<u16> words) {
        status why{errc::bad_argument};
        const byte_buffer response = frame.first(5 + 2 * words.size());
        for (unsigned attempt = 0; attempt <= node_.read_retries; ++attempt) {
            why = carried(request, response);
            mind(why);
            if (!why.has_response()) drop_word_order(); // a retry may be answered in another one
            if (why.error() == errc::ok) words_view{bytes{response}.subspan(3)}.copy_to(words);
            if (!is_worth_a_retry(why)) break;
        }
        return why;
    }

    /// True if something answers here that is no echo: a read, of whatever value, or its exception.
    [[gnu::cold, gnu::noinline]] constexpr bool answers(u16 address) {
        const modbus::frame<8> request = modbus::read_frame<crc>(node_.address, address, 1);
        for (unsigned attempt = 0; attempt <= node_.read_retries && !line_->is_echo_ruled_out(); ++attempt) {
            std::uint8_t response[7];
            mind(carried(request, response));
        }
        return line_->is_echo_ruled_out();
    }

    /// On a line where nothing has answered yet in another way, the response to function 06 may be an echo:
    /// there the write, which may be a stop, is followed by a read.
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
        const auto payload = static_cast<std::uint8_t>(frame.size() - 9);
        frame[0] = node_address;
        frame[1] = static_cast<std::uint8_t>(modbus::function::write_multiple_registers);
        store_word(frame, 2, address);
        frame[4] = 0;
        frame[5] = payload / 2;
        frame[6] = payload;
        const byte_buffer tail = frame.last(2);
        const u16 check = modbus::crc16<crc>(bytes{frame}.first(frame.size() - 2));
        tail[0] = static_cast<std::uint8_t>(check & 0xFFu);
        tail[1] = static_cast<std::uint8_t>(check >> 8);
    }

    /// What writes that the device does not keep need, until something makes it void. To be taken behind the
    /// read that proves it, whose own lost attempts came before its answer.
    constexpr servobus::ram_only new_token() {
        drop_stale_settings();
        return servobus::ram_only{troubles_};
    }
    constexpr bool is_good(servobus::ram_only token) {
        mind_what_is_forgotten();
        drop_stale_settings();
        return token.number_ == troubles_;
    }
    static constexpr bool has_tokens = Device::facts.eeprom_switch != 0;
    /// Whether a word order can become stale, while a read goes on too.
    static constexpr bool loses_word_order = Device::facts.word_order_register != 0 && !is_fixed<Node>;
    /// The node's, unless something made it void.
    constexpr word_order current_word_order() {
        mind_what_is_forgotten();
        drop_stale_settings();
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

    // A blocking line takes them unchecked, since they are made here.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr status carried(bytes request, byte_buffer response,
                                                    bool is_single = false) {
        if constexpr (Line::is_small) {
            return line_->run(exchange_for<IsBroadcast>::trusted(request, response, node_.limits, is_single),
                              node_.gaps);
        } else {
            exchange x = exchange::trusted(request, response, line_->timing(), node_.limits);
            line_->run(x, node_.gaps);
            return x.status();
        }
    }

    // Follows each attempt of a stepped read, as in `ask`, whose loop a call makes longer on a small core.
    constexpr void end_read(const status& why) {
        mind(why);
        if (!why.has_response()) drop_word_order();
    }
    // Follows each write.
    [[gnu::always_inline]] constexpr void end_write(const status& w) {
        mind(w);
        if (w.outcome() == outcome::unknown) drop_word_order();
    }

    // What a write makes void.
    struct voided {
        bool tokens = false;
        bool word_order = false;
    };
    [[gnu::always_inline]] static constexpr voided voided_by(bytes request) {
        return {Device::facts.eeprom_switch != 0 && writes(Device::facts.eeprom_switch, request),
                loses_word_order && writes(Device::facts.word_order_register, request)};
    }
    [[gnu::always_inline]] constexpr void invalidate(const voided& what) {
        if constexpr (Device::facts.eeprom_switch != 0) {
            if (what.tokens) invalidate_tokens();
        }
        if (what.word_order) invalidate_word_order();
    }

    constexpr bool is_worth_a_retry(const status& why) const {
        if (why.error() == errc::exception)
            return why.exception() != 0 && why.exception() == node_.limits.corrupted_request;
        return why.error() >= errc::timeout && why.error() < errc::exception;
    }

    template <bool IsBroadcast>
    [[gnu::always_inline]] constexpr status send_write(byte_buffer request, bool is_single = false) {
        if (!IsBroadcast && !node_.is_valid()) return errc::bad_argument;
        invalidate(voided_by(request));
        const status w =
            carried<IsBroadcast>(request, request.first(8), is_single); // its response's memory too
        end_write(w);
        return w;
    }

    static constexpr bool writes(u16 wanted, bytes request) {
        const u16 address = load_word(request, 2);
        const u16 words = request[1] == 0x10 ? load_word(request, 4) : u16{1};
        const u16 distance = static_cast<u16>(wanted - address);
        return distance < words;
    }

    // A blocking line has no epoch.
    static constexpr bool learns = !Line::is_small && (loses_word_order || Device::facts.eeprom_switch != 0);
    // A word order that was read from the drive is stale; one that the node was made with is not.
    constexpr void drop_word_order() {
        if constexpr (loses_word_order) node_.word_order = stated_word_order_;
    }
    // Whatever was stated before: it is another one now.
    constexpr void invalidate_word_order() {
        if constexpr (loses_word_order) {
            stated_word_order_ = word_order::unknown;
            node_.word_order = word_order::unknown;
        }
    }

    // What was learned is void after a silence of the drive and a loss of the port, whoever met it.
    constexpr void drop_stale_settings() {
        if constexpr (learns) {
            const epoch now = line_->epoch(node_.address);
            if (learned_in_.is == now) return;
            learned_in_.is = now;
            if constexpr (Device::facts.eeprom_switch != 0) invalidate_tokens();
            drop_word_order();
        }
    }

    // A request whose sender is gone has met a silence too.
    constexpr void mind_what_is_forgotten() {
        if constexpr (learns) (void)line_->is_free();
    }

    // Counts what makes a proof void; costs nothing where there is no such switch.
    constexpr void mind(const status& why) {
        if constexpr (Device::facts.eeprom_switch != 0) {
            if (!why.has_response()) invalidate_tokens();
        }
    }
    constexpr void invalidate_tokens() {
        if (++troubles_ == 0) troubles_ = 1;
    }

    // 0 is the number of a void proof. Nothing where there is no switch.
    struct no_number {
        constexpr explicit no_number(int) {}
    };
    using trouble_number = std::conditional_t<Device::facts.eeprom_switch != 0, std::uint16_t, no_number>;
    [[no_unique_address]] trouble_number troubles_{1};

    struct no_epoch {
        constexpr no_epoch(const Line&, std::uint8_t) {}
    };
    struct known_epoch {
        epoch is;
        constexpr known_epoch(const Line& on, std::uint8_t node_address) : is{on.epoch(node_address)} {}
    };
    [[no_unique_address]] std::conditional_t<learns, known_epoch, no_epoch> learned_in_{*line_,
                                                                                        node_.address};

    struct no_word_order {
        constexpr explicit no_word_order(word_order) {}
    };
    using word_order_if_any = std::conditional_t<loses_word_order, word_order, no_word_order>;
    [[no_unique_address]] word_order_if_any stated_word_order_;
};

} // namespace servobus
