// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: waits that end on time, though the system wakes a sleeping thread late. A wait sleeps less by the
// lateness that was measured, and polls for the rest. It knows no system: tests run it in virtual time.
//
//     |<- slept ->|  woken late  |<- polled ->| the end of the wait
//
// The lateness that it goes by rises by half of the way to a later wake-up and falls by a sixteenth of the way to
// an earlier one. Where wake-ups vary, that settles so that a quarter or less of them are later. A wake-up that is
// later than `latest` does not count: another thread had the processor, and no polling helps. The lateness never
// exceeds `longest_poll`. So a single outlier raises it by half of that at most, and after 36 wake-ups a tenth of that
// is left.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::posix::detail {

class early_wake_up {
  public:
    /// No call polls longer.
    static constexpr duration longest_poll = milliseconds(1);
    /// The longest lateness that counts.
    static constexpr duration latest = milliseconds(2);
    /// A wait of this length or more sleeps to its end. Lines divide what is not urgent, such as the wait for a slow
    /// drive, into waits of this length.
    static constexpr duration longest_exact = milliseconds(5);
    /// The most polls in each us: they end where the clock stands still.
    static constexpr std::uint32_t polls_each_us = 4;

    /// A wait from its start: it sleeps, polls until `polled_until`, and sleeps for the rest.
    struct pieces {
        duration slept;
        duration polled_until;
    };
    constexpr pieces to_end_of(duration asked) const {
        if (asked >= longest_exact) return {asked, asked};
        return {less(asked, lateness_), asked};
    }
    /// While a frame arrives whose last byte is due in `due`. It may come earlier by the lateness, since the byte
    /// before was found late. It is polled for by the lateness longer.
    constexpr pieces to_last_byte(duration asked, duration due) const {
        const duration slept = less(due, lateness_ * 2);
        return {slept, shorter_of(asked, shorter_of(due + lateness_, slept + longest_poll))};
    }

    /// How much later than asked a wake-up is expected.
    constexpr duration lateness() const { return lateness_; }
    /// A sleep of `asked` took so long. One that a signal or a jump of the clock has ended tells nothing.
    constexpr void note(duration asked, duration took) {
        duration late = took - asked; // of a shorter one it is huge
        if (late > latest) return;
        late = shorter_of(late, longest_poll);
        if (late > lateness_)
            lateness_ = lateness_ + duration{(late.us - lateness_.us + 1) / 2};
        else
            lateness_ = lateness_ - duration{(lateness_.us - late.us + 15) / 16};
    }

    /// Waits for a byte, for at most `asked`. `due`: when the last byte of the frame that arrives is due; zero if none
    /// does. `system` has `now()`, and `wait(duration)`, which returns the events that have ended it, or 0; with a zero
    /// duration it does not sleep. Returns the events.
    template <class System> constexpr int wait(System&& system, duration asked, duration due) {
        const pieces all = due != duration{} && due < asked ? to_last_byte(asked, due) : to_end_of(asked);
        const instant start = system.now();
        duration passed{};
        if (all.slept != duration{}) {
            const int events = sleep(system, start, all.slept, passed);
            if (events != 0 || passed < all.slept) return events; // a signal
        }
        std::uint32_t polls = (all.polled_until - all.slept).us * polls_each_us;
        for (; polls != 0 && passed < all.polled_until; --polls) {
            if (const int events = system.wait(duration{}); events != 0) return events;
            passed = since(start, system.now());
        }
        const duration rest = less(asked, passed);
        return rest == duration{} ? 0 : sleep(system, system.now(), rest, passed);
    }

  private:
    static constexpr duration less(duration a, duration b) { return a > b ? a - b : duration{}; }

    template <class System>
    constexpr int sleep(System& system, instant start, duration asked, duration& passed) {
        const int events = system.wait(asked);
        passed = since(start, system.now());
        if (events == 0) note(asked, passed);
        return events;
    }

    duration lateness_{};
};

} // namespace servobus::posix::detail
