// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the commands that set it up: ramps, brakes, stop options, positions cleared,
// parameters saved and restored, watchdog, speed resolution. servobus/device/zlac8015d.hpp includes it.
// Source: RS485 manual V1.07, sections 3.2, 3.3, 3.6, 3.7 and 4.
//
//     if (!wheels.run(zlac8015d::ramps{800 * millisecond, 500 * millisecond})) return 1;
//     if (!wheels.run(zlac8015d::watchdog{500 * millisecond})) return 1; // it stops without requests
//     if (!wheels.run(zlac8015d::save{})) return 1;                      // in the EEPROM; while disabled
#pragma once

#include <cstdint>

#include <servobus/device/zlac8015d/prepared_command.hpp>

namespace servobus::zlac8015d {

/// Acceleration and deceleration times of both wheels, 0..32767 ms.
struct ramps {
    time acceleration;
    time deceleration;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o =
            detail::set_pair<left_acceleration_time>(routines::ramps, acceleration, deceleration, cached);
        o.arguments = {o.arguments[0], o.arguments[0], o.arguments[1], o.arguments[1]};
        return o;
    }
};

/// Deceleration time of the quick stop, both wheels, 0..32767 ms.
struct quick_stop_ramp {
    time deceleration;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_pair<left_quick_stop_time>(routines::quick_stop_ramp, deceleration, deceleration,
                                                      cached);
    }
};

/// What a quick stop does, 2011h.
struct quick_stop_by {
    quick_stop_option option;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::quick_stop_by,
                .arguments = {static_cast<std::uint16_t>(option)},
                .refusal = detail::first_error(detail::needs_init_done(cached),
                                               detail::in_range<quick_stop_option_code>(option))};
    }
};

/// Slope of the torque targets, both wheels, mA/s.
struct torque_slope {
    current_slope slope;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_pair<left_torque_slope>(routines::torque_slope, slope, slope, cached);
    }
};

/// Top speeds of the position modes, whole r/min, 1..1000.
struct position_speed {
    speed left;
    speed right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_pair<left_max_speed>(routines::position_speed, left, right, cached);
    }
};

/// Sets the brake outputs, 201Ah and 201Bh. Section 3.6. Which code holds the shaft is not known, see
/// `brake`.
struct brakes {
    brake left;
    brake right;

    constexpr brakes(brake at_left, brake at_right) : left{at_left}, right{at_right} {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::brakes,
                .arguments = {static_cast<std::uint16_t>(left), static_cast<std::uint16_t>(right)},
                .refusal = detail::first_error(detail::needs_init_done(cached),
                                               detail::first_error(detail::in_range<left_brake>(left),
                                                                   detail::in_range<right_brake>(right)))};
    }
};

/// What the shafts do after the emergency-stop input, 2021h. Section 3.7.
struct on_input_stop {
    input_stop_action action;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::input_stop,
                .arguments = {static_cast<std::uint16_t>(action)},
                .refusal = detail::first_error(detail::needs_init_done(cached),
                                               detail::in_range<input_stop>(action))};
    }
};

/// Parking mode, 200Ch.
struct park {
    off_on parking;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::parking,
                .arguments = {static_cast<std::uint16_t>(parking)},
                .refusal = detail::first_error(detail::needs_init_done(cached),
                                               detail::in_range<parking_mode>(parking))};
    }
};

/// Makes the present places of these wheels zero, at standstill: of the feedback, 2005h, and of the absolute mode,
/// 2006h, in one frame. Where only one of them was set, by a client or another program, absolute moves end
/// `stopped_short` though the wheels are at their targets.
struct clear_position {
    wheels of = wheels::both;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto which = static_cast<std::uint16_t>(of);
        return {.steps = routines::clear_positions,
                .arguments = {which, which},
                .then = effect::positions_cleared,
                .refusal = detail::first_error(detail::needs_init_done(cached),
                                               detail::in_range<clear_feedback_position>(of))};
    }
};

/// Keeps all parameters marked RW/S in EEPROM, 2010h = 1; at standstill, disabled. Writes 2010h = 0 after it, since 1
/// may be a mode in which each later write is kept too [errata B11]. Writes mode 0 first, which the
/// next `enable` sets anew: a drive that saves every row that can be written would keep a mode, and a restart
/// could not be told by it [errata B11]. A mode that another program has saved is kept until this is run
/// once. Errors: `wrong_state` while enabled, `unexpected_value` if the mode does not change, since a wheel
/// turns.
struct save {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::save, .refusal = detail::needs_disabled(cached)};
    }
};

using servobus::sole_drive_on_the_line;

/// Restores the factory's parameters, 2009h; at standstill, disabled. Initialise again afterwards: address,
/// baud rate and scales may have changed. Where 2022h was not the factory's the state is `needs_power_cycle`, as after
/// `resolution`.
struct factory_reset {
    constexpr explicit factory_reset(sole_drive_on_the_line) {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_rescaled = cached.resolution != speed_resolution.initial;
        return {.steps = is_rescaled ? routine{routines::reset_resolution} : routine{routines::factory_reset},
                .then = is_rescaled ? effect::rescaled : effect::forgotten,
                .refusal = detail::needs_disabled(cached)};
    }
};

/// The drive's own watchdog, 2000h: it stops the motors after this long without a request; up to 32767 ms, at
/// least what one lost frame costs (182 ms with the default limits of its node). 0 is refused: its meaning is
/// not documented, and perhaps nothing stops the motors then, or nothing moves [errata B28].
/// `watchdog{undocumented_zero{}}` writes it; the facade counts it as the factory's second.
struct watchdog {
    time limit;
    bool is_zero_by_name = false;

    constexpr watchdog(time after) : limit{after} {} // NOLINT: implicit, as a quantity converts to a time
    constexpr explicit watchdog(undocumented_zero) : limit{}, is_zero_by_name{true} {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        auto ms = detail::count_in<host_timeout>(limit);
        if (is_zero_by_name) ms.error = errc::ok;
        return {.steps = routines::set_host_timeout,
                .arguments = {detail::as_word(ms.count)},
                .then = effect::timeout_set,
                .refusal = detail::first_error(detail::needs_init_done(cached), ms.error)};
    }
};

/// Resolution of commanded speeds, 2022h: 1/n r/min, n = 1..10; at standstill, disabled. A drive that has it keeps it,
/// and nothing is written. Another value is written and saved, which wears the EEPROM once, and counts from the next
/// power-on [errata B21]. The state is `needs_power_cycle` then. Neither an enable nor a speed is possible before an
/// `init` has found that the power was off. Speeds that are ordered through the drive follow the new value.
///
///     if (wheels.state() == drive_state::needs_power_cycle) std::puts("power the drive off and on, then init");
///
/// A value that a client or another program has written is taken as it is found. It counts only if the power was off
/// since, which no register shows. The facade finds a power-on by the mode 200Dh: a client does not write it meanwhile.
struct resolution {
    std::uint16_t n;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const errc wrong = speed_resolution.limits.contains(n) ? errc::ok : errc::out_of_range;
        const bool is_so = n == cached.resolution;
        return {.steps = is_so ? routine{routines::same_resolution} : routine{routines::set_resolution},
                .arguments = {n},
                .then = is_so ? effect::none : effect::rescaled,
                .refusal = detail::first_error(detail::needs_disabled(cached), wrong)};
    }
};

} // namespace servobus::zlac8015d
