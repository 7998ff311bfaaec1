// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus sim c630s
#include <servobus/sim/c630s.hpp>

#include "../interpretations/c630s_switches.hpp"
#include "../streams/messages.hpp"
#include "served.hpp"
#include "simulators.hpp"

namespace tool {
namespace {

using servobus::u16;

namespace coolmay = servobus::c630s;

bool set(servobus::sim::c630s& drive, u16 address, u16 value) {
    const std::uint8_t word[] = {static_cast<std::uint8_t>(value >> 8),
                                 static_cast<std::uint8_t>(value & 0xFFu)};
    return drive.write(address, servobus::words_view{word}) == 0;
}

} // namespace

int simulate_c630s(const simulation& wanted) {
    constexpr std::uint32_t rates[] = {2400, 4800, 9600, 19200, 38400, 57600};
    u16 rate = 0;
    while (rate < std::size(rates) && rates[rate] != wanted.baud) ++rate;
    if (rate == std::size(rates))
        return complain(usage, "--baud: c630s has 2400, 4800, 9600, 19200, 38400 and 57600");
    static servobus::sim::c630s drive{options_of(c630s_switches, wanted.ways)};
    // As a real one is set: with P0C-13 = 1, as from the factory, both are kept.
    if (!set(drive, coolmay::rs485_baud_rate.address, rate) ||
        !set(drive, coolmay::node_address.address, wanted.node))
        return complain(failed, "the model refused its settings");
    return served<servobus::sim::c630s>{drive, wanted}.run(wanted.link);
}

} // namespace tool
