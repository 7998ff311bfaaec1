// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random lives of a robot: faults, wired stops, restarts, cut and unplugged lines, lost frames, commands that are no
// numbers, and a manager that makes transitions at any time. What must hold is judged by the simulated wheels, not by
// the interface.
#include "robot.hpp"

#include <cstdio>
#include <limits>

#include <servobus/sim/faults.hpp>

namespace robots::hostile {

enum event { restart, fault, wired_stop, unplug, cut, lossy, not_a_number, deactivate, clean_up, kinds };

struct totals {
    unsigned events[kinds]{};
    unsigned activations = 0, errors = 0, gaps = 0, judged_positions = 0, judged_speeds = 0;
    double seconds = 0;
};

/// One life, and what is judged in it.
class life {
  public:
    life(std::uint64_t seed, totals& count)
        : w_{options_of(seed), seed}, dice_{seed}, count_{count}, is_stop_silent_{seed % 5 == 0} {
        auto info = description();
        info.hardware_parameters["reset_faults"] = "true";
        w_.component.initialise(info);
        revive();
    }
    ~life() { w_.drive.end_faults(); }

    void play(std::uint32_t ms) {
        const std::uint64_t end = w_.wire.time_us() + std::uint64_t{ms} * 1000;
        while (w_.wire.time_us() < end) {
            if (dice_.below(250) == 0) happen(static_cast<event>(dice_.below(kinds)));
            if (dice_.below(60) == 0 && !is_wrong_) command(dice_.below(9));
            cycle();
        }
        mend();
        for (int i = 0; i < 300; ++i) cycle(); // what was under way may still end in an error
        // A wired stop that the drive does not report holds it until it is enabled again.
        if (is_stop_silent_) w_.component.deactivate();
        revive();
        CHECK(w_.component.is_active());
        command(5);
        for (int i = 0; i < 250; ++i) cycle();
        CHECK(w_.velocity("left") == doctest::Approx(left_).epsilon(0.02));
        ++count_.judged_speeds;
        count_.seconds += static_cast<double>(w_.wire.time_us()) / 1e6;
    }

  private:
    static sim::zlac8015d_options options_of(std::uint64_t seed) {
        using o = sim::zlac8015d_options;
        o chosen;
        chosen.resumes_after_watchdog = seed % 2 == 0;
        chosen.while_turning = seed % 3 == 0 ? o::shaft::released : o::shaft::locked;
        chosen.after_quick_stop = seed % 5 == 0 ? o::stopped::locked : o::stopped::emergency;
        chosen.bit = seed % 7 == 0   ? o::running::enabled
                     : seed % 7 == 1 ? o::running::driven
                                     : o::running::turns;
        return chosen; // not `until_restart`: such a drive is faulted until its power has been off
    }

    void command(std::uint32_t level) {
        left_ = 1.5 * (static_cast<double>(level) - 4);
        right_ = 1.1 * (4 - static_cast<double>(dice_.below(9)));
        if (level == 0 || level == 8) left_ = right_ = 0;
        w_.component.command(left_, right_);
    }
    void happen(event e) {
        ++count_.events[e];
        still_ = 0;
        switch (e) {
        case restart: w_.drive.power_cycle(); break;
        case fault:
            using servobus::zlac8015d::fault;
            w_.drive.raise(fault::overload, dice_.below(2) == 0 ? fault::none : fault::hall);
            break;
        case wired_stop: w_.drive.set_input(dice_.below(2) == 0, true); break;
        case unplug: w_.wire.unplug(); break;
        case cut: w_.wire.cut_for(milliseconds(20 + dice_.below(2000))); break;
        case lossy:
            w_.wire.faults().lost_response = static_cast<std::uint16_t>(dice_.below(200));
            w_.wire.faults().corrupted_response = static_cast<std::uint16_t>(dice_.below(100));
            w_.wire.faults().late_response = static_cast<std::uint16_t>(dice_.below(50));
            break;
        case not_a_number:
            is_wrong_ = true;
            w_.component.command(1, std::numeric_limits<double>::quiet_NaN());
            break;
        case deactivate: w_.component.deactivate(); break;
        case clean_up:
            w_.component.deactivate();
            if (w_.component.state() == primary::PRIMARY_STATE_INACTIVE) w_.component.clean_up();
            break;
        case kinds: break;
        }
        if (!w_.component.is_active()) note_inactive();
    }
    void mend() {
        w_.drive.end_faults();
        w_.drive.set_input(false, false);
        w_.wire.plug();
        w_.wire.faults() = {};
        w_.wire.cut_for(milliseconds(0));
    }
    void revive() {
        is_wrong_ = false;
        if (w_.component.is_active()) return;
        w_.component.configure();
        const std::uint32_t enables = w_.drive.enables();
        w_.component.activate();
        ++count_.activations;
        CHECK(w_.drive.enables() <= enables + 1);
        enables_ = w_.drive.enables();
        if (w_.component.is_active()) CHECK(w_.drive.stands_still());
        note_inactive();
        settle();
    }
    void note_inactive() { inactive_since_ = w_.wire.time_us(); }

    void cycle() {
        const bool was_active = w_.component.is_active();
        const double before[2]{w_.position("left"), w_.position("right")};
        const double real[2]{w_.left(), w_.right()};
        (void)w_.cycle();
        follow("left", 0, before[0], w_.left() - real[0]);
        follow("right", 1, before[1], w_.right() - real[1]);
        CHECK(w_.longest_us < 300);
        if (was_active && !w_.component.is_active()) {
            ++count_.errors;
            note_inactive();
        }
        CHECK(w_.drive.enables() == enables_); // nothing energises but an activation
        settle();
        if (w_.component.is_active()) return;
        // The longest ramp, and the watchdog of a drive that cannot be reached.
        if (w_.wire.time_us() - inactive_since_ > 2'500'000) CHECK(w_.drive.stands_still());
        if (w_.wire.time_us() - inactive_since_ > 3'000'000 && dice_.below(50) == 0) {
            if (dice_.below(4) != 0) mend();
            revive();
        }
    }
    // A position moves on by no more than its wheel since it did so before, and what both may lag by.
    void follow(const char* side, std::size_t wheel, double before, double moved) {
        way_[wheel] += std::abs(moved);
        const double now = w_.position(side);
        CHECK(std::abs(now - before) < way_[wheel] + 0.7);
        if (now != before) way_[wheel] = 0;
    }
    // At standstill, with young feedback, a position differs from the wheel's by a constant, until there is another
    // gap.
    void settle() {
        const sim::fault_plan& plan = w_.wire.faults();
        const bool is_clean = plan.lost_response + plan.corrupted_response + plan.late_response == 0;
        still_ = w_.drive.stands_still() && w_.component.is_active() && is_clean ? still_ + 1 : 0;
        const double gaps = w_.component.value("drive/position_gaps");
        if (still_ < 60 || w_.component.value("drive/is_faulted") != 0) return;
        if (gaps == gaps_) {
            CHECK(w_.position("left") - w_.left() == doctest::Approx(off_[0]).epsilon(1e-9));
            CHECK(w_.position("right") - w_.right() == doctest::Approx(off_[1]).epsilon(1e-9));
            ++count_.judged_positions;
        } else {
            ++count_.gaps;
        }
        gaps_ = gaps;
        off_[0] = w_.position("left") - w_.left();
        off_[1] = w_.position("right") - w_.right();
        still_ = 0;
    }

    world w_;
    sim::dice dice_;
    totals& count_;
    double left_ = 0, right_ = 0, gaps_ = -1, off_[2]{}, way_[2]{};
    std::uint64_t inactive_since_ = 0;
    std::uint32_t enables_ = 0;
    unsigned still_ = 0;
    bool is_wrong_ = false;
    bool is_stop_silent_;
};

TEST_CASE("200 random lives") {
    totals count;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        CAPTURE(seed);
        life one{seed, count};
        one.play(60'000);
    }
    std::printf("%.0f s of virtual time, %u activations, %u errors, %u gaps; %u positions and %u speeds "
                "judged; events:",
                count.seconds, count.activations, count.errors, count.gaps, count.judged_positions,
                count.judged_speeds);
    for (const unsigned n : count.events) {
        std::printf(" %u", n);
        CHECK(n > 100);
    }
    std::puts("");
    CHECK(count.judged_positions > 400);
    CHECK(count.errors > 500);
}

} // namespace robots::hostile
