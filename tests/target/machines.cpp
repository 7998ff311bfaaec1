// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The programs of examples/robot, lift and press in a superloop: each iteration steps the machine and waits for
// nothing. MACHINE chooses one; the board's inputs choose what it does.
#include "board.hpp"

#if MACHINE == 1
#include "../../examples/robot/robot.hpp"
#elif MACHINE == 2
#include "../../examples/lift/lift.hpp"
#else
#include "../../examples/press/press.hpp"
#endif

extern "C" {
extern volatile std::int32_t wanted; // what an operator or another task wants
volatile std::int32_t wanted = 0;
}

namespace {
using namespace servobus;
uart port;
line wire{port, modbus::timing_at(115200)};

#if MACHINE == 1
robot::robot machine{wire};
bool iterate() {
    if (wanted == 1) machine.enable();
    if (wanted == 2) (void)machine.stop();
    machine.drive({wanted * units::micrometre_per_second, wanted * units::microradian_per_second});
    (void)machine.step();
    const loop_report ended = machine.take_report();
    return machine.pose().is_continuous && (!ended || ended.how);
}
bool end() { return machine.shut_down(); }
#elif MACHINE == 2
lift::drive<decltype(wire)> machine{wire, 1, lift::screw};
bool iterate() {
    static micrometres_per_second held{};
    (void)lift::jog(machine, wanted * units::micrometre_per_second, held);
    return static_cast<bool>(machine.position(milliseconds(100)));
}
bool end() {
    return lift::prepare(machine) && lift::go_to(machine, micrometres{wanted}).how == arrival_state::reached;
}
#else
press::drive<decltype(wire)> machine{wire, 1, press::ram};
bool iterate() {
    (void)machine.step();
    if (machine.is_idle() && wanted != 0)
        return machine.begin(press::c::start_segment{press::down}) == errc::ok;
    return machine.arrival().how == arrival_state::reached;
}
bool end() {
    return machine.run(press::set_up) && press::prepare(machine) && press::cycle(machine) &&
           press::remedy(machine).remedy != nullptr;
}
#endif
} // namespace

extern "C" bool job() {
    for (int i = 0; i < 1000; ++i) (void)iterate();
    return end();
}
