// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the manual of the ZLAC8015D leaves open: the options of its simulator. [Bn] are errata of the device.
#pragma once

#include <servobus/sim/zlac8015d/options.hpp>

#include "switches.hpp"

namespace tool {

namespace detail {
inline constexpr const char* zlac_kept[] = {"marked", "all"};
inline constexpr const char* zlac_zero[] = {"off", "stops"};
inline constexpr const char* zlac_shaft[] = {"locked", "released"};
inline constexpr const char* zlac_stopped[] = {"emergency", "locked"};
inline constexpr const char* zlac_running[] = {"turns", "driven", "enabled"};
inline constexpr const char* zlac_code[] = {"until_reset", "until_restart"};
inline constexpr const char* zlac_off[] = {"both_wheels", "its_wheel"};
inline constexpr const char* zlac_brake[] = {"engages", "releases"};
inline constexpr const char* zlac_idle[] = {"released", "emergency"};
inline constexpr const char* zlac_start[] = {"any", "by_200F"};
inline constexpr const char* zlac_ramp[] = {"begins_anew", "linear"};
} // namespace detail

using zlac_options = servobus::sim::zlac8015d_options;
inline constexpr option_switch<zlac_options> zlac8015d_switches[] = {
    switched<&zlac_options::resumes_after_watchdog>(
        "resumes_after_watchdog", "2000h: a request ends a watchdog stop, and the wheels turn on [B34]"),
    switched<&zlac_options::save>("save", detail::zlac_kept, "2010h: which rows it saves [B11]"),
    switched<&zlac_options::host_timeout>("host_timeout", detail::zlac_zero,
                                          "2000h = 0: no watchdog, or an immediate stop [B28]"),
    switched<&zlac_options::while_turning>("while_turning", detail::zlac_shaft,
                                           "20A2h: the shaft of a wheel that turns [B30]"),
    switched<&zlac_options::in_torque_mode>("in_torque_mode", detail::zlac_shaft,
                                            "20A2h: the shaft in torque mode [B30]"),
    switched<&zlac_options::after_quick_stop>("after_quick_stop", detail::zlac_stopped,
                                              "20A2h: the shaft after a quick stop [B30]"),
    switched<&zlac_options::bit>("bit", detail::zlac_running, "20A2h: bits 0 and 8, running [B31]"),
    switched<&zlac_options::code>("code", detail::zlac_code, "20A5h, 20A6h: how long they keep a code [B32]"),
    switched<&zlac_options::by_fault>("by_fault", detail::zlac_off, "which wheel a fault switches off [B33]"),
    switched<&zlac_options::code_1>("code_1", detail::zlac_brake,
                                    "201Ah, 201Bh = 1: what the brake does [B29]"),
    switched<&zlac_options::idle_shaft>("idle_shaft", detail::zlac_idle,
                                        "20A2h: the shaft of a motor without power [B30]"),
    switched<&zlac_options::shows_speed_of_moves>("shows_speed_of_moves",
                                                  "20ABh, 20ACh show the speed of a move too [B31]"),
    switched<&zlac_options::position_start>("position_start", detail::zlac_start,
                                            "10h, 11h and 12h: which of them start a move [B25]"),
    switched<&zlac_options::enables_without_mode>("enables_without_mode", "08h before a mode enables [B35]"),
    switched<&zlac_options::speed_ramp>("speed_ramp", detail::zlac_ramp,
                                        "2080h to 2083h: how a speed is reached [B36]"),
    switched<&zlac_options::checks_option_codes>("checks_option_codes",
                                                 "2012h to 2014h take the printed codes alone [B14]"),
    switched<&zlac_options::rescales_immediately>(
        "rescales_immediately", "2022h: a new value scales speeds before the next power-on [B21]"),
};
inline constexpr auto zlac8015d_interpretations = interpretations_of(zlac8015d_switches);

} // namespace tool
