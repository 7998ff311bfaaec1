// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Blocking access to the registers of one node: a thin typed layer over the line. Every call returns within
// `line::bound` for each request it makes; reads are retried, writes never.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/line.hpp>
#include <servobus/node.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/setting.hpp>
#include <servobus/volatile_writes.hpp>

namespace servobus {

namespace detail {
/// A read of a fixed node, in flash.
template <class Node, u16 Address, u16 Words>
inline constexpr auto read_request = modbus::read_frame(Node::unit, Address, Words).data;
} // namespace detail

/// A client of one node on a line. Not thread-safe; the line is shared by the clients of one thread.
template <class Line, device_class Device, class Node = node<Device>> class client {
    static_assert(!is_fixed<Node> || Line::is_small,
                  "a fixed_node is for a small_line; on a line the figures of a node can be changed");
    static_assert(Device::facts.max_read <= modbus::max_read && Device::facts.max_write <= modbus::max_write,
                  "a frame has room for 125 registers that are read, and for 123 that are written");

  public:
    using device = Device;

    constexpr client(Line& on, Node at) : line_{&on}, node_{at} {}

    constexpr Line& line() { return *line_; }
    constexpr Node& node() { return node_; }
    constexpr const Node& node() const { return node_; }

    /// Reads one register.
    /// Errors: those of `read_words`; `needs_word_order` for 32 bits in an order that is not known.
    template <const auto& R>
    requires is_register<R>
    constexpr result<reading<R>> read() {
        using row = detail::row_type<R>;
        check_row<R>();
        static_assert(row::rights != access::wo, "this register is write-only");
        return read_at<R>(R.address);
    }

    /// Reads element `index` of an array of registers. Errors: as `read<R>()`; `bad_argument` if there is no
    /// such element.
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr result<reading<at<Rows, 0>>> read(std::size_t index) {
        using rows = detail::row_type<Rows>;
        static_assert(rows::rights != access::wo, "this register is write-only");
        check_row<Rows>();
        if (index >= rows::size) return failure{errc::bad_argument};
        const result<u32> bits = read_bits<rows::words>(Rows[index].address);
        if (!bits) return bits.why();
        return detail::reading_of<at<Rows, 0>>(*bits);
    }

    /// Reads several registers in the fewest requests, never across an address that is not named; `get<R>`
    /// takes a value out. If one request fails there is no result at all.
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) constexpr result<readings<Rs...>> read() {
        check_device<Rs...>();
        constexpr const auto& plan = readings<Rs...>::plan;
        constexpr bool has_pair = ((detail::row_type<Rs>::words == 2) || ...);
        // Filled where the caller will have it: a copy would be a memcpy.
        result<readings<Rs...>> values{failure{}};
        values->set_order(node_.order);
        std::array<std::uint8_t, 5 + 2 * plan.words> frame;
        failure why{has_pair && node_.order == word_order::unknown ? errc::needs_word_order : errc::ok};
        if constexpr (is_fixed<Node> && plan.count == 1) {
            if (why.code == errc::ok)
                why = ask(detail::read_request<Node, plan.requests[0].address, plan.words>, frame,
                          values->words());
        } else {
            std::size_t offset = 0;
            for (std::size_t i = 0; i < plan.count && why.code == errc::ok; ++i) {
                const extent& part = plan.requests[i];
                why = read_some(frame, part.address, values->words().subspan(offset, part.words));
                offset += part.words;
            }
        }
        if (why.code != errc::ok) {
            if constexpr (plan.count > 1) values->clear();
            values.fail(why);
        }
        return values;
    }

    /// Writes one register: function 06, or 10h for two words.
    template <const auto& R>
    requires is_register<R>
    constexpr written write(setting<R> value) {
        check_wear<R>();
        return put<R>(value);
    }

    /// Writes element `index` of an array of registers; `setting` of element 0 has the rules for all.
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr written write(std::size_t index, setting<at<Rows, 0>> value) {
        check_wear<at<Rows, 0>>();
        return put<Rows>(index, value);
    }

    /// Writes adjacent registers in one frame, function 10h: all or nothing.
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) [[gnu::always_inline]] constexpr written write(setting<Rs>... values) {
        (check_wear<Rs>(), ...);
        return write_block<Rs...>(values...);
    }

    /// Writes registers that the device keeps in its EEPROM at every write, which wears it: for set-up, not
    /// for what comes again and again.
    template <const auto& R>
    requires is_register<R>
    constexpr written store(setting<R> value) { return put<R>(value); }
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr written store(std::size_t index, setting<at<Rows, 0>> value) { return put<Rows>(index, value); }
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) constexpr written store(setting<Rs>... values) {
        return write_block<Rs...>(values...);
    }

    /// Reads whether the device's writes wear its EEPROM now; if not, gives what such writes need.
    /// Errors: as `read`; `wrong_state` if they do wear it.
    constexpr result<servobus::volatile_writes> volatile_writes() {
        static_assert(Device::facts.eeprom_switch != 0, "this device keeps writes only when told to");
        const result<u32> kept = read_bits<1>(Device::facts.eeprom_switch);
        if (!kept) return kept.why();
        if (*kept != 0) return failure{errc::wrong_state};
        return servobus::volatile_writes{troubles_};
    }

    /// As `write`, for registers that the device would keep, while it does not. Errors: `needs_init` if
    /// `proof` is void.
    template <const auto& R>
    requires is_register<R>
    constexpr written write(setting<R> value, servobus::volatile_writes proof) {
        if (proof.number_ != troubles_) return written::not_sent(errc::needs_init);
        return put<R>(value);
    }
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr written write(std::size_t index, setting<at<Rows, 0>> value, servobus::volatile_writes proof) {
        if (proof.number_ != troubles_) return written::not_sent(errc::needs_init);
        return put<Rows>(index, value);
    }

    /// Reads the register first and writes only what it does not have yet. `done` without a write if it does.
    template <const auto& R>
    requires is_register<R>
    constexpr written write_if_different(setting<R> value) {
        check_wear<R>();
        return put_if_different<R>(value);
    }
    /// The same for registers that the device keeps at every write: an equal value wears nothing.
    template <const auto& R>
    requires is_register<R>
    constexpr written store_if_different(setting<R> value) { return put_if_different<R>(value); }

    /// Reads how the device orders the words of 32-bit values; from then on they can be read and written.
    /// Errors: as `read`; `unexpected_value` for a setting that its manual does not have.
    constexpr failure learn_word_order() {
        static_assert(Device::facts.order_register != 0, "the word order of this device is fixed");
        node_.order = word_order::unknown;
        const result<u32> order = read_bits<1>(Device::facts.order_register);
        if (!order) return order.why();
        if (*order > 1) return {errc::unexpected_value};
        node_.order = *order == 0 ? word_order::high_first : word_order::low_first;
        return {};
    }

    /// Writes one register of every device on the line at once (address 0); none answers. `done` means that
    /// the frame left in full.
    template <const auto& R>
    requires is_register<R>
    constexpr written broadcast(setting<R> value) {
        check_wear<R>();
        check_row<R>();
        if (value.error() != errc::ok) return written::not_sent(value.error());
        return write_bits<detail::row_type<R>::words, true>(R.address, value.bits());
    }

    /// Reads `words.size()` raw registers from `address` on, function 03 or 04; for what a map does not have.
    /// On failure `words` is as it was.
    /// Errors: `bad_argument` (the node's address, or more registers than the device gives at once), the
    /// transport's, the reply's, `exception`.
    constexpr failure read_words(u16 address, std::span<u16> words,
                                 modbus::function code = modbus::function::read_holding_registers) {
        if (words.empty() || words.size() > Device::facts.max_read) return {errc::bad_argument};
        std::array<std::uint8_t, modbus::max_frame> frame;
        return read_some(frame, address, words, code);
    }

    /// Writes one raw register, function 06.
    constexpr written write_word(u16 address, u16 value) { return write_one(address, value); }

    /// Writes raw adjacent registers, function 10h.
    constexpr written write_words(u16 address, std::span<const u16> words) {
        if (words.empty() || words.size() > Device::facts.max_write ||
            !modbus::fits_address_space(address, static_cast<u16>(words.size())))
            return written::not_sent(errc::bad_argument);
        std::array<std::uint8_t, modbus::max_frame> frame;
        for (std::size_t i = 0; i < words.size(); ++i) store_word(frame, 7 + 2 * i, words[i]);
        return write_many(byte_buffer{frame}.first(9 + 2 * words.size()), address);
    }

    /// Sends any PDU; the reply's PDU must fill `reply_pdu` exactly, or be an exception. Never retried.
    /// Errors: as `read_words`, and `bad_argument` for an empty PDU, one that is too long, or no room for a
    /// reply. Not on a `small_line`, which knows four functions.
    constexpr written transact(bytes pdu, byte_buffer reply_pdu) {
        static_assert(!Line::is_small, "a small_line has functions 03, 04, 06 and 10h only; a line has all");
        if (!node_.is_valid() || pdu.empty() || pdu.size() > modbus::max_pdu || reply_pdu.size() < 2 ||
            reply_pdu.size() > modbus::max_pdu)
            return written::not_sent(errc::bad_argument);
        std::array<std::uint8_t, modbus::max_frame> request{};
        std::array<std::uint8_t, modbus::max_frame> reply{};
        request[0] = node_.unit;
        for (std::size_t i = 0; i < pdu.size(); ++i) request[i + 1] = pdu[i];
        const std::size_t size = modbus::close_frame(request, pdu.size());
        exchange x{bytes{request}.first(size), byte_buffer{reply}.first(reply_pdu.size() + 3),
                   line_->timing(), node_.limits};
        if (x.reply_size() != reply_pdu.size() + 3) return written::not_sent(errc::bad_argument);
        line_->run(x, node_.quiet);
        if (x.why().code == errc::ok) {
            if (!line_->is_proven() && same_bytes(x.reply(), x.request())) return {failure{errc::echo}, true};
            for (std::size_t i = 0; i < reply_pdu.size(); ++i) reply_pdu[i] = x.reply()[i + 1];
        }
        return {x.why(), x.was_sent()};
    }

  private:
    template <bool IsBroadcast>
    using exchange_for =
        typename Line::template exchange_for<std::remove_cvref_t<decltype(Node::limits)>, IsBroadcast>;
    using exchange = exchange_for<false>;

    // A small line takes them unseen, since they are made here.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr written carried(bytes request, byte_buffer reply,
                                                     bool is_single = false) {
        if constexpr (Line::is_small) {
            return line_->run(exchange_for<IsBroadcast>::trusted(request, reply, node_.limits, is_single),
                              node_.quiet);
        } else {
            exchange x{request, reply, line_->timing(), node_.limits};
            line_->run(x, node_.quiet);
            return x.ended();
        }
    }

    template <const auto& R> static constexpr void check_row() {
        static_assert(belongs_to<typename detail::row_type<R>::device, Device>,
                      "this register belongs to another device");
    }
    template <const auto&... Rs> static constexpr void check_device() {
        static_assert((belongs_to<typename detail::row_type<Rs>::device, Device> && ...),
                      "this register belongs to another device");
    }

    template <const auto& R> static constexpr void check_wear() {
        static_assert(!has(R.flags, flag::saved_on_write),
                      "every write of this register wears the drive's EEPROM: store() it, or write it with "
                      "what volatile_writes() gives");
    }

    template <const auto& R> constexpr written put(setting<R> value) {
        check_row<R>();
        if (value.error() != errc::ok) return written::not_sent(value.error());
        if (!node_.is_valid()) return written::not_sent(errc::bad_argument);
        if constexpr (has(R.flags, flag::communication)) { // whose answer may be the last at this address
            if (!line_->is_proven() && !answers(R.address)) return written::not_sent(errc::echo);
        }
        return write_bits<detail::row_type<R>::words>(R.address, value.bits());
    }
    template <const auto& Rows> constexpr written put(std::size_t index, setting<at<Rows, 0>> value) {
        using rows = detail::row_type<Rows>;
        check_row<Rows>();
        if (index >= rows::size) return written::not_sent(errc::bad_argument);
        if (value.error() != errc::ok) return written::not_sent(value.error());
        return write_bits<rows::words>(Rows[index].address, value.bits());
    }
    template <const auto& R> constexpr written put_if_different(setting<R> value) {
        constexpr std::size_t words = detail::row_type<R>::words;
        static_assert(detail::row_type<R>::rights == access::rw, "this register is write-only");
        check_row<R>();
        if (value.error() != errc::ok) return written::not_sent(value.error());
        const result<u32> held = read_bits<words>(R.address);
        if (!held) return written{held.why(), false};
        const u32 mask = words == 2 ? 0xFFFF'FFFFu : 0xFFFFu;
        if (((*held ^ value.bits()) & mask) == 0) return written{failure{}, true};
        return put<R>(value);
    }

    // Counts what makes a proof void; costs nothing where there is no such switch.
    constexpr void mind(const failure& why) {
        if constexpr (Device::facts.eeprom_switch != 0) {
            if (why.code != errc::ok && why.code != errc::exception) void_proofs();
        }
    }
    constexpr void void_proofs() {
        if (++troubles_ == 0) troubles_ = 1;
    }

    template <const auto& R> constexpr result<reading<R>> read_at(u16 address) {
        const result<u32> bits = read_bits<detail::row_type<R>::words>(address);
        if (!bits) return bits.why();
        return detail::reading_of<R>(*bits);
    }

    template <std::size_t Words> constexpr result<u32> read_bits(u16 address) {
        if (Words == 2 && node_.order == word_order::unknown) return failure{errc::needs_word_order};
        std::array<u16, Words> words{};
        std::array<std::uint8_t, 5 + 2 * Words> frame;
        const failure why = read_some(frame, address, words);
        if (why.code != errc::ok) return why;
        if constexpr (Words == 2) {
            return join_words(words[0], words[1], node_.order);
        } else {
            return u32{words[0]};
        }
    }

    template <std::size_t Words, bool IsBroadcast = false>
    constexpr written write_bits(u16 address, u32 bits) {
        if constexpr (Words == 2) {
            if (node_.order == word_order::unknown) return written::not_sent(errc::needs_word_order);
            const word_pair pair = split_words(bits, node_.order);
            std::array<std::uint8_t, 13> frame;
            store_word(frame, 7, pair.first);
            store_word(frame, 9, pair.second);
            return write_many<IsBroadcast>(frame, address);
        } else {
            return write_one<IsBroadcast>(address, static_cast<u16>(bits));
        }
    }

    template <const auto&... Rs> [[gnu::always_inline]] constexpr written write_block(setting<Rs>... values) {
        check_device<Rs...>();
        using plan = write_plan<Rs...>;
        std::array<std::uint8_t, 9 + 2 * plan::words> frame;
        std::size_t used = 7;
        errc wrong = errc::ok;
        const auto put = [&](const auto& value, std::size_t size) {
            if (value.error() != errc::ok && wrong == errc::ok) wrong = value.error();
            if (size == 2) {
                if (node_.order == word_order::unknown && wrong == errc::ok) wrong = errc::needs_word_order;
                const word_pair pair = split_words(value.bits(), node_.order);
                store_word(frame, used, pair.first);
                store_word(frame, used + 2, pair.second);
            } else {
                store_word(frame, used, static_cast<u16>(value.bits()));
            }
            used += 2 * size;
        };
        (put(values, detail::row_type<Rs>::words), ...);
        if (wrong != errc::ok) return written::not_sent(wrong);
        return write_many(frame, plan::rows[0].address);
    }

    // The untemplated layer below the rows: one copy each, however many registers a program uses.
    constexpr failure read_some(byte_buffer frame, u16 address, std::span<u16> words,
                                modbus::function code = modbus::function::read_holding_registers) {
        const modbus::frame<8> request =
            modbus::read_frame(node_.unit, address, static_cast<u16>(words.size()), code);
        if (!node_.is_valid() || request.size == 0) return {errc::bad_argument};
        return ask(request, frame, words);
    }

    // Inline: of what it is given, nearly all is constant.
    [[gnu::always_inline]] constexpr failure ask(bytes request, byte_buffer frame, std::span<u16> words) {
        failure why{errc::bad_argument};
        const byte_buffer reply = frame.first(5 + 2 * words.size());
        for (unsigned attempt = 0; attempt <= node_.read_retries; ++attempt) {
            why = carried(request, reply).why();
            mind(why);
            if (why.code == errc::ok) words_view{bytes{reply}.subspan(3)}.copy_to(words);
            if (!is_worth_a_retry(why)) break;
        }
        return why;
    }

    constexpr bool is_worth_a_retry(const failure& why) const {
        if (why.code == errc::exception)
            return why.exception != 0 && why.exception == node_.limits.corrupted_request;
        return why.code >= errc::timeout && why.code < errc::exception;
    }

    // On a line where nothing has answered yet in another way, the reply to function 06 may be an echo: there
    // the write, which may be a stop, is followed by a read.
    template <bool IsBroadcast = false> constexpr written write_one(u16 address, u16 value) {
        modbus::frame<8> f =
            modbus::write_frame(IsBroadcast ? modbus::broadcast : node_.unit, address, value);
        const written w = send_write<IsBroadcast>(f.data, true);
        if (IsBroadcast || line_->is_proven() || !w || answers(address)) return w;
        return {failure{errc::echo}, true};
    }

    // True if something answers here that is no echo: a read, of whatever value, or its exception.
    [[gnu::cold, gnu::noinline]] constexpr bool answers(u16 address) {
        const modbus::frame<8> request = modbus::read_frame(node_.unit, address, 1);
        for (unsigned attempt = 0; attempt <= node_.read_retries && !line_->is_proven(); ++attempt) {
            std::array<std::uint8_t, 7> reply;
            mind(carried(request, reply).why());
        }
        return line_->is_proven();
    }

    // The words are in their place already.
    template <bool IsBroadcast = false>
    [[gnu::noinline]] constexpr written write_many(byte_buffer frame, u16 address) {
        const auto payload = static_cast<std::uint8_t>(frame.size() - 9);
        frame[0] = IsBroadcast ? modbus::broadcast : node_.unit;
        frame[1] = static_cast<std::uint8_t>(modbus::function::write_multiple_registers);
        store_word(frame, 2, address);
        frame[4] = 0;
        frame[5] = payload / 2;
        frame[6] = payload;
        const byte_buffer tail = frame.last(2);
        const u16 crc = modbus::crc16(bytes{frame}.first(frame.size() - 2));
        tail[0] = static_cast<std::uint8_t>(crc & 0xFFu);
        tail[1] = static_cast<std::uint8_t>(crc >> 8);
        return send_write<IsBroadcast>(frame);
    }

    template <bool IsBroadcast>
    [[gnu::always_inline]] constexpr written send_write(byte_buffer request, bool is_single = false) {
        if (!IsBroadcast && !node_.is_valid()) return written::not_sent(errc::bad_argument);
        if constexpr (Device::facts.eeprom_switch != 0) {
            if (writes_switch(request)) void_proofs();
        }
        const written w =
            carried<IsBroadcast>(request, request.first(8), is_single); // its reply's memory too
        mind(w.why());
        return w;
    }

    static constexpr bool writes_switch(bytes request) {
        const u16 address = load_word(request, 2);
        const u16 words = request[1] == 0x10 ? load_word(request, 4) : u16{1};
        const u16 distance = static_cast<u16>(Device::facts.eeprom_switch - address);
        return distance < words;
    }

    Line* line_;
    [[no_unique_address]] Node node_;
    // 0 is the number of a void proof. Nothing where there is no switch.
    struct no_number {
        constexpr explicit no_number(int) {}
    };
    using trouble_number = std::conditional_t<Device::facts.eeprom_switch != 0, std::uint16_t, no_number>;
    [[no_unique_address]] trouble_number troubles_{1};
};

template <class Line, device_class Device> client(Line&, node<Device>) -> client<Line, Device>;
template <class Line, device_class Device, std::uint8_t Unit>
client(Line&, fixed_node<Device, Unit>) -> client<Line, Device, fixed_node<Device, Unit>>;

} // namespace servobus
