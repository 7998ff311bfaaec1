// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Adds an axis to the facade of a drive: the commands of control/axis_commands.hpp, and the drive's feedback in lengths
// and speeds of the machine. The `axis_drive` of each device derives from it.
//
//     template <class Drive> bool is_above(const axis_facade<Drive>& lift, micrometres place) {
//         const result<micrometres> there = lift.position(milliseconds(100));
//         return there && *there > place;
//     }
#pragma once

#include <servobus/axis/axis_place.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

namespace detail {
template <class Wanted, class Settings>
concept axis_planned = requires(const Wanted& wanted, const axis_place& at, const Settings& known) {
    plan_on_axis(wanted, at, known);
};
/// A command with the place of the axis that it is of.
template <class Wanted> struct command_of_axis {
    const axis_place& at;
    const Wanted& wanted;

    template <class Settings> constexpr auto prepare(const Settings& known) const {
        return plan_on_axis(wanted, at, known);
    }
};
} // namespace detail

/// A drive whose model has an `axis_place`. The axis is referred to.
template <class Drive> class axis_facade : public Drive {
  public:
    using settings = typename Drive::settings;

    /// The axis that the drive moves.
    constexpr const axis& geometry() const { return this->model().place().geometry(); }

    /// As the drive's own, also for the commands of an axis.
    template <class Wanted> [[gnu::always_inline]] command_status run(const Wanted& wanted) {
        if constexpr (detail::axis_planned<Wanted, settings>) {
            return Drive::run(with_geometry(wanted));
        } else {
            return Drive::run(wanted);
        }
    }
    /// Runs a command that is made of others, such as `take_over`. Waits. Returns which of them failed, and how.
    template <commands::made_of_commands Wanted> command_status run(const Wanted& wanted) {
        return wanted.run_by(*this, [this](const auto& part) { return this->run(part); });
    }
    template <class Wanted> [[gnu::always_inline]] constexpr command_status begin(const Wanted& wanted) {
        if constexpr (detail::axis_planned<Wanted, settings>) {
            return Drive::begin(with_geometry(wanted));
        } else {
            return Drive::begin(wanted);
        }
    }
    /// Runs a move and waits for its end. Returns how that was; `none` if the move did not begin, as `last` says.
    template <class Move> axis_arrival run(const Move& move, const wait_reached& end) {
        commands::check_target<Move>();
        if (!run(move)) return {};
        (void)run(end);
        return arrival();
    }
    /// Where the last move has come to, as the drive's own.
    constexpr axis_arrival arrival() const {
        const auto a = Drive::arrival();
        const std::int32_t counts = a.missing.count();
        return {a.how, a.cause, geometry().length_of(counts).value_or(micrometres{})};
    }
    constexpr axis_arrival arrival(const wait_reached&) const { return arrival(); }

    /// Where the axis is, by feedback that is at most `oldest` old. It goes on where the drive's own position wraps,
    /// and is counted from elsewhere after `init`, a restart, a homing, `declare_position`. Errors: as `feedback`.
    constexpr result<micrometres> position(duration oldest) const {
        const auto seen = Drive::feedback(oldest);
        if (!seen) return seen.error();
        return this->model().place().length();
    }
    /// The speed of the axis, likewise.
    constexpr result<micrometres_per_second> speed(duration oldest) const {
        const auto seen = Drive::feedback(oldest);
        if (!seen) return seen.error();
        return geometry().speed_of(seen->speed);
    }

    /// A command of an axis with this one, as `why` asks for it.
    template <class Wanted>
    requires detail::axis_planned<Wanted, settings>
    constexpr detail::command_of_axis<Wanted> with_geometry(const Wanted& wanted) const {
        return {this->model().place(), wanted};
    }

  protected:
    template <class... Arguments>
    constexpr explicit axis_facade(const axis& of, Arguments&&... arguments) : Drive{arguments...} {
        this->model().place() = axis_place{of};
    }
    ~axis_facade() = default;
};

} // namespace servobus
