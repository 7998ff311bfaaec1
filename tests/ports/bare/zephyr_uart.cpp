// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The Zephyr port in a program.
#include "examples/ports/zephyr_uart.hpp"

#include "tests/ports/program.hpp"

extern const device uart;
extern const gpio_dt_spec pin;
constinit servobus::ports::zephyr_uart rs485{&uart, &pin, 115200};

bool job() { return rs485.start() && program::count_up(rs485); }
