// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Modbus RTU server of libmodbus on a serial device, until it is killed. It prints each register and coil that
// a request has changed, one a line.   libmodbus_server DEVICE
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include <modbus/modbus.h>

#include "registers.hpp"

int main(int, char** words) {
    modbus_t* const server = modbus_new_rtu(words[1], interop::baud, 'N', 8, 1);
    modbus_mapping_t* const map = modbus_mapping_new_start_address(
        interop::first_coil, interop::coils, interop::first_input, interop::inputs, interop::first,
        interop::count, interop::first, interop::count);
    if (server == nullptr || map == nullptr || modbus_set_slave(server, interop::node_address) != 0 ||
        modbus_connect(server) != 0) {
        (void)std::fprintf(stderr, "libmodbus_server: %s: %s\n", words[1], modbus_strerror(errno));
        return 1;
    }
    // libmodbus sleeps for the response timeout before each exception. After an invalid frame it drops all
    // received bytes.
    (void)modbus_set_response_timeout(server, 0, 1000);
    (void)modbus_set_byte_timeout(server, 0, 300'000); // on a busy machine a frame may arrive in pieces
    (void)modbus_set_error_recovery(server, MODBUS_ERROR_RECOVERY_PROTOCOL);
    for (unsigned i = 0; i < interop::count; ++i)
        map->tab_registers[i] = map->tab_input_registers[i] = interop::initial(interop::first + i);
    for (unsigned i = 0; i < interop::coils; ++i)
        map->tab_bits[i] = interop::initial_bit(interop::first_coil + i) ? 1 : 0;
    for (unsigned i = 0; i < interop::inputs; ++i)
        map->tab_input_bits[i] = interop::initial_bit(interop::first_input + i) ? 1 : 0;
    std::vector<std::uint8_t> request(MODBUS_RTU_MAX_ADU_LENGTH);
    while (true) {
        const int size = modbus_receive(server, request.data());
        if (size < 0 && (errno == EIO || errno == EBADF)) return 1;
        if (size <= 0) continue;
        const std::vector<std::uint16_t> before(map->tab_registers, map->tab_registers + interop::count);
        const std::vector<std::uint8_t> coils(map->tab_bits, map->tab_bits + interop::coils);
        (void)modbus_reply(server, request.data(), size, map);
        for (unsigned i = 0; i < interop::count; ++i) {
            if (map->tab_registers[i] != before[i])
                std::printf("%04X=%04X\n", interop::first + i, unsigned{map->tab_registers[i]});
        }
        for (unsigned i = 0; i < interop::coils; ++i) {
            if (map->tab_bits[i] != coils[i])
                std::printf("coil %04X=%X\n", interop::first_coil + i, unsigned{map->tab_bits[i]});
        }
        (void)std::fflush(stdout);
        // Function 04 reads the same registers here.
        std::memcpy(map->tab_input_registers, map->tab_registers, 2 * interop::count);
    }
}
