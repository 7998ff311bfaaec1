// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the manual of the YAKOTEC steppers leaves open: the options of their simulator. [An] are errata of the device.
#pragma once

#include <servobus/sim/yako/options.hpp>

#include "switches.hpp"

namespace tool {

namespace detail {
inline constexpr const char* yako_kept_ways[] = {"saved", "marked", "line_settings", "written"};
inline constexpr const char* yako_in_position_ways[] = {"at_rest", "until_commanded", "after_first_move",
                                                        "at_target", "until_next_move"};
inline constexpr const char* yako_homed_ways[] = {"until_homing", "until_place_lost", "always"};
inline constexpr const char* yako_alarm_ways[] = {"releases", "clearing_enables", "holds"};
} // namespace detail

using yako_chosen = servobus::sim::yako_options;
inline constexpr option_switch<yako_chosen> yako_switches[] = {
    switched<&yako_chosen::is_enabled_at_power_on>("is_enabled_at_power_on",
                                                   "0007h, bit 4 at power-on [A55]"),
    switched<&yako_chosen::answers_bad_crc>("answers_bad_crc", "a bad CRC is answered by exception 1 [A4]"),
    switched<&yako_chosen::kept>("kept", detail::yako_kept_ways, "which rows a restart keeps [A53, A55]"),
    switched<&yako_chosen::restart_keeps_place>("restart_keeps_place", "000Ah after a restart [A55]"),
    switched<&yako_chosen::restart_keeps_homed>("restart_keeps_homed", "0007h, bit 1 after a restart [A55]"),
    switched<&yako_chosen::in_position>("in_position", detail::yako_in_position_ways, "0007h, bit 0 [A54]"),
    switched<&yako_chosen::homed>("homed", detail::yako_homed_ways, "0007h, bit 1: what clears it [A54]"),
    switched<&yako_chosen::is_homed_before_offset>("is_homed_before_offset",
                                                   "0007h, bit 1: set at home, before the offset move [A54]"),
    switched<&yako_chosen::alarm>("alarm", detail::yako_alarm_ways, "what an alarm does to the motor [A57]"),
    switched<&yako_chosen::refuses_unfit>("refuses_unfit",
                                          "exception 7 to a command that does not fit the state [A56]"),
    switched<&yako_chosen::saves_while_moving>("saves_while_moving",
                                               "002Dh = 0042h while the motor moves [A56]"),
    switched<&yako_chosen::commands_read_back>("commands_read_back",
                                               "0027h and 002Dh read as what was written [A47]"),
    switched<&yako_chosen::stops_homing>("stops_homing", "bits 8 and 9 of 0027h end a homing too [A58]"),
    switched<&yako_chosen::interrupts_from_target>(
        "interrupts_from_target", "from where a relative move counts that interrupts another [A59]"),
    switched<&yako_chosen::ramps_to_1000_r_per_min>("ramps_to_1000_r_per_min",
                                                    "ramp times lead to 1000 r/min [A32]"),
    switched<&yako_chosen::rescales_feedback_only>("rescales_feedback_only",
                                                   "001Ah rescales the feedback only [A37]"),
    switched<&yako_chosen::restores_eeprom>("restores_eeprom", "002Dh = 0041h restores the EEPROM too [A55]"),
    switched<&yako_chosen::moves_address_immediately>("moves_address_immediately",
                                                      "0013h takes effect when it is written [A60]"),
};
inline constexpr auto yako_interpretations = interpretations_of(yako_switches);

} // namespace tool
