// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the RP2040 port uses of hardware_uart. The registers are objects, so that the fake detects each
// access.
#pragma once

#include <stdint.h>

#define UART_UARTDR_OE_BITS 0x00000800u
#define UART_UARTDR_BE_BITS 0x00000400u
#define UART_UARTDR_PE_BITS 0x00000200u
#define UART_UARTDR_FE_BITS 0x00000100u
#define UART_UARTFR_BUSY_BITS 0x00000008u

struct stub_data_register {
    operator uint32_t() const;
    void operator=(uint32_t byte) const;
};
struct stub_flag_register {
    operator uint32_t() const;
};

typedef struct {
    stub_data_register dr;
    stub_flag_register fr;
} uart_hw_t;

typedef struct uart_inst {
    uart_hw_t hw;
} uart_inst_t;

uart_hw_t* uart_get_hw(uart_inst_t* uart);
bool uart_is_writable(uart_inst_t* uart);
bool uart_is_readable(uart_inst_t* uart);
void uart_set_irq_enables(uart_inst_t* uart, bool rx_has_data, bool tx_needs_data);
