// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the manual of the C630S leaves open: the options of its simulator. [Cn] are errata of the device.
#pragma once

#include <servobus/sim/c630s/options.hpp>

#include "switches.hpp"

namespace tool {

namespace detail {
inline constexpr const char* c630s_restart_ways[] = {"parameters", "levels", "homing_command",
                                                     "alarms_and_position", "everything"};
inline constexpr const char* c630s_brake_ways[] = {"follows_servo", "wired_only", "always_released"};
inline constexpr const char* c630s_bus_stop_ways[] = {"lasts", "resets", "frees_shaft"};
} // namespace detail

using c630s_chosen = servobus::sim::c630s_options;
inline constexpr option_switch<c630s_chosen> c630s_switches[] = {
    switched<&c630s_chosen::stores_eeprom_off>("stores_eeprom_off", "P0C-13 = 0 is itself stored [C10]"),
    switched<&c630s_chosen::resets_while_enabled>("resets_while_enabled", "P0D-01 of an enabled drive"),
    switched<&c630s_chosen::virtual_brake_delays>("virtual_brake_delays",
                                                  "FunOUT.9 on a virtual output counts as a brake [C77]"),
    switched<&c630s_chosen::echoes_byte_count>("echoes_byte_count",
                                               "the response to 10h has the byte count [C2]"),
    switched<&c630s_chosen::home_output_falls>("home_output_falls",
                                               "HomeAttain falls when a homing begins [C80]"),
    switched<&c630s_chosen::restart_keeps>("restart_keeps", detail::c630s_restart_ways,
                                           "what a restart keeps besides parameters [C10, C80]"),
    switched<&c630s_chosen::software_reset_is_power_on>("software_reset_is_power_on",
                                                        "P0D-00 counts as a power cycle [C82]"),
    switched<&c630s_chosen::brake>("brake", detail::c630s_brake_ways, "what FunOUT.9 shows [C77]"),
    switched<&c630s_chosen::bus_stop>("bus_stop", detail::c630s_bus_stop_ways,
                                      "P0D-05 once the motor is at rest [C81]"),
    switched<&c630s_chosen::commands_end>("commands_end",
                                          "P0D-01, P0D-20, P02-31 read 0 once they are carried out [C80]"),
    switched<&c630s_chosen::segment_start_is_level>("segment_start_is_level", "FunIN.28 needs a level [C23]"),
    switched<&c630s_chosen::jog_follows_command>("jog_follows_command",
                                                 "FunIN.18 and 19 run at P06-03 [C83]"),
    switched<&c630s_chosen::shows_last_alarm>("shows_last_alarm",
                                              "P0B-34 of record 0 after an alarm has ended [C17]"),
    switched<&c630s_chosen::bus_voltage_in_volts>("bus_voltage_in_volts", "P0B-40 is in V [C43]"),
    switched<&c630s_chosen::delay_is_additional>("delay_is_additional",
                                                 "P0C-25 is added to the drive's own time [C79]"),
    switched<&c630s_chosen::disabled_inputs_count>("disabled_inputs_count",
                                                   "virtual inputs count for Er.130 while P0C-09 is 0 [C78]"),
    switched<&c630s_chosen::first_output_shows>("first_output_shows",
                                                "two outputs with one function: which shows it [C78]"),
    switched<&c630s_chosen::gear_keeps_rest>("gear_keeps_rest",
                                             "what a displacement leaves below a count of the encoder [C84]"),
    switched<&c630s_chosen::homing_command_ends>("homing_command_ends",
                                                 "P05-30 reads 0 once it is carried out [C80]"),
    switched<&c630s_chosen::servo_on_waits_for_power_on>(
        "servo_on_waits_for_power_on", "a change of S-ON's terminal waits for the next power-on [C15]"),
};
inline constexpr auto c630s_interpretations = interpretations_of(c630s_switches);

} // namespace tool
