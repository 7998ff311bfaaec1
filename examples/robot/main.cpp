// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The robot on a serial port drives a circle until Ctrl-C: `robot PORT`. It prints each second where it
// is. The consent that it asks for is the operator's.
#include <cstdio>

#include <servobus/line/reconnecting.hpp>

#include "../host.hpp"
#include "robot.hpp"

int main(int argc, char** argv) {
    using namespace servobus;
    using namespace servobus::literals;
    if (argc != 2 && argc != 4) return std::fprintf(stderr, "usage: robot PORT [--simulator PID]\n"), 2;
    if (argc == 2)
        host::ask_for_consent("The robot drives a circle of 1 m: lift its wheels, or clear the place.");
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ); // also into a file
    reconnecting<host::serial> port{argv[1], host::settings_of(robot::z::device::facts)};
    if (!port.is_open())
        return std::fprintf(stderr, "cannot open %s: %s\n", argv[1],
                            host::open_failure(argv[1], port.why().error(), port.port().os_error()).c_str()),
               1;
    line wire{port, modbus::timing_at(robot::z::device::facts.baud)};
    robot::robot bot{wire};
    host::watch_for_interruptions();
    bool is_new = false;
    bot.enable();
    for (instant shown = wire.now(); !host::is_interrupted();) {
        bot.drive({150_mm_per_s, 300_mrad_per_s});
        wire.sleep(bot.step());
        // After a loss the robot stays where it is: this program asks for a consent at its start alone.
        if (port.take_change()) std::printf("port: %s\n", text(port.why().error()));
        if (const loop_report ended = bot.take_report()) {
            std::printf("%s: %s; drive %s, cause %s, %s\n", text(ended.what), text(ended.how.error()),
                        text(bot.state()), text(bot.cause()), text(bot.faults().first()));
            // Once in a drive's life: its speeds are finer from the next power-on. Who switches it on consents.
            if (ended.how.part() == take_over_part::power_cycle) {
                is_new = true;
                std::puts("Switch the drive off and on: then the robot drives.");
            } else if (is_new && ended.what == loop_part::take_over && ended.how) {
                is_new = false;
                bot.is_at({}); // it has not moved yet
                bot.enable();
            }
        }
        if (since(shown, wire.now()) < milliseconds(1000)) continue;
        shown = shown + milliseconds(1000);
        const plane_pose p = bot.pose();
        std::printf("x %d mm, y %d mm, heading %d urad%s\n", int(p.x_mm().count()), int(p.y_mm().count()),
                    int(p.heading().count()), p.is_continuous ? "" : ", not continuous");
    }
    return bot.shut_down() ? 0 : 1;
}
