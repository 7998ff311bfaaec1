// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The token for repeated writes to a drive that can keep every write in its EEPROM: proof that the drive
// does not do so now. A client returns it and takes it; client/raw_client.hpp includes it.
//
//     const result<ram_only> token = servo.ram_only(); // reads P0C-13
//     if (!token) return 1;                            // `wrong_state` if each write would wear the EEPROM
//     if (!servo.write<c630s::target_speed>(300 * r_per_min, *token)) return 1;
#pragma once

#include <cstdint>

#include <servobus/core/epoch.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus {

template <class Line, device_class Device, class Node> class raw_client;
namespace detail {
template <class Line, device_class Device, class Node> class node_link;
} // namespace detail

/// Shows that a drive does not keep writes in its EEPROM: its switch was read. `client::ram_only` gives the token,
/// for writes that are repeated. The token becomes void with the epoch of its line: by a request of any client to
/// the drive without a response, by a write of the drive's switch or word order, or by a loss of the port. A write
/// with a void token, or with one of another node, is refused (`needs_init`).
class ram_only {
  public:
    constexpr ram_only() = default; ///< void from the start

  private:
    template <class Line, device_class Device, class Node> friend class raw_client;
    template <class Line, device_class Device, class Node> friend class detail::node_link;
    constexpr ram_only(std::uint8_t node_address, epoch read_in)
        : misses_{read_in.misses}, losses_{read_in.events.losses}, address_{node_address} {}
    constexpr bool holds(std::uint8_t node_address, epoch now) const {
        return address_ == node_address && is_same_life(now, epoch{misses_, {losses_}});
    }

    std::uint16_t misses_ = 0; // the epoch in two fields: four bytes together
    std::uint8_t losses_ = 0;
    std::uint8_t address_ = 0; // no node's
};

} // namespace servobus
