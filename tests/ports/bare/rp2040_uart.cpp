// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The RP2040 port in a program.
#include "examples/ports/rp2040_uart.hpp"

#include "tests/ports/program.hpp"

extern uart_inst_t stub_uart;
constinit servobus::ports::rp2040_uart rs485{&stub_uart, 2, 115200};

void uart_interrupt() { rs485.on_interrupt(); }

bool job() {
    rs485.start();
    return program::count_up(rs485);
}
