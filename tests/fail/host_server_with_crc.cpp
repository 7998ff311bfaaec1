// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An option of strict timing for a server in host timing.
// EXPECT: with_crc and with_leading_bytes are options of a row_server
// MEND: (void)servobus::host_row_server<silent_port, tank_values>{port, values, 7, servobus::modbus::timing_at(9600)};
#include <servobus/server/host_row_server.hpp>

#include "served.hpp"

int main() {
    silent_port port;
    tank_values values;
    (void)servobus::host_row_server<silent_port, tank_values, servobus::with_leading_bytes<4>>{
        port, values, 7, servobus::modbus::timing_at(9600)}; // wrong
}
