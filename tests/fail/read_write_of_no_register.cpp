// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A request of function 17h that reads nothing.
// EXPECT: a_read_write_reads_1_to_125_registers_inside_the_address_space
// MEND: (void)modbus::put_read_write_request(pdu, 3, 6, 14, values);
#include <cstdint>

#include <servobus/modbus/read_write.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    constexpr std::uint16_t values[]{255, 255};
    (void)modbus::put_read_write_request(pdu, 3, 0, 14, values); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
