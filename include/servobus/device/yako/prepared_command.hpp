// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: what a command is, which settings the facade has cached, and how physical units
// become counts. A command is checked against the cached settings before anything is sent, and becomes a
// routine with its arguments; the routine checks the drive's own state. The headers with the commands include
// it; programs use the drive's state and its quantities.
//
//     if (axis.state() == yako::drive_state::needs_init && !axis.run(init{})) return 1;
//     if (axis.state() == yako::drive_state::disabled && !axis.run(enable{})) return 1;
//     const bool may_move_to = axis.cached().is_homed;       // what an absolute move requires
//     constexpr yako::speed creep = 5 * part<10>(r_per_min); // 0.5 r/min
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/command.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/device/yako/routines.hpp>

namespace servobus::yako {

using servobus::disable, servobus::drive_state, servobus::enable, servobus::fault_reset, servobus::halt,
    servobus::init, servobus::quick_stop, servobus::read_feedback, servobus::wait_reached,
    servobus::wait_standstill;

/// Speeds: a closed loop drive counts 1 or 0.1 r/min. `60 * r_per_min` and `5 * part<10>(r_per_min)` convert
/// to it exactly.
using speed = quantity<units::r_per_min / 10, std::int32_t>;
using time = quantity<units::millisecond, std::int32_t>;
using distance = quantity<units::pulse, std::int32_t>;

/// What the program has cached of the drive. Invalid after an unknown outcome or a restart.
struct cached_settings {
    static constexpr std::size_t profile_words = 4;

    drive_state state = drive_state::needs_init;
    bool is_closed_loop = true;
    limit_enable limits = limit_enable::disabled;          ///< 0018h
    servobus::word_order word_order = word_order::unknown; ///< 0019h
    speed_count resolution = speed_count::one_r_per_min;   ///< 001Ah
    bool has_scale = false;                                ///< what a count of a speed is worth is certain
    bool has_profile = false;                              ///< 0020h..0023h hold speeds in that count,
    bool has_homing_profile = false;                       ///< and so do 0032h and 0033h
    bool is_homed = false;        ///< homed, or its position declared, and nothing since that could lose it
    bool was_homed = false;       ///< what the drive said of it at `init`
    bool is_marked = false;       ///< `marker` was written: a restart that loses what was not saved shows
    std::uint16_t microsteps = 0; ///< 0011h
    std::uint16_t profile[profile_words]{}; ///< 0020h..0023h
    std::uint16_t homing_speeds[2]{};       ///< 0032h, 0033h
    std::uint16_t marker[2]{};              ///< 00BAh, 00BBh, the target of position segment 16
};

/// What becomes of the cached settings once the routine is done.
enum class effect : std::uint8_t {
    none,
    initialised,
    enabled,
    disabled,
    quick_stopped,
    moved,
    crept,
    jogged,
    homed,
    kept, ///< saved
    profile_set,
    homing_profile_set,
    limited, ///< in its travel
    unlimited,
    word_order_set,
    resolution_set,
    forgotten,
    reset, ///< to the factory's parameters
    seen,  ///< feedback was read
    alarm_cleared,
    trusted,
    position_cleared,
    positions_compared,
    marked,        ///< the marker was written
    segment_set,   ///< position segment 16, which has the marker otherwise
    arrived,       ///< the end of a move was waited for
    stop_examined, ///< what may have stopped it short was read
    end
};

/// What the drive must be like before a command is sent.
enum class requirement : std::uint8_t {
    nothing = 0,
    standing = 1, ///< else `busy`
    healthy = 2,  ///< else `faulted`
    enabled = 4,  ///< else `wrong_state`
    released = 8, ///< else `wrong_state`
    homed = 16,   ///< else `needs_homing`
};
constexpr requirement operator|(requirement a, requirement b) {
    return static_cast<requirement>(static_cast<std::uint8_t>(a) | static_cast<std::uint8_t>(b));
}
constexpr bool has(requirement set, requirement one) {
    return (static_cast<std::uint8_t>(set) & static_cast<std::uint8_t>(one)) != 0;
}
inline constexpr requirement at_rest_and_able =
    requirement::standing | requirement::healthy | requirement::enabled;

/// A command made ready: steps and arguments, or the reason why it is refused here.
struct prepared_command {
    routine steps;
    steps::arguments arguments{};
    std::uint16_t shift = 0;
    effect then = effect::none;
    requirement needs = requirement::nothing;
    bool has_profile = false; ///< the first four arguments are the profile of moves
    bool is_absolute = false;
    bool has_target = false; ///< `target` is where it ends, counted as `is_absolute` says
    errc refusal = errc::ok;
    stop_priority stop = stop_priority::no_stop; ///< a stop is sent in any state and replaces another command
    std::int32_t target = 0;
    duration limit{};
    /// Of a hold: puts in its target, once the position is seen. Null: the command has its target.
    errc (*aim)(prepared_command&, const std::uint16_t* feedback, const cached_settings&) = nullptr;
};

namespace detail {
template <class Device> inline constexpr bool is_closed_loop = std::is_base_of_v<closed_loop::device, Device>;

using servobus::commands::first_error, servobus::commands::in_range;

struct counted {
    std::uint16_t word = 0;
    errc error = errc::ok;
};

/// A speed in counts, or the error: `wrong_state` while the worth of a count is not certain, `out_of_range`
/// outside the limits of the row, which are r/min; `inexact` if it is no whole number of counts.
template <const auto& R> constexpr counted count_of(speed wanted, const cached_settings& cached) {
    const std::int32_t tenths = wanted.count();
    if (!cached.has_scale) return {0, errc::wrong_state};
    if (tenths < R.limits.low * 10 || tenths > R.limits.high * 10) return {0, errc::out_of_range};
    if (cached.resolution == speed_count::tenth_r_per_min)
        return {static_cast<std::uint16_t>(tenths), errc::ok};
    if (tenths % 10 != 0) return {0, errc::inexact};
    return {static_cast<std::uint16_t>(tenths / 10), errc::ok};
}
/// A time in counts of a row.
template <const auto& R> constexpr counted count_of(time wanted) {
    const errc error = R.limits.contains(wanted.count()) ? errc::ok : errc::out_of_range;
    return {static_cast<std::uint16_t>(wanted.count()), error};
}
/// The ends of the range stand for what did not fit into it.
constexpr errc in_range(distance d) {
    return d.count() == 0x7FFF'FFFF || d.count() < -0x7FFF'FFFF ? errc::out_of_range : errc::ok;
}
constexpr word_pair words_of(distance d, const cached_settings& cached) {
    return split_words(static_cast<u32>(d.count()), cached.word_order);
}

constexpr errc needs_init_done(const cached_settings& cached) {
    return cached.state == drive_state::needs_init ? errc::needs_init : errc::ok;
}
constexpr errc needs_homed(const cached_settings& cached) {
    return cached.is_homed ? errc::ok : errc::needs_homing;
}
constexpr errc needs_closed_loop(const cached_settings& cached) {
    return cached.is_closed_loop ? errc::ok : errc::bad_argument;
}

/// A setting of one word: written and read back.
constexpr prepared_command set_word(routine steps, std::uint16_t word, errc wrong,
                                    const cached_settings& cached, requirement needs = requirement::nothing) {
    return {.steps = steps,
            .arguments = {word},
            .needs = needs,
            .refusal = first_error(needs_init_done(cached), wrong)};
}
} // namespace detail

} // namespace servobus::yako
