// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command of a drive that forgets its steps.
// EXPECT: servobus::routine
// MEND:     return {.steps = zlac::routines::init, .then = zlac::effect::initialised};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

constexpr zlac::prepared_command plan_init() {
    return {.then = zlac::effect::initialised}; // wrong
}

int main() { return plan_init().steps.size() == 0 ? 1 : 0; }
