// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lift in simulated time: homing, places, a button, a stop input, a power loss, an alarm, lost responses. It fails
// if the simulated platform is elsewhere than the program says.
#include <cstdio>

#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>

#include "lift.hpp"

using namespace servobus;
using namespace servobus::literals;

namespace {
class world {
  public:
    world() {
        wire.attach(station_);
        sim::yako_machine rails;
        rails.home_from = -6200; // pulses from where the platform is at first
        rails.home_to = -6000;
        rails.negative_limit = -7000;
        rails.negative_stop = -7400;
        rails.positive_limit = 38'000;
        rails.positive_stop = 38'500;
        drive.attach(rails);
    }
    void check(const char* what, bool is_right) {
        std::printf("%-34s %s; %7.2f mm, drive %s\n", what, is_right ? "ok" : "WRONG", mm(),
                    text(platform.state()));
        all_right_ = all_right_ && is_right;
    }
    /// From home, which is where the simulated switch begins.
    double mm() const { return (static_cast<double>(drive.view().position) - home_) / 200; }
    void is_home() { home_ = static_cast<double>(drive.view().position); }
    bool stands_at(double place) const {
        return !drive.view().is_moving && mm() > place - 0.01 && mm() < place + 0.01;
    }
    void press(micrometres_per_second speed, std::uint32_t ms) {
        for (std::uint32_t t = 0; t < ms * 10; ++t) {
            (void)lift::jog(platform, speed, held_);
            wire.pass(microseconds(100));
        }
    }
    int end() const {
        return std::puts(all_right_ ? "as it should be" : "NOT as it should be"), all_right_ ? 0 : 1;
    }

    sim::yako_closed_loop drive;
    sim::virtual_line wire{115200};

  private:
    sim::station<sim::yako_closed_loop> station_{drive};
    line<sim::virtual_line> line_{wire, modbus::timing_at(115200)};
    double home_ = 0;
    bool all_right_ = true;
    micrometres_per_second held_{};

  public:
    lift::drive<line<sim::virtual_line>> platform{line_, 1, lift::screw};
};
} // namespace

int main() {
    world w;
    w.check("prepared, at home", lift::prepare(w.platform) && w.platform.read());
    w.is_home();
    for (const micrometres place : {micrometres{10_mm}, micrometres{120.5_mm}, micrometres{0_mm}}) {
        const axis_arrival there = lift::go_to(w.platform, place);
        const double mm = static_cast<double>(place.count()) / 1000;
        w.check("a place", there.how == arrival_state::reached && w.stands_at(mm));
    }
    const axis_arrival beyond = lift::go_to(w.platform, 201_mm);
    w.check("beyond the limit it stops short", beyond.how == arrival_state::stopped_short && w.mm() < 201);
    w.check("and back", lift::go_to(w.platform, 50_mm).how == arrival_state::reached && w.stands_at(50));

    w.press(10_mm_per_s, 2000);
    const double released = w.mm();
    w.press(0_mm_per_s, 1000);
    w.check("a button is held for 2 s", released > 60 && w.mm() - released < 3 && !w.drive.view().is_moving);
    w.press(-10_mm_per_s, 1000);
    const double hung = w.mm();
    w.wire.pass(milliseconds(3000));
    w.check("a program that hangs", hung - w.mm() < 4 && !w.drive.view().is_moving);
    w.press(0_mm_per_s, 500);

    if (!w.platform.run(move_to{150_mm, lift::fast})) w.check("it goes", false);
    w.wire.pass(milliseconds(800));
    w.drive.set_input(3, true);
    (void)w.platform.run(wait_reached{});
    w.check("a stop input", w.platform.arrival().cause == stop_cause::input && !w.drive.view().is_moving);
    w.drive.set_input(3, false);
    w.check("and on", lift::go_to(w.platform, 150_mm).how == arrival_state::reached && w.stands_at(150));

    w.drive.power_cycle();
    w.check("a power loss is seen", lift::go_to(w.platform, 20_mm).how == arrival_state::none);
    w.check("prepared again",
            lift::prepare(w.platform) && lift::go_to(w.platform, 20_mm).how == arrival_state::reached);
    w.drive.raise_alarm(4);
    w.check("an alarm", lift::go_to(w.platform, 50_mm).how != arrival_state::reached);
    w.drive.end_alarm();
    w.check("prepared again", lift::prepare(w.platform));

    w.wire.faults().lost_response = 20;
    unsigned arrived = 0;
    for (int i = 0; i < 20; ++i) {
        arrived +=
            lift::go_to(w.platform, i % 2 == 0 ? 10_mm : 30_mm).how == arrival_state::reached ? 1u : 0u;
        if (w.platform.state() != drive_state::enabled) (void)lift::prepare(w.platform);
    }
    w.wire.faults() = {};
    w.check("a fiftieth is lost: most arrive", arrived >= 15);
    w.check("freed", static_cast<bool>(w.platform.run(disable{})));
    return w.end();
}
