// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A function that needs data in a request without any.
// EXPECT: a_request_without_data_is_of_function_07_0B_0C_or_11h
// MEND: (void)modbus::put_bare_request(pdu, modbus::function::report_server_id);
#include <cstdint>

#include <servobus/modbus/diagnostics.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    (void)modbus::put_bare_request(pdu, modbus::function::read_holding_registers); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
