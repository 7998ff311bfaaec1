// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What happens to the line, the drives, the port and the clock between and during operations.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "world.hpp"

namespace trial {

class events {
  public:
    explicit events(world& in) : in_{in} {}

    /// Between two operations: mostly a short time, sometimes about an hour, sometimes with noise on the
    /// line.
    void pass_some_time() {
        scene& on = in_.state();
        if (on.one_in(3)) return;
        if (in_.has_only_test_devices() && on.one_in(1000)) {
            on.strikes(strike::long_rest);
            return in_.rest(std::uint64_t{on.between(30 * 60, 75 * 60)} * 1'000'000);
        }
        in_.rest(on.one_in(20) ? on.random.below(200'000) : on.random.below(4'000));
        if (in_.state().one_in(12)) let_neighbours_speak();
        if (happens(4) && on.now() > babbling_until_) babble();
    }

    /// An operation begins, on this device.
    void begin(participant& at) {
        scene& on = in_.state();
        on.chance = in_.hostility;
        on.is_struck = on.may_end_early = on.does_clock_lie = on.must_fail = on.cuts_quarantine =
            on.has_intruded = on.has_jumped_back = false;
        clock_factor_ = 1;
        is_clock_stopped_ = jumps_back_only_ = false;
        look_after(at);
        on.is_any_away = is_any_away();
        if (happens(1)) strike_at(at);
        const bool is_faulty = in_.port().is_gone() || on.now() < faulty_until_;
        on.may_end_early = is_faulty || (in_.port().has_plans() && !jumps_back_only_) || on.does_clock_lie;
        // The line waits no longer than two frames in addition to its gaps.
        const bool is_flooded = on.sounding_until > on.now() + on.wire_time(256);
        on.is_struck = on.is_struck || is_flooded || is_faulty || on.now() < babbling_until_ ||
                       at.slow_until != 0 || at.device().is_off();
    }

    /// A device that is off, or slow and still responding to an earlier request, misses a broadcast.
    bool is_any_away() const {
        if (in_.is_empty()) return true;
        for (const auto& s : in_.participants()) {
            if (s->slow_until != 0 || s->device().is_off()) return true;
        }
        return false;
    }

    /// The rest of an abandoned request still leaves.
    void wait_for_rest_of_request(bool was_given_up) {
        scene& on = in_.state();
        if (was_given_up || on.does_clock_lie || in_.port().is_leaving()) in_.rest(on.wire_time(270));
    }

    void end(participant&) {
        scene& on = in_.state();
        if (!on.does_clock_lie) return;
        in_.port().forget_plans();
        if (is_clock_stopped_) in_.port().stop_clock(false);
        rest_long();
        in_.court().pardon();
    }

    /// Each backward jump may restart a wait.
    std::uint64_t clock_factor() const { return clock_factor_; }
    bool is_clock_stopped() const { return is_clock_stopped_; }

  private:
    bool happens(std::uint32_t divisor) { return in_.state().random.below(1000 * divisor) < in_.events; }
    void excuse_until(std::uint64_t at) { faulty_until_ = std::max(faulty_until_, at); }

    void look_after(participant& at) {
        scene& on = in_.state();
        if (at.slow_until != 0 && on.now() > at.slow_until) {
            at.slow_until = 0;
            at.set_delay(servobus::duration{at.usual_delay_us});
        }
        if (!at.is_where_it_is_looked_for() && on.one_in(3)) at.address() = at.device_address();
    }

    // An exchange of other nodes, before whose end nothing is sent.
    void let_neighbours_speak() {
        scene& on = in_.state();
        const neighbour what = any_neighbour(on);
        ++on.count->lives.between[played::at(what)];
        const auto from = static_cast<std::uint8_t>(on.between(200, 247));
        participant& at = in_.any_participant();
        const byte_list carried =
            closed({at.device_address(), 0x06, 0x02, 0x00, on.any_byte(), on.any_byte()});
        const std::uint64_t end =
            in_.others().sender.send_at(on.now() + 1, frame_of(on, what, from, carried));
        in_.rest(1); // the line reads the schedule of the new bytes
        in_.rest(end - on.now() + 1 + on.random.below(4 * on.timing.t3_5));
    }
    void babble() {
        scene& on = in_.state();
        on.strikes(strike::rubbish);
        byte_list b = random_bytes(on, on.one_in(4) ? on.between(1, 4096) : on.between(1, 40));
        b[0] = 0xF9; // the address of no device, since some drives respond to a damaged request
        babbling_until_ = in_.others().sender.send_at(on.now() + on.random.below(3000), b);
        in_.rest(1); // the line reads the schedule of the new bytes
        if (!on.one_in(3)) in_.rest(babbling_until_ - on.now() + 2);
    }

    void strike_at(participant& at) {
        scene& on = in_.state();
        const std::uint64_t when =
            on.now() + on.random.below(at.limits().response.us + at.gaps().quarantine.us);
        const std::uint32_t time = 1000u * on.between(1, 400);
        switch (on.random.below(9)) {
        case 0: return in_.port().plan(when, [this, time] { cut(time); });
        case 1: return in_.port().plan(when, [this, &at, time] { reboot(at, time); });
        case 2: return in_.port().plan(when, [this, &at] { move(at); });
        case 3: return slow_down(at);
        case 4:
            in_.port().plan(when, [this] {
                in_.state().strikes(strike::lost_port);
                in_.port().vanish();
            });
            return in_.port().plan(when + time, [this] {
                in_.state().is_struck = true;
                in_.port().come_back();
            });
        case 5: return in_.port().plan(when, [this] { send(); });
        default: return upset_clock();
        }
    }

    void cut(std::uint32_t time) {
        in_.state().strikes(strike::stuck_line);
        in_.wire().cut_for(servobus::duration{time});
        excuse_until(in_.state().now() + time);
    }
    void send() {
        scene& on = in_.state();
        const std::uint64_t end = in_.let_talk(on.between(100'000, 2'000'000));
        babbling_until_ = std::max(babbling_until_, end);
        excuse_until(end);
    }
    void reboot(participant& at, std::uint32_t time) {
        in_.state().strikes(strike::reboot);
        at.reboot(in_.state().now() + time);
        excuse_until(in_.state().now() + time);
    }
    void move(participant& at) {
        in_.state().strikes(strike::new_address);
        const std::uint8_t to = in_.free_unit();
        in_.state().moves(at.device_address(), to);
        at.set_device_address(to);
    }
    // The delay may exceed the client's time limit.
    void slow_down(participant& at) {
        scene& on = in_.state();
        on.strikes(strike::slow_drive);
        at.set_delay(servobus::duration{on.between(at.usual_delay_us, at.gaps().quarantine.us * 9 / 10)});
        at.slow_until = on.now() + on.between(1'000, 1'000'000);
    }

    // A client without a correct clock cannot keep gaps. So the line is at rest for longer than any late
    // response before the clock fails and after it.
    void upset_clock() {
        scene& on = in_.state();
        if (in_.port().has_plans() || in_.port().is_gone()) return;
        if (on.one_in(3)) return jump_back();
        rest_long();
        on.does_clock_lie = true;
        if (on.one_in(8)) {
            is_clock_stopped_ = true;
            in_.port().plan(on.now() + on.random.below(50'000), [this] {
                in_.state().strikes(strike::clock_stopped);
                in_.port().stop_clock(true);
            });
            return;
        }
        for (std::uint32_t n = on.between(1, 3); n != 0; --n) {
            const bool is_back = on.one_in(2);
            const std::int64_t by = on.one_in(3) ? std::int64_t{on.between(1, 4000)} * 1'000'000
                                                 : std::int64_t{on.between(1000, 500'000)};
            if (is_back) ++clock_factor_;
            in_.port().plan(on.now() + on.random.below(200'000), [this, by, is_back] {
                in_.state().strikes(is_back ? strike::clock_back : strike::clock_forward);
                in_.port().jump(is_back ? -by : by);
            });
        }
    }
    // A backward jump shortens no gap and no quarantine, so responses may still be late.
    void jump_back() {
        scene& on = in_.state();
        jumps_back_only_ = true;
        on.chance = on.one_in(2) ? on.chance : 600; // makes it likely that a jump coincides with a fault
        for (std::uint32_t n = on.between(1, 3); n != 0; --n) {
            const std::int64_t by = on.one_in(2) ? on.between(1, 2'000'000) : on.between(1, 20'000);
            ++clock_factor_;
            in_.port().plan(on.now() + on.random.below(on.one_in(2) ? 200'000 : 20'000), [this, by] {
                in_.state().strikes(strike::clock_back);
                in_.state().has_jumped_back = true;
                in_.state().jumped_back_at = in_.state().now();
                in_.state().hide_pause();
                in_.port().jump(-by);
            });
        }
    }
    void rest_long() {
        scene& on = in_.state();
        std::uint64_t longest = 0;
        for (const auto& s : in_.participants())
            longest = std::max<std::uint64_t>(longest, s->limits().response.us + s->gaps().quarantine.us);
        in_.rest(2 * longest + on.wire_time(700));
    }

    world& in_;
    std::uint64_t faulty_until_ = 0;
    std::uint64_t babbling_until_ = 0;
    std::uint64_t clock_factor_ = 1;
    bool is_clock_stopped_ = false;
    bool jumps_back_only_ = false;
};

} // namespace trial
