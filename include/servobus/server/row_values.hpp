// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The values of a device's rows: holding and input registers, coils and discrete inputs. The rows make the storage, so
// no value can be bound to a wrong address. server/row_server.hpp serves them to clients; the device itself reads and
// sets them. If the profile has a `word_order_register`, its row decides in which order 32-bit values are sent and
// received; a request that changes it has the order from before.
//
//     using tank_values = row_values<tank::lowest, tank::highest, tank::level, tank::valve>;
//     constexpr void keep(tank_values& values, i32 measured) { values.set<tank::level>(measured); }
//     static_assert(!tank_values{}.get<tank::valve>()); // the factory default
//
// A value is stored and loaded by one instruction of a 32-bit core: an interrupt may `set` a row or `get` it while the
// server executes a request, and neither meets half a value. On smaller cores that is so for values of 8 bits; others
// need a lock around `set`, `get` and `row_server::step`. Several rows are never of one moment: a read may contain the
// new value of one row and the old value of the next.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/server/detail/row_storage.hpp>
#include <servobus/server/detail/row_table.hpp>
#include <servobus/server/stored_value.hpp>

namespace servobus {

template <class Values, class... Options> class request_executor;
template <class Values> class changes;
namespace detail {
template <class Values, bool HasProbe> class row_walk;

// The argument of `set`. Rows of its other overloads have a type that no value converts to, for clang.
template <const auto& R> struct stored_type { struct type; };
template <const auto& R>
requires is_register<R>
struct stored_type<R> {
    using type = stored_value<R>;
};
template <const auto& R>
requires(is_register_array<R> && !has_bits<R>) struct stored_type<R> {
    using type = stored_value<at<R, 0>>;
};
template <const auto& R> using stored = typename stored_type<R>::type;
} // namespace detail

/// Storage for `Rows`: rows, arrays of rows, and computed rows (server/computed.hpp), in any order. It begins with the
/// factory defaults. A default that a row does not state is 0, or the lowest value if 0 is out of range.
template <const auto&... Rows> class row_values {
    static constexpr const auto& list = detail::rows_of<Rows...>;

    static_assert(detail::same_device_of<typename detail::entry_of<Rows>::row::device...>::value,
                  "the rows of a server belong to one device");
    static_assert(!list.repeats, "a server has each row once");
    static_assert(!list.overlaps, "rows of a server overlap");
    static_assert(detail::count_of_rows<Rows...> <= detail::served_row::most_slots,
                  "a server has at most 2048 rows");

  public:
    using device = typename detail::same_device_of<typename detail::entry_of<Rows>::row::device...>::device;
    static_assert(device_class<device>, "the device of a server's rows has a profile, `facts`");
    static_assert(
        device::facts.word_order != word_order::unknown || device::facts.word_order_register != 0,
        "a server has one word order, or a register that switches it: state it in the device's profile");
    static_assert(
        has_fixed_word_order<device> || list.has_switch_at(device::facts.word_order_register),
        "the device switches its word order: its server has that register, a stored row from 0 to 1");

    constexpr row_values() = default;

    /// The value of row `R`: a bool for a coil or a discrete input, else a `reading<R>`.
    template <const auto& R>
    requires(!is_register_array<R>) constexpr auto get() const { return decode<R>(load<R>(0)); }
    /// The value of element `i` of an array of rows. `i` is below its size, as the index of an array.
    template <const auto& R>
    requires is_register_array<R>
    constexpr auto get(std::size_t i) const { return reading_of<at<R, 0>>(load<R>(element<R>(i))); }

    /// Sets a register: to a constant, to `clamped(v)`, or to any value if its range is that of its type.
    template <const auto& R>
    requires is_register<R>
    constexpr void set(detail::stored<R> value) { store<R>(0, value.bits()); }
    /// Sets a register unless `v` is out of range or no whole number of counts.
    /// Errors: `out_of_range`, `inexact`.
    template <const auto& R, class V>
    requires is_register<R>
    [[nodiscard]] constexpr status set(checked_value<V> v) { return set_checked<R, R>(0, v); }

    /// Sets a coil or a discrete input.
    template <const auto& R, class V>
    requires is_bit<R>
    constexpr void set(V on) {
        static_assert(std::is_same_v<V, bool>, "a coil or an input is set to true or false, not to a number");
        store<R>(0, on ? 1 : 0);
    }
    /// Sets element `i` of an array of coils or discrete inputs. `i` is below its size.
    template <const auto& R, class V>
    requires(is_register_array<R>&& detail::has_bits<R>) constexpr void set(std::size_t i, V on) {
        static_assert(std::is_same_v<V, bool>, "a coil or an input is set to true or false, not to a number");
        store<R>(element<R>(i), on ? 1 : 0);
    }

    /// Sets element `i` of an array of registers. `i` is below its size.
    template <const auto& R>
    requires is_register_array<R>
    constexpr void set(std::size_t i, detail::stored<R> value) { store<R>(element<R>(i), value.bits()); }
    /// The same for a value that may be out of range. Errors: `out_of_range`, `inexact`.
    template <const auto& R, class V>
    requires(is_register_array<R> && !detail::has_bits<R>) [[nodiscard]] constexpr status
        set(std::size_t i, checked_value<V> v) {
        return set_checked<R, at<R, 0>>(element<R>(i), v);
    }

    /// Sets all rows to the factory defaults, not as a whole: an interrupt may meet half a value.
    constexpr void reset() { storage_ = initial; }

  private:
    template <class Values, class... Options> friend class request_executor;
    template <class Values> friend class changes;
    template <class Values, bool HasProbe> friend class detail::row_walk;

    // The tables in flash that requests need.
    static constexpr const auto& flash = detail::flash_rows<Rows...>;
    static constexpr const auto& functions = detail::flash_functions<Rows...>;
    template <class Int, detail::pool In> static constexpr const auto& ranges() {
        return detail::flash_ranges<Int, In, Rows...>.all;
    }

    // The word order of 32-bit values. Where a register switches it: that of now.
    constexpr word_order order_of_pairs() const {
        if constexpr (has_fixed_word_order<device>) {
            return device::facts.word_order;
        } else {
            constexpr std::size_t slot = list.find_word(device::facts.word_order_register)->slot;
            return storage_.narrow.load(slot) == 0 ? word_order::high_first : word_order::low_first;
        }
    }

    template <const auto& R> static consteval std::size_t index_of() {
        const auto wanted = [] {
            if constexpr (is_register_array<R>) {
                return detail::plain(R.first);
            } else {
                return detail::plain(R);
            }
        }();
        for (std::size_t i = 0; i < detail::count_of_rows<Rows...>; ++i) {
            if (list.rows[i].key() == wanted.key() && list.rows[i].type == wanted.type) return i;
        }
        return detail::count_of_rows<Rows...>;
    }
    template <const auto& R> static consteval detail::plain_row place_of() {
        constexpr std::size_t i = index_of<R>();
        static_assert(i < detail::count_of_rows<Rows...>, "the server does not have this row");
        return list
            .rows[i < detail::count_of_rows<Rows...> ? i : 0]; // so that the assertion is the only error
    }

    // As in `slice`, checked only where the standard library's assertions are enabled.
    template <const auto& R> static constexpr std::size_t element(std::size_t i) {
#ifdef _GLIBCXX_ASSERTIONS
        if (i >= row_type<R>::size) __builtin_trap();
#endif
        return i;
    }

    template <const auto& R> constexpr u32 load(std::size_t i) const {
        constexpr detail::plain_row r = place_of<R>();
        if constexpr (r.in == detail::pool::functions) {
            return functions.all[r.slot]();
        } else {
            return storage_.template of<r.in>().load(r.slot + i);
        }
    }
    template <const auto& R> constexpr void store(std::size_t i, u32 bits) {
        constexpr detail::plain_row r = place_of<R>();
        static_assert(r.in != detail::pool::functions, "a function computes this row: it cannot be set");
        storage_.template of<r.in>().store(r.slot + i, bits);
    }
    template <const auto& R> static constexpr auto decode(u32 bits) {
        if constexpr (is_bit<R>) {
            return bits != 0;
        } else {
            return reading_of<R>(bits);
        }
    }
    template <const auto& R, const auto& Element, class V>
    constexpr status set_checked(std::size_t i, checked_value<V> v) {
        if constexpr (detail::has_codec<typename row_type<Element>::value_type>) {
            const auto wanted = stored_value<Element>::encoded(v.value);
            if (wanted.error != errc::ok) return wanted.error;
            store<R>(i, stored_value<Element>::bits_of(wanted.number));
        } else {
            const counted c = count_of<Element>(v.value);
            if (c.error != errc::ok) return c.error;
            if (!Element.limits.contains(c.count)) return errc::out_of_range;
            store<R>(i, static_cast<u32>(static_cast<std::uint64_t>(c.count)));
        }
        return errc::ok;
    }

    static constexpr auto initial = detail::initial_storage<list>();
    detail::storage_for<list> storage_ = initial;
};

/// The value of row `R`: the free twin of `row_values::get`.
template <const auto& R, const auto&... Rows> constexpr auto get(const row_values<Rows...>& from) {
    return from.template get<R>();
}
/// Sets row `R`: the free twin of `row_values::set`.
template <const auto& R, const auto&... Rows>
requires is_register<R>
constexpr void set(row_values<Rows...>& to, detail::stored<R> value) { to.template set<R>(value); }

} // namespace servobus
