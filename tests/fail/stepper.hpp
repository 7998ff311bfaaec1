// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An open loop stepper on a port that does nothing, for the wrong programs that command one.
#pragma once

#include <servobus/device/yako.hpp>

#include "program.hpp"

namespace yako = servobus::yako;

struct some_stepper : yako::open_loop::drive<servobus::line<some_port>> {
    some_stepper() : drive{wire, 1} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};
