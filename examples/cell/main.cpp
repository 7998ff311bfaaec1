// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The cell on a serial port until Ctrl-C: `cell PORT`. Lift and press go to their homes, then the robot drives a circle
// while the sensor says that the way is free. After a loss, as of the adapter, everything rests until the operator
// consents again.
#include <cstdio>
#include <cstring>

#include <servobus/line/reconnecting.hpp>

#include "../host.hpp"
#include "cell.hpp"

namespace {
using namespace servobus;
using namespace servobus::literals;
using port_type = reconnecting<host::serial>;
using line_type = scheduled_line<port_type>;

// Until the robot or the port is lost, or the program is interrupted.
void drive(cell::cell<line_type>& floor, line_type& wire, port_type& port) {
    while (!host::is_interrupted() && floor.wheels.state() == drive_state::enabled) {
        if (floor.wheels.is_idle()) (void)floor.drive({150_mm_per_s, 300_mrad_per_s});
        wire.sleep(floor.all.step());
        if (port.take_change()) std::printf("port: %s\n", text(port.why().error()));
    }
}
// Steps the bus, and so the port, which opens itself again.
void wait_for_the_port(cell::cell<line_type>& floor, line_type& wire, port_type& port) {
    while (!host::is_interrupted() && !port.is_open()) wire.sleep(floor.all.step());
    if (port.take_change()) std::printf("port: %s\n", text(port.why().error()));
}
// Nothing moves while the operator is asked, for the program steps no drive then.
bool rest(cell::cell<line_type>& floor) {
    const bool are_off = floor.all.run(floor.wheels, disable{}) && floor.all.run(floor.press, disable{});
    return floor.all.run(floor.lift, halt{}) && are_off; // what hangs on a lift falls without power
}
bool consents_again() {
    std::printf("Type MOVE to go on, anything else to end: ");
    std::fflush(stdout);
    char answer[16] = {};
    return std::fgets(answer, sizeof answer, stdin) != nullptr && std::strcmp(answer, "MOVE\n") == 0;
}
} // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: cell PORT\n"), 2;
    host::ask_for_consent("Lift and press move to their homes, then the robot drives a circle of 1 m.");
    auto settings = host::settings_of(zlac8015d::device::facts);
    settings.baud = cell::shared.baud;
    port_type port{argv[1], settings};
    if (!port.is_open())
        return std::fprintf(stderr, "cannot open %s: %s\n", argv[1],
                            host::open_failure(argv[1], port.why().error(), port.port().os_error()).c_str()),
               1;
    line_type wire{port, cell::plan.timing()};
    cell::cell floor{wire};
    host::watch_for_interruptions();
    bool is_at_rest = false;
    do {
        if (floor.prepare())
            drive(floor, wire, port);
        else
            std::printf("not prepared: wheels %s, lift %s, press %s\n", text(floor.wheels.last().error()),
                        text(floor.lift.last().error()), text(floor.press.last().error()));
        wait_for_the_port(floor, wire, port);
        is_at_rest = rest(floor);
    } while (!host::is_interrupted() && consents_again());
    return is_at_rest ? 0 : 1;
}
