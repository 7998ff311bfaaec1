// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of coils past the last address.
// EXPECT: a_write_of_coils_has_1_to_1968_inside_the_address_space
// MEND: (void)modbus::put_write_coils_request(pdu, 0xFFFE, coils);
#include <cstdint>

#include <servobus/modbus/bits.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    constexpr bool coils[]{true, false};
    (void)modbus::put_write_coils_request(pdu, 0xFFFF, coils); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
