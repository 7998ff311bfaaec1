// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges the refusals of commands: a plan against a test's own rules, and against what `why` says of it.
//
//     refusal_judge of{drive_states{drive_state::needs_init, drive_state::disabled, drive_state::enabled}};
//     const rule rules[] = {rule::whole(0x2080, 5, 2), rule::range(0x2080, 5, 2, 0, 32'767)}; // 2.5 counts
//     of.judge(zlac8015d::ramps{}, settings, rules);
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <span>
#include <string>

#include <servobus/control/why.hpp>

namespace servobus::refusal_tests {

/// A rule of a command about one argument: a value of `numerator / denominator` counts of the register at `address`.
/// A number without a register has the address -1.
struct rule {
    long address;
    errc error; ///< the error of a value that breaks it
    bool is_broken;

    static rule whole(long address, long double numerator, long double denominator = 1) {
        return {address, errc::inexact, std::fmod(numerator, denominator) != 0};
    }
    static rule range(long address, long double numerator, long double denominator, long double low,
                      long double high) {
        return {address, errc::out_of_range, numerator < low * denominator || numerator > high * denominator};
    }
    static rule range(long address, long double count, long double low, long double high) {
        return range(address, count, 1, low, high);
    }
    static rule index(long double n, long double low, long double high) {
        return {-1, errc::bad_argument, n < low || n > high};
    }
    static rule that(long address, errc error, bool is_kept) { return {address, error, !is_kept}; }
};

/// Random values, most of them beside limits.
class near_limits {
  public:
    explicit near_limits(std::uint64_t seed) : state_{seed} {}

    std::uint64_t next() {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return state_ * 0x2545'F491'4F6C'DD1Dull >> 16;
    }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(next() % n); }
    bool one_in(std::uint32_t n) { return below(n) == 0; }

    /// A value beside one of the marks, between the first and the last of them, or anywhere in 32 bits.
    std::int32_t value(std::initializer_list<std::int64_t> marks, std::int64_t step = 1) {
        const std::int64_t mark = marks.begin()[below(static_cast<std::uint32_t>(marks.size()))];
        const std::int64_t low = *marks.begin();
        const std::int64_t high = *(marks.end() - 1);
        switch (below(16)) {
        case 0: {
            constexpr std::int64_t beyond = 0x1'0000'0000;
            const std::uint32_t end = below(4);
            if (end < 2) return limited(end == 0 ? -beyond : beyond); // what a saturated quantity has
            return static_cast<std::int32_t>(next());
        }
        case 1: {
            const std::int64_t way = one_in(2) ? step : -step;
            return limited(mark + way * static_cast<std::int64_t>(below(9)));
        }
        case 2:
        case 3:
        case 4: return limited(mark + static_cast<std::int64_t>(below(7)) - 3);
        default:
            return high <= low ? limited(low)
                               : limited(low + static_cast<std::int64_t>(
                                                   next() % static_cast<std::uint64_t>(high - low + 1)) /
                                                   step * step);
        }
    }
    /// A code, also one that the enumeration does not have.
    template <class E> E code(std::int64_t low, std::int64_t high) {
        const std::int64_t n = one_in(8) ? static_cast<std::int64_t>(next() & 0xFFFF)
                                         : low - 1 + below(static_cast<std::uint32_t>(high - low + 3));
        return static_cast<E>(static_cast<std::uint16_t>(n));
    }

  private:
    static std::int32_t limited(std::int64_t v) {
        constexpr std::int64_t least = std::numeric_limits<std::int32_t>::min();
        constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
        return static_cast<std::int32_t>(v < least ? least : v > most ? most : v);
    }
    std::uint64_t state_;
};

class refusal_judge {
  public:
    /// `all`: the states that the manual of the drive has, but for a fault.
    constexpr explicit refusal_judge(drive_states all) : all_{all} {}

    /// The number of plans for each way in which they ended.
    std::string seen() const {
        std::string all;
        for (std::size_t i = 0; i < std::size(counts_); ++i)
            all += (i == 0 ? "" : ", ") + std::to_string(counts_[i]) + ' ' + names[i];
        return all;
    }

    /// Checks that the plan refuses a value if, and only if, a rule of the test is broken, by the error of the first;
    /// and that `why` names the register of that rule, with limits that the value breaks.
    template <class Command, class Settings>
    void judge(const Command& wanted, const Settings& known, std::span<const rule> rules) {
        const errc got = commands::prepared(wanted, known).refusal;
        const refusal r = commands::refusal_of(wanted, known);
        const bool is_drive_asked = got == errc::ok && r.error != errc::ok; // by what the program knows of it
        REQUIRE((r.error == got || is_drive_asked));
        count(r.error);
        const rule* broken = nullptr;
        for (const rule& one : rules) {
            if (one.is_broken && broken == nullptr) broken = &one;
        }
        const bool is_of_state = r.error == errc::needs_init || r.error == errc::wrong_state;
        CHECK(r.is_of_state() == is_of_state);
        if (is_drive_asked) CHECK(broken == nullptr);
        if (got == errc::ok) check_all(arguments(wanted, known));
        if (is_of_state || r.error == errc::needs_homing || r.error == errc::needs_word_order) {
            CHECK_FALSE(r.is_of_value());
            if (is_of_state) check_states(r, wanted, known);
            return;
        }
        const errc wanted_error = broken == nullptr ? errc::ok : broken->error;
        CHECK(got == wanted_error);
        CHECK(r.is_of_value() == (broken != nullptr));
        if (broken != nullptr && r.is_of_value()) judge(r, *broken);
    }
    template <class Command, class Settings>
    void judge(const Command& wanted, const Settings& known, std::initializer_list<rule> rules) {
        judge(wanted, known, std::span<const rule>{rules.begin(), rules.size()});
    }
    template <class Command, class Settings>
    void judge(const Command& wanted, const Settings& known, const rule& one) {
        judge(wanted, known, {one});
    }

  private:
    template <class List> static void check_all(const List& accepted) {
        for (const command_argument& a : accepted) {
            CHECK(a.is_exact);
            CHECK_FALSE(a.is_refused());
        }
    }
    // The states in which the command is possible if nothing else changes, if there are any.
    template <class Command, class Settings>
    void check_states(const refusal& r, const Command& wanted, const Settings& known) const {
        drive_states possible;
        const auto is_refused = [](errc e) { return e == errc::needs_init || e == errc::wrong_state; };
        for (unsigned n = 0; n <= static_cast<unsigned>(drive_state::faulted); ++n) {
            Settings other = known;
            other.state = static_cast<drive_state>(n);
            if (!all_.has(other.state)) continue;
            const auto planned = commands::prepared(wanted, other);
            bool is_possible = !is_refused(planned.refusal);
            // Also with a wrong value, which is refused before the drive is asked.
            if constexpr (requires { permitted(planned, other); })
                is_possible = is_possible && !is_refused(permitted(planned, other));
            if (is_possible) possible.add(other.state);
        }
        CHECK_FALSE(possible.has(known.state));
        if (!possible.is_empty()) CHECK(r.states == possible);
        // Otherwise a setting is in the way, and it is named.
        if (possible.is_empty()) CHECK(r.unmet() != nullptr);
    }
    static void judge(const refusal& r, const rule& broken) {
        const command_argument& a = r.argument;
        CHECK((a.has_register ? long{a.address} : -1L) == broken.address);
        if (broken.error == errc::inexact) {
            CHECK_FALSE(a.is_exact);
        } else {
            const bool is_above = a.is_exact ? a.count > a.limits.high : a.count >= a.limits.high;
            CHECK((is_above || a.count < a.limits.low || !a.is_taken));
        }
    }
    static constexpr const char* names[] = {"accepted",     "out of range",  "inexact",
                                            "bad argument", "for the state", "for other reasons"};
    void count(errc e) {
        const std::size_t which = e == errc::ok                                     ? 0
                                  : e == errc::out_of_range                         ? 1
                                  : e == errc::inexact                              ? 2
                                  : e == errc::bad_argument                         ? 3
                                  : e == errc::needs_init || e == errc::wrong_state ? 4
                                                                                    : 5;
        ++counts_[which];
    }

    drive_states all_;
    unsigned counts_[std::size(names)]{};
};

} // namespace servobus::refusal_tests
