// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The wire of the fake UARTs: virtual time, characters with their duration, an RS-485 driver that must be
// on for each of them, and a node that responds to a complete frame after a gap. Reading a clock lets time
// pass, and events that are due meanwhile run like interrupts.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace fake {

using frame = std::vector<std::uint8_t>;

enum class damage { none, framing, overrun };

struct wire {
    static constexpr std::uint64_t character = 87; // us at 115200 Bd, 8N1
    static constexpr std::uint64_t t3_5 = 1750;
    static constexpr std::uint64_t work = 2000; // us that the node waits after a request

    // The 32 bits of a microsecond clock wrap within each test.
    std::uint64_t now = (std::uint64_t{1} << 32) - 21'000;
    bool has_echo = false;
    std::function<frame(const frame&)> node; // makes the response; no response if empty
    std::size_t damaged = SIZE_MAX;          // the damaged character of the response
    damage how = damage::none;
    std::function<void(std::uint8_t, damage)> hears; // the receiver of the port

    frame left;                      // characters that have left complete, with the driver on
    std::vector<frame> requests;     // as the node received them
    std::uint64_t free_at = 0;       // end of the last stop bit
    std::uint64_t longest_pause = 0; // between characters of a request
    std::uint64_t driver_off_at = 0;
    unsigned torn = 0;       // characters that left without the driver
    unsigned collisions = 0; // characters of the node that arrived while the driver was on
    bool driver = false;

    void drive(bool on) {
        if (driver && !on) {
            driver_off_at = now;
            ++switched_off_;
        }
        driver = on;
    }

    void at(std::uint64_t when, std::function<void()> what) { later_.emplace(when, std::move(what)); }
    void in(std::uint64_t us, std::function<void()> what) { at(now + us, std::move(what)); }

    void advance(std::uint64_t us) {
        const std::uint64_t until = now + us;
        is_in_interrupt_ = true;
        while (!later_.empty() && later_.begin()->first <= until) {
            const auto due = later_.begin();
            if (due->first > now) now = due->first;
            const std::function<void()> what = std::move(due->second);
            later_.erase(due);
            what();
        }
        is_in_interrupt_ = false;
        if (until > now) now = until;
    }
    /// A reading of a clock.
    std::uint64_t look() {
        if (!is_in_interrupt_) advance(5);
        return now;
    }
    /// Sleeps until `is_over`, at most for `us`.
    template <class Predicate> void sleep(std::uint64_t us, Predicate is_over) {
        const std::uint64_t until = now + us;
        while (!is_over() && now < until) advance(1);
    }

    /// One character leaves; `end` is called after its stop bit.
    void transmit(std::uint8_t byte, std::function<void()> end) {
        const std::uint64_t begin = free_at > now ? free_at : now;
        if (!current_.empty() && begin - free_at > longest_pause) longest_pause = begin - free_at;
        free_at = begin + character;
        const std::uint64_t ends = free_at;
        at(begin, [this, byte, ends, end] {
            const bool was_on = driver;
            const unsigned before = switched_off_;
            at(ends, [this, byte, ends, end, was_on, before] {
                if (was_on && driver && before == switched_off_)
                    left.push_back(byte);
                else
                    ++torn;
                current_.push_back(byte);
                at(ends + work, [this, ends] {
                    if (free_at == ends && !current_.empty()) answer();
                });
                if (has_echo) hears(byte, damage::none);
                end();
            });
        });
    }

    /// Characters of the node arrive, without gaps.
    void arrive(const frame& bytes) {
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            in((i + 1) * character, [this, byte = bytes[i], kind = i == damaged ? how : damage::none] {
                if (driver)
                    ++collisions;
                else
                    hears(byte, kind);
            });
        }
    }

  private:
    void answer() {
        const frame request = std::exchange(current_, {});
        requests.push_back(request);
        if (torn == 0 && node) arrive(node(request));
    }

    std::multimap<std::uint64_t, std::function<void()>> later_;
    frame current_;
    unsigned switched_off_ = 0;
    bool is_in_interrupt_ = false;
};

/// The only wire of a test program: the functions of the vendors are global, too.
inline wire& line() {
    static wire one;
    return one;
}

} // namespace fake
