// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus sim yako-closed-loop, servobus sim yako-open-loop
#include <servobus/sim/yako.hpp>

#include "../interpretations/yako_switches.hpp"
#include "../streams/messages.hpp"
#include "served.hpp"
#include "simulators.hpp"

namespace tool {
namespace {

using servobus::u16;

namespace yako = servobus::yako;

bool set(servobus::sim::yako_drive& drive, u16 address, u16 value) {
    const std::uint8_t word[] = {static_cast<std::uint8_t>(value >> 8),
                                 static_cast<std::uint8_t>(value & 0xFFu)};
    return drive.write(address, servobus::words_view{word}) == 0;
}

// Runs as a real one is set: the address by switches as far as these reach, the rest kept in its EEPROM; both
// hold from the next power-on.
template <class Model> int simulate_yako(const simulation& wanted) {
    constexpr std::uint32_t rates[] = {115200, 38400, 19200, 9600};
    constexpr std::uint8_t highest_switched = 31;
    u16 rate = 0;
    while (rate < std::size(rates) && rates[rate] != wanted.baud) ++rate;
    if (rate == std::size(rates))
        return complain(usage, "--baud: the YAKOTEC drives have 9600, 19200, 38400 and 115200");
    static Model drive{options_of(yako_switches, wanted.ways)};
    drive.set_switches(wanted.node <= highest_switched ? wanted.node : std::uint8_t{0});
    if (!set(drive, yako::rs485_baud_rate.address, rate) ||
        !set(drive, yako::node_address.address, wanted.node) ||
        !set(drive, yako::auxiliary_command.address, static_cast<u16>(yako::auxiliary::save_parameters)))
        return complain(failed, "the model refused its settings");
    drive.power_cycle();
    return served<Model>{drive, wanted}.run(wanted.link);
}

} // namespace

int simulate_yako_closed_loop(const simulation& wanted) {
    return simulate_yako<servobus::sim::yako_closed_loop>(wanted);
}

int simulate_yako_open_loop(const simulation& wanted) {
    return simulate_yako<servobus::sim::yako_open_loop>(wanted);
}

} // namespace tool
