// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Names the known drive at an address, by registers that only one of them has. `scan` names what it finds, `doctor` the
// drive that is there in place of the one on its command line.
#pragma once

#include <cstdint>
#include <string_view>

#include <servobus/client/scan.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

namespace tool {

/// The register in which a drive keeps its own address. No other drive has it there.
struct identity {
    const char* name;
    std::uint16_t address;
};
inline constexpr identity identities[] = {
    {"zlac8015d", servobus::zlac8015d::node_address.address},
    {"yako", servobus::yako::actual_node_address.address},
    {"c630s", servobus::c630s::node_address.address},
};

/// The name of the drive; `yako` if it does not show which stepper it is; null for an unknown device. `look(address)`
/// reads a register of the drive, and returns a `servobus::finding`.
template <class Look> const char* name_of_drive(std::uint8_t node_address, Look look) {
    for (const identity& known : identities) {
        const servobus::finding f = look(known.address);
        if (!f.has_word || f.word != node_address) continue;
        if (known.name != std::string_view{"yako"}) return known.name;
        // Only a closed loop has an encoder.
        const servobus::finding encoder = look(servobus::yako::closed_loop::encoder_resolution.address);
        if (encoder.has_word) return "yako-closed-loop";
        return encoder.what == servobus::presence::present ? "yako-open-loop" : known.name;
    }
    return nullptr;
}

} // namespace tool
