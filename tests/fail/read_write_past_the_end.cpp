// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A request of function 17h that writes past the last address.
// EXPECT: a_read_write_writes_1_to_121_registers_inside_the_address_space
// MEND: (void)modbus::put_read_write_request(pdu, 3, 6, 0xFFFE, values);
#include <cstdint>

#include <servobus/modbus/read_write.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    constexpr std::uint16_t values[]{255, 255};
    (void)modbus::put_read_write_request(pdu, 3, 6, 0xFFFF, values); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
