// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interpretations of the YAKOTEC manual as choices of switches, and how safety scenes are played under them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <servobus/sim/yako/options.hpp>

#include "under_interpretations.hpp"

namespace interpretations {

/// The number of positions of each switch of `yako_options_of`. Five interpretations have tests of their own, since
/// no other scene would reach them: `answers_bad_crc` needs a corrupted request, `rescales_feedback_only` 0.1
/// r/min, `commands_read_back` a read of 0027h or 002Dh, `restores_eeprom` two restarts and
/// `moves_address_immediately` a drive whose switches are off.
inline const std::vector<unsigned> yako_switches{4, 2, 2, 2, 5, 3, 2, 3, 2, 2, 2, 2, 2};

inline servobus::sim::yako_options yako_options_of(const choice& c) {
    using namespace servobus::sim;
    yako_options o;
    o.kept = static_cast<yako_kept>(c[0]);
    o.restart_keeps_place = c[1] != 0;
    o.restart_keeps_homed = c[2] != 0;
    o.is_enabled_at_power_on = c[3] == 0;
    o.in_position = static_cast<yako_in_position>(c[4]);
    o.homed = static_cast<yako_homed>(c[5]);
    o.is_homed_before_offset = c[6] != 0;
    o.alarm = static_cast<yako_alarm>(c[7]);
    o.refuses_unfit = c[8] != 0;
    o.saves_while_moving = c[9] != 0;
    o.stops_homing = c[10] == 0;
    o.interrupts_from_target = c[11] != 0;
    o.ramps_to_1000_r_per_min = c[12] != 0;
    return o;
}

/// Plays `scenes(options, number, is_whole)` under each choice; it returns how many scenes it played. In the
/// whole product (`is_whole`) a test with one scene for each frame plays only part of the scenes under each
/// choice.
template <class Scenes> void under_yako(const Scenes& scenes) {
    const char* wanted = std::getenv("SERVOBUS_INTERPRETATIONS");
    const bool is_whole = wanted != nullptr && std::string_view{wanted} == "whole";
    std::size_t number = 0;
    under("yako", yako_switches,
          [&](const choice& c) -> std::size_t { return scenes(yako_options_of(c), number++, is_whole); });
}

} // namespace interpretations
