// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Options of a server: functions beyond those that its rows bring along, hooks, and more. Each is a type among the
// server's template arguments, so an option that does not exist does not compile. server/request_executor.hpp includes
// it.
//
//     constexpr identity about[]{{0, "Example works"}, {1, "T-10"}, {2, "1.0"}};
//     template <class Values> using tank_server =
//         request_executor<Values, with_mask_write, with_read_write, with_identification<about>>;
//
// Source: Modbus Application Protocol V1.1b3, sections 6.8, 6.13, 6.16, 6.17 and 6.21.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/modbus/crc16.hpp>
#include <servobus/server/changes.hpp>

namespace servobus {

/// Function 16h: changes some bits of a register.
struct with_mask_write {};
/// Function 17h: writes registers, then reads registers.
struct with_read_write {};
/// Function 08 with sub-function 0: returns the request, up to the server's buffer.
struct with_return_query_data {};

/// An object of a device's identification: vendor name (0), product code (1), revision (2), URL (3), product name (4),
/// model name (5), application name (6), or one of its own (80h and above).
struct identity {
    std::uint8_t id;
    std::uint8_t size;
    const char* text;

    static constexpr std::size_t longest = 244; ///< characters that fit a response

    template <std::size_t N>
    consteval identity(std::uint8_t object, const char (&value)[N])
        : id{object}, size{static_cast<std::uint8_t>(N - 1)}, text{value} {
        static_assert(N - 1 <= longest, "an object of an identification has at most 244 characters");
    }
};

/// Function 2Bh/0Eh: the device's identification. `Objects` is an array of `identity` in the order of their IDs, which
/// begins with 0, 1 and 2.
template <const auto& Objects> struct with_identification {
    static constexpr const identity* begin() { return &Objects[0]; }
    static constexpr std::size_t count = sizeof Objects / sizeof *Objects;
    static constexpr bool is_in_order = [] {
        for (std::size_t i = 1; i < count; ++i) {
            if (Objects[i].id <= Objects[i - 1].id) return false;
        }
        return count >= 3 && Objects[2].id == 2;
    }();
    static_assert(is_in_order, "an identification has objects 0, 1 and 2, and its objects ascend");
};

namespace detail {
inline constexpr char no_data[] = "";
}

/// Function 11h: the device's ID, an array of characters, a run indicator that is on, and additional data of the
/// device's own, another such array. Either may have zeros inside, as binary data has: "\x02\0\x01".
template <const auto& Text, const auto& Additional = detail::no_data> struct with_server_id {
    static constexpr const char* text() { return &Text[0]; }
    static constexpr std::size_t size = sizeof Text - 1;
    static constexpr const char* additional() { return &Additional[0]; }
    static constexpr std::size_t additional_size = sizeof Additional - 1;
    static_assert(size >= 1 && size <= 250, "a server's ID has 1 to 250 characters");
    static_assert(size + additional_size <= 250,
                  "a server's ID and its additional data have at most 250 characters");
};

/// The engine of the CRC of a `row_server`.
template <modbus::crc_engine Crc> struct with_crc {};

/// Skips up to `Count` bytes 00 or FF between a gap and a frame, as an RS-485 driver that is switched on sends them.
/// For a `row_server`, whose buffer is as much longer. A `host_row_server` skips four without an option.
template <std::uint8_t Count> struct with_leading_bytes {};

/// A class with both hooks of a server's writes.
template <class H, class Values>
concept write_hooks = requires(H& hooks, const changes<Values>& written) {
    { hooks.before_write(written) } -> std::same_as<std::uint8_t>;
    { hooks.after_write(written) } -> std::same_as<void>;
};

/// Calls `before_write` when a write has been checked: it returns 0, or the exception that refuses the write. Calls
/// `after_write` when it is stored. The server refers to an object of `Hooks`, which has both:
///
///     std::uint8_t before_write(const changes<Values>& written);
///     void after_write(const changes<Values>& written);
template <class Hooks> struct with_hooks {};

namespace detail {
/// A number for each option; 0 for what is none. The last two are for servers on a line with strict timing.
template <class O> inline constexpr unsigned option_number = 0;
template <> inline constexpr unsigned option_number<with_mask_write> = 1;
template <> inline constexpr unsigned option_number<with_read_write> = 2;
template <> inline constexpr unsigned option_number<with_return_query_data> = 3;
template <const auto& O> inline constexpr unsigned option_number<with_identification<O>> = 4;
template <const auto& T, const auto& A> inline constexpr unsigned option_number<with_server_id<T, A>> = 5;
template <class H> inline constexpr unsigned option_number<with_hooks<H>> = 6;
template <class C> inline constexpr unsigned option_number<with_crc<C>> = 7;
template <std::uint8_t N> inline constexpr unsigned option_number<with_leading_bytes<N>> = 8;

template <class... Options> constexpr bool has_each_once() {
    const unsigned numbers[]{0, option_number<Options>...};
    for (std::size_t i = 1; i <= sizeof...(Options); ++i) {
        for (std::size_t other = 1; other < i; ++other) {
            if (numbers[i] == numbers[other]) return false;
        }
    }
    return true;
}

/// The hooks among the options; `void` without any.
template <class... Options> struct hooks_among { using type = void; };
template <class H, class... Others> struct hooks_among<with_hooks<H>, Others...> { using type = H; };
template <class Other, class... Others> struct hooks_among<Other, Others...> : hooks_among<Others...> {};

template <class... Options> inline constexpr std::uint8_t leading_bytes_among = 0;
template <std::uint8_t N, class... Others>
inline constexpr std::uint8_t leading_bytes_among<with_leading_bytes<N>, Others...> = N;
template <class Other, class... Others>
inline constexpr std::uint8_t leading_bytes_among<Other, Others...> = leading_bytes_among<Others...>;

template <class... Options> struct crc_among { using type = modbus::default_crc; };
template <class C, class... Others> struct crc_among<with_crc<C>, Others...> { using type = C; };
template <class Other, class... Others> struct crc_among<Other, Others...> : crc_among<Others...> {};

template <class... Options> struct identification_among { using type = void; };
template <const auto& O, class... Others> struct identification_among<with_identification<O>, Others...> {
    using type = with_identification<O>;
};
template <class Other, class... Others>
struct identification_among<Other, Others...> : identification_among<Others...> {};

template <class... Options> struct server_id_among { using type = void; };
template <const auto& T, const auto& A, class... Others>
struct server_id_among<with_server_id<T, A>, Others...> {
    using type = with_server_id<T, A>;
};
template <class Other, class... Others>
struct server_id_among<Other, Others...> : server_id_among<Others...> {};
} // namespace detail

} // namespace servobus
