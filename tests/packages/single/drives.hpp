// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port that nothing responds to, and calls of each drive, for both sources of one program. The including source has
// the single headers.
#pragma once

struct dead_uart {
    servobus::instant clock{};

    servobus::transfer send(servobus::bytes frame) { return static_cast<std::uint16_t>(frame.size()); }
    bool sent() { return true; }
    servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
    servobus::instant now() { return clock = clock + servobus::milliseconds(1); }
};

/// How many of the drives' commands have ended with a timeout: all three of them.
inline int unanswered() {
    using namespace servobus;
    dead_uart uart;
    line wire{uart, modbus::timing_at(115200)};
    zlac8015d::drive wheels{wire, 1, unsupervised};
    yako::closed_loop::drive axis{wire, 2};
    c630s::drive servo{wire, 3};
    const auto is_unanswered = [](errc error) { return error == errc::timeout; };
    return is_unanswered(wheels.run(init{}).error()) + is_unanswered(axis.run(init{}).error()) +
           is_unanswered(servo.run(init{}).error());
}
