// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names that a program writes, and no others. Names for the authors of devices, drives and ports stay in servobus:
// `reg`, `at`, `step`, `bus`, `field`, `list`. There they do not meet those of firmware. Programs include it beside the
// headers of their devices.
//
//     using namespace servobus::words;
//     bool is_charged(auto& wire) {
//         client drive{wire, node<servobus::zlac8015d::device>{1}};
//         return drive.template read<servobus::zlac8015d::bus_voltage>().value_or(0_V) > 44.5_V;
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/any_device.hpp>
#include <servobus/axis/axis.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/line/reconnecting.hpp>
#include <servobus/registers/literals.hpp>
#include <servobus/registers/quantity_text.hpp>
#include <servobus/servobus.hpp>

/// The names of a program. A name is here only if firmware seldom has it for something else; a test compiles firmware
/// with common words of its own.
namespace servobus::words {
// lines, nodes, values
using servobus::checked;
using servobus::client, servobus::line, servobus::node, servobus::reconnecting, servobus::responds_within;
using servobus::duration, servobus::instant, servobus::milliseconds, servobus::since;
using servobus::errc, servobus::outcome, servobus::result, servobus::status, servobus::text;
using namespace servobus::literals;

// commands of all drives
using servobus::after_enable, servobus::setpoint_loop, servobus::setpoints, servobus::take_over,
    servobus::with_fault_reset;
using servobus::by_plan, servobus::no_command_timeout, servobus::supervision, servobus::unsupervised;
using servobus::command_status, servobus::drive_state;
using servobus::declare_position, servobus::hold, servobus::limit_travel, servobus::move_by,
    servobus::move_to, servobus::velocity;
using servobus::disable, servobus::enable, servobus::fault_reset, servobus::halt, servobus::init,
    servobus::quick_stop, servobus::read_feedback, servobus::wait_reached, servobus::wait_standstill;

// several on a line
using servobus::controlled, servobus::cyclic, servobus::make_bus, servobus::poll_plan,
    servobus::scheduled_line;

// the machine's units
using servobus::axis, servobus::axis_profile, servobus::counts_per_turn, servobus::differential,
    servobus::gear_ratio, servobus::lead, servobus::mirrored, servobus::rolling, servobus::twist;
} // namespace servobus::words
