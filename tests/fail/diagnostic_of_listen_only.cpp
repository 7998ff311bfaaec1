// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A diagnostic request that silences the device.
// EXPECT: a_diagnostic_without_data_is_sub_function_02_0A_to_12_or_14h
// MEND: (void)modbus::put_diagnostic_request(pdu, modbus::diagnostic::bus_messages);
#include <cstdint>

#include <servobus/modbus/diagnostics.hpp>

namespace modbus = servobus::modbus;

constexpr int request() {
    std::uint8_t pdu[16]{};
    (void)modbus::put_diagnostic_request(pdu, modbus::diagnostic::listen_only); // wrong
    return pdu[0];
}

int main() {
    constexpr int code = request();
    return code;
}
