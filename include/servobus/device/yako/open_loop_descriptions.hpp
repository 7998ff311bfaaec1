// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, open loop: a sentence about each register, in address order. yako/open_loop_catalogue.hpp
// includes it; programs on a target do not. Source: manual V2.6.0, appendix 3, in short English.
//
//     for (const description& d : yako::open_loop::descriptions)
//         std::printf("%04Xh %s\n", unsigned{d.address}, d.sentence);
#pragma once

#include <servobus/device/yako/common_descriptions.hpp>
#include <servobus/registers/descriptions.hpp>

namespace servobus::yako::open_loop {

// clang-format off
/// Describes the registers that the other variant lacks, or that differ there.
inline constexpr description own_descriptions[] = {
    {0x0008, "Shows the states of inputs X0 (bit 0) to X6 (bit 6): 0 inactive, 1 active."},
    {0x0009, "Shows the states of outputs Y0 (bit 0) to Y2 (bit 2): 0 inactive, 1 active."},
    {0x000A, "Shows the motor position, which is the commanded position."},
    {0x0031, "Selects the CiA 402 homing method: 17-30 by limit or home switch, 35 current position."},
    {0x0040, "Selects normally open (0) or normally closed (1) for inputs X0 (bit 0) to X6 (bit 6)."},
    {0x0045, "Selects input X4 function: 0 none, 1 home, 2-3 limits, 4 release, 5-6 stops, 7-10 moves, 11 homing, 12-18 segments."},
    {0x0046, "Selects input X5 function: 0 none, 1 home, 2-3 limits, 4 release, 5-6 stops, 7-10 moves, 11 homing, 12-18 segments."},
    {0x0047, "Selects input X6 function: 0 none, 1 home, 2-3 limits, 4 release, 5-6 stops, 7-10 moves, 11 homing, 12-18 segments."},
    {0x004B, "Selects normally open (0) or normally closed (1) for outputs Y0 (bit 0) to Y2 (bit 2)."},
    {0x004E, "Selects output Y2 function: 0 none, 1 alarm, 2 moving, 3 homed, 4 in position, 5 brake, 9-11 user-defined."},
    {0x0051, "Selects the PV (speed segment) trigger: 0 level, 1 rising edge, needed to mix position and speed segments."},
    {0x0130, "Sets the start speed of segment 1, shared by position (PT) and speed (PV) segments."},
    {0x0131, "Sets the start speed of segment 2, shared by position (PT) and speed (PV) segments."},
    {0x0132, "Sets the start speed of segment 3, shared by position (PT) and speed (PV) segments."},
    {0x0133, "Sets the start speed of segment 4, shared by position (PT) and speed (PV) segments."},
    {0x0134, "Sets the start speed of segment 5, shared by position (PT) and speed (PV) segments."},
    {0x0135, "Sets the start speed of segment 6, shared by position (PT) and speed (PV) segments."},
    {0x0136, "Sets the start speed of segment 7, shared by position (PT) and speed (PV) segments."},
    {0x0137, "Sets the start speed of segment 8, shared by position (PT) and speed (PV) segments."},
    {0x0138, "Sets the start speed of segment 9, shared by position (PT) and speed (PV) segments."},
    {0x0139, "Sets the start speed of segment 10, shared by position (PT) and speed (PV) segments."},
    {0x013A, "Sets the start speed of segment 11, shared by position (PT) and speed (PV) segments."},
    {0x013B, "Sets the start speed of segment 12, shared by position (PT) and speed (PV) segments."},
    {0x013C, "Sets the start speed of segment 13, shared by position (PT) and speed (PV) segments."},
    {0x013D, "Sets the start speed of segment 14, shared by position (PT) and speed (PV) segments."},
    {0x013E, "Sets the start speed of segment 15, shared by position (PT) and speed (PV) segments."},
    {0x013F, "Sets the start speed of segment 16, shared by position (PT) and speed (PV) segments."},
};
// clang-format on

inline constexpr auto descriptions = joined(common_descriptions, own_descriptions);

} // namespace servobus::yako::open_loop
