// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The robot on a serial port drives a circle until Ctrl-C: `robot PORT`. It prints each second where it is.
#include <cstdio>

#include "../host.hpp"
#include "robot.hpp"

int main(int argc, char** argv) {
    using namespace servobus;
    using namespace servobus::literals;
    host::serial port;
    const char* path = argc == 2 ? argv[1] : "";
    if (port.open(path, host::settings_of(robot::z::device::facts)) != errc::ok) {
        std::fprintf(stderr, "usage: robot PORT; '%s': %s\n", path,
                     host::open_failure(path, port.os_error()).c_str());
        return 2;
    }
    line wire{port, modbus::timing_at(robot::z::device::facts.baud)};
    robot::robot bot{wire};
    host::watch_for_interruptions();
    bot.enable(); // this is the operator
    for (instant shown = wire.now(); !host::is_interrupted();) {
        bot.drive({300_mm_per_s, 500_mrad_per_s});
        wire.sleep(bot.step());
        if (const loop_report ended = bot.take_report())
            std::printf("%s: %s; drive %s, cause %s, %s\n", text(ended.what), text(ended.how.error()),
                        text(bot.state()), text(bot.cause()), text(bot.faults().first()));
        if (since(shown, wire.now()) < milliseconds(1000)) continue;
        shown = shown + milliseconds(1000);
        const plane_pose p = bot.pose();
        std::printf("x %d mm, y %d mm, heading %d urad%s\n", int(p.x_mm().count()), int(p.y_mm().count()),
                    int(p.heading().count()), p.is_continuous ? "" : ", not continuous");
    }
    return bot.shut_down() ? 0 : 1;
}
