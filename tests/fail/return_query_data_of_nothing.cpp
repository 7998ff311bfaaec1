// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Return Query Data request without data.
// EXPECT: return_query_data_has_1_to_125_words
// MEND: (void)modbus::put_return_query_data_request(pdu, values);
#include <cstdint>

#include <servobus/modbus/diagnostics.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    (void)modbus::put_return_query_data_request(pdu, servobus::slice<const std::uint16_t>{}); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
