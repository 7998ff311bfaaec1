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
