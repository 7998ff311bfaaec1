// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Shared by the measurements of a line's use: the registers of the drives, a plan that fills the line, and
// the least time of its reads.
#pragma once

#include <cstdint>
#include <span>

#include <servobus/bus/bus.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>

namespace bench {

// Each register holds its own address.
struct store {
    static std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = address++;
        return 0;
    }
    static std::uint8_t write(std::uint16_t, servobus::words_view) { return 0; }
};

inline constexpr servobus::node<servobus::zlac8015d::device> wheels{1};
inline constexpr servobus::node<servobus::yako::closed_loop::device> lift{2};

// Reads the speeds of two wheels and the state of a lift every `period`.
consteval auto cycle(std::uint32_t baud, servobus::duration period) {
    using namespace servobus;
    return poll_plan{modbus::timing_at(baud),
                     cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels, period),
                     cyclic<yako::status_word>(lift, period)};
}
// The shortest period that the line allows if both drives respond after t3.5.
consteval auto endless(std::uint32_t baud) {
    const auto slow = cycle(baud, servobus::milliseconds(1000));
    return cycle(baud, slow.shortest(slow.polls[0]) + slow.shortest(slow.polls[1]));
}
inline constexpr auto at_9600 = endless(9600);
inline constexpr auto at_57600 = endless(57'600);
inline constexpr auto at_115200 = endless(115'200);

/// The least time of a request to a drive that responds after `delay`, and of the response: the wire time
/// of both frames and two gaps. The first gap is the longer of t3.5 and the drive's delay.
template <class Plan>
constexpr servobus::duration least_time(const Plan& plan, const servobus::poll& p, servobus::duration delay) {
    const servobus::duration t3_5{plan.timing().t3_5};
    return plan.timing().wire_time(8) + longer_of(delay, t3_5) + plan.timing().wire_time(p.response_size()) +
           t3_5;
}

} // namespace bench
