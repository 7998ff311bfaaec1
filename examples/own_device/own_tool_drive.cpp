// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive of your own in the command-line tool: its map, its simulator, its alarms and its rules. The tool is built
// with it, and nothing else changes:
//
//     cmake -B build -DSERVOBUS_TOOL_DRIVES=/home/me/own_tool_drive.cpp && cmake --build build
//     build/servobus read /dev/ttyUSB0 winch:5 position
#include <array>
#include <string>
#include <vector>

#include <servobus/registers/catalogue.hpp>

#include "../servobus/devices/registered_drive.hpp"
#include "../servobus/doctor/examination.hpp"
#include "../servobus/registers/at_rest.hpp"
#include "../servobus/simulators/served.hpp"
#include "own_device.hpp"
#include "own_simulator.hpp"

namespace winch {
namespace {

// --- The map: the rows of own_device.hpp by their names

constexpr servobus::named_value control_codes[] = {servobus::code(0, "off"), servobus::code(1, "hold"),
                                                   servobus::code(2, "turn"), servobus::code(3, "move"),
                                                   servobus::code(4, "clear_fault")};
constexpr servobus::named_value status_names[] = {servobus::named_bit(status_bits::energised, "energised"),
                                                  servobus::named_bit(status_bits::turning, "turning")};
constexpr auto rows = servobus::in_address_order(
    servobus::list("control_word", control_word, servobus::naming::names, control_codes),
    servobus::list("speed", speed), servobus::list("ramp", ramp), servobus::list("limit", limit),
    servobus::list("host_word", host_word), servobus::list("target", target), servobus::list("load", load),
    servobus::list("position", position),
    servobus::list("status_word", status_word, servobus::naming::names, status_names),
    servobus::list("fault", fault), servobus::list("stop_", stops));
constexpr servobus::catalogue catalogue{&device::facts, rows};

// --- The simulator, on a pseudo-terminal

struct simulated_node : simulated {
    explicit simulated_node(const tool::simulation& wanted) : node{wanted.node}, rate{wanted.baud} {}
    std::uint8_t address() const { return node; }
    std::uint32_t baud() const { return rate; }

    std::uint8_t node;
    std::uint32_t rate; // bits a second
};
int simulate(const tool::simulation& wanted) {
    simulated_node drum{wanted};
    return tool::served<simulated_node>{drum, wanted}.run(wanted.link);
}

// --- What its manual says of its alarms

std::vector<tool::alarm_row> alarms() {
    return {
        {"1", "fault", "yes", "overload", {"The load is too heavy.", "Take some off.", "control_word = 4"}},
        {"2", "fault", "no", "rope", {"The rope is slack.", "Wind it by hand.", "Switch it off and on."}}};
}

// --- Whether its parameters may be changed now, and what stops it

tool::repose at_rest(tool::session& on) {
    std::array<std::uint16_t, 1> word{};
    if (const auto why = tool::read_words(on, status_word.address, word); !tool::is_ok(why)) return {why, {}};
    if ((word[0] & status_bits::energised) != 0) return {{}, "the winch is energised; control_word=off"};
    return {};
}
bool stops_it(std::uint16_t address, std::uint16_t word) {
    return address == control_word.address && word <= static_cast<std::uint16_t>(control_code::hold);
}

// --- What keeps it from turning, for `doctor`; without it doctor says of it what it says of any device

namespace doctor = tool::diagnosis;
bool is_energised(const doctor::held_registers& r, const doctor::check&) {
    return (r.word(status_word) & status_bits::energised) != 0;
}
constexpr doctor::check checks[] = {
    {doctor::refuses,
     {fault},
     doctor::is_set,
     "the winch is not energised while it has a fault",
     {.act = "mend its cause", .write = "control_word=clear_fault"}},
    {doctor::matters, {limit}, doctor::is_zero, "the motor gets no current", {.write = "limit=10"}},
    {doctor::matters,
     {status_word},
     is_energised,
     "another program commands the winch, or has left it so",
     {.write = "control_word=off"}},
};
constexpr std::uint16_t read_first[] = {status_word.address};
constexpr doctor::examination examination{{checks}, read_first};

const tool::registered_drive of_winch{{.map = catalogue,
                                       .simulate = simulate,
                                       .alarms = alarms,
                                       .at_rest = at_rest,
                                       .stops = stops_it,
                                       .examination = &examination}};

} // namespace
} // namespace winch
