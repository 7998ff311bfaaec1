// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ESP-IDF port in a program.
#include "examples/ports/esp_idf_uart.hpp"

#include "tests/ports/program.hpp"

constinit servobus::ports::esp_idf_uart rs485{UART_NUM_1};

bool job(const uart_config_t& settings) {
    return rs485.start(settings, 17, 16, 4) && program::count_up(rs485);
}
