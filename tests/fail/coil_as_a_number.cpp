// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number written to a coil.
// EXPECT: a coil is written as true or false, not as a number
// MEND: (void)modbus::put_write_coil_request(pdu, 0x00AC, true);
#include <cstdint>

#include <servobus/modbus/bits.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[5]{};
    (void)modbus::put_write_coil_request(pdu, 0x00AC, 0xFF00); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
