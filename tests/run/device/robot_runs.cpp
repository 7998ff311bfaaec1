// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot's pose in 10 000 random runs: twists, paths that bend both ways, blocking calls, stops, restarts of the drive
// at every moment and what the program does first after them, lost and late frames, a lost port, cleared positions,
// programs that stall. A pose that calls itself continuous is at most 1 mm from where the simulated wheels have carried
// the robot; each kind of event is counted and has a floor.
#include <cstddef>
#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/parameters.hpp>
#include <servobus/sim/faults.hpp>
#include <tests/support/robot_world.hpp>
#include <tests/support/zlac8015d_interpretations.hpp>

namespace robot_runs_tests {

using namespace servobus;
using namespace servobus::literals;
using robots::place;

namespace {

constexpr feed small = rolling(534_mm, counts_per_turn{4096});
constexpr feed large = rolling(652.3_mm, counts_per_turn{16384});
constexpr feed worn = rolling(651.9_mm, counts_per_turn{16384});
constexpr auto on_small = differential::of({.left = small, .right = mirrored(small), .track = 400_mm});
constexpr auto on_large = differential::of({.left = mirrored(large), .right = worn, .track = 500_mm});
struct choice {
    robots::machine is;
    const differential& said;
};
const choice machines[] = {{{534, -534, 400, 1024}, on_small}, {{-652.3L, 651.9L, 500, 4096}, on_large}};

struct counts {
    std::size_t checks = 0, continuous = 0, told = 0;
    std::size_t restarts = 0, moving = 0, near_zero = 0, dark = 0, losses = 0, ports = 0, clearings = 0,
                stalls = 0;
    std::size_t blocking = 0, stops = 0, inits = 0, faults = 0, breaks = 0;
    std::size_t paths = 0, gaps = 0, late = 0, twice = 0, first[5] = {}, prompt = 0, steep = 0, field = 0;
    long double worst = 0;
};

class run {
  public:
    run(std::uint64_t seed, counts& played)
        : random_{seed}, played_{played}, machine_{machines[seed % 2]}, w_{machine_.is,   machine_.said,
                                                                           options(seed), supervision_of(),
                                                                           seed,          node_of()} {}

    /// How far the worst continuous pose was from the truth, mm.
    long double play() {
        for (int i = 0; i < 40; ++i) {
            act();
            live(random_.below(90));
        }
        return worst_;
    }

  private:
    sim::zlac8015d_options options(std::uint64_t seed) {
        interpretations::choice c;
        for (const unsigned size : zlac8015d_interpretations::sizes)
            c.push_back(one_in(3) ? random_.below(size) : 0);
        sim::dice other{seed + 77}; // of their own, so that a seed lives as it did before they were there
        const bool has_all = seed % 8 == 3; // of what the field has shown
        if (has_all) ++played_.field;
        for (const unsigned size : zlac8015d_interpretations::sizes_of_field)
            c.push_back(has_all ? size - 1 : other.below(3) == 0 ? other.below(size) : 0);
        return zlac8015d_interpretations::options_of(c);
    }
    supervision supervision_of() {
        return {.feedback = milliseconds(one_in(4) ? 50 : 20), .command_timeout = milliseconds(400)};
    }
    node<zlac8015d::device> node_of() {
        const node<zlac8015d::device> at{1};
        if (one_in(2)) return at;
        ++played_.prompt;
        return responds_within(at, milliseconds(30));
    }
    bool one_in(std::uint32_t n) { return random_.below(n) == 0; }
    std::int32_t any(std::int32_t most) {
        return static_cast<std::int32_t>(random_.below(2 * static_cast<std::uint32_t>(most) + 1)) - most;
    }

    void look() {
        const plane_pose p = w_.robot.pose();
        ++played_.checks;
        if (was_continuous_ && !p.is_continuous) ++played_.breaks;
        const bool is_new = p.time != judged_;
        was_continuous_ = p.is_continuous;
        if (!p.is_continuous || !is_told_ || !is_new) return;
        judged_ = p.time;
        ++played_.continuous;
        const long double off = robots::distance(p, w_, machine_.is);
        worst_ = off > worst_ ? off : worst_;
    }
    void live(std::uint32_t ms) {
        const std::uint64_t end = w_.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (w_.wire.time_us() < end) {
            const duration idle = w_.robot.step();
            look();
            w_.wait(idle.us < 100 ? microseconds(100) : idle.us > 1000 ? milliseconds(1) : idle);
        }
    }
    // A blocking call: the pose is looked at after it.
    template <class Command> bool block(const Command& c) {
        ++played_.blocking;
        const bool is_done = static_cast<bool>(w_.robot.run(c));
        look();
        return is_done;
    }
    twist any_twist() {
        const bool is_straight = one_in(2);
        const std::int32_t speed = any(800'000);
        return {.speed = decltype(twist::speed){speed},
                .turn = decltype(twist::turn){is_straight ? 0 : any(1'500'000)}};
    }
    /// The program learns where the robot is, where it can be known.
    void learn_place() {
        if (w_.robot.pose().is_continuous && is_told_) return;
        if (!block(read_feedback{})) return;
        // A response that was late enough is taken for the one to this request: where the robot is, is not known then.
        if (w_.drive.given().empty()) return;
        if (w_.drive.given().back().us - w_.robot.pose().time.us > 60'000) return;
        robots::tell(w_, w_.drive.given().back().at);
        is_told_ = true;
        ++played_.told;
        look();
    }
    void restart() {
        ++played_.restarts;
        if (!w_.drive.stands_still()) ++played_.moving;
        const auto small_count = [&](std::uint16_t at) {
            const std::uint32_t raw =
                std::uint32_t{w_.drive.peek(at)} << 16 | w_.drive.peek(static_cast<std::uint16_t>(at + 1));
            return raw + 400u <= 800u;
        };
        if (small_count(0x20A7)) ++played_.near_zero;
        w_.drive.power_cycle();
        if (one_in(4)) { // again, in the same feedback period
            ++played_.twice;
            w_.wait(microseconds(random_.below(15'000)));
            w_.drive.power_cycle();
        }
        if (one_in(2)) w_.wait(milliseconds(random_.below(one_in(3) ? 300 : 20)));
        if (one_in(2)) return command_first();
        if (one_in(2)) return;
        ++played_.dark;
        w_.wire.cut_for(milliseconds(random_.below(one_in(2) ? 60 : 1500)));
    }
    // Two twists in turn, with a gap in the responses at any moment.
    void follow_path() {
        static constexpr std::int32_t ways[][4] = {
            {600, 1000, 600, -1000}, // S-curve; mm/s, mrad/s
            {500, 800, -500, 800},   // reversing in an arc
            {700, 0, -700, 0},       // reversing
            {0, 1500, 0, -1500},     // spinning
            {800, 0, 500, 1200},     // into a curve
            {300, 1500, 300, -1500}, // slalom
            {0, 0, 400, 700},        // from standing
        };
        ++played_.paths;
        const auto& way = ways[random_.below(std::size(ways))];
        const std::uint32_t each = 40 + random_.below(600);
        const std::uint32_t hole = random_.below(3 * each);
        for (std::uint32_t t = 0, turn = 0; t < 3 * each; t += 20) {
            const bool is_second = t / each % 2 == 1;
            if (turn++ % 2 == 0 && w_.robot.is_idle())
                (void)w_.robot.begin(twist{.speed = decltype(twist::speed){way[is_second ? 2 : 0] * 1000},
                                           .turn = decltype(twist::turn){way[is_second ? 3 : 1] * 1000}});
            if (t <= hole && hole < t + 20) {
                live(random_.below(20));
                lose(random_.below(220));
            } else {
                live(20);
            }
        }
    }
    // Responses are lost or late for a time.
    void lose(std::uint32_t ms) {
        const sim::fault_plan before = w_.wire.faults();
        ++played_.gaps;
        if (one_in(3)) {
            ++played_.late;
            w_.wire.faults().late_response = 1000;
            w_.wire.faults().late_by = milliseconds(random_.below(200));
        } else {
            w_.wire.faults().lost_response = 1000;
        }
        live(ms);
        w_.wire.faults() = before;
    }
    // The program's first command after a restart, which it may not have seen yet.
    void command_first() {
        const std::uint32_t what = random_.below(5);
        ++played_.first[what];
        if (what == 0) (void)w_.robot.begin(disable{});
        if (what == 1) (void)w_.robot.begin(halt{});
        if (what == 2) (void)w_.robot.begin(quick_stop{});
        if (what == 3) (void)w_.robot.begin(any_twist());
        if (what == 4) (void)w_.robot.begin(read_feedback{});
    }
    void change_ramps() {
        ++played_.steep;
        const std::int32_t ms = one_in(2) ? 500 : 10 + static_cast<std::int32_t>(random_.below(300));
        for (std::uint16_t at = 0x2080; at <= 0x2083; ++at)
            w_.drive.set(at, static_cast<std::uint16_t>(ms)); // by another
    }
    void act() {
        const drive_state s = w_.robot.state();
        if (s == drive_state::enabled && one_in(12)) return follow_path();
        if (one_in(60)) return change_ramps();
        switch (random_.below(26)) {
        case 0: return restart();
        case 1:
            ++played_.losses;
            w_.wire.faults().lost_response = static_cast<std::uint16_t>(random_.below(400));
            w_.wire.faults().lost_request = static_cast<std::uint16_t>(random_.below(200));
            w_.wire.faults().late_response = static_cast<std::uint16_t>(random_.below(100));
            return;
        case 2:
        case 3: w_.wire.faults() = {}; return;
        case 4:
            ++played_.ports;
            w_.wire.unplug();
            live(random_.below(200));
            return w_.wire.plug();
        case 5:
            if (s != drive_state::disabled) return;
            ++played_.clearings;
            (void)block(zlac8015d::clear_position{});
            return;
        case 6: ++played_.stalls; return w_.wait(milliseconds(random_.below(one_in(3) ? 1200 : 150)));
        case 7:
            ++played_.stops;
            (void)w_.robot.begin(halt{});
            return;
        case 8:
            ++played_.stops;
            (void)block(quick_stop{});
            return;
        case 9:
            ++played_.stops;
            (void)w_.robot.begin(disable{});
            return;
        case 10:
            ++played_.faults;
            w_.drive.raise(zlac8015d::fault::overload, {});
            live(50);
            return w_.drive.end_faults();
        case 11: (void)block(fault_reset{}); return;
        case 12:
            ++played_.inits;
            (void)block(init{});
            return;
        case 13:
        case 14: return learn_place();
        case 15: (void)block(read_feedback{}); return;
        case 16: (void)block(wait_standstill{milliseconds(500)}); return;
        default: break;
        }
        if (s == drive_state::needs_init)
            (void)block(init{});
        else if (s == drive_state::faulted)
            (void)block(fault_reset{});
        else if (s != drive_state::enabled)
            (void)block(enable{});
        else if (one_in(6)) {
            ++played_.blocking;
            (void)w_.robot.run(any_twist());
            look();
        } else
            (void)w_.robot.begin(any_twist());
    }

    sim::dice random_;
    counts& played_;
    choice machine_;
    robots::world w_;
    long double worst_ = 0;
    bool is_told_ = false, was_continuous_ = false;
    instant judged_{};
};

counts play(std::uint64_t from, std::uint64_t to) {
    counts all;
    for (std::uint64_t seed = from; seed < to; ++seed) {
        CAPTURE(seed);
        const long double worst = run{seed, all}.play();
        CHECK(worst < 1);
        all.worst = worst > all.worst ? worst : all.worst;
    }
    return all;
}

} // namespace

TEST_CASE(
    "a pose that is continuous is within 1 mm of the robot, whatever happens to drive, line and program") {
    const counts c = play(1, 10001);
    MESSAGE("worst ", c.worst * 1000, " um; looks ", c.checks, ", continuous ", c.continuous, ", told ",
            c.told, ", breaks ", c.breaks);
    struct kind {
        const char* what;
        std::size_t played, at_least;
    };
    const kind kinds[] = {
        {"restarts", c.restarts, 10'000},
        {"restarts while moving", c.moving, 2000},
        {"restarts near zero", c.near_zero, 5000},
        {"two restarts in a row", c.twice, 2000},
        {"restarts with a dark drive", c.dark, 2000},
        {"first after a restart: disable", c.first[0], 1000},
        {"first after a restart: halt", c.first[1], 1000},
        {"first after a restart: quick stop", c.first[2], 1000},
        {"first after a restart: twist", c.first[3], 1000},
        {"first after a restart: read", c.first[4], 1000},
        {"lossy times", c.losses, 10'000},
        {"paths that bend", c.paths, 3000},
        {"gaps in a path", c.gaps, 3000},
        {"late responses in a path", c.late, 1000},
        {"lost ports", c.ports, 10'000},
        {"cleared positions", c.clearings, 2000},
        {"stalled programs", c.stalls, 10'000},
        {"faults", c.faults, 10'000},
        {"blocking calls", c.blocking, 100'000},
        {"stops", c.stops, 20'000},
        {"inits", c.inits, 10'000},
        {"prompt nodes", c.prompt, 4000},
        {"all that the field has shown", c.field, 1000},
        {"changed ramps", c.steep, 3000},
        {"poses that were told", c.told, 10'000},
        {"continuous poses", c.continuous, 100'000},
    };
    for (const kind& k : kinds) {
        MESSAGE(std::string{k.what}, ": ", k.played);
        CHECK(k.played >= k.at_least);
    }
}

} // namespace robot_runs_tests
