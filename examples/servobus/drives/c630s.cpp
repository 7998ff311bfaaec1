// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S as the tool knows it.
#include <array>
#include <cstdio>
#include <string>

#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/c630s/assignments.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/c630s/model.hpp>
#include <servobus/device/c630s/registers.hpp>

#include "../devices/registered_drive.hpp"
#include "../doctor/c630s.hpp"
#include "../interpretations/c630s_switches.hpp"
#include "../probe/c630s.hpp"
#include "../registers/at_rest.hpp"
#include "../registers/session.hpp"
#include "../simulators/simulators.hpp"

namespace tool {
namespace {

// No documented register says whether the servo is on: it is if a terminal with the function S-ON, a real one
// or a virtual one, is active.
repose c630s_at_rest(session& on) {
    namespace c630s = servobus::c630s;
    constexpr auto servo_on = static_cast<u16>(c630s::input_function::servo_on);
    constexpr auto low_level = static_cast<u16>(c630s::input_logic::low_level);
    std::array<u16, 1> speed{};
    if (const auto why = read_words(on, c630s::actual_speed.address, speed); !is_ok(why)) return {why, {}};
    if (speed[0] != 0) return {{}, "the motor turns; stop it first"};

    std::array<u16, 1> levels{};
    if (const auto why = read_words(on, c630s::virtual_input_levels.address, levels); !is_ok(why))
        return {why, {}};
    // What is active since power-on shows nowhere: P31-00 reads 0 then.
    std::array<u16, 1> at_power_on{};
    if (const auto why = read_words(on, c630s::power_on_functions_1_to_16.address, at_power_on); !is_ok(why))
        return {why, {}};
    if ((at_power_on[0] & 1u) != 0)
        return {
            {},
            "power_on_functions_1_to_16 enables the servo at power-on; take servo_on out of it, and switch "
            "the drive off and on"};
    if (const auto why = read_words(on, c630s::virtual_inputs_at_power_on.address, at_power_on); !is_ok(why))
        return {why, {}};
    constexpr std::size_t half = 8;
    for (std::size_t first = 0; first < 16; first += half) {
        std::array<u16, 2 * half> rows{}; // function, logic, function, …
        const u16 address = c630s::virtual_input_functions[first].address;
        if (const auto why = read_words(on, address, rows); !is_ok(why)) return {why, {}};
        for (std::size_t i = 0; i < half; ++i) {
            if (rows[2 * i] == servo_on && (unsigned{at_power_on[0]} >> (first + i) & 1u) != 0) {
                return {{},
                        "virtual input " + std::to_string(first + i + 1) +
                            " enables the servo at power-on; take it out of virtual_inputs_at_power_on, and "
                            "switch the drive off and on"};
            }
            if (rows[2 * i] == servo_on && (unsigned{levels[0]} >> (first + i) & 1u) != 0) {
                return {{},
                        "virtual input " + std::to_string(first + i + 1) +
                            " enables the servo; take it out of virtual_input_levels first"};
            }
        }
    }

    std::array<u16, 1> conducts{};
    std::array<u16, 2 * half> rows{};
    if (const auto why = read_words(on, c630s::input_conduction.address, conducts); !is_ok(why))
        return {why, {}};
    if (const auto why = read_words(on, c630s::di1_function.address, rows); !is_ok(why)) return {why, {}};
    for (std::size_t i = 0; i < half; ++i) {
        const bool conducting = (unsigned{conducts[0]} >> i & 1u) != 0;
        if (rows[2 * i] == servo_on && conducting == (rows[2 * i + 1] == low_level))
            return {{}, "terminal DI" + std::to_string(i + 1) + " enables the servo; open it first"};
    }
    return {};
}

bool c630s_stops(u16 address, u16 word) {
    namespace c630s = servobus::c630s;
    return word == 0 &&
           (address == c630s::virtual_input_levels.address || address == c630s::target_speed.address);
}

std::vector<alarm_row> c630s_alarms() {
    namespace c630s = servobus::c630s;
    std::vector<alarm_row> rows;
    for (const c630s::alarm& a : c630s::alarms) {
        char code[8];
        (void)std::snprintf(code, sizeof code, "Er.%03X", static_cast<unsigned>(a.code) & 0xFFFu);
        rows.push_back(
            {code, text(a.kind), a.is_resettable ? "yes" : "no", text(a), c630s::advice_for(a.code)});
    }
    return rows;
}

// No register says how many counts its encoder has: 2^17 or 2^23.
turned_shafts c630s_turning(session& on) {
    namespace c630s = servobus::c630s;
    std::array<u16, 2> pulses{};
    const auto& row = *c630s::catalogue.find(c630s::pulses_per_revolution.address);
    if (const auto why = on.read(choose(row), pulses); !is_ok(why)) return {why, {}};
    return {{},
            {{"motor", c630s::absolute_position.address, number_of(row, pulses), "pulses_per_revolution"},
             {"encoder", c630s::feedback_pulses.address, 0, ""}}};
}

int c630s_parameter(std::string_view text) {
    return servobus::c630s::detail::parameter_address(text.data(), text.size());
}

// More than 200 stored parameters raise the alarm Er.942.
const registered_drive of_c630s{{.map = servobus::c630s::catalogue,
                                 .simulate = simulate_c630s,
                                 .alarms = c630s_alarms,
                                 .at_rest = c630s_at_rest,
                                 .stops = c630s_stops,
                                 .number = c630s_parameter,
                                 .most_stored = 200,
                                 .excludes = servobus::c630s::excludes,
                                 .interpretations = c630s_interpretations,
                                 .probe =
                                     [](probe_bench& on, findings& found) {
                                         c630s_probe{on, found}.run();
                                     },
                                 .version_register = servobus::c630s::software_version.address,
                                 .turning = c630s_turning,
                                 .on_line = &servobus::c630s::device::on_line,
                                 .node_register = servobus::c630s::node_address.address,
                                 .examination = &diagnosis::c630s_examination,
                                 .has_watchdog = servobus::c630s::model::traits.stops_without_line}};

} // namespace
} // namespace tool
