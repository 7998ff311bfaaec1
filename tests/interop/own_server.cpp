// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's server with plain registers on a pseudo-terminal, until it is killed. It prints each
// register that a request has changed, one a line.   own_server LINK
#include <array>
#include <cstdio>
#include <span>

#include <servobus/modbus/server.hpp>
#include <servobus/posix/pseudo_terminal.hpp>

#include "registers.hpp"

using namespace servobus;

namespace {

struct store {
    std::array<std::uint16_t, interop::count> words{};

    store() {
        for (unsigned i = 0; i < interop::count; ++i) words[i] = interop::initial(interop::first + i);
    }
    static bool has(std::uint16_t address, std::size_t size) {
        return address >= interop::first && address - interop::first + size <= interop::count;
    }
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) const {
        if (!has(address, to.size())) return 2;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[address - interop::first + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (!has(address, from.size())) return 2;
        for (std::size_t i = 0; i < from.size(); ++i) {
            std::uint16_t& word = words[address - interop::first + i];
            if (word != from[i])
                std::printf("%04X=%04X\n", address + static_cast<unsigned>(i), unsigned{from[i]});
            word = from[i];
        }
        (void)std::fflush(stdout);
        return 0;
    }
};

} // namespace

int main(int, char** words) {
    posix::pseudo_terminal port;
    if (port.open(words[1]) != errc::ok) return 1;
    store registers;
    modbus::server<store> server{interop::node_address, registers, modbus::timing_at(interop::baud),
                                 modbus::server_rules{.reads_input_registers = true}};
    while (true) {
        port.wait(server.is_answering() ? microseconds(200) : milliseconds(5));
        const instant before = port.now();
        std::array<std::uint8_t, 512> chunk{};
        const transfer came = port.receive(chunk);
        if (!came) return 1;
        if (*came == 0)
            server.elapse(before);
        else
            server.feed_late(bytes{chunk}.first(*came), port.now());
        bytes response = server.response(port.now());
        if (response.empty()) continue;
        while (!response.empty()) {
            const transfer took = port.send(response);
            if (!took) return 1;
            response = response.subspan(*took);
        }
        server.sent(port.now());
    }
}
