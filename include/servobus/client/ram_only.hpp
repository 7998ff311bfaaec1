// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Writes that come again and again to a drive that keeps every write in its EEPROM: allowed only with proof
// that it does not do so now.
#pragma once

#include <cstdint>

#include <servobus/registers/profile.hpp>

namespace servobus {

template <class Line, device_class Device, class Node> class raw_client;

/// Proof that a drive which keeps every write in its EEPROM was read not to do so now: it goes with writes
/// that come again and again. `client::ram_only` gives it; a lost response, whoever on the line missed
/// it, a port that failed or a write to the drive's switch voids it, and a write with a void one is refused
/// (`needs_init`).
class ram_only {
  public:
    constexpr ram_only() = default; ///< void from the start

  private:
    template <class Line, device_class Device, class Node> friend class raw_client;
    constexpr explicit ram_only(std::uint16_t number) : number_{number} {}
    std::uint16_t number_ = 0;
};

} // namespace servobus
