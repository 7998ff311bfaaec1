// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus sim zlac8015d
#include <servobus/sim/zlac8015d.hpp>

#include "../interpretations/zlac8015d_switches.hpp"
#include "../streams/messages.hpp"
#include "served.hpp"
#include "simulators.hpp"

namespace tool {
namespace {

using servobus::u16;

namespace zlac = servobus::zlac8015d;

bool set(servobus::sim::zlac8015d& drive, u16 address, u16 value) {
    const std::uint8_t word[] = {static_cast<std::uint8_t>(value >> 8),
                                 static_cast<std::uint8_t>(value & 0xFFu)};
    return drive.write(address, servobus::words_view{word}) == 0;
}

// 0 if the drive does not have the rate.
u16 code_of(std::uint32_t baud) {
    constexpr std::uint32_t rates[] = {128000, 115200, 57600, 38400, 19200, 9600};
    for (std::size_t i = 0; i < std::size(rates); ++i) {
        if (rates[i] == baud) return static_cast<u16>(i + 1);
    }
    return 0;
}

} // namespace

int simulate_zlac8015d(const simulation& wanted) {
    const u16 rate = code_of(wanted.baud);
    if (rate == 0)
        return complain(usage, "--baud: zlac8015d has 9600, 19200, 38400, 57600, 115200 and 128000");
    static servobus::sim::zlac8015d drive{options_of(zlac8015d_switches, wanted.ways)};
    // As a real one is set: both are kept in its EEPROM and hold from the next power-on.
    if (!set(drive, zlac::rs485_baud_rate.address, rate) ||
        !set(drive, zlac::node_address.address, wanted.node) || !set(drive, zlac::save_parameters.address, 1))
        return complain(failed, "the model refused its settings");
    drive.power_cycle();
    return served<servobus::sim::zlac8015d>{drive, wanted}.run(wanted.link);
}

} // namespace tool
