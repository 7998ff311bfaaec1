// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of bits by the function of registers.
// EXPECT: a_read_of_bits_is_function_01_or_02
// MEND: (void)modbus::put_read_bits_request(pdu, modbus::function::read_coils, 0, 8);
#include <cstdint>

#include <servobus/modbus/bits.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[5]{};
    (void)modbus::put_read_bits_request(pdu, modbus::function::read_holding_registers, 0, 8); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
