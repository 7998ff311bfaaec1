// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facades of all drives on a serial port: commands, moves until arrival, feedback, steps. This file is only compiled.
#include <servobus/servobus.hpp>

#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/explain/explain.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/registers/format.hpp>
#include <servobus/registers/literals.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::literals;

using wire = line<posix::serial>;

bool turns(zlac8015d::drive<wire>& wheels) {
    using namespace zlac8015d;
    return wheels.run(init{}) && wheels.run(enable{}) && wheels.run(velocity{30_r_per_min, -30_r_per_min}) &&
           wheels.run(disable{}) && wheels.feedback(milliseconds(100));
}
bool moves(yako::closed_loop::drive<wire>& lift) {
    using namespace yako;
    return lift.run(init{}) && lift.run(enable{}) && lift.run(disable{}) && lift.feedback(milliseconds(100));
}
bool moves(yako::open_loop::drive<wire>& lift) {
    using namespace yako;
    return lift.run(init{}) && lift.run(enable{}) && lift.run(disable{}) && lift.feedback(milliseconds(100));
}
bool moves(c630s::drive<wire>& spindle) {
    using namespace c630s;
    return spindle.run(init{}) && spindle.run(enable{}) && spindle.run(disable{}) &&
           spindle.feedback(milliseconds(100));
}
bool is_taken_over(zlac8015d::drive<wire>& wheels, c630s::drive<wire>& spindle) {
    using namespace zlac8015d;
    return wheels.run(take_over{with_fault_reset{}, resolution{10}, watchdog{500 * millisecond}}) &&
           spindle.run(take_over{c630s::set_up{}, c630s::torque_limits{40 * percent, 40 * percent}});
}

constexpr auto shared = settings_on_one_line(node<zlac8015d::device>{1}, node<yako::closed_loop::device>{2},
                                             node<c630s::device>{3});
errc open(posix::serial& port) { return port.open("/dev/ttyUSB0", posix::settings_of(shared)); }

loop_part loops(zlac8015d::drive<wire>& wheels, yako::closed_loop::drive<wire>& lift) {
    setpoint_loop driven{wheels, take_over{zlac8015d::resolution{10}}, enable{},
                         setpoints<zlac8015d::clamped_velocity>{}};
    driven.enable();
    driven.set({30_r_per_min, -30_r_per_min});
    wheels.line().sleep(driven.step());
    setpoint_loop moved{lift, take_over{disable{}}};
    if (moved.begin(yako::move_by{500 * pulse}) != errc::ok && moved.reset_faults()) (void)moved.halt();
    return driven.take_report().what;
}
