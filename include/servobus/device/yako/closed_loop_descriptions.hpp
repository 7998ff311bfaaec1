// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, closed loop: a sentence about each register, in address order.
// yako/closed_loop_catalogue.hpp includes it; programs on a target do not. Source: manual V2.6.0, appendix 2, in short
// English.
//
//     for (const description& d : yako::closed_loop::descriptions)
//         std::printf("%04Xh %s\n", unsigned{d.address}, d.sentence);
#pragma once

#include <servobus/device/yako/common_descriptions.hpp>
#include <servobus/registers/descriptions.hpp>

namespace servobus::yako::closed_loop {

// clang-format off
/// Describes the registers that the other variant lacks, or that differ there.
inline constexpr description own_descriptions[] = {
    {0x0008, "Shows the states of inputs X0 (bit 0) to X3 (bit 3): 0 inactive, 1 active."},
    {0x0009, "Shows the states of outputs Y0 (bit 0) and Y1 (bit 1): 0 inactive, 1 active."},
    {0x000A, "Shows the motor position, which is the encoder feedback converted to microsteps."},
    {0x001A, "Selects the speed resolution: 0 one revolution per minute, 1 a tenth of that."},
    {0x0031, "Selects the CiA 402 homing method: 1-14, 33-34 with index pulse, 17-30 without, 35 current position, or -1..-4 collision."},
    {0x003B, "Sets the encoder position error at a stall above which homing methods -1 to -4 detect a collision."},
    {0x003C, "Reduces the motor current to this share during homing by methods -1 to -4."},
    {0x0040, "Selects normally open (0) or normally closed (1) for inputs X0 (bit 0) to X3 (bit 3)."},
    {0x004B, "Selects normally open (0) or normally closed (1) for outputs Y0 (bit 0) and Y1 (bit 1)."},
    {0x0051, "Selects the PV or speed trigger: 0 level, 1 rising edge, needed to mix position and speed segments."},
    {0x0100, "Selects the operating mode: 1 open loop, 2 angle-based switching between open and closed loop, 3 full closed loop."},
    {0x0101, "Sets the encoder resolution, which is four times the number of encoder lines."},
    {0x0103, "Limits the current at rated load in closed loop to this share of the maximum output current."},
    {0x010A, "Sets the position error threshold of the following error alarm."},
    {0x010B, "Sets the range of the positioning error."},
    {0x0112, "Sets the LA speed parameter Kp1."},
    {0x0113, "Sets the LA speed parameter Kv1."},
    {0x0114, "Sets the LA speed node 1."},
    {0x0115, "Sets the LA speed parameter Kp2."},
    {0x0116, "Sets the LA speed parameter Kv2."},
    {0x0117, "Sets the LA speed node 2."},
    {0x0118, "Sets the LA speed feedforward gain Kvf."},
    {0x0119, "Sets the LA position loop gain Ki."},
};
// clang-format on

inline constexpr auto descriptions = joined(common_descriptions, own_descriptions);

} // namespace servobus::yako::closed_loop
