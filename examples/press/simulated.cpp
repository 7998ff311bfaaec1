// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The press in simulated time: its set-up, strokes, a piece that is pressed, alarms, a restart, lost responses. It
// fails if the simulated ram is elsewhere than the program says.
#include <cstdio>

#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

#include "press.hpp"

using namespace servobus;

namespace {
class world {
  public:
    world() { wire.attach(station_); }

    void check(const char* what, bool is_right) {
        std::printf("%-34s %s; %7.2f mm, drive %s\n", what, is_right ? "ok" : "WRONG", mm(),
                    text(servo.state()));
        all_right_ = all_right_ && is_right;
    }
    /// From where the ram was at first, 131072 counts a turn of 5 mm.
    double mm() const { return static_cast<double>(drive.position() - home_) * 5 / 131'072; }
    void is_home() { home_ = drive.position(); }
    bool is_near(double place) const { return mm() > place - 0.01 && mm() < place + 0.01; }
    bool take_over() {
        command_status done = servo.run(press::set_up);
        if (done.part() == take_over_part::power_cycle) {
            drive.power_cycle(); // a person does it
            done = servo.run(press::set_up);
        }
        if (!done) std::printf("  %s %u: %s\n", text(done.part()), done.setting(), text(done.error()));
        if (!done || !press::prepare(servo)) return false;
        is_home();
        return true;
    }
    void wait(std::uint32_t ms) {
        for (std::uint32_t t = 0; t < ms * 5; ++t) {
            (void)servo.step();
            wire.pass(microseconds(200));
        }
    }
    int end() const {
        return std::puts(all_right_ ? "as it should be" : "NOT as it should be"), all_right_ ? 0 : 1;
    }

    sim::c630s drive;
    sim::virtual_line wire{57'600};

  private:
    sim::station<sim::c630s> station_{drive};
    line<sim::virtual_line> line_{wire, modbus::timing_at(57'600)};
    std::int64_t home_ = 0;
    bool all_right_ = true;

  public:
    press::drive<line<sim::virtual_line>> servo{line_, 1, press::ram};
};
} // namespace

int main() {
    world w;
    w.check("set up, switched off and on, homed", w.take_over());
    w.check("a cycle", press::cycle(w.servo) && w.is_near(0));
    w.check("down", press::go(w.servo, press::down) && w.is_near(75));

    if (!w.servo.run(press::c::start_segment{press::push})) w.check("it pushes", false);
    w.wait(3000);
    w.drive.block_shaft(true);
    const bool is_held = !w.servo.run(wait_reached{milliseconds(10'000)});
    const axis_arrival held = w.servo.arrival();
    w.check("a piece", is_held && held.cause == stop_cause::blocked && held.missing.count() > 5000);
    std::printf("  %.2f mm above the end\n", static_cast<double>(held.missing.count()) / 1000);
    w.check("off", static_cast<bool>(w.servo.run(disable{})));
    w.drive.block_shaft(false); // the piece holds it downwards only
    w.check("up", press::raise(w.servo) && w.is_near(0));

    for (const std::uint16_t code : {std::uint16_t{0x620}, std::uint16_t{0xB00}}) {
        if (!w.servo.run(press::c::start_segment{press::down})) w.check("it goes down", false);
        w.wait(400);
        w.drive.raise(code);
        (void)w.servo.run(wait_reached{});
        const advice what = press::remedy(w.servo);
        std::printf("  Er.%03X: %s; %s\n", unsigned{code}, what.cause, what.remedy);
        w.check("an alarm", w.servo.state() == drive_state::faulted && w.drive.stands_still());
        w.check("prepared again", w.take_over() && press::cycle(w.servo));
    }
    w.drive.power_cycle();
    w.check("a restart: it does not move", !press::go(w.servo, press::down) && w.drive.stands_still());
    w.check("prepared again", w.take_over() && press::cycle(w.servo) && w.is_near(0));

    w.wire.faults().lost_response = 10;
    unsigned done = 0;
    for (int i = 0; i < 20; ++i) {
        done += press::cycle(w.servo) ? 1u : 0u;
        if (w.servo.state() != drive_state::enabled) (void)w.take_over();
    }
    w.wire.faults() = {};
    w.check("a hundredth is lost: most are done", done >= 12);
    w.check("servo off", static_cast<bool>(w.servo.run(disable{})));
    return w.end();
}
