// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The same program without the library. The figures of the other programs are their difference to this one.
#include "board.hpp"

namespace {
constexpr std::uint8_t request[8]{};
}

extern "C" bool job() {
    (void)clock_us();
    return uart_send(request, sizeof request) == 8 && uart_sent() && uart_receive() < 0;
}
