// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of inputs past the last address.
// EXPECT: a_read_of_bits_asks_for_1_to_2000_inside_the_address_space
// MEND: (void)modbus::put_read_bits_request(pdu, modbus::function::read_discrete_inputs, 0xFFFF, 1);
#include <cstdint>

#include <servobus/modbus/bits.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[5]{};
    (void)modbus::put_read_bits_request(pdu, modbus::function::read_discrete_inputs, 0xFFFF, 2); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
