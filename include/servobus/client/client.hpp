// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Blocking access to the registers of one node by their rows: a thin typed layer over the line. Programs
// include it, or servobus.hpp. Every call returns within `line::bound` for each request that it makes;
// reads are retried, writes never.
//
//     client wheels{wire, node<zlac8015d::device>{1}};
//     const auto voltage = wheels.read<zlac8015d::bus_voltage>(); // or the reason: voltage.error()
//     if (!voltage || *voltage < 22 * volt) return 1;
//     if (!wheels.write<zlac8015d::left_acceleration_time>(800 * millisecond)) return 1;
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/client/detail/row_checks.hpp>
#include <servobus/client/raw_client.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/register_value.hpp>

namespace servobus {

struct coil_word; // registers/coil_value.hpp

namespace detail {
/// A read of a fixed node, in flash: the bytes alone.
struct short_request {
    std::uint8_t all[8];
};
/// The calls for rows of the other tables and for functions 16h and 17h: any_device.hpp has them.
template <class Client> struct table_calls {
    static_assert(sizeof(Client) == 0,
                  "for coils, inputs and functions 16h and 17h include servobus/any_device.hpp");
};

template <class Node, u16 Address, u16 Words, modbus::crc_engine Crc>
inline constexpr auto read_request = [] {
    const auto frame = modbus::read_frame<Crc>(Node::address, Address, Words);
    short_request r{};
    for (std::size_t i = 0; i < frame.size; ++i) r.all[i] = frame.data[i];
    return r;
}();
} // namespace detail

/// A client of one node on a line. Not thread-safe; the line is shared by the clients of one thread.
/// Registers without a row are reached by their addresses, as in a `raw_client`.
template <class Line, device_class Device, class Node = node<Device>>
class client : public raw_client<Line, Device, Node> {
    using raw = raw_client<Line, Device, Node>;
    using raw::current_word_order;
    using raw::line_;
    using raw::loses_word_order;
    using raw::new_token;
    using raw::node_;
    using raw::read_by;
    using raw::read_some;
    using raw::write_many;
    using raw::write_one;
    using typename raw::condition;
    friend struct detail::table_calls<client>;
    using other = detail::table_calls<client>;

  public:
    using device = Device;

    constexpr client(Line& on, Node at) : raw{on, at} {}

    /// Reads one register, function 03, and returns its value in the register's unit (see `reading`). A
    /// request without a valid response is repeated `node::read_retries` times; the last one's error counts.
    ///
    /// Errors:
    /// - `bad_argument`: the device cannot have the node's address; nothing was sent
    /// - `needs_word_order`: the word order of a 32-bit value is unknown, or became stale by a retry
    /// - `busy`: a stepped exchange has the line; nothing was sent
    /// - `line_busy`: no gap on the line was long enough to send
    /// - `send_failed`, `partial_send`, `receive_failed`, `port_lost`: the port failed; not repeated
    /// - `clock_stopped`: the port's clock does not advance; not repeated
    /// - `no_echo`, `collision`, `own_echo`: of an adapter with a local echo; not repeated
    /// - `timeout`: no response began within `node::limits`
    /// - `gateway_exception`: a gateway responded in the device's place; `status::exception()` has its number
    /// - `truncated_response`, with strict timing `bad_gap`: the response ended before its last byte
    /// - `bad_crc`, `wrong_function`, `wrong_byte_count`: the response does not fit its CRC or the request
    /// - `exception`: the device refused; `status::exception()` has its number, in general not repeated
    /// - `acknowledged`: it responded with exception 5, which is for requests that take it longer; not repeated
    template <const auto& R>
    requires is_register<R>
    constexpr result<reading<R>> read() {
        using row = row_type<R>;
        detail::check_device<Device, R>();
        static_assert(row::rights != access::wo, "this register is write-only");
        if constexpr (detail::needs_table_calls<R>)
            return other::template read_input<R>(*this);
        else
            return read_at<R>(R.address);
    }

    /// Reads one coil or discrete input, function 01 or 02. Errors: as of a register; `unexpected_value` if a bit
    /// after it is set.
    template <const auto& R>
    requires is_bit<R>
    constexpr result<bool> read() { return other::template read_bit<R>(*this); }

    /// Reads element `index` of an array of registers, coils or inputs. Errors: as `read<R>()`; `bad_argument` if there
    /// is no such element.
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr result<reading<at<Rows, 0>>> read(std::size_t index) {
        using rows = row_type<Rows>;
        static_assert(rows::rights != access::wo, "this register is write-only");
        detail::check_device<Device, Rows>();
        if (index >= rows::size) return errc::bad_argument;
        if constexpr (detail::needs_table_calls<Rows>)
            return other::template read_element<Rows>(*this, index);
        else
            return read_at<at<Rows, 0>>(Rows[index].address);
    }

    /// Does not compile: an array has no value of its own.
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr status read() {
        static_assert(!is_register_array<Rows>,
                      "an array is read by the element: read<rows>(i), or read<at<rows, 0>, at<rows, 1>>()");
        return {};
    }

    /// Reads several rows in the fewest requests for each table, never across an address that is not named; `get<R>`
    /// takes a value out. If one request fails there is no result at all. Errors: as `read<R>()`.
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) constexpr result<readings<Rs...>> read() {
        if constexpr (!detail::same_device<Rs...>::value) {
            return errc::bad_argument; // the assertion of `readings` is the only error
        } else {
            detail::check_device<Device, Rs...>();
            if constexpr ((detail::needs_table_calls<Rs> || ...))
                return other::template read_rows<Rs...>(*this);
            else if constexpr (read_plan<Rs...>.overlaps)
                return errc::bad_argument; // likewise
            else
                return read_registers<Rs...>();
        }
    }

    /// Writes one register: function 06, or 10h for two words. A setting of the line is written once a read has
    /// ruled out an echo; else the error is `own_echo`, not sent, also if no device responds.
    template <const auto& R>
    requires is_register<R>
    constexpr status write(register_value<R> value) {
        detail::check_wear<R>();
        return put<R>(value);
    }

    /// Writes element `index` of an array of registers or coils; the `register_value` of element 0 has the rules for
    /// all.
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr status write(std::size_t index, register_value<at<Rows, 0>> value) {
        if constexpr (detail::has_bits<Rows>) {
            return other::template write_element<Rows, false>(*this, index, value);
        } else {
            detail::check_wear<at<Rows, 0>>();
            return put<Rows>(index, value);
        }
    }

    /// Does not compile: an array is written by the element. Without this overload the first bool would be an index.
    template <const auto& Rows, std::same_as<bool>... Values>
    requires is_register_array<Rows>
    constexpr status write(Values...) {
        static_assert(!is_register_array<Rows>, "an array is written by the element: write<rows>(i, v), or "
                                                "write<at<rows, 0>, at<rows, 1>>(v, w)");
        return {};
    }

    /// Writes one coil, function 05: true or false. The response to it may be an echo, as that to function 06; then the
    /// coil is read.
    template <const auto& R>
    requires is_bit<R>
    constexpr status write(register_value<R> value) {
        return other::template write_coil<R, false>(*this, value);
    }
    /// Sends another word than on and off to one coil, function 05: `write<relay_1>(coil_word{0x5500})`. The device
    /// decides what the word means, so the state of the coil is unknown after it.
    template <const auto& R, std::same_as<coil_word> Word>
    requires is_bit<R>
    constexpr status write(Word word) { return other::template write_coil_word<R>(*this, word); }

    /// Writes adjacent registers in one frame, function 10h, or adjacent coils, function 0Fh: all or nothing.
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) [[gnu::always_inline]] constexpr status write(register_value<Rs>... values) {
        if constexpr ((is_bit<Rs> || ...)) {
            return other::template write_coils<false, false, Rs...>(*this, values...);
        } else {
            (detail::check_wear<Rs>(), ...);
            return write_block<Rs...>(values...);
        }
    }

    /// Sets the bits of `Mask` in one register to those of `value`, function 16h; the device keeps the others. Never
    /// repeated. For registers without a range: the client does not know what the change makes of the other bits.
    template <const auto& R, u16 Mask>
    requires is_register<R>
    constexpr status change_bits(u16 value) { return other::template change_bits<R, Mask>(*this, value); }
    /// Sets a part of a register, which other rows have the rest of, function 16h: `change_bits<oven::mode>(3)`.
    template <const auto& R>
    requires is_register<R>
    constexpr status change_bits(register_value<R> value) {
        return other::template change_part<R>(*this, value);
    }

    /// Writes the adjacent registers `Ws`, then reads the adjacent registers of `Reads`, which is `rows<Rs...>`, in one
    /// transaction: function 17h. Never repeated. Errors: as of a write.
    template <class Reads, const auto&... Ws> constexpr auto write_then_read(register_value<Ws>... values) {
        return other::template write_then_read<Reads, Ws...>(*this, values...);
    }

    /// Writes registers that the device keeps in its EEPROM. Each write wears it: for set-up, not for repeated
    /// writes.
    template <const auto& R>
    requires is_register<R>
    constexpr status store(register_value<R> value) { return put<R>(value); }
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr status store(std::size_t index, register_value<at<Rows, 0>> value) {
        if constexpr (detail::has_bits<Rows>)
            return other::template write_element<Rows, true>(*this, index, value);
        else
            return put<Rows>(index, value);
    }
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) constexpr status store(register_value<Rs>... values) {
        if constexpr ((is_bit<Rs> || ...))
            return other::template write_coils<true, false, Rs...>(*this, values...);
        else
            return write_block<Rs...>(values...);
    }
    /// The same for one coil.
    template <const auto& R>
    requires is_bit<R>
    constexpr status store(register_value<R> value) {
        return other::template write_coil<R, false, true>(*this, value);
    }

    /// Reads whether writes wear the device's EEPROM now; if not, returns the token that repeated writes need.
    /// Errors: as `read`; `wrong_state` if they do wear it.
    constexpr result<servobus::ram_only> ram_only() {
        static_assert(Device::facts.eeprom_switch != 0, "this device keeps writes only when told to");
        const result<u32> kept = read_bits<1>(Device::facts.eeprom_switch);
        if (!kept) return kept.status();
        if (*kept != 0) return errc::wrong_state;
        return new_token();
    }

    /// Writes a register that the device can keep in its EEPROM, while `token` shows that it does not. Errors:
    /// as `write`; `needs_init` if `token` is void.
    template <const auto& R>
    requires is_register<R>
    constexpr status write(register_value<R> value, servobus::ram_only token) {
        return put<R>(value, raw::needing(token));
    }
    template <const auto& Rows>
    requires is_register_array<Rows>
    constexpr status write(std::size_t index, register_value<at<Rows, 0>> value, servobus::ram_only token) {
        return put<Rows>(index, value, raw::needing(token));
    }

    /// Reads the register, and writes it if it has another value. `done` without a write if the value is equal.
    template <const auto& R>
    requires is_register<R>
    constexpr status write_if_different(register_value<R> value) {
        detail::check_wear<R>();
        return put_if_different<R>(value);
    }
    /// As `write_if_different`, for registers that the device keeps at every write: an equal value wears nothing.
    template <const auto& R>
    requires is_register<R>
    constexpr status store_if_different(register_value<R> value) { return put_if_different<R>(value); }
    /// Not of a coil: a write of an equal value changes nothing, and takes no longer than the read.
    template <const auto& R>
    requires is_bit<R>
    constexpr status write_if_different(register_value<R>) {
        static_assert(!is_bit<R>,
                      "write_if_different is for registers: write() the coil, or read() it first");
        return {};
    }
    template <const auto& R>
    requires is_bit<R>
    constexpr status store_if_different(register_value<R>) {
        static_assert(!is_bit<R>, "store_if_different is for registers: read() the coil, then store() it");
        return {};
    }

    /// Reads the word order of 32-bit values, which can be read and written from then on. The word order becomes
    /// stale when a request to the drive gets no valid response on this line, or when any client of the line writes
    /// its register. Errors: as `read`; `unexpected_value` for a setting that is not in the manual.
    constexpr status learn_word_order() {
        static_assert(Device::facts.word_order_register != 0, "the word order of this device is fixed");
        (void)current_word_order(); // drops one that is stale already
        const result<u32> order = read_bits<1>(Device::facts.word_order_register);
        (void)current_word_order(); // the read's own lost attempts came before its answer
        node_.word_order = word_order::unknown;
        if (!order) return order.status();
        if (*order > 1) return errc::unexpected_value;
        node_.word_order = *order == 0 ? word_order::high_first : word_order::low_first;
        return {};
    }

    /// Writes one register of every device on the line (address 0); none responds. `done` means that
    /// the frame left in full. Not for a setting of the line: two drives must not have one address, and no
    /// client would know of the new word order.
    template <const auto& R>
    requires is_register<R>
    constexpr status broadcast(register_value<R> value) {
        static_assert(!has(R.flags, flag::communication),
                      "a setting of the line goes to one node at a time, never to all of them");
        detail::check_wear<R>();
        detail::check_device<Device, R>();
        if (value.error() != errc::ok) return value.error();
        if constexpr (detail::takes_words<typename row_type<R>::value_type>)
            return other::template put_words<R, true>(*this, R.address, value);
        else if constexpr (raw::link_type::template are_cached<R>)
            return raw::template changed<true>(write_bits<row_type<R>::words, true>(R.address, value.bits()));
        else
            return write_bits<row_type<R>::words, true>(R.address, value.bits());
    }
    /// The same for one coil.
    template <const auto& R>
    requires is_bit<R>
    constexpr status broadcast(register_value<R> value) {
        return other::template write_coil<R, true>(*this, value);
    }
    /// The same for adjacent coils, in one frame.
    template <const auto&... Rs>
    requires(sizeof...(Rs) > 1) constexpr status broadcast(register_value<Rs>... values) {
        constexpr bool are_coils = (is_bit<Rs> && ...);
        static_assert(are_coils, "a broadcast has one register, or adjacent coils");
        if constexpr (are_coils)
            return other::template write_coils<false, true, Rs...>(*this, values...);
        else
            return {};
    }

  private:
    template <const auto& R> constexpr status put(register_value<R> value, const condition& on = {}) {
        detail::check_device<Device, R>();
        if (value.error() != errc::ok) return value.error();
        if (!node_.is_valid()) return errc::bad_argument;
        // The answer to a setting of the line may be the last one at this address.
        constexpr bool is_last = has(R.flags, flag::communication);
        if constexpr (detail::takes_words<typename row_type<R>::value_type>)
            return other::template put_words<R, false, is_last>(*this, R.address, value, on);
        else if constexpr (raw::link_type::template are_cached<R>)
            return raw::changed(write_bits<row_type<R>::words, false, is_last>(R.address, value.bits(), on));
        else
            return write_bits<row_type<R>::words, false, is_last>(R.address, value.bits(), on);
    }
    template <const auto& Rows>
    constexpr status put(std::size_t index, register_value<at<Rows, 0>> value, const condition& on = {}) {
        using rows = row_type<Rows>;
        static_assert(!detail::has_bits<Rows>, "a coil is written or stored without a token");
        detail::check_device<Device, Rows>();
        if (index >= rows::size) return errc::bad_argument;
        if (value.error() != errc::ok) return value.error();
        const u16 address = Rows[index].address;
        if constexpr (detail::takes_words<typename rows::value_type>)
            return other::template put_words<at<Rows, 0>>(*this, address, value, on);
        else if constexpr (raw::link_type::template has_cached_element<Rows>)
            return raw::written(address, rows::words, write_bits<rows::words>(address, value.bits(), on));
        else
            return write_bits<rows::words>(address, value.bits(), on);
    }
    template <const auto& R> constexpr status put_if_different(register_value<R> value) {
        constexpr std::size_t words = row_type<R>::words;
        static_assert(row_type<R>::rights == access::rw, "this register is write-only");
        detail::check_device<Device, R>();
        if (value.error() != errc::ok) return value.error();
        if constexpr (detail::takes_words<typename row_type<R>::value_type>) {
            const result<bool> is_held = other::template holds<R>(*this, value);
            if (!is_held) return is_held.status().with_sent(false);
            if (*is_held) return status::sent(errc::ok);
        } else {
            const result<u32> held = read_bits<words>(R.address);
            if (!held) return held.status().with_sent(false);
            const u32 mask = words == 2 ? 0xFFFF'FFFFu : 0xFFFFu;
            if (((*held ^ value.bits()) & mask) == 0) return status::sent(errc::ok);
        }
        return put<R>(value);
    }

    template <const auto&... Rs> [[gnu::always_inline]] constexpr result<readings<Rs...>> read_registers() {
        constexpr const auto& plan = readings<Rs...>::plan;
        constexpr bool has_pairs = readings<Rs...>::has_pairs;
        // Filled where the caller will have it: a copy would be a memcpy.
        result<readings<Rs...>> values{status{}};
        word_order order = current_word_order();
        std::uint8_t frame[5 + 2 * plan.words];
        status why{has_pairs && order == word_order::unknown ? errc::needs_word_order : errc::ok};
        std::size_t offset = 0;
        for (std::size_t i = 0; i < plan.count && why.error() == errc::ok; ++i) {
            const extent& part = plan.requests[i];
            if constexpr (is_fixed<Node> && plan.count == 1) {
                why = read_by(
                    detail::read_request<Node, plan.requests[0].address, plan.words, typename Line::crc>.all,
                    frame, values->words());
            } else {
                why = read_some(frame, part.address, values->words().subspan(offset, part.words));
            }
            offset += part.words;
            if constexpr (loses_word_order && has_pairs) { // an attempt had no response
                const word_order now = current_word_order();
                if (why.error() == errc::ok && !raw::is_one_order(i, order, now))
                    why = errc::needs_word_order;
                order = now;
            }
        }
        if (loses_word_order && has_pairs && why.error() == errc::ok && order == word_order::unknown)
            why = errc::needs_word_order;
        values->set_word_order(order);
        if (why.error() != errc::ok) {
            if constexpr (plan.count > 1 || loses_word_order) values->clear();
            values.fail(why);
        }
        return values;
    }

    template <const auto& R> constexpr result<reading<R>> read_at(u16 address) {
        const result<u32> bits = read_bits<row_type<R>::words>(address);
        if (!bits) return bits.status();
        return reading_of<R>(*bits);
    }

    template <std::size_t Words> constexpr result<u32> read_bits(u16 address) {
        if (Words == 2 && current_word_order() == word_order::unknown) return errc::needs_word_order;
        u16 words[Words]{};
        std::uint8_t frame[5 + 2 * Words];
        const status why = read_some(frame, address, words);
        if (why.error() != errc::ok) return why;
        if constexpr (Words == 2) {
            if constexpr (loses_word_order) { // an attempt had no response
                if (current_word_order() == word_order::unknown) return errc::needs_word_order;
            }
            return join_words(words[0], words[1], node_.word_order);
        } else {
            return u32{words[0]};
        }
    }

    template <std::size_t Words, bool IsBroadcast = false, bool AsksFirst = false>
    constexpr status write_bits(u16 address, u32 bits, condition on = {}) {
        if constexpr (Words == 2) {
            const word_order order = current_word_order();
            if (order == word_order::unknown) return errc::needs_word_order;
            on.use(order);
            const word_pair pair = split_words(bits, order);
            std::uint8_t frame[13];
            store_word(frame, 7, pair.first);
            store_word(frame, 9, pair.second);
            return raw::template write_many<IsBroadcast, AsksFirst>(frame, address, on);
        } else {
            return raw::template write_one<IsBroadcast, AsksFirst>(address, static_cast<u16>(bits), on);
        }
    }

    template <const auto&... Rs>
    [[gnu::always_inline]] constexpr status write_block(register_value<Rs>... values) {
        detail::check_device<Device, Rs...>();
        if constexpr (!detail::are_of<Device, Rs...>) {
            return {}; // the assertion is the only error
        } else {
            using plan = write_plan<Rs...>;
            plan::check();
            std::uint8_t frame[9 + 2 * plan::words];
            std::size_t used = 7;
            errc wrong = errc::ok;
            const auto put = [&](const auto& value, std::size_t size) {
                if (value.error() != errc::ok && wrong == errc::ok) wrong = value.error();
                if constexpr (detail::stores_words<decltype(value)>) {
                    detail::check_whole<std::remove_cvref_t<decltype(value)>>();
                    if (value.needs_word_order && this->current_word_order() == word_order::unknown &&
                        wrong == errc::ok)
                        wrong = errc::needs_word_order;
                    value.store(frame, used, this->node_.word_order);
                } else if (size == 2) {
                    if (this->current_word_order() == word_order::unknown && wrong == errc::ok)
                        wrong = errc::needs_word_order;
                    const word_pair pair = split_words(value.bits(), this->node_.word_order);
                    store_word(frame, used, pair.first);
                    store_word(frame, used + 2, pair.second);
                } else {
                    store_word(frame, used, static_cast<u16>(value.bits()));
                }
                used += 2 * size;
            };
            (put(values, row_type<Rs>::words), ...);
            if (wrong != errc::ok) return wrong;
            if constexpr (raw::link_type::template are_cached<Rs...>)
                return raw::changed(write_many(frame, plan::rows[0].address));
            else
                return write_many(frame, plan::rows[0].address);
        }
    }

    // Last, and not of the base: clang++ has no member that follows a failed assertion, and no base with one. It would
    // print an error for each use.
    static_assert(!is_fixed<Node> || Line::is_small,
                  "a fixed_node is for a blocking_line; on a line the figures of a node can be changed");
    static_assert(Device::facts.max_read <= modbus::max_read && Device::facts.max_write <= modbus::max_write,
                  "a frame has room for 125 registers that are read, and for 123 that are written");
};

template <class Line, device_class Device> client(Line&, node<Device>) -> client<Line, Device>;
template <class Line, device_class Device, std::uint8_t Address>
client(Line&, fixed_node<Device, Address>) -> client<Line, Device, fixed_node<Device, Address>>;

} // namespace servobus
