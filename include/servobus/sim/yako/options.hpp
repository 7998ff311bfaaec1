// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a test may choose of a simulated YAKOTEC stepper: its set-up, and the interpretations of the manual V2.6.0
// where it is silent or can be read in two ways. Each interpretation names the place in the manual and its erratum
// in device/errata.md.
//
//     servobus::sim::yako_options chosen;
//     chosen.kept = servobus::sim::yako_kept::marked;
//     servobus::sim::yako_closed_loop drive{chosen};
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::sim {

/// Which registers keep their value over a restart. The appendices mark rows RW and RW/S and do not say what
/// the S means, while 002Dh = 0042h saves "all parameters" (section 5.1) [errata A53, A55].
enum class yako_kept : std::uint8_t {
    saved,         ///< every writable register, with the value of the last save
    marked,        ///< likewise, but a save keeps only RW/S and the line's settings 0013h..0015h
    line_settings, ///< as `saved`, but 0013h..0015h, 0019h and 001Ah are kept as soon as they are written
    written,       ///< everything, as soon as it is written
};

/// What bit 0 of 0007h says, "in position" (appendices; section 5.2, output function 4) [errata A54].
enum class yako_in_position : std::uint8_t {
    at_rest,         ///< the motor has been at rest for 010Ch, near its commanded position; also after a stop
                     ///< that ended a move early, and until a commanded motion begins
    until_commanded, ///< likewise, and it is cleared when a motion is commanded
    after_first_move, ///< as `at_rest`, but not before the first position move since power-on has ended
    at_target,        ///< only after a position move that reached its target, until a motion begins
    until_next_move,  ///< likewise, until a position move begins: a jog, a homing or a stop leave it set
};

/// When bit 1 of 0007h, "homing complete", is cleared while the drive stays on (appendices) [errata A54].
enum class yako_homed : std::uint8_t {
    until_homing,     ///< when the next homing begins
    until_place_lost, ///< likewise, and by an emergency stop, a release, or when the position is cleared
    always,           ///< never, not even during another homing
};

/// What an alarm, and clearing it by 002Dh = 0021h, does to the motor (section 5.1) [errata A57].
enum class yako_alarm : std::uint8_t {
    releases,         ///< the motor is released until it is enabled
    clearing_enables, ///< the motor is released until the alarm is cleared
    holds,            ///< the motor stops without a ramp and stays enabled; starts are ignored
};

/// What a test may choose of the simulated stepper.
struct yako_options {
    /// Time from the acknowledged start to the motion and its status bit.
    duration start_delay = milliseconds(2);
    /// The motor is enabled at power-on. Bit 4 of 0007h at power-on is not stated (appendices) [errata A55].
    bool is_enabled_at_power_on = true;
    /// A request with a bad CRC is answered by exception 1 (section 3.4) [errata A4].
    bool answers_bad_crc = false;
    /// The switches SW1..SW7. The lower five are the address; if all of them are off, 0013h is the address.
    std::uint8_t switches = 1;

    yako_kept kept = yako_kept::saved;
    /// True: a restart keeps position and home. False: after it the position is 0 where the motor is.
    /// Appendices, 000Ah [errata A55].
    bool restart_keeps_place = false;
    /// Bit 1 of 0007h keeps its value over a restart. Appendices [errata A55].
    bool restart_keeps_homed = false;
    yako_in_position in_position = yako_in_position::at_rest;
    yako_homed homed = yako_homed::until_homing;
    /// Bit 1 of 0007h is set when home is found, not after the offset move. Section 4.3 [errata A54].
    bool is_homed_before_offset = false;
    yako_alarm alarm = yako_alarm::releases;
    /// A command that does not fit the state is answered by exception 7, not acknowledged and ignored. The
    /// manual states that it is ignored while moving (4.1, 5.1), but not what the response is [errata A56].
    bool refuses_unfit = false;
    /// A save while the motor moves is carried out, contrary to section 5.1 [errata A56].
    bool saves_while_moving = false;
    /// 0027h and 002Dh read as what was last written, not as 0. Section 3.4, appendices [errata A47].
    bool commands_read_back = false;
    /// Bits 8 and 9 of 0027h end a homing too; section 4.6 names positioning and speed only [errata A58].
    bool stops_homing = true;
    /// A relative move that interrupts another one counts from the target of that one, not from the present
    /// position. Section 4.1 [errata A59].
    bool interrupts_from_target = false;
    /// Ramp times lead from 0 to 1000 r/min, not to the motion's speed. Section 4.1, 4.4 [errata A32].
    bool ramps_to_1000_r_per_min = false;
    /// 001Ah rescales the feedback 000Ch only, not the commanded speeds. Appendix 2 [errata A37].
    bool rescales_feedback_only = false;
    /// 0041h in 002Dh restores the EEPROM too; otherwise a restart brings the old values back. Section 5.1
    /// [errata A55].
    bool restores_eeprom = true;
    /// 0013h takes effect when it is written, otherwise at the next power-on. Section 2.2 [errata A60].
    bool moves_address_immediately = false;
};

} // namespace servobus::sim
