// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the memory of a server's values, by width. A bit has a byte, so that an interrupt which sets one does not
// write its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/server/detail/row_table.hpp>

namespace servobus::detail {

/// Values of one width. Each is loaded and stored as a whole where the core can.
template <class Int, std::size_t N> struct cells {
    Int all[N]{};

    constexpr Int load(std::size_t i) const {
        if (std::is_constant_evaluated()) return all[i];
        if constexpr (__atomic_always_lock_free(sizeof(Int), nullptr)) {
            return __atomic_load_n(&all[i], __ATOMIC_RELAXED);
        } else { // without a call of a library, which takes a lock
            return *static_cast<const volatile Int*>(&all[i]);
        }
    }
    constexpr void store(std::size_t i, u32 bits) {
        const auto value = static_cast<Int>(bits);
        if (std::is_constant_evaluated()) {
            all[i] = value;
        } else if constexpr (__atomic_always_lock_free(sizeof(Int), nullptr)) {
            __atomic_store_n(&all[i], value, __ATOMIC_RELAXED);
        } else {
            *static_cast<volatile Int*>(&all[i]) = value;
        }
    }
};
/// No values, and no memory.
template <class Int> struct cells<Int, 0> {
    constexpr Int load(std::size_t) const { return 0; }
    constexpr void store(std::size_t, u32) {}
};

template <std::size_t Wide, std::size_t Narrow, std::size_t Bits> struct row_storage {
    [[no_unique_address]] cells<u32, Wide> wide;
    [[no_unique_address]] cells<u16, Narrow> narrow;
    [[no_unique_address]] cells<std::uint8_t, Bits> bits;

    template <pool In> constexpr auto& of() { return of<In>(*this); }
    template <pool In> constexpr const auto& of() const { return of<In>(*this); }

  private:
    template <pool In, class Storage> static constexpr auto& of(Storage& s) {
        if constexpr (In == pool::wide) {
            return s.wide;
        } else if constexpr (In == pool::narrow) {
            return s.narrow;
        } else {
            return s.bits;
        }
    }
};

/// The storage for a list of rows.
template <const auto& List>
using storage_for = row_storage<List.places[static_cast<std::size_t>(pool::wide)],
                                List.places[static_cast<std::size_t>(pool::narrow)],
                                List.places[static_cast<std::size_t>(pool::bits)]>;
template <const auto& List> constexpr storage_for<List> initial_storage() {
    storage_for<List> s{};
    for (const plain_row& r : List.rows) {
        const auto bits = static_cast<u32>(static_cast<std::uint64_t>(r.initial));
        if (r.in == pool::wide) s.wide.store(r.slot, bits);
        if (r.in == pool::narrow) s.narrow.store(r.slot, bits);
        if (r.in == pool::bits) s.bits.store(r.slot, bits);
    }
    return s;
}

} // namespace servobus::detail
