// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D that is polled and not supervised: the reads would keep its watchdog from expiring, and its wheels would
// turn on for a program that has stopped commanding.
// EXPECT: this drive needs a command timeout, or no_command_timeout by name
// MEND: (void)zlac::drive{wire, 1, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

int main() {
    some_port port;
    line wire{port, modbus::timing_at(115200)};
    (void)zlac::drive{wire, 1, {.feedback = milliseconds(20)}}; // wrong
}
