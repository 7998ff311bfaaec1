// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLAC8015D on a pseudo-terminal, in place of a machine: node 1 at 115200 Bd.
//     simulated_drive LINK      makes LINK, which programs open like a serial port, and runs until Ctrl-C
// SIGUSR1 pulls the plug of its line, and the next one puts it back. SIGUSR2 switches it off and on. `servobus sim`
// does this for every drive, with the pace of a wire and with faults at will.
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <string>
#include <system_error>

#include <servobus/modbus/server.hpp>
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace {

volatile std::sig_atomic_t is_stopped = 0;
volatile std::sig_atomic_t is_unplugged = 0;
volatile std::sig_atomic_t is_cycled = 0;

} // namespace

int main(int argc, char** argv) {
    using namespace servobus;
    posix::pseudo_terminal port;
    if (argc != 2) return std::fprintf(stderr, "usage: simulated_drive LINK\n"), 2;
    if (port.open(argv[1]) != errc::ok) {
        const std::string why = std::generic_category().message(port.os_error());
        return std::fprintf(stderr, "cannot make %s: %s\n", argv[1], why.c_str()), 1;
    }
    (void)std::signal(SIGINT, [](int) { is_stopped = 1; });
    (void)std::signal(SIGTERM, [](int) { is_stopped = 1; });
    (void)std::signal(SIGUSR1, [](int) { is_unplugged = is_unplugged != 0 ? 0 : 1; });
    (void)std::signal(SIGUSR2, [](int) { is_cycled = 1; });

    sim::zlac8015d drive;
    modbus::server served{drive.address(), drive, modbus::timing_at(drive.baud())};
    std::puts(port.path());
    (void)std::fflush(stdout);
    while (is_stopped == 0) {
        const instant now = port.now();
        if (is_cycled != 0) drive.power_cycle();
        is_cycled = 0;
        drive.advance(now); // its motors turn while no one asks
        std::uint8_t arrived[modbus::max_frame];
        const transfer came = port.receive(arrived);
        if (came && *came != 0 && is_unplugged == 0) {
            served.feed_late(bytes{arrived}.first(*came), port.now());
        } else {
            served.elapse(now);
        }
        if (const bytes response = served.response(port.now()); !response.empty()) {
            (void)port.send(response);
            served.sent(port.now());
        }
        port.wait(microseconds(500));
    }
    return 0;
}
