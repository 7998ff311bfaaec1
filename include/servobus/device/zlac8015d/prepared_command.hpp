// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: what a command is, which settings the facade has cached, and how physical units become
// counts. A command is checked against the cached settings before anything is sent, and becomes a routine
// with its arguments. The headers with its commands include it; programs use the drive's state and its
// quantities.
//
//     if (wheels.state() == zlac8015d::drive_state::needs_init && !wheels.run(zlac8015d::init{})) return 1;
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
    std::uint16_t resolution = 1;   ///< 2022h: a commanded count is 1/resolution r/min
    std::uint16_t max_speed = 0;    ///< 2008h, r/min
    std::uint16_t host_timeout = 0; ///< 2000h, ms; 0: none
};

/// What becomes of the cached settings once the routine is done.
enum class effect : std::uint8_t {
    none,
    initialised,
    enabled,
    disabled,
    quick_stopped,
    moved,
    motion, ///< a target was set: counts as a command of the application
    timeout_set,
    speeds_set, ///< the arguments are resolution and top speed
    forgotten,
    seen, ///< feedback was read
    positions_compared,
    positions_cleared,
    arrived, ///< the end of a move was waited for
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
// Its own division: that of the run-time library takes 700 bytes on a small core.
constexpr std::int32_t quotient(std::int32_t a, std::uint32_t by) {
    std::uint32_t left = a < 0 ? 0u - static_cast<std::uint32_t>(a) : static_cast<std::uint32_t>(a);
    std::uint32_t rest = 0;
    for (int bit = 0; bit < 32; ++bit) {
        rest = rest << 1 | left >> 31;
        left <<= 1;
        if (rest < by) continue;
        rest -= by;
        ++left;
    }
    return static_cast<std::int32_t>(a < 0 ? 0u - left : left);
}
constexpr speed_count count_of(speed wanted, const cached_settings& cached) {
    constexpr std::int32_t per_r_per_min = 2520;
    const std::int32_t parts = wanted.count();
    const std::int32_t limit = cached.max_speed * per_r_per_min;
    if (parts > limit || parts < -limit) return {0, errc::out_of_range};
    const std::int32_t scaled = parts * cached.resolution;
    const std::int32_t counts = quotient(scaled, per_r_per_min);
    if (counts * per_r_per_min != scaled) return {0, errc::inexact};
    if (counts < left_target_speed.limits.low || counts > left_target_speed.limits.high)
        return {0, errc::out_of_range};
    return {static_cast<std::uint16_t>(counts), errc::ok};
}

constexpr errc needs(const cached_settings& cached, operating_mode mode) {
    if (cached.state == drive_state::needs_init) return errc::needs_init;
    return cached.state == drive_state::enabled && cached.mode == mode ? errc::ok : errc::wrong_state;
}
constexpr errc needs_init_done(const cached_settings& cached) {
    return cached.state == drive_state::needs_init ? errc::needs_init : errc::ok;
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
