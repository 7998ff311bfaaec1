// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Packed coils with a byte too few.
// EXPECT: packed_coils_fill_their_bytes_and_no_other
// MEND: (void)modbus::put_write_coils_request(pdu, 0, modbus::bits_view{servobus::hex("CD 01"), 10});
#include <cstdint>

#include <servobus/modbus/bits.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    (void)modbus::put_write_coils_request(pdu, 0, modbus::bits_view{servobus::hex("CD"), 10}); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
