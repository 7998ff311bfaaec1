// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A board's port whose receive gives a plain number, and could not say that it failed.
// EXPECT: does not satisfy
// MEND: servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
#include "program.hpp"

struct plain_count {
    servobus::transfer send(servobus::bytes) { return std::uint16_t{0}; }
    bool sent() { return false; }
    int receive(servobus::byte_buffer) { return -1; }
    servobus::instant now() { return {}; }
};

int main() {
    plain_count port;
    servobus::blocking_line<plain_count, servobus::modbus::timing_at(115200)> wire{port}; // wrong
    (void)wire;
}
