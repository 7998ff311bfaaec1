// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The requests of stepped calls beyond holding registers: rows of the other tables, and functions 16h and 17h.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/detail/row_rules.hpp>
#include <servobus/client/detail/stepped_request.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/read_write.hpp>
#include <servobus/registers/tables.hpp>

namespace servobus::detail {

/// One call at a time, as of its base, which moves it on.
template <class Link> class stepped_table_request : public stepped_request<Link> {
    using base = stepped_request<Link>;

  protected:
    static constexpr std::size_t coil_room = Link::refuses_function_05 ? 10 : 8;

    constexpr explicit stepped_table_request(Link& of) : base{of} {}

    /// Reads rows of any table. `frame` has `part_room` of the response.
    constexpr errc begin_part(std::uint8_t* frame, const table_extent& part) {
        if (const errc no = refusal(); no != errc::ok) return no;
        const std::size_t size = part.response_size();
        store_word({frame, base::part_room(size)}, base::part_room(size) - 2, part.quantity);
        return base::template begin<call_of::tables>(request_machine::read(), frame, size, part.address,
                                                     part.code());
    }
    /// Writes a value that stores its words itself.
    template <std::size_t Words, class Value>
    constexpr errc begin_words(std::uint8_t* frame, u16 address, const Value& value,
                               const typename base::condition& with, bool asks_first) {
        if (!base::done()) return errc::busy;
        const word_order order = value.needs_word_order ? base::current_order() : word_order::high_first;
        if (order == word_order::unknown) return base::refused(errc::needs_word_order);
        if constexpr (Words == 1) {
            std::uint8_t word[2];
            value.store(word, 0, order);
            return base::template begin_value<1>(frame, address, load_word(word, 0), with, asks_first);
        } else {
            typename base::condition on = with;
            if constexpr (Value::needs_word_order) on.use(order);
            value.store({frame, 7 + 2 * Words}, 7, order);
            return base::begin_block(frame, Words, address, on, asks_first);
        }
    }
    /// True if the response in `frame` may be the echo of the request that read `part`.
    constexpr bool is_echo(const table_extent& part, const std::uint8_t* frame) {
        return part.is_repeated_by({frame, 6}) && !base::is_echo_ruled_out();
    }
    /// Writes a coil by function 05, or coils whose bits lie in `frame` from its byte 7 on by 0F.
    constexpr errc begin_coil(std::uint8_t* frame, u16 address, bool is_on) {
        if constexpr (Link::refuses_function_05) {
            if (!base::done()) return errc::busy;
            frame[7] = is_on ? 1 : 0;
            return begin_coils(frame, address, 1);
        } else {
            return begin_coil_word(frame, address, is_on ? u16{0xFF00} : u16{0});
        }
    }
    /// Function 05 with any word.
    constexpr errc begin_coil_word(std::uint8_t* frame, u16 address, u16 word) {
        static_assert(!Link::refuses_function_05, "this device takes no function 05");
        if (const errc no = refusal(); no != errc::ok) return no;
        modbus::put_trusted_request({frame + 1, 5}, modbus::function::write_single_coil, address, word);
        return begin_bits(frame, 8, address);
    }
    constexpr errc begin_coils(std::uint8_t* frame, u16 address, u16 count) {
        if (const errc no = refusal(); no != errc::ok) return no;
        const std::size_t payload = modbus::bytes_of_bits(count);
        modbus::detail::put_coils_head({frame + 1, 6}, address, count, payload);
        return begin_bits(frame, 9 + payload, address);
    }
    /// Changes bits of a register by function 16h; `frame` has ten bytes.
    constexpr errc begin_masked(std::uint8_t* frame, u16 address, u16 and_mask, u16 or_mask) {
        if (const errc no = refusal(); no != errc::ok) return no;
        const byte_buffer request{frame, 10};
        request[0] = base::node().address;
        modbus::put_mask_write_request(request.subspan(1), {address, and_mask, or_mask});
        (void)modbus::close_trusted<typename base::crc>(request, 7);
        return base::template begin<call_of::masked>(request_machine::write(), frame, 10, address, frame[1]);
    }
    /// Writes the words that lie in `frame` from its byte 11 on, and reads `read`, by function 17h.
    constexpr errc begin_both(std::uint8_t* frame, const both_extents& both,
                              const typename base::condition& on) {
        if (const errc no = refusal(); no != errc::ok) return no;
        const std::size_t words = both.written.words;
        const byte_buffer request{frame, 13 + 2 * words};
        request[0] = base::node().address;
        modbus::detail::put_read_write_head(request.subspan(1), both.read.address, both.read.words,
                                            both.written.address, both.written.words);
        (void)modbus::close_trusted<typename base::crc>(request, request.size() - 3);
        base::set_condition(on);
        // The address is in the request; its place has the length of the response.
        return base::template begin<call_of::both>(request_machine::transaction(), frame, request.size(),
                                                   static_cast<u16>(5 + 2 * both.read.words), frame[1]);
    }

  private:
    // The error with which a call cannot begin.
    constexpr errc refusal() {
        if (!base::done()) return errc::busy;
        return base::node().is_valid() ? errc::ok : base::refused(errc::bad_argument);
    }
    // The PDU is in `frame` already.
    constexpr errc begin_bits(std::uint8_t* frame, std::size_t size, u16 address) {
        const byte_buffer request{frame, size};
        request[0] = base::node().address;
        (void)modbus::close_trusted<typename base::crc>(request, size - 3);
        return base::template begin<call_of::tables>(request_machine::write(), frame, size, address,
                                                     frame[1]);
    }
};

} // namespace servobus::detail
