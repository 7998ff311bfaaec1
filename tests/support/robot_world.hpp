// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot on a simulated ZLAC8015D, and where it really is: the counts of its simulated wheels, summed up in long
// double. The place is noted whenever the drive gives its positions away, so a pose is compared with what it was made
// of.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <deque>

#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace robots {

struct place {
    long double x = 0, y = 0, heading = 0; // mm, rad
};
struct given_place {
    place at;
    std::uint32_t us; // when its positions left the drive
};
/// What a machine is, in plain numbers.
struct machine {
    long double left_travel, right_travel; // mm a turn, negative: mounted mirrored
    long double track;                     // mm
    unsigned lines;                        // 2030h, 2060h
};

/// Sums up small steps of two wheels.
class dead_reckoning {
  public:
    explicit dead_reckoning(const machine& of) : of_{of} {}

    void follow(std::int64_t left, std::int64_t right) {
        const long double counts = 4.0L * of_.lines;
        const long double l = static_cast<long double>(left - left_) / counts * of_.left_travel;
        const long double r = static_cast<long double>(right - right_) / counts * of_.right_travel;
        left_ = left;
        right_ = right;
        const long double turn = (r - l) / of_.track;
        at_.x += (l + r) / 2 * std::cos(at_.heading + turn / 2);
        at_.y += (l + r) / 2 * std::sin(at_.heading + turn / 2);
        at_.heading += turn;
    }
    const place& at() const { return at_; }

  private:
    machine of_;
    std::int64_t left_ = 0, right_ = 0;
    place at_{};
};

/// A drive that notes where it was each time it gave its positions away.
class observed_drive : public servobus::sim::zlac8015d {
  public:
    observed_drive(const machine& of, options chosen) : servobus::sim::zlac8015d{chosen}, reckoning_{of} {
        set(0x2030, static_cast<std::uint16_t>(of.lines));
        set(0x2060, static_cast<std::uint16_t>(of.lines));
        if (chosen.code_1 == options::brake::releases) {
            set(0x201A, 1);
            set(0x201B, 1);
        }
        set(0x2010, 1);
    }
    std::uint8_t read(std::uint16_t address, servobus::slice<std::uint16_t> to) {
        const bool has_positions = address <= 0x20A7 && address + to.size() >= 0x20AB;
        if (has_positions) {
            follow();
            given_.push_back({reckoning_.at(), now_.us});
            if (given_.size() > 100) given_.pop_front();
        }
        return servobus::sim::zlac8015d::read(address, to);
    }
    void follow() { reckoning_.follow(left().position, right().position); }
    const place& at() const { return reckoning_.at(); }
    const std::deque<given_place>& given() const { return given_; }
    /// A place in each millisecond of the last 512.
    const std::array<given_place, 512>& places() const { return places_; }
    void advance(servobus::instant now) {
        now_ = now;
        servobus::sim::zlac8015d::advance(now);
        given_place& in_this_ms = places_[now.us / 1000 % places_.size()];
        if (in_this_ms.us / 1000 == now.us / 1000) return;
        follow();
        in_this_ms = {reckoning_.at(), now.us};
    }

    /// Writes a register as another program does.
    void set(std::uint16_t address, std::uint16_t value) {
        const std::uint8_t word[]{static_cast<std::uint8_t>(value >> 8),
                                  static_cast<std::uint8_t>(value & 0xFFu)};
        (void)write(address, servobus::words_view{word});
    }

  private:
    dead_reckoning reckoning_;
    std::deque<given_place> given_;
    std::array<given_place, 512> places_{};
    servobus::instant now_{};
};

struct world {
    observed_drive drive;
    servobus::sim::station<observed_drive> station{drive};
    servobus::sim::virtual_line wire;
    using line_type = servobus::line<servobus::sim::virtual_line>;
    line_type line{wire, servobus::modbus::timing_at(115200)};
    servobus::zlac8015d::robot<line_type> robot;

    world(const machine& of, const servobus::differential& base,
          servobus::sim::zlac8015d_options options = {},
          const servobus::supervision& by = {.feedback = servobus::milliseconds(20),
                                             .command_timeout = servobus::milliseconds(400)},
          std::uint64_t seed = 1,
          const servobus::node<servobus::zlac8015d::device>& at =
              servobus::node<servobus::zlac8015d::device>{1})
        : drive{of, options}, wire{115200, seed}, robot{line, at, base, by} {
        wire.attach(station);
    }
    /// Lets time pass in steps in which a wheel hardly turns.
    void wait(servobus::duration time) {
        for (std::uint32_t left = time.us; left != 0;) {
            const std::uint32_t part = left < 1000 ? left : 1000;
            wire.pass(servobus::microseconds(part));
            drive.follow();
            left -= part;
        }
    }
    /// A loop that steps the robot.
    void live(servobus::duration time) {
        const std::uint64_t end = wire.time_us() + time.us;
        while (wire.time_us() < end) {
            const servobus::duration idle = robot.step();
            wait(idle.us == 0     ? servobus::microseconds(20)
                 : idle.us > 1000 ? servobus::milliseconds(1)
                                  : idle);
        }
    }
};

/// How far a pose is from a place, mm; the heading as the way of a wheel.
inline long double distance(const servobus::plane_pose& p, const place& at, const machine& of) {
    const long double fine = 16777216.0L * 1000;
    const long double x = static_cast<long double>(p.x_fine) / fine - at.x;
    const long double y = static_cast<long double>(p.y_fine) / fine - at.y;
    const long double turn = 2 * std::acos(-1.0L);
    const long double heading =
        static_cast<long double>(p.heading_fine) / 18446744073709551616.0L * turn - at.heading;
    const long double off = std::remainder(heading, turn) * of.track / 2;
    return std::sqrt(x * x + y * y + off * off);
}
/// From the nearest of some places that were reached at most 60 ms after the pose's time, over a wrap of the clock too.
template <class Places>
long double least_distance(const servobus::plane_pose& p, const Places& places, const machine& of) {
    long double least = 1e9L;
    for (const given_place& g : places) {
        if (g.us - p.time.us > 60'000) continue;
        const long double d = distance(p, g.at, of);
        least = d < least ? d : least;
    }
    return least;
}
/// From the nearest of the places that the drive has given away in response to a request of the pose's time. Where it
/// gave none, as for a response that was late enough to be taken for the next one: from where the robot was.
inline long double distance(const servobus::plane_pose& p, const world& w, const machine& of) {
    const long double given = least_distance(p, w.drive.given(), of);
    return given < 1e9L ? given : least_distance(p, w.drive.places(), of);
}
/// Tells the robot where it is.
inline void tell(world& w, const place& at) {
    using namespace servobus;
    const auto um = [](long double mm) {
        return micrometres{static_cast<std::int64_t>(std::llround(mm * 1000))};
    };
    const long double turn = 2 * std::acos(-1.0L);
    const auto heading = static_cast<std::int32_t>(std::lround(std::remainder(at.heading, turn) * 1e6L));
    w.robot.set_pose(
        plane_pose::at(um(at.x), um(at.y), plane_pose::microradians{heading}, w.robot.pose().time));
}

} // namespace robots
