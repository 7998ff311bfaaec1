// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the commands that operate them, in a control engineer's words: take over,
// enable, stop, move, home, read feedback. servobus/device/yako.hpp includes it. Source: manual V2.6.0,
// chapter 4 and section 5.1. What a command requires of the drive's state is read from the drive before
// anything else is sent; if it is refused then, only reads were sent.
//
//     if (!axis.run(init{}) || !axis.run(enable{})) return 1;
//     if (!axis.run(yako::closed_loop::home{yako::homing::home_24, 200 * pulse})) return 1;
//     constexpr yako::motion_profile slow{0 * r_per_min, 90 * millisecond, 90 * millisecond, 60 * r_per_min};
//     const yako::arrival there = axis.run(move_to{5000 * pulse, slow}, wait_reached{});
//     if (there.how != arrival_state::reached) return 1;
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/control/motion_commands.hpp>
#include <servobus/device/yako/prepared_command.hpp>

namespace servobus::yako {

/// Takes a drive over, whatever a program before this one did: stops it, waits until it stands (up to 8 s),
/// reads what must be known, and writes a marker by which a restart shows (`restart_visible()`): the target of
/// position segment 16 becomes 1 to 15 pulses, unless the drive holds a target there that a program has set.
/// Nothing moves or is enabled. Absolute moves are refused until the axis has been homed or its position
/// declared: whether the drive's homing is still valid is not known. Errors: `unexpected_value` for a setting
/// that the manual does not list; `not_reached` if the motor runs on, as a homing may: section 4.6 does not say
/// that a stop ends one [errata A58].
constexpr prepared_command prepare(init, const cached_settings& cached) {
    return {.steps = cached.is_closed_loop ? routine{routines::init_closed_loop}
                                           : routine{routines::init_open_loop},
            .then = effect::initialised};
}

/// Energises the motor; only at standstill and without an alarm. Nothing moves by itself, but an input whose
/// function is a jog or a speed move acts at once if it is active.
constexpr prepared_command prepare(enable, const cached_settings& cached) {
    return {.steps = routines::enable,
            .then = effect::enabled,
            .needs = requirement::standing | requirement::healthy,
            .refusal = detail::needs_init_done(cached)};
}

/// Stops, waits until the motor stands, and frees its shaft. An open loop drive must be
/// homed again afterwards; where a release ends the drive's homing [errata A54], the next command finds that
/// as it finds a restart (`needs_init`). Errors: as `init`; the shaft is not freed then.
constexpr prepared_command prepare(disable, const cached_settings&) {
    return {.steps = routines::release, .then = effect::disabled, .stop = stop_priority::disable};
}

/// Stops by the deceleration time that was set *before* the move, and waits until the motor stands; it stays
/// energised. Section 4.6. Errors: as `init`.
constexpr prepared_command prepare(halt, const cached_settings&) {
    return {.steps = routines::stop, .stop = stop_priority::halt};
}

/// Stops at once, without a ramp. Steps may be lost, so that the axis must be homed before its next absolute
/// move. Section 4.6. Errors: as `init`.
constexpr prepared_command prepare(quick_stop, const cached_settings&) {
    return {.steps = routines::quick_stop, .then = effect::quick_stopped, .stop = stop_priority::quick_stop};
}

/// Clears the alarm, at standstill. Whether the motor was released by it, or is enabled afterwards, is not
/// stated [errata A57]: `drive::state()` says which. Errors: `faulted` if the alarm is still there.
constexpr prepared_command prepare(fault_reset, const cached_settings& cached) {
    return {.steps = routines::fault_reset,
            .then = effect::alarm_cleared,
            .needs = requirement::standing,
            .refusal = detail::needs_init_done(cached)};
}

/// How a position is reached: 0020h..0023h. Made without anything it is the one that the drive holds, as
/// `set_profile` or the move before left it. From which speed to which the times count is not stated.
class motion_profile {
  public:
    constexpr motion_profile() = default;
    /// Speeds 0..3000 r/min, times 0..2000 ms.
    constexpr motion_profile(speed start, time acceleration, time deceleration, speed top)
        : start_{start}, top_{top}, acceleration_{acceleration}, deceleration_{deceleration}, is_stored_{
                                                                                                  false} {}

    constexpr bool is_stored() const { return is_stored_; }
    constexpr speed start() const { return start_; }
    constexpr time acceleration() const { return acceleration_; }
    constexpr time deceleration() const { return deceleration_; }
    constexpr speed top() const { return top_; }

    /// A stored profile, or one whose top speed is above 0 and not below its start.
    constexpr bool has_order() const { return is_stored_ || (top_.count() > 0 && start_ <= top_); }
    /// Puts its four words in front of the arguments, or what the drive should hold behind a target; or gives
    /// the reason why not.
    constexpr errc put(steps::arguments& arguments, const cached_settings& cached) const {
        if (is_stored_) {
            for (std::size_t i = 0; i < cached_settings::profile_words; ++i)
                arguments[2 + i] = cached.profile[i];
            return cached.has_profile ? errc::ok : errc::wrong_state;
        }
        const auto start = detail::count_of<closed_loop::start_speed>(start_, cached);
        const auto rise = detail::count_of<acceleration_time>(acceleration_);
        const auto fall = detail::count_of<deceleration_time>(deceleration_);
        const auto top = detail::count_of<closed_loop::positioning_speed>(top_, cached);
        arguments[0] = start.word;
        arguments[1] = rise.word;
        arguments[2] = fall.word;
        arguments[3] = top.word;
        const errc order = has_order() ? errc::ok : errc::out_of_range;
        return detail::first_error(start.error, rise.error, fall.error, top.error, order);
    }

  private:
    speed start_{};
    speed top_{};
    time acceleration_{};
    time deceleration_{};
    bool is_stored_ = true;
};

namespace detail {
template <positioning From> constexpr routine move_table(const motion_profile& by, while_moving then) {
    using enum while_moving;
    if (by.is_stored()) {
        return then == ignore ? routine{routines::stored_move<From, ignore>}
                              : routine{routines::stored_move<From, interrupt>};
    }
    return then == ignore ? routine{routines::move<From, ignore>} : routine{routines::move<From, interrupt>};
}

template <positioning From>
constexpr prepared_command move(distance target, const motion_profile& by, while_moving then,
                                const cached_settings& cached) {
    prepared_command o{.steps = move_table<From>(by, then),
                       .then = effect::moved,
                       .needs = then == while_moving::ignore ? at_rest_and_able
                                                             : requirement::healthy | requirement::enabled,
                       .has_profile = !by.is_stored(),
                       .is_absolute = From == positioning::absolute,
                       .has_target = true,
                       .refusal = first_error(needs_init_done(cached), in_range(target)),
                       .target = target.count()};
    o.refusal = first_error(o.refusal, by.put(o.arguments, cached));
    const std::size_t place = by.is_stored() ? 0 : 4;
    const word_pair words = words_of(target, cached);
    o.arguments[place] = words.first;
    o.arguments[place + 1] = words.second;
    return o;
}
} // namespace detail

} // namespace servobus::yako

namespace servobus {
/// A move of a YAKO by a profile, which may be written in braces.
template <unit U, class Rep>
requires(detail::same_kind(U, units::pulse))
    move_by(quantity<U, Rep>, yako::motion_profile, yako::while_moving = yako::while_moving::ignore)
->move_by<detail::kept<quantity<U, Rep>>, yako::motion_profile, yako::while_moving>;
template <unit U, class Rep>
requires(detail::same_kind(U, units::pulse))
    move_to(quantity<U, Rep>, yako::motion_profile, yako::while_moving = yako::while_moving::ignore)
->move_to<detail::kept<quantity<U, Rep>>, yako::motion_profile, yako::while_moving>;
} // namespace servobus

namespace servobus::yako {

using servobus::declare_position, servobus::hold, servobus::move_by, servobus::move_to, servobus::velocity;

/// The commands of motion in the units of the drive: `move_to{place}`, `move_to{place, profile}`,
/// `move_to{place, profile, while_moving::interrupt}`. `in_units_of` makes them of the shorter forms.
using relative_move = move_by<distance, motion_profile, while_moving>;
using absolute_move = move_to<distance, motion_profile, while_moving>;
using jog_velocity = velocity<speed, time, time>;
using held_velocity = hold<speed, duration, time, time>;
using position_declaration = declare_position<distance>;

constexpr relative_move in_units_of(const move_by<distance>& wanted, const cached_settings*) {
    return {wanted.way};
}
constexpr absolute_move in_units_of(const move_to<distance>& wanted, const cached_settings*) {
    return {wanted.place};
}
/// `velocity{speed}` with ramps of 100 ms, `velocity{speed, acceleration, deceleration}`.
template <unit U, class Rep, std::same_as<time>... Ramps>
[[gnu::always_inline]] constexpr jog_velocity in_units_of(const velocity<quantity<U, Rep>, Ramps...>& wanted,
                                                          const cached_settings*) {
    const speed target = commands::exactly<speed>(wanted.target);
    if constexpr (sizeof...(Ramps) == 0)
        return {target, time{100}, time{100}};
    else
        return {target, wanted.acceleration, wanted.deceleration};
}
/// `hold{speed, every}` with ramps of 100 ms, `hold{speed, every, acceleration, deceleration}`.
template <unit U, class Rep, std::same_as<time>... Ramps>
[[gnu::always_inline]] constexpr held_velocity
in_units_of(const hold<quantity<U, Rep>, duration, Ramps...>& wanted, const cached_settings*) {
    const speed target = commands::exactly<speed>(wanted.target);
    if constexpr (sizeof...(Ramps) == 0)
        return {target, wanted.every, time{100}, time{100}};
    else
        return {target, wanted.every, wanted.acceleration, wanted.deceleration};
}

/// Moves by a way; its sign is the direction. Refused while the motor moves (`busy`), unless it is to
/// interrupt; what an interrupting way is counted from then is not stated. The move is ordered once: after an
/// unanswered start the position is compared (`drive::motion()`), nothing is sent again. Returns once the
/// move is seen to have begun. Section 4.1.
/// Errors: `not_executed` if the start was acknowledged and the motor is not seen to move within 200 ms;
/// `exception` if the drive refuses it instead [errata A56]; `not_reached` if the motor has moved, and is at
/// rest elsewhere than at its target for as long: an input or a restart has stopped it; `wrong_state` with
/// the drive's own profile, if its speeds are in a count that is not certain.
constexpr prepared_command prepare(const relative_move& wanted, const cached_settings& cached) {
    return detail::move<positioning::relative>(wanted.way, wanted.by, wanted.then, cached);
}

/// Moves to a place, as `move_by` otherwise. Errors: `needs_homing` until the axis has been homed or its
/// position declared, and again after a quick stop, a restart, and on open loop a release. (An input that
/// frees the motor for a moment, between two looks, is not seen.) **A restart is not seen either of a drive
/// that keeps its homed bit and its registers and counts from zero again: whether there is one is not stated.
/// Home the axis, or declare its position, whenever its power may have been off** [errata A55].
constexpr prepared_command prepare(const absolute_move& wanted, const cached_settings& cached) {
    prepared_command o = detail::move<positioning::absolute>(wanted.place, wanted.by, wanted.then, cached);
    o.needs = o.needs | requirement::homed;
    o.refusal = detail::first_error(o.refusal, detail::needs_homed(cached));
    return o;
}

/// Turns without end at a speed whose sign is the direction, -3000..3000 r/min. **No watchdog is documented:
/// if the line is lost, the motor runs on.** Offer `bounded_jog` to people. Refused while the motor moves:
/// stop first to change the speed. Section 4.2. Errors: as `move_by`; `not_reached` if the motor is at rest
/// again.
constexpr prepared_command prepare(const jog_velocity& wanted, const cached_settings& cached) {
    const auto count = detail::count_of<closed_loop::jog_speed>(wanted.target, cached);
    const auto rise = detail::count_of<jog_acceleration_time>(wanted.acceleration);
    const auto fall = detail::count_of<jog_deceleration_time>(wanted.deceleration);
    const errc standing = wanted.target.count() == 0 ? errc::out_of_range : errc::ok;
    return {.steps = routines::jog,
            .arguments = {count.word, rise.word, fall.word},
            .then = effect::jogged,
            .needs = at_rest_and_able,
            .refusal = detail::first_error(detail::needs_init_done(cached), standing, count.error, rise.error,
                                           fall.error)};
}

/// A jog that ends by itself: a way that must be ordered again and again. While a creep is under way it is
/// let be; when it has ended, the next command begins another. So the motor never runs on by more than `way`,
/// whatever becomes of the line and the program. To turn round or change the speed, stop first.
struct bounded_jog {
    distance way;
    motion_profile by{};
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::move<positioning::relative>(way, by, while_moving::ignore, cached);
        o.then = effect::crept;
        return o;
    }
};

namespace detail {
// Not constexpr on purpose: a constant that calls it does not compile, and the error names the rule.
inline void this_drive_has_no_such_homing_method() {}

template <class Device> constexpr bool has_method(homing m) {
    if constexpr (is_closed_loop<Device>) {
        return closed_loop::is_valid(m);
    } else {
        return open_loop::is_valid(m);
    }
}

constexpr prepared_command home(i16 method, distance offset, offset_handling then, duration limit,
                                const cached_settings& cached) {
    const word_pair words = words_of(offset, cached);
    return {.steps = routines::home,
            .arguments = {static_cast<std::uint16_t>(then), static_cast<std::uint16_t>(method), words.first,
                          words.second, cached.homing_speeds[0], cached.homing_speeds[1]},
            .then = effect::homed,
            .needs = at_rest_and_able,
            .is_absolute = true,
            .refusal =
                first_error(needs_init_done(cached), in_range(offset), in_range<homing_offset_mode>(then)),
            .limit = limit};
}
} // namespace detail

/// A homing method of a drive. A constant that the drive does not have does not compile; a run-time value
/// enters by name, `checked(m)`, and is refused then (`out_of_range`). The mechanical stops, whose directions
/// are not documented, enter as constants only.
template <class Device> class homing_choice {
  public:
    consteval homing_choice(homing constant)
        : method_{constant} { // NOLINT: implicit, `home{homing::home_24}`
        if (!detail::has_method<Device>(constant)) detail::this_drive_has_no_such_homing_method();
    }
    constexpr homing_choice(checked_value<homing> m) // NOLINT: implicit, `home{checked(m)}`
        : method_{m.value}, is_known_{number_of(m.value) > 0 && detail::has_method<Device>(m.value)} {}

    constexpr homing method() const { return method_; }
    constexpr errc error() const { return is_known_ ? errc::ok : errc::out_of_range; }

  private:
    homing method_;
    bool is_known_ = true;
};

/// Homes the axis at the speeds of `set_homing_profile` and waits until it is done, at most `limit`; beyond
/// that, or when it cannot be seen any more, it is ordered to stop. As in CiA 402 the position is zero
/// `offset` away from home, and the motor goes there, unless `then` says otherwise. Limit and home switches
/// are inputs: see `set_input`. Section 4.3. Errors: `not_executed` if it did not begin, `not_reached` if it
/// ended without finding home, `faulted`. An axis that was homed before counts as homed again only if the
/// drive's homed bit was seen to fall or the position is what `then` makes it [errata A54].
template <class Device> struct basic_home {
    using device = Device;
    homing_choice<Device> by;
    distance offset{};
    offset_handling then = offset_handling::move_position_zero;
    duration limit = milliseconds(60'000);
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::home(number_of(by.method()), offset, then, limit, cached);
        const errc profile = cached.has_homing_profile ? errc::ok : errc::wrong_state;
        o.refusal = detail::first_error(o.refusal, by.error(), profile);
        return o;
    }
};
namespace closed_loop {
using home = basic_home<device>;
}
namespace open_loop {
using home = basic_home<device>;
}

/// Says that the motor, where it stands, is at `place`; by homing method 35, without a motion. Section 4.3.
constexpr prepared_command prepare(const position_declaration& wanted, const cached_settings& cached) {
    prepared_command o = detail::home(number_of(homing::current_position), wanted.place,
                                      offset_handling::stay_position_offset, milliseconds(1'000), cached);
    o.has_target = true;
    o.target = wanted.place.count();
    return o;
}

/// Says that the drive's position is still valid, which was homed by a program before this one. Errors:
/// `needs_homing` if the drive reports no homing.
struct accept_position {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::accept_position,
                .then = effect::trusted,
                .needs = requirement::standing | requirement::enabled,
                .refusal = detail::needs_init_done(cached)};
    }
};

/// Sets the drive's position to zero, at standstill. That is no homing: a drive that was not homed is not
/// homed afterwards. Section 5.1.
struct clear_position {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::clear_position,
                .then = effect::position_cleared,
                .needs = requirement::standing,
                .refusal = detail::needs_init_done(cached)};
    }
};

/// Waits until the motor stands. Errors: `not_reached` after `limit`; `faulted`; `stopped_short` if a move was
/// commanded last and the motor is not at its target.
constexpr prepared_command prepare(const wait_standstill& wanted, const cached_settings& cached) {
    return {.steps = routines::wait_standstill,
            .refusal = detail::needs_init_done(cached),
            .limit = wanted.limit};
}

/// Waits for the end of the last move. Errors: `stopped_short` if the motor is at rest elsewhere than at its
/// target (`drive::arrival()` says how far from it, and why); `not_reached` after `limit`; `faulted`;
/// `wrong_state` without a move, or after one whose target is not known.
constexpr prepared_command prepare(const wait_reached& wanted, const cached_settings& cached) {
    return {.steps = routines::wait_reached,
            .then = effect::arrived,
            .refusal = detail::needs_init_done(cached),
            .limit = wanted.limit};
}

/// Reads error, status, terminals, position and speed in one frame; `drive::feedback` has them.
constexpr prepared_command prepare(read_feedback, const cached_settings& cached) {
    return {.steps = routines::feedback, .then = effect::seen, .refusal = detail::needs_init_done(cached)};
}

/// By which a take-over knows that it moves the motor, which its plan does not show.
template <class Device> void moves_or_energises(const basic_home<Device>*);

} // namespace servobus::yako
