// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers of a drive that its facade caches: a device lists them as `cached_by_facade`. A write to one of them by
// a client makes the facade's settings stale. The `values.hpp` of each drive includes it, and clients do.
//
//     struct device { // 0010h, and 0020h to 0023h
//         static constexpr address_range cached_by_facade[] = {{0x0010, 0x0010}, {0x0020, 0x0023}};
//     };
//     static_assert(is_cached_by_facade<device>(0x001F, 2) && !is_cached_by_facade<device>(0x0024, 1));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

#include <servobus/registers/wire.hpp>

namespace servobus {

/// The addresses `first` to `last`.
struct address_range {
    u16 first;
    u16 last;
};

namespace detail {
template <class Device>
concept has_cached_registers = requires {
    Device::cached_by_facade[0];
};
} // namespace detail

/// True if a facade of `Device` caches one of the `words` registers from `address` on.
template <class Device> constexpr bool is_cached_by_facade(u16 address, std::size_t words) {
    if constexpr (detail::has_cached_registers<Device>) {
        for (const address_range& cached : Device::cached_by_facade) {
            if (address <= cached.last && address + words > cached.first) return true;
        }
    }
    return false;
}

} // namespace servobus
