// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An identification of a kind that the standard does not have.
// EXPECT: an_identification_is_basic_regular_extended_or_single
// MEND: (void)modbus::put_identification_request(pdu, {modbus::identification::regular, 0});
#include <cstdint>

#include <servobus/modbus/identification.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    (void)modbus::put_identification_request(pdu, {modbus::identification{5}, 0}); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
