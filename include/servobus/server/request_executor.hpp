// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Executes requests on the rows of a device: the server without a line. server/row_server.hpp receives requests on a
// serial line and executes them by it; a program that gets PDUs in another way, such as Modbus TCP, includes it.
//
//     constexpr auto answer = [](auto& values, auto& pdu, std::size_t size) { // `pdu`: an array of 253 bytes
//         using values_of_device = std::remove_reference_t<decltype(values)>;
//         return request_executor<values_of_device, with_mask_write>{values}.execute(pdu, size);
//     };
//
// The rows bring along the functions that read their tables (01 .. 04) and write them (05, 06, 0Fh, 10h). The checks
// have the order of the standard: the function (exception 1), quantity and byte count (3), the addresses (2), the
// values (3). A request is checked whole before anything changes.
//
// Source: Modbus Application Protocol V1.1b3, section 6.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/read_write.hpp>
#include <servobus/server/detail/identify.hpp>
#include <servobus/server/detail/row_walk.hpp>
#include <servobus/server/options.hpp>
#include <servobus/server/row_values.hpp>

namespace servobus {

/// Executes request PDUs on `Values`, a `row_values`.
template <class Values, class... Options> class request_executor {
    static_assert(((detail::option_number<Options> != 0) && ...),
                  "this is no option of a server: see server/options.hpp");
    static_assert(detail::has_each_once<Options...>(), "a server has each option once");

    using hooks = typename detail::hooks_among<Options...>::type;
    using objects = typename detail::identification_among<Options...>::type;
    using server_id = typename detail::server_id_among<Options...>::type;
    static constexpr bool has_hooks = !std::is_void_v<hooks>;
    template <class O> static constexpr bool has = (std::is_same_v<O, Options> || ...);

    static constexpr const auto& list = Values::list;
    static constexpr bool has_bits = list.first[2] != 0;
    static constexpr bool has_words = list.first[4] != list.first[2];
    static constexpr bool writes_words = list.can_write[2];
    static constexpr bool has_mask_write = has<with_mask_write>;
    static constexpr bool has_read_write = has<with_read_write>;
    static_assert((!has_mask_write && !has_read_write) || (writes_words && list.can_read[2]),
                  "functions 16h and 17h need holding registers that clients read and write");

    using walk = detail::row_walk<Values, has_read_write>;
    using step = detail::walk_step;

    static constexpr std::size_t larger(std::size_t a, std::size_t b) { return a < b ? b : a; }
    static constexpr std::size_t smaller(std::size_t a, std::size_t b) { return a < b ? a : b; }
    // The most that a request may have, in words.
    static constexpr unsigned max_read = smaller(modbus::max_read, Values::device::facts.max_read);
    static constexpr unsigned max_write = smaller(modbus::max_write, Values::device::facts.max_write);
    static constexpr unsigned max_write_of_read_write = smaller(modbus::max_write_of_read_write, max_write);
    // The most that a request for rows that exist has, in bytes.
    static constexpr std::size_t longest_bits_read =
        modbus::bytes_of_bits(smaller(list.longest_bits, modbus::max_read_bits));
    static constexpr std::size_t longest_bits_write =
        modbus::bytes_of_bits(smaller(list.longest_bits, modbus::max_write_bits));
    static constexpr std::size_t longest_read = 2 * smaller(list.longest_run, max_read);
    static constexpr std::size_t longest_write = 2 * smaller(list.longest_write, max_write);

  public:
    /// The longest request for rows that exist, in bytes. Longer ones are refused whatever they contain.
    static constexpr std::size_t longest_request = [] {
        const std::size_t words =
            has_read_write ? 10 + smaller(longest_write, std::size_t{2} * max_write_of_read_write) : 0;
        return larger(larger(6 + larger(longest_write, longest_bits_write), words), 7);
    }();
    /// The longest response, in bytes.
    static constexpr std::size_t longest_response = [] {
        std::size_t most = larger(2 + larger(longest_read, longest_bits_read), 7);
        if constexpr (!std::is_void_v<objects>) most = larger(most, detail::least_room<objects>());
        if constexpr (!std::is_void_v<server_id>)
            most = larger(most, server_id::size + 3 + server_id::additional_size);
        return most;
    }();
    /// The smallest buffer, in bytes.
    static constexpr std::size_t buffer_size = larger(longest_request, longest_response);

    static_assert(buffer_size <= modbus::max_pdu);

    constexpr explicit request_executor(Values& values) requires(!has_hooks) : values_{&values} {}
    /// `owner` has the hooks. It outlives the executor, as `values` does.
    template <class H>
    requires(has_hooks&& std::is_same_v<H, hooks>) constexpr request_executor(Values& values, H& owner)
        : values_{&values}, hooks_{&owner} {
        static_assert(
            write_hooks<H, Values>,
            "hooks are std::uint8_t before_write(const changes<Values>&) and void after_write of the same");
    }

    /// Executes the request at the beginning of `pdu` and builds the response there. `size` is the length of the
    /// request, which may be more than the buffer has room for. Returns the length of the response; 0 for what is no
    /// request: not 1 to 253 bytes, or a function code with the exception flag.
    template <std::size_t N> constexpr std::size_t execute(std::uint8_t (&pdu)[N], std::size_t size) {
        static_assert(N >= buffer_size, "the buffer of a request has at least buffer_size bytes");
        return size == 0 || size > modbus::max_pdu
                   ? 0
                   : execute_at(pdu, N < modbus::max_pdu ? N : modbus::max_pdu, size);
    }

    /// True if a broadcast of this function may be executed, without a response. Nothing is read.
    static constexpr bool takes_broadcast(std::uint8_t code) {
        if (walk::must_probe && code <= 4) return false; // without a response the other reads do nothing
        return !has_read_write || code != 0x17;
    }

  protected:
    // `room` bytes belong to the buffer.
    constexpr std::size_t execute_at(std::uint8_t* pdu, [[maybe_unused]] std::size_t room, std::size_t size) {
        const unsigned code = pdu[0];
        if (code >= modbus::exception_flag) return 0;
        const unsigned refused = run(pdu, room, size);
        if (refused == 0) return size_of_response(pdu, size);
        pdu[0] = static_cast<std::uint8_t>(code | modbus::exception_flag);
        pdu[1] = static_cast<std::uint8_t>(refused);
        return 2;
    }

  private:
    static constexpr unsigned illegal_function = 1, illegal_address = 2, illegal_value = 3;

    // The size of a response that `run` has made.
    static constexpr std::size_t size_of_response(const std::uint8_t* p, [[maybe_unused]] std::size_t size) {
        const unsigned code = p[0];
        if (code <= 4 || (has_read_write && code == 0x17)) return 2u + p[1];
        if constexpr (!std::is_void_v<server_id>) {
            if (code == 0x11) return 2u + p[1];
        }
        if constexpr (!std::is_void_v<objects>) {
            if (code == 0x2B) return detail::size_of_identification(p);
        }
        if constexpr (has_mask_write || has<with_return_query_data>) {
            if (code == 0x16 || code == 0x08) return size;
        }
        return 5;
    }

    // A bit for each function below 20h that is served.
    static constexpr u32 served_functions = [] {
        u32 set = 0;
        for (unsigned t = 0; t < 4; ++t) set |= list.can_read[t] ? 2u << t : 0u;
        if (list.can_write[0]) set |= u32{1} << 0x05 | u32{1} << 0x0F;
        if (writes_words) set |= u32{1} << 0x06 | u32{1} << 0x10;
        if (has_mask_write) set |= u32{1} << 0x16;
        if (has_read_write) set |= u32{1} << 0x17;
        if (has<with_return_query_data>) set |= u32{1} << 0x08;
        if (!std::is_void_v<server_id>) set |= u32{1} << 0x11;
        return set;
    }();
    static constexpr unsigned word_at(const std::uint8_t* p) { return p[0] * 256u + p[1]; }

    // From here on each returns 0, or an exception.
    constexpr unsigned run(std::uint8_t* p, [[maybe_unused]] std::size_t room, std::size_t size) {
        const unsigned code = p[0];
        if constexpr (!std::is_void_v<objects>) {
            if (code == 0x2B) return detail::identify<objects>(p, room, size);
        }
        if (code >= 32 || (served_functions >> code & 1u) == 0) return illegal_function;
        if constexpr (has_mask_write) {
            if (code == 0x16) return mask(p, size);
        }
        if constexpr (has_read_write) {
            if (code == 0x17) return write_then_read(p, size);
        }
        if constexpr (has<with_return_query_data>) {
            if (code == 0x08) {
                if (size >= 3 && word_at(p + 1) != 0) return illegal_function; // another sub-function
                return size < 5 || size % 2 == 0 || size > room ? illegal_value : 0;
            }
        }
        if constexpr (!std::is_void_v<server_id>) {
            if (code == 0x11) return size == 1 ? detail::report<server_id>(p) : illegal_value;
        }
        return access_rows(p, size);
    }

    // Functions 01 .. 06, 0Fh and 10h. Inlined: 24 bytes of flash and 24 of stack less on a Cortex-M0+.
    [[gnu::always_inline]] constexpr unsigned access_rows(std::uint8_t* p, std::size_t size) {
        const unsigned code = p[0];
        const unsigned address = word_at(p + 1);
        unsigned quantity = word_at(p + 3);
        const bool is_reading = code <= 4;
        const bool is_bits = has_bits && (!has_words || code <= 2 || code == 0x05 || code == 0x0F);
        unsigned most = is_bits ? modbus::max_read_bits : max_read;
        std::size_t expected = 5;
        std::uint8_t* data = p + 3;
        const unsigned payload = is_bits ? (quantity + 7) / 8 : 2 * quantity;
        if (code == 0x05 || code == 0x06) {
            if (is_bits && quantity != modbus::coil_on && quantity != modbus::coil_off) return illegal_value;
            quantity = 1;
        } else if (!is_reading) {
            if (is_bits) most = modbus::max_write_bits;
            if (!is_bits && max_write < modbus::max_write)
                most = max_write; // else a PDU has no room for more
            expected = 6 + payload;
            data = p + 6;
            if (p[5] != payload) return illegal_value;
        }
        if (size != expected || quantity - 1 >= most) return illegal_value;
        if (!is_reading) return change(is_bits ? 0 : 2, address, quantity, data);
        if constexpr (walk::must_probe) {
            if (walk::go(*values_, step::probe, code - 1, address, quantity, p + 2) != 0)
                return illegal_address;
        }
        p[1] = static_cast<std::uint8_t>(payload);
        return walk::go(*values_, in_order(step::read), code - 1, address, quantity, p + 2);
    }

    constexpr step in_order(step what) const { return walk::in(values_->order_of_pairs(), what); }

    // Changes all or nothing.
    constexpr unsigned change(unsigned of, unsigned address, unsigned quantity, std::uint8_t* data) {
        const word_order order = values_->order_of_pairs(); // the request may switch it
        const unsigned wrong = walk::go(*values_, walk::in(order, step::check), of, address, quantity, data);
        if (wrong != 0) return wrong;
        if constexpr (has_hooks) {
            const changes<Values> written{
                *values_, static_cast<table>(of), static_cast<u16>(address), static_cast<u16>(quantity), data,
                order};
            const unsigned refusal = hooks_->before_write(written);
            if (refusal != 0) return refusal;
            (void)walk::go(*values_, walk::in(order, step::store), of, address, quantity, data);
            hooks_->after_write(written);
            return 0;
        } else {
            return walk::go(*values_, walk::in(order, step::store), of, address, quantity, data);
        }
    }

    constexpr unsigned mask(std::uint8_t* p, std::size_t size) {
        if (size != 7) return illegal_value;
        std::uint8_t data[2]{};
        const unsigned address = word_at(p + 1);
        if (walk::go(*values_, step::read, 2, address, 1, data) != 0) return illegal_address;
        for (unsigned i = 0; i < 2; ++i)
            data[i] = static_cast<std::uint8_t>((data[i] & p[3 + i]) | (p[5 + i] & ~unsigned{p[3 + i]}));
        return change(2, address, 1, data);
    }

    // Both parts are checked before anything changes. The read returns what was written.
    constexpr unsigned write_then_read(std::uint8_t* p, std::size_t size) {
        const unsigned from = word_at(p + 1), quantity = word_at(p + 3);
        const unsigned written = word_at(p + 7);
        if (size != 10 + 2 * written || p[9] != 2 * written || quantity - 1 >= max_read ||
            written - 1 >= max_write_of_read_write)
            return illegal_value;
        if (walk::go(*values_, step::probe, 2, from, quantity, p + 2) != 0) return illegal_address;
        const unsigned wrong = change(2, word_at(p + 5), written, p + 10);
        if (wrong != 0) return wrong;
        p[1] = static_cast<std::uint8_t>(2 * quantity);
        return walk::go(*values_, in_order(step::read), 2, from, quantity, p + 2);
    }

    struct none {};

    Values* values_;
    [[no_unique_address]] std::conditional_t<has_hooks, std::add_pointer_t<hooks>, none> hooks_{};
};

} // namespace servobus
