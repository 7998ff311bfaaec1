// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The plans of the simulated buses. Their cyclic reads are of registers that the facades do not read, so each
// frame on the wire shows whether the bus or a facade sent it.
#pragma once

#include <servobus/bus/bus.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "test_device.hpp"

namespace trial::plans {

template <class Device>
constexpr servobus::node<Device> with_times(std::uint8_t node_address, std::uint32_t response_ms,
                                            std::uint32_t quarantine_ms, std::uint32_t gap_us = 0) {
    servobus::node<Device> n{node_address};
    n.limits.response = servobus::milliseconds(response_ms);
    n.gaps.quarantine = servobus::milliseconds(quarantine_ms);
    n.gaps.gap = servobus::duration{gap_us};
    return n;
}

/// Feedback every `ms`, and no command timeout: the runs set one on some drives.
constexpr servobus::supervision every(std::uint32_t ms) {
    return {.feedback = servobus::milliseconds(ms), .command_timeout = servobus::no_command_timeout};
}

/// Wheels and a lift that are polled at high rates, a test device, and one that the program itself asks.
namespace fast {
inline constexpr std::uint32_t baud = 115200;
inline constexpr auto wheels_node = with_times<servobus::zlac8015d::device>(1, 30, 40);
inline constexpr auto lift_node = with_times<servobus::yako::closed_loop::device>(2, 30, 40, 3000);
inline constexpr auto test_node = with_times<test_device::device>(11, 40, 50);
inline constexpr auto asked_node = with_times<test_device::device>(21, 25, 40);
inline constexpr servobus::poll_plan plan{
    servobus::modbus::timing_at(baud),
    servobus::controlled(wheels_node, every(30)),
    servobus::controlled(lift_node, every(50)),
    servobus::cyclic<servobus::zlac8015d::bus_voltage>(wheels_node, servobus::milliseconds(100)),
    servobus::cyclic<servobus::yako::closed_loop::output_polarity>(lift_node, servobus::milliseconds(120)),
    servobus::cyclic<test_device::live_pair, test_device::other_word>(test_node, servobus::milliseconds(50)),
    servobus::cyclic<test_device::live_word>(test_node, servobus::milliseconds(70)),
    servobus::own_requests(asked_node, servobus::milliseconds(110), 3)};
} // namespace fast

/// A servo and three test devices, one of which has a keep-alive, and one that the program itself asks.
namespace slow {
inline constexpr std::uint32_t baud = 19200;
inline constexpr auto servo_node = with_times<servobus::c630s::device>(3, 60, 50);
inline constexpr auto first_node = with_times<test_device::device>(11, 50, 60);
inline constexpr auto second_node = with_times<test_device::device>(12, 40, 30, 5000);
inline constexpr auto third_node = with_times<test_device::device>(13, 80, 40);
inline constexpr auto asked_node = with_times<test_device::device>(22, 90, 50, 6000);
inline constexpr servobus::poll_plan plan{
    servobus::modbus::timing_at(baud, servobus::modbus::timing_mode::strict),
    servobus::controlled(servo_node, every(100)),
    servobus::cyclic<test_device::live_word>(first_node, servobus::milliseconds(90))
        .keeps_alive(servobus::milliseconds(3400)),
    servobus::cyclic<servobus::c630s::bus_voltage>(servo_node, servobus::milliseconds(250)),
    servobus::cyclic<test_device::live_pair, test_device::other_word>(second_node,
                                                                      servobus::milliseconds(150)),
    servobus::cyclic<test_device::live_pair>(third_node, servobus::milliseconds(400)),
    servobus::own_requests(asked_node, servobus::milliseconds(330), 5)};
} // namespace slow

} // namespace trial::plans
