// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a test may choose of the simulated C630S: how it behaves where the manual V24.111 is silent or can be
// read in two ways. Each switch names the place in the manual and the entry of device/errata_c630s.md; the
// first value is the model's default.
//
//     servobus::sim::c630s_options chosen;
//     chosen.brake = servobus::sim::c630s_brake::wired_only;
//     servobus::sim::c630s drive{chosen};
//
// Where the manual is silent, the model does one of the things that a drive may do, usually the worst for a
// careless program. These are assumptions, not facts about the drive. Where the facade depends on one,
// `c630s_options` has a switch for the other interpretations, named in parentheses; for the others the reason why
// there is none is in square brackets.
//
//  1  Writing a read-only parameter is exception 2, a value outside its range 3, a parameter for the stopped
//     drive 4 while the motor is enabled or turns; so is P0D-01 (`resets_while_enabled`). A single word of a
//     32-bit parameter is joined with its other word. Loss of the bus has no effect: the motor continues to
//     run. [The strictest responses; a drive that refuses less is not asked for more. The facade writes no
//     single word.]
//  2  Every stored register counts as an EEPROM write, also one whose value does not change, and P0C-13 = 0
//     itself (`stores_eeprom_off`); more than 200 of them within 10 s raise Er.942 (`many_writes_within`).
//     P31 is counted but 0 after power-on (`restart_keeps`).
//  3  A change of a parameter that waits for power-on raises the warning Er.941. P0D-00 counts as power-on
//     (`software_reset_is_power_on`).
//  4  P0C-00, P0C-02 and P0C-03 act immediately; the response may be sent with the new setting. [The facade
//     assumes nothing about the drive afterwards.]
//  5  Open inputs are high. P0B-03 and P0D-18 show levels; P30-04, P0B-05 and P0D-19 show which terminals
//     conduct. With P0C-10 set, these levels hold from power-on though P31-00 reads 0 until it is written.
//     [P0C-10 is 0 before each enable.]
//  6  A function that needs an edge, on a level, acts when the level becomes active; a function that needs a
//     level, on an edge, never acts. Functions of P03-00, P03-01 and P03-34 stay active. Any function on two
//     inputs is Er.130 (`disabled_inputs_count`); on two outputs both show it (`first_output_shows`).
//     FunIN.28 needs an edge (`segment_start_is_level`).
//  7  S-ON enables if there is no fault; only the level counts, also at power-on. With FunOUT.9 on a DO or
//     VDO, commands and edges are ignored for P02-09 after enabling, though the brake is released (`brake`,
//     `virtual_brake_delays`). [An S-ON that needs an edge enables less often.]
//  8  Ramp times lead from 0 to 1000 r/min; at zero speed the position is held. Stops at zero speed take 33
//     ms from 1000 r/min. A fault lets the motor coast. M1-SEL active selects the mode named last. [These
//     times depend on the machine; the facade waits for a standstill that it reads, and refuses modes that
//     inputs switch.]
//  9  Jog (FunIN.18, 19) works in every mode, at P06-04 (`jog_follows_command`), and discards the motion in
//     progress.
// 10  Steps (P05-05) run at 100 r/min without a ramp and add up; a segment start during a run is ignored. The
//     end of PosInSen stops nothing; INHIBIT, S-ON off, jog and limit switches interrupt a run, and with
//     P11-02 = 0 the next start finishes the rest. P11-00 = 3 runs from P11-05 to P11-01 without waiting.
//     P05-16 has no effect. [A start needs a standstill; where a run leads depends on its parameters.]
// 11  While a position command runs, the deviation is the distance of 25 ms at its speed. COIN is active at
//     rest and for a short time after a start. [The worst for `wait_standstill`.]
// 12  P05-30 = 4 and 5 wait until the motor is enabled in position control; 6 acts
//     immediately. If stored, 4 to 6 are 0 after power-on, and 3 homes when the motor is first enabled. 0
//     stops a homing. P05-61 sets the unit of P05-35 to 1, 10 or 100 ms. At home P0B-07 is P05-36. Er.601
//     leaves the motor enabled. (`homing_command_ends`, `restart_keeps`, `home_output_falls`)
// 13  Emergency stops (FunIN.34, P0D-05) last as long as their cause; then a speed command is carried out
//     again (`bus_stop`).
// 14  Er.950 and Er.952 end with their switch. With P02-07 = 0 or 2 a limit switch releases the shaft until
//     S-ON has been off; with 1 only the other direction is possible. [The facade reads neither; the brake
//     output shows a released shaft.]
// 15  P30-00 is 1 ready, 2 enabled, 3 fault [not read]. P0B-34 of record 0 is 0 without an alarm
//     (`shows_last_alarm`); warnings are recorded.
// 16  P0D-20 = 1 ends the causes of Er.731, Er.733 and Er.735, 2 also clears the turns. P0D-02, P0D-03,
//     P0D-11, P31-04, P0C-30, gains, filters and P02-02 have no effect. [`reset_encoder` writes 2; no command
//     writes the others.]
// 17  A displacement of a segment is cut to whole counts of the encoder: relative ones lose the rest, up to a count
//     each, so that many of them drift (`gear_keeps_rest`).
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::sim {

/// What a restart keeps besides the parameters in the EEPROM. Sections 7.11, 7.12, 7.18 [C10, C80].
enum class c630s_restart : std::uint8_t {
    parameters,          ///< nothing else
    levels,              ///< P31-00 from the EEPROM, and these virtual inputs are active
    homing_command,      ///< P05-30 = 4, 5 and 6 from the EEPROM: they are carried out
    alarms_and_position, ///< alarms until they are reset, and P0B-07 with an incremental encoder
    everything,          ///< all of these
};

/// What FunOUT.9, the brake, shows. Sections 6.4.2 and 7.2 [C77].
enum class c630s_brake : std::uint8_t {
    follows_servo,  ///< released while the motor is energised, on whichever output it is shown
    wired_only,     ///< the same, but only while a wired output, DO1 to DO6, has the function
    always_released ///< always released, as in a drive without a brake
};

/// What an emergency stop by P0D-05 does once the motor is at rest. Section 7.13 [C81].
enum class c630s_bus_stop : std::uint8_t {
    lasts,       ///< it holds the position until P0D-05 is 0
    resets,      ///< P0D-05 becomes 0 by itself: the next command is carried out
    frees_shaft, ///< the power is off until S-ON has been inactive
};

/// What a test may choose of the simulated C630S.
struct c630s_options {
    /// Er.942: more than 200 parameters stored within this time.
    duration many_writes_within = milliseconds(10'000);
    /// The write of P0C-13 = 0 is itself stored in the EEPROM, like every write while P0C-13 is 1. Section
    /// 7.12 [C10].
    bool stores_eeprom_off = true;
    /// P0D-01 resets warnings of an enabled drive too, though its row requires a stopped drive. Section 7.13.
    bool resets_while_enabled = false;
    /// FunOUT.9 on a virtual output counts as a brake: P02-09 to P02-12 have an effect. Section 7.2 [C77].
    bool virtual_brake_delays = true;
    /// The response to function 10h is as section 9.2.3 prints it: with the byte count in place of the
    /// quantity [C2].
    bool echoes_byte_count = false;
    /// HomeAttain and ElecHomeAttain are cleared when a new homing begins; otherwise only at power-off.
    /// Section 6.4.2 [C80].
    bool home_output_falls = true;
    /// What a restart keeps.
    c630s_restart restart_keeps = c630s_restart::parameters;
    /// P0D-00 counts as a power cycle; otherwise changes that wait for power-on continue to wait. Section
    /// 7.13 [C82].
    bool software_reset_is_power_on = true;
    /// What the brake output shows.
    c630s_brake brake = c630s_brake::follows_servo;
    /// What P0D-05 does.
    c630s_bus_stop bus_stop = c630s_bus_stop::lasts;
    /// P0D-01, P0D-20 and P02-31 read 0 once they are carried out. Otherwise they keep the value, and the same value is
    /// no command again. Sections 7.2 and 7.13 [C80].
    bool commands_end = true;
    /// P05-30 reads 0 once its 4, 5 or 6 is carried out. False: it keeps the value, as an ancestor of the drive keeps a
    /// 4, and the same value is no command again. Section 7.5 [C80].
    bool homing_command_ends = false;
    /// FunIN.28 needs a level and not an edge: a virtual input whose logic is an edge never starts the
    /// segments. Section 6.4.1 [C23].
    bool segment_start_is_level = false;
    /// FunIN.18 and FunIN.19 run "at the given command", P06-03, and not at P06-04. Section 6.4.1 [C83].
    bool jog_follows_command = false;
    /// P0B-34 of record 0 is the newest alarm, also after it has ended, and not the present one. Section 7.11
    /// [C17].
    bool shows_last_alarm = false;
    /// P0B-40 is in V, as printed, and not in 0.1 V as P0B-26 [C43].
    bool bus_voltage_in_volts = false;
    /// P0C-25 is added to the time that the drive itself needs for a response, here 40 ms, and does not
    /// include it [C79].
    bool delay_is_additional = false;
    /// The functions of virtual inputs count for Er.130 even while P0C-09 is 0. Chapter 8 [C78].
    bool disabled_inputs_count = false;
    /// If two outputs have the same function, only the first of them shows it, DO1 to DO6 before VDO1 to
    /// VDO16. Section 6.4.2 [C78].
    bool first_output_shows = false;
    /// A change of S-ON's terminal waits for the next power-on. False: for standstill, as the maker's worked example of
    /// the Lichuan A5 needs it. Sections 6.4.1 and 7.16 [C15].
    bool servo_on_waits_for_power_on = true;
    /// What a relative displacement leaves below a count of the encoder is added to the next one. Section 6.1.2 [C84].
    bool gear_keeps_rest = false;
};

} // namespace servobus::sim
