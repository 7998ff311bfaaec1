// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels and a servo on ports that do nothing, for the wrong programs that command them.
#pragma once

#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

struct some_wheels : zlac::drive<servobus::line<some_port>> {
    some_wheels() : drive{wire, 1, servobus::unsupervised} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};

struct some_servo : servobus::c630s::drive<servobus::line<some_port>> {
    some_servo() : drive{wire, 1} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(57600)};
};
