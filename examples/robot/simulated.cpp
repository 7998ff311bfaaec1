// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The robot in simulated time, with a fault, a restart and lost responses: `robot_simulated PATH.svg` prints where it
// is and draws its way. It fails if the robot stands more than 1 mm from a pose that says it is continuous.
#include <cmath>
#include <cstdio>
#include <string>

#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "robot.hpp"

using namespace servobus;
using namespace servobus::literals;

namespace {
/// Where the wheels have been: their counts, summed up in small steps.
struct truth {
    double x = 0, y = 0, heading = 0; // mm, rad
    double left = 0, right = 0;

    void follow(const sim::zlac8015d& drive) {
        const double l = static_cast<double>(drive.left().position) * 534 / 4096;
        const double r = static_cast<double>(drive.right().position) * -534 / 4096;
        const double turn = (r - right - (l - left)) / 400, way = (r - right + l - left) / 2;
        x += way * std::cos(heading + turn / 2);
        y += way * std::sin(heading + turn / 2);
        heading += turn;
        left = l;
        right = r;
    }
};

class world {
  public:
    world() { wire_.attach(station_); }

    void go(const char* what, std::uint32_t ms, const twist& by = {}) {
        for (std::uint32_t t = 0; t < ms * 10; ++t) { // steps of 100 us
            bot.drive(by);
            (void)bot.step();
            if (const loop_report ended = bot.take_report())
                std::printf("  %s: %s\n", text(ended.what), text(ended.how.error()));
            wire_.pass(microseconds(100));
            truth_.follow(drive);
            if (t % 1000 == 0) way_ += std::to_string(truth_.x) + ',' + std::to_string(-truth_.y) + ' ';
        }
        const plane_pose p = bot.pose();
        std::printf("%-26s x %5d y %5d mm, true %5.0f %5.0f%s; drive %s\n", what, int(p.x_mm().count()),
                    int(p.y_mm().count()), truth_.x, truth_.y, p.is_continuous ? "" : ", not continuous",
                    text(bot.state()));
        const double off = std::hypot(static_cast<double>(p.x().count()) / 1000 - truth_.x,
                                      static_cast<double>(p.y().count()) / 1000 - truth_.y);
        if (p.is_continuous && drive.stands_still() && off > 1) is_right = false;
    }
    void tell() {
        const auto um = [](double mm) { return micrometres{std::llround(mm * 1000)}; };
        const auto urad = std::remainder(truth_.heading, 2 * std::acos(-1)) * 1e6;
        bot.is_at(plane_pose::at(um(truth_.x), um(truth_.y),
                                 plane_pose::microradians{static_cast<std::int32_t>(urad)}, line_.now()));
    }
    void lose(std::uint16_t per_mille) { wire_.faults().lost_response = per_mille; }
    std::string svg() const {
        return "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-1500 -2500 4000 4000'><polyline "
               "fill='none' "
               "stroke='black' stroke-width='10' points='" +
               way_ + "'/></svg>\n";
    }

    sim::zlac8015d drive;
    bool is_right = true;

  private:
    sim::station<sim::zlac8015d> station_{drive};
    sim::virtual_line wire_{115200};
    line<sim::virtual_line> line_{wire_, modbus::timing_at(115200)};
    truth truth_;
    std::string way_;

  public:
    robot::robot<line<sim::virtual_line>> bot{line_};
};
} // namespace

int main(int argc, char** argv) {
    world w;
    constexpr twist curve{300_mm_per_s, 500_mrad_per_s}, straight{300_mm_per_s, 0_rad_per_s};
    w.go("a new drive keeps 2022h", 1000);
    w.drive.power_cycle();
    w.go("switched off and on", 2000);
    w.tell();
    w.bot.enable();
    w.go("enabled", 1000);
    w.go("a curve", 5000, curve);
    w.go("too fast: both slow down", 1000, {9_m_per_s, 6_rad_per_s});
    w.go("it stands", 2000);
    w.drive.raise(zlac8015d::fault::none, zlac8015d::fault::overcurrent);
    w.go("a fault of a wheel", 1000, straight);
    std::printf("  right or left wheel: %s\n", text(w.bot.faults().first()));
    w.drive.end_faults();
    w.is_right = w.is_right && w.bot.reset_faults();
    w.go("reset: it does not move", 1000, straight);
    w.bot.enable();
    w.go("enabled again", 2000, straight);
    w.drive.power_cycle();
    w.go("a restart: it does not move", 2000, straight);
    w.is_right = w.is_right && !w.bot.pose().is_continuous;
    w.tell();
    w.bot.enable();
    w.lose(20);
    w.go("a fiftieth is lost", 10'000, curve);
    w.lose(0);
    w.go("it stands", 2000);
    w.is_right = w.bot.shut_down() && w.is_right;
    w.go("shut down", 500);
    std::FILE* const to = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (to != nullptr)
        w.is_right = std::fputs(w.svg().c_str(), to) >= 0 && std::fclose(to) == 0 && w.is_right;
    std::puts(w.is_right ? "as it should be" : "NOT as it should be");
    return w.is_right ? 0 : 1;
}
