// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: what a command is, which settings the facade has cached, and how physical units become
// counts. A command is checked against the cached settings before anything is sent, and becomes a routine
// with its arguments. The headers with its commands include it; programs use the drive's state and its
// quantities.
//
//     if (wheels.state() == zlac8015d::drive_state::needs_init && !wheels.run(init{})) return 1;
//     const zlac8015d::speed top = wheels.cached().max_speed * r_per_min; // 2008h
//     constexpr zlac8015d::speed crawl = 5 * part<10>(r_per_min);         // 0.5 r/min
#pragma once

#include <cstdint>

#include <servobus/control/command.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/device/zlac8015d/routines.hpp>

namespace servobus::zlac8015d {

using servobus::disable, servobus::drive_state, servobus::enable, servobus::fault_reset, servobus::halt,
    servobus::init, servobus::quick_stop, servobus::read_feedback, servobus::wait_reached,
    servobus::wait_standstill;

/// Speeds: every resolution that the drive has, 1 .. 1/10 r/min, is a whole number of these. `30 * r_per_min`
/// and `125 * part<10>(r_per_min)` convert to it exactly.
using speed = quantity<units::r_per_min / 2520, std::int32_t>;
using current = quantity<units::milliampere, std::int32_t>;
using time = quantity<units::millisecond, std::int32_t>;
using distance = quantity<units::pulse, std::int32_t>;
using current_slope = quantity<units::milliampere_per_second, std::int32_t>;

/// What the program has cached of the drive. Void after an unknown outcome, silence or a restart.
struct cached_settings {
    drive_state state = drive_state::needs_init;
    operating_mode mode = operating_mode::undefined;
    synchronisation starts = synchronisation::asynchronous;
    std::uint16_t resolution = 1;   ///< 2022h, in force: a commanded count is 1/resolution r/min
    std::uint16_t max_speed = 0;    ///< 2008h, r/min
    std::uint16_t host_timeout = 0; ///< 2000h, ms; 0: none
};

/// What becomes of the cached settings once the routine is done.
enum class effect : std::uint8_t {
    none,
    motion,      ///< a target was set: counts as a command of the application
    seen,        ///< feedback was read
    arrived,     ///< the end of a move was waited for
    initialised, ///< by `routines::init`
    enabled,
    disabled,
    quick_stopped,
    moved,
    timeout_set,
    speeds_set, ///< the arguments are resolution and top speed
    rescaled,   ///< 2022h has another value, which counts from the next power-on
    forgotten,
    positions_compared,
    positions_cleared,
    end
};

/// A command made ready: steps and arguments, or the reason why it is refused here.
struct prepared_command {
    routine steps;
    steps::arguments arguments{};
    effect then = effect::none;
    operating_mode mode = operating_mode::undefined;
    wheels which = wheels::none; ///< that a move moves
    errc refusal = errc::ok;
    stop_priority stop = stop_priority::no_stop; ///< a stop is sent in any state and replaces another command
    duration limit{};                            ///< for a wait
};

namespace detail {
using servobus::commands::count_in, servobus::commands::first_error, servobus::commands::in_range,
    servobus::commands::as_word;

/// A speed in counts of 2088h/2089h, or the error: `out_of_range` above the drive's own limit 2008h, beyond
/// which it raises a fault [errata B5]; `inexact` if it is no whole number of counts.
struct speed_count {
    std::uint16_t word = 0;
    errc error = errc::ok;
};
struct division {
    std::uint32_t whole;
    std::uint32_t rest;
};
// The division of the run-time library takes 700 bytes on a small core.
constexpr division divided(std::uint32_t left, std::uint32_t by) {
    std::uint32_t rest = 0;
    for (int bit = 0; bit < 32; ++bit) {
        rest = rest << 1 | left >> 31;
        left <<= 1;
        if (rest < by) continue;
        rest -= by;
        ++left;
    }
    return {left, rest};
}
constexpr std::uint32_t magnitude(std::int32_t n) {
    return n < 0 ? 0u - static_cast<std::uint32_t>(n) : static_cast<std::uint32_t>(n);
}
constexpr speed_count count_of(speed wanted, const cached_settings& cached) {
    constexpr std::uint32_t per_r_per_min = 2520;
    static_assert(left_target_speed.limits.low == -left_target_speed.limits.high);
    const std::uint32_t parts = magnitude(wanted.count());
    if (parts > cached.max_speed * per_r_per_min) return {0, errc::out_of_range};
    const division counts = divided(parts * cached.resolution, per_r_per_min);
    if (counts.rest != 0) return {0, errc::inexact};
    if (counts.whole > static_cast<std::uint32_t>(left_target_speed.limits.high))
        return {0, errc::out_of_range};
    return {static_cast<std::uint16_t>(wanted.count() < 0 ? 0u - counts.whole : counts.whole), errc::ok};
}

constexpr errc needs(const cached_settings& cached, operating_mode mode) {
    if (cached.state == drive_state::needs_init) return errc::needs_init;
    return cached.state == drive_state::enabled && cached.mode == mode ? errc::ok : errc::wrong_state;
}
constexpr errc needs_init_done(const cached_settings& cached) {
    return cached.state == drive_state::needs_init ? errc::needs_init : errc::ok;
}
/// As `needs_init_done`; `wrong_state` until a new 2022h is in force.
constexpr errc needs_power(const cached_settings& cached) {
    if (cached.state == drive_state::needs_init) return errc::needs_init;
    return cached.state < drive_state::disabled ? errc::wrong_state : errc::ok;
}
constexpr errc needs_disabled(const cached_settings& cached) {
    if (cached.state == drive_state::needs_init) return errc::needs_init;
    return cached.state == drive_state::disabled ? errc::ok : errc::wrong_state;
}

/// Both wheels take one value of a row and its twin: 10h with a pair of equal rows.
template <const auto& R, unit U>
constexpr prepared_command set_pair(routine steps, quantity<U, std::int32_t> left,
                                    quantity<U, std::int32_t> right, const cached_settings& cached) {
    const auto l = count_in<R>(left);
    const auto r = count_in<R>(right);
    return {.steps = steps,
            .arguments = {as_word(l.count), as_word(r.count)},
            .refusal = first_error(needs_init_done(cached), first_error(l.error, r.error))};
}
} // namespace detail

} // namespace servobus::zlac8015d
