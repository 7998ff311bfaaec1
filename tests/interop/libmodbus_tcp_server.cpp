// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// libmodbus as a server of Modbus TCP on a free port of 127.0.0.1, which it prints. Register n holds n, and what is
// written. It answers node 1; register 500, which counts its reads, 1.5 s late the first time. For register 501 it
// closes the connection, for register 502 after half of a response.
#include <array>
#include <cstdint>
#include <cstdio>

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

int main() {
    modbus_t* server = modbus_new_tcp("127.0.0.1", 1502); // the port is that of the socket below
    modbus_mapping_t* map = modbus_mapping_new(0, 0, 1000, 0);
    const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    auto* address = reinterpret_cast<sockaddr*>(&at);
    if (server == nullptr || map == nullptr || ::bind(listening, address, size) != 0 ||
        ::listen(listening, 1) != 0 || ::getsockname(listening, address, &size) != 0)
        return 1;
    for (int i = 0; i < map->nb_registers; ++i) map->tab_registers[i] = static_cast<std::uint16_t>(i);
    std::printf("%u\n", unsigned{ntohs(at.sin_port)});
    std::fflush(stdout);
    for (;;) {
        int connection = ::accept(listening, nullptr, nullptr);
        modbus_set_socket(server, connection);
        std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
        for (;;) {
            const int length = modbus_receive(server, request.data());
            if (length < 0) break;
            if (length == 0 || request[6] != 1) continue;
            const unsigned first = unsigned{request[8]} * 256u + request[9];
            if (first == 501) break;
            if (first == 502) {
                (void)::send(connection, request.data(), 8, 0);
                break;
            }
            if (first == 500 && map->tab_registers[500]++ == 500) ::usleep(1'500'000);
            (void)modbus_reply(server, request.data(), length, map);
        }
        ::close(connection);
    }
}
