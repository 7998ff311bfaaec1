// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The calls of a client beyond holding registers: rows of the other tables, and functions 16h and 17h. A program has
// one copy for each type of client of what needs addresses only. any_device.hpp includes it.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/client.hpp>
#include <servobus/client/detail/row_rules.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/read_write.hpp>
#include <servobus/registers/tables.hpp>

namespace servobus::detail {

template <class Line, device_class Device, class Node> struct table_calls<client<Line, Device, Node>> {
    using own = client<Line, Device, Node>;
    using crc = typename Line::crc;
    static_assert(most_bits == modbus::max_read_bits);

    template <const auto& R> static constexpr result<bool> read_bit(own& of) {
        check_device<Device, R>();
        static_assert(row_type<R>::rights != access::wo, "this coil is write-only");
        return bit_of(of, only_request<R>);
    }
    static constexpr result<bool> bit_of(own& of, const table_extent& one) {
        std::uint8_t frame[6];
        const status why = read_part(of, one, frame, sizeof frame);
        if (why.error() != errc::ok) return why;
        if (frame[3] > 1) return status::sent(errc::unexpected_value);
        return frame[3] == 1;
    }
    /// One input register, or two.
    template <const auto& R> static constexpr result<reading<R>> read_input(own& of) {
        const result<readings<R>> one = read_rows<R>(of);
        if (!one) return one.status();
        return one->template get<R>();
    }
    /// Element `index` of an array of coils or inputs, which is below its size.
    template <const auto& Rows>
    static constexpr result<reading<at<Rows, 0>>> read_element(own& of, std::size_t index) {
        constexpr std::size_t words = row_type<Rows>::words;
        const table_extent one{table_of<Rows>, Rows[index].address, static_cast<u16>(words), 0};
        if constexpr (has_bits<Rows>) {
            return bit_of(of, one);
        } else {
            constexpr bool needs_order = needs_word_order<at<Rows, 0>>();
            using type = typename row_type<Rows>::value_type;
            if (needs_order && of.current_word_order() == word_order::unknown) return errc::needs_word_order;
            std::uint8_t frame[5 + 2 * words];
            if (const status why = read_part(of, one, frame, sizeof frame); !why) return why;
            if constexpr (takes_words<type>) {
                const word_order order = needs_order ? of.current_word_order() : word_order::high_first;
                if (order == word_order::unknown) return errc::needs_word_order;
                return codec<type>::template value_in<at<Rows, 0>>(
                    [&](std::size_t i) { return load_word(frame, 3 + 2 * i); }, order);
            } else if constexpr (words == 1) {
                return reading_of<at<Rows, 0>>(load_word(frame, 3));
            } else {
                const word_order order = of.current_word_order(); // stale if an attempt had no response
                if (order == word_order::unknown) return errc::needs_word_order;
                return reading_of<at<Rows, 0>>(join_words(load_word(frame, 3), load_word(frame, 5), order));
            }
        }
    }
    /// Rows of any tables. If one request fails there is no value at all.
    template <const auto&... Rs> static constexpr result<readings<Rs...>> read_rows(own& of) {
        using all = readings<Rs...>;
        constexpr const auto& plan = all::plan;
        result<all> values{status{}};
        word_order order = all::has_pairs ? of.current_word_order() : word_order::high_first;
        status why{order == word_order::unknown ? errc::needs_word_order : errc::ok};
        std::uint8_t frame[plan.longest_response];
        for (std::size_t i = 0; i < plan.count && why.error() == errc::ok; ++i) {
            const table_extent& part = plan.count == 1 ? only_request<Rs...> : plan.requests[i];
            const std::size_t size = part.response_size();
            if constexpr (is_fixed<Node> && plan.count == 1)
                why = repeated(of, constant_request<plan.requests[0].code(), plan.requests[0].address,
                                                    plan.requests[0].quantity>.all,
                               frame, size);
            else
                why = read_part(of, part, frame, size);
            if (why.error() != errc::ok) break;
            if constexpr (plan.has_echo_like_response) {
                if (part.is_repeated_by(frame) && !of.line_->is_echo_ruled_out(of.node_.address)) {
                    why = status::sent(errc::own_echo);
                    break;
                }
            }
            if (!values->take(i, bytes{frame}.subspan(3, part.size())))
                why = status::sent(errc::unexpected_value);
            if constexpr (own::loses_word_order && all::has_pairs) { // an attempt had no response
                const word_order now = of.current_word_order();
                if (!own::is_one_order(i, order, now) || now == word_order::unknown)
                    why = errc::needs_word_order;
                order = now;
            }
        }
        values->set_word_order(order);
        if (why.error() != errc::ok) {
            if constexpr (plan.count > 1 || plan.requests[0].has_bits() || own::loses_word_order)
                values->clear();
            values.fail(why);
        }
        return values;
    }

    /// A value that stores its words itself.
    template <const auto& R, bool IsBroadcast = false, bool AsksFirst = false>
    static constexpr status put_words(own& of, u16 address, const register_value<R>& value,
                                      typename own::condition on = {}) {
        constexpr std::size_t words = row_type<R>::words;
        check_whole<register_value<R>>();
        const word_order order = value.needs_word_order ? of.current_word_order() : word_order::high_first;
        if (order == word_order::unknown) return errc::needs_word_order;
        std::uint8_t frame[9 + 2 * words];
        value.store(frame, 7, order);
        if constexpr (words == 1) {
            return noted<R, IsBroadcast>(
                of, address, of.template write_one<IsBroadcast, AsksFirst>(address, load_word(frame, 7), on));
        } else {
            if constexpr (register_value<R>::needs_word_order) on.use(order);
            return noted<R, IsBroadcast>(of, address,
                                         of.template write_many<IsBroadcast, AsksFirst>(frame, address, on));
        }
    }
    template <const auto& R, bool IsBroadcast>
    static constexpr status noted(own& of, [[maybe_unused]] u16 address, status why) {
        if constexpr (IsBroadcast && own::link_type::template are_cached<R>)
            return of.template changed<true>(why);
        else if constexpr (!IsBroadcast)
            return of.written(address, row_type<R>::words, why);
        else
            return why;
    }
    /// True if the device holds the value.
    template <const auto& R> static constexpr result<bool> holds(own& of, const register_value<R>& value) {
        constexpr std::size_t size = 2 * row_type<R>::words;
        std::uint8_t frame[5 + size];
        const status why = read_part(of, only_request<R>, frame, sizeof frame);
        if (why.error() != errc::ok) return why;
        const word_order order = value.needs_word_order ? of.current_word_order() : word_order::high_first;
        if (order == word_order::unknown) return errc::needs_word_order;
        std::uint8_t wanted[size];
        value.store(wanted, 0, order);
        return same_bytes(bytes{frame}.subspan(3, size), wanted);
    }

    template <const auto& R, bool IsBroadcast, bool Wears = false>
    static constexpr status write_coil(own& of, const register_value<R>& value) {
        check_coils<Device, Wears, R>();
        return write_bit<IsBroadcast>(of, R.address, value.bits() != 0);
    }
    /// Function 05 with a word of the device. The coil's state after it is not compared; an echo is ruled out.
    template <const auto& R> static constexpr status write_coil_word(own& of, coil_word word) {
        check_coils<Device, false, R>();
        static_assert(!Device::facts.refuses_function_05(), "this device takes no function 05");
        return write_05<false>(of, R.address, word.value);
    }
    template <const auto& Rows, bool Wears>
    static constexpr status write_element(own& of, std::size_t index,
                                          const register_value<at<Rows, 0>>& value) {
        check_coils<Device, Wears, at<Rows, 0>>();
        if (index >= row_type<Rows>::size) return errc::bad_argument;
        return write_bit(of, Rows[index].address, value.bits() != 0);
    }
    template <bool Wears, bool IsBroadcast, const auto&... Rs>
    static constexpr status write_coils(own& of, const register_value<Rs>&... values) {
        using plan = coils_plan<Device, Rs...>;
        check_coils<Device, Wears, Rs...>();
        std::uint8_t frame[plan::room];
        plan::put(frame, values...);
        return write_bits<IsBroadcast>(of, frame, plan::rows[0].address, plan::count);
    }

    template <const auto& R> static constexpr status change_part(own& of, const register_value<R>& value) {
        check_part<Device, R>();
        if (value.error() != errc::ok) return value.error();
        return change<R, part_mask<R>()>(of, static_cast<u16>(value.bits()));
    }
    template <const auto& R, u16 Mask> static constexpr status change_bits(own& of, u16 value) {
        check_mask<Device, R, Mask>();
        return change<R, Mask>(of, value);
    }
    template <const auto& R, u16 Mask> static constexpr status change(own& of, u16 value) {
        const auto kept = static_cast<u16>(~Mask);
        if constexpr (own::link_type::template are_cached<R>)
            return of.changed(write_masked(of, R.address, kept, static_cast<u16>(value & Mask)));
        else
            return write_masked(of, R.address, kept, static_cast<u16>(value & Mask));
    }
    template <class Reads, const auto&... Ws>
    static constexpr auto write_then_read(own& of, const register_value<Ws>&... values) {
        using plan = both_plan<Device, Reads, Ws...>;
        plan::check();
        write_plan<Ws...>::check();
        if constexpr (plan::are_holding) // else the assertion is the only error
            return write_then_read_by<plan, Ws...>(of, values...);
        else
            return status{};
    }
    template <class Plan, const auto&... Ws>
    static constexpr auto write_then_read_by(own& of, const register_value<Ws>&... values) {
        using plan = Plan;
        result<typename plan::values> read{status{}};
        std::uint8_t request[plan::request];
        std::uint8_t response[plan::response];
        status why;
        const word_order order = plan::has_pairs ? of.current_word_order() : word_order::high_first;
        if (order == word_order::unknown) why = errc::needs_word_order;
        if (const errc wrong = plan::put(request, order, values...); wrong != errc::ok) why = wrong;
        if (why.error() == errc::ok) {
            why = write_and_read(of, request, plan::extents, response);
            if constexpr (own::link_type::template are_cached<Ws...>) (void)of.changed(why);
        }
        if constexpr (plan::has_echo_like_response) {
            if (why.error() == errc::ok && !of.line_->is_echo_ruled_out(of.node_.address) &&
                same_bytes(response, request))
                why = status::sent(errc::own_echo);
        }
        if (why.error() == errc::ok) {
            plan::take(read, bytes{response}.subspan(3, std::size_t{2} * plan::read.words), order);
        } else {
            read.fail(why);
        }
        return read;
    }

  private:
    /// One request with retries. `size`: of the whole response.
    [[gnu::noinline]] static constexpr status read_part(own& of, const table_extent& part,
                                                        std::uint8_t* response, std::size_t size) {
        if (!of.node_.is_valid()) return errc::bad_argument;
        const short_request request = request_for(of.node_.address, part.code(), part.address, part.quantity);
        return repeated(of, request.all, response, size);
    }
    static constexpr status repeated(own& of, const std::uint8_t* request, std::uint8_t* response,
                                     std::size_t size) {
        status why;
        request_machine call = request_machine::read();
        do why = of.carried(bytes{request, 8}, byte_buffer{response, size});
        while (call.goes_on(why, of.node_, false, false));
        return why;
    }
    static constexpr short_request request_for(std::uint8_t node_address, std::uint8_t code, u16 address,
                                               u16 quantity) {
        short_request r{};
        r.all[0] = node_address;
        modbus::put_trusted_request(byte_buffer{r.all}.subspan(1), static_cast<modbus::function>(code),
                                    address, quantity);
        (void)modbus::close_trusted<crc>(r.all, 5);
        return r;
    }
    /// A read of a fixed node, in flash.
    template <std::uint8_t Code, u16 Address, u16 Quantity>
    static constexpr short_request constant_request = request_for(Node::address, Code, Address, Quantity);

    template <bool IsBroadcast = false> static constexpr status write_bit(own& of, u16 address, bool is_on) {
        if constexpr (Device::facts.refuses_function_05()) {
            std::uint8_t frame[10];
            frame[7] = is_on ? 1 : 0;
            return write_bits<IsBroadcast>(of, frame, address, 1);
        } else {
            return write_05<IsBroadcast>(of, address, is_on ? modbus::coil_on : modbus::coil_off);
        }
    }
    /// Writes one coil, function 05. The response repeats the request: where it may be an echo, the coil is read.
    template <bool IsBroadcast>
    [[gnu::noinline]] static constexpr status write_05(own& of, u16 address, u16 word) {
        if (!IsBroadcast && !of.node_.is_valid()) return errc::bad_argument;
        std::uint8_t frame[8];
        frame[0] = IsBroadcast ? modbus::broadcast : of.node_.address;
        modbus::put_trusted_request(byte_buffer{frame}.subspan(1), modbus::function::write_single_coil,
                                    address, word);
        (void)modbus::close_trusted<crc>(frame, 5);
        const status why = of.template carried<IsBroadcast>(frame, frame, true);
        return IsBroadcast ? why : rules_out_echo<modbus::function::read_coils>(of, why, address);
    }
    /// Writes adjacent coils, function 0Fh, whose packed bits lie in `frame` from its byte 7 on.
    template <bool IsBroadcast>
    [[gnu::noinline]] static constexpr status write_bits(own& of, byte_buffer frame, u16 address, u16 count) {
        if (!IsBroadcast && !of.node_.is_valid()) return errc::bad_argument;
        frame[0] = IsBroadcast ? modbus::broadcast : of.node_.address;
        modbus::detail::put_coils_head(frame.subspan(1), address, count, frame.size() - 9);
        (void)modbus::close_trusted<crc>(frame, frame.size() - 3);
        return of.template carried<IsBroadcast>(frame, frame.first(8));
    }

    /// Changes some bits of a register, function 16h.
    [[gnu::noinline]] static constexpr status write_masked(own& of, u16 address, u16 and_mask, u16 or_mask) {
        if (!of.node_.is_valid()) return errc::bad_argument;
        std::uint8_t frame[10];
        frame[0] = of.node_.address;
        modbus::put_mask_write_request(byte_buffer{frame}.subspan(1), {address, and_mask, or_mask});
        (void)modbus::close_trusted<crc>(frame, 7);
        status why = of.carried(frame, frame, true);
        // A blocking line takes a byte count in each response of a device that may send one.
        if constexpr (Line::is_small) {
            if (of.node_.limits.echoes_byte_count && why.error() == errc::ok &&
                (load_word(frame, 4) != and_mask || load_word(frame, 6) != or_mask))
                why = status::sent(errc::wrong_value);
        }
        return rules_out_echo<modbus::function::read_holding_registers>(of, why, address);
    }

    /// Writes and then reads registers, function 17h. The values to write lie in `request` from its byte 11 on.
    [[gnu::noinline]] static constexpr status write_and_read(own& of, std::uint8_t* request_data,
                                                             const both_extents& both,
                                                             std::uint8_t* response_data) {
        if (!of.node_.is_valid()) return errc::bad_argument;
        const std::size_t written = std::size_t{2} * both.written.words; // bytes
        const byte_buffer request{request_data, 13 + written};
        const byte_buffer response{response_data, 5 + std::size_t{2} * both.read.words};
        request[0] = of.node_.address;
        modbus::detail::put_read_write_head(request.subspan(1), both.read.address, both.read.words,
                                            both.written.address, both.written.words);
        (void)modbus::close_trusted<crc>(request, request.size() - 3);
        return of.carried_both(request, response);
    }

    template <modbus::function Asks>
    static constexpr status rules_out_echo(own& of, status why, u16 address) {
        request_machine call = request_machine::write();
        const bool goes_on = call.goes_on(why, of.node_, true, of.line_->is_echo_ruled_out(of.node_.address));
        return goes_on ? status::sent(of.template ask<false, Asks>(address)) : why;
    }
};

} // namespace servobus::detail
