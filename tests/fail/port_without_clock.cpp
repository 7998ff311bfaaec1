// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A board's port that has no clock.
// EXPECT: p.now()
// MEND: servobus::instant now() { return {}; }
#include "program.hpp"

struct no_clock {
    servobus::transfer send(servobus::bytes) { return std::uint16_t{0}; }
    bool sent() { return false; }
    servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
};

int main() {
    no_clock port;
    servobus::line<no_clock> wire{port, servobus::modbus::timing_at(115200)}; // wrong
    (void)wire;
}
