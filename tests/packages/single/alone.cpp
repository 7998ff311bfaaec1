// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One single header, SINGLE_HEADER, alone; with DRIVE and COMMANDS, commands of its drive.
#include SINGLE_HEADER

#ifdef DRIVE
struct uart {
    servobus::transfer send(servobus::bytes frame);
    bool sent();
    servobus::transfer receive(servobus::byte_buffer into);
    servobus::instant now();
};

bool job(uart& rs485) {
    servobus::line wire{rs485, servobus::modbus::timing_at(115200)};
    servobus::DRIVE drive{wire, 1, servobus::unsupervised};
    return drive.run(servobus::COMMANDS::init{}) && drive.run(servobus::COMMANDS::enable{});
}
#endif
