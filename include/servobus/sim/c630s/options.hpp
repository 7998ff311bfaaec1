// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a test may choose of the simulated C630S: how it behaves where the manual V24.111 is silent or can be
// read two ways. Each switch names the place in the manual and the entry of device/errata_c630s.md; the first
// position is what the model does by default.
#pragma once

#include <cstdint>

#include <servobus/time.hpp>

namespace servobus::sim {

/// What a restart keeps beside the parameters that are in the EEPROM. Sections 7.11, 7.12, 7.18 [C10, C80].
enum class c630s_restart : std::uint8_t {
    parameters,          ///< nothing else
    levels,              ///< P31-00 as the EEPROM holds it, and these virtual inputs are active
    homing_order,        ///< P05-30 = 4, 5 and 6 as the EEPROM holds them: they are carried out
    alarms_and_position, ///< alarms until they are reset, and P0B-07 with an incremental encoder
    everything,          ///< all of these
};

/// What FunOUT.9, the brake, shows. Sections 6.4.2 and 7.2 [C77].
enum class c630s_brake : std::uint8_t {
    follows_servo,  ///< released while the motor is energised, on whichever output it is shown
    wired_only,     ///< the same, but only while a wired output, DO1 to DO6, has the function
    always_released ///< without a brake it is never applied
};

/// What an emergency stop by P0D-05 does once the motor is at rest. Section 7.13 [C81].
enum class c630s_bus_stop : std::uint8_t {
    lasts,       ///< it holds the position until P0D-05 is 0
    resets,      ///< P0D-05 becomes 0 by itself: the next command is obeyed
    frees_shaft, ///< the power is off until S-ON was inactive
};

/// What a test may choose of the simulated drive.
struct c630s_options {
    /// Er.942: more than 200 parameters stored within this time.
    duration many_writes_within = milliseconds(10'000);
    /// P0C-13 = 0 is itself kept in the EEPROM, as everything that is written while it is 1. Section 7.12
    /// [C10].
    bool stores_eeprom_off = true;
    /// P0D-01 resets warnings of an enabled drive too, though its row is for the stopped one. Section 7.13.
    bool resets_while_enabled = false;
    /// FunOUT.9 on a virtual output counts as a brake: P02-09 to P02-12 matter. Section 7.2 [C77].
    bool virtual_brake_delays = true;
    /// It answers function 10h as section 9.2.3 prints it: with the byte count in the place of the quantity
    /// [C2].
    bool echoes_byte_count = false;
    /// HomeAttain and ElecHomeAttain end as a new homing begins; otherwise only with the power. Section 6.4.2
    /// [C80].
    bool home_output_falls = true;
    /// What a restart keeps.
    c630s_restart restart_keeps = c630s_restart::parameters;
    /// P0D-00 counts as switching off and on: otherwise what waits for power-on goes on waiting. Section 7.13
    /// [C82].
    bool software_reset_is_power_on = true;
    /// What the brake output shows.
    c630s_brake brake = c630s_brake::follows_servo;
    /// What P0D-05 does.
    c630s_bus_stop bus_stop = c630s_bus_stop::lasts;
    /// P05-30, P0D-01, P0D-20 and P02-31 read 0 once they are carried out; otherwise they keep the value, and
    /// the same value again is no command. Sections 7.2, 7.5 and 7.13 [C80].
    bool orders_end = true;
    /// FunIN.28 is a level and not an edge: a virtual input that is active for an edge never starts the
    /// segments. Section 6.4.1 [C23].
    bool segment_start_is_level = false;
    /// FunIN.18 and FunIN.19 run "at the given command", P06-03, and not at P06-04. Section 6.4.1 [C83].
    bool jog_follows_command = false;
    /// P0B-34 of record 0 is the newest alarm also after it is gone, and not the present one. Section 7.11
    /// [C17].
    bool shows_last_alarm = false;
    /// P0B-40 counts volts, as printed, and not tenths as P0B-26 [C43].
    bool bus_voltage_in_volts = false;
    /// P0C-25 comes on top of what the drive takes for a response, here 40 ms, instead of being granted in it
    /// [C79].
    bool delay_is_additional = false;
    /// Virtual inputs have their functions for Er.130 while P0C-09 is 0 too. Chapter 8 [C78].
    bool disabled_inputs_count = false;
    /// An output function that two outputs have is shown by the first of them only, DO1 to DO6 before VDO1 to
    /// VDO16. Section 6.4.2 [C78].
    bool first_output_shows = false;
};

} // namespace servobus::sim
