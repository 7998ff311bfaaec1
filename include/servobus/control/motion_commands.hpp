// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands of motion, one word each. Their unit names the owner of the numbers: pulses, reference units and r/min
// are the drive's, lengths the axis'. Each device lists in its `commands.hpp` the forms that it takes; another one does
// not compile. Programs get them with the header of a device.
//
//     (void)wheels.run(velocity{30 * r_per_min, -30 * r_per_min}); // a ZLAC8015D: left, right
//     (void)axis.run(move_to{5000 * pulse});                       // a YAKO, by the profile that it holds
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/control/command.hpp>
#include <servobus/core/time.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
// A command keeps one type for all lengths, one for all speeds of an axis, one for all pulses, one for all times. A
// speed of a motor stays as it was written: its drive converts it (`in_units_of`).
template <class T> struct kept_type { using type = T; };
template <unit U, class Rep> struct kept_type<quantity<U, Rep>> {
    template <class Kept> static constexpr auto exactly() {
        constexpr bool is_exact = std::convertible_to<quantity<U, Rep>, Kept>;
        static_assert(is_exact, "this quantity is finer than a count of the command: it would be rounded");
        if constexpr (is_exact)
            return Kept{};
        else
            return quantity<U, Rep>{}; // no second error follows
    }
    static constexpr auto choose() {
        if constexpr (same_kind(U, units::micrometre))
            return exactly<quantity<unit{measure::micrometre}, std::int64_t>>();
        else if constexpr (same_kind(U, units::micrometre_per_second))
            return exactly<quantity<unit{measure::micrometre_per_second}, std::int32_t>>();
        else if constexpr (same_kind(U, units::pulse))
            return exactly<quantity<units::pulse, std::int32_t>>();
        else if constexpr (same_kind(U, units::reference_unit))
            return exactly<quantity<units::reference_unit, std::int32_t>>();
        else if constexpr (same_kind(U, units::millisecond))
            return exactly<quantity<units::millisecond, std::int32_t>>();
        else
            return quantity<U, Rep>{};
    }
    using type = decltype(choose());
};
template <class T> using kept = typename kept_type<std::remove_cvref_t<T>>::type;
// Not constexpr on purpose: a constant that calls it does not compile, and the error names the rule.
inline void the_lowest_place_stands_before_the_highest() {}
template <class T>
concept a_period = std::convertible_to<T, duration>;
} // namespace detail

/// Moves to a place.
template <class... What> struct move_to;
template <class Place> struct move_to<Place> { Place place; };
template <class Place, class Profile> struct move_to<Place, Profile> {
    Place place;
    Profile by{};
};
template <class Place> struct move_to<Place, Place> {
    Place left;
    Place right;
};
template <class Place, class Profile, class Then> struct move_to<Place, Profile, Then> {
    Place place;
    Profile by{};
    Then then{};
};
template <class... What> move_to(What...) -> move_to<detail::kept<What>...>;

/// Moves by a way; its sign is the direction.
template <class... What> struct move_by;
template <class Way> struct move_by<Way> { Way way; };
template <class Way, class Profile> struct move_by<Way, Profile> {
    Way way;
    Profile by{};
};
template <class Way> struct move_by<Way, Way> {
    Way left;
    Way right;
};
template <class Way, class Profile, class Then> struct move_by<Way, Profile, Then> {
    Way way;
    Profile by{};
    Then then{};
};
template <class... What> move_by(What...) -> move_by<detail::kept<What>...>;

/// Turns or moves at a speed until another command; its sign is the direction.
template <class... What> struct velocity;
template <class Speed> struct velocity<Speed> { Speed target; };
template <class Left, class Right> struct velocity<Left, Right> {
    Left left{};
    Right right{};

    constexpr velocity() = default;
    constexpr velocity(Left l, Right r) : left{l}, right{r} {} // not one of both
};
template <class Speed, class Rise, class Fall> struct velocity<Speed, Rise, Fall> {
    Speed target;
    Rise acceleration;
    Fall deceleration;
};
template <class... What> velocity(What...) -> velocity<detail::kept<What>...>;

/// Turns or moves at a speed while the program repeats the command, as while a button is held; `halt` ends it. One
/// without a period of its own needs a command timeout.
template <class... What> struct hold;
template <class Speed> struct hold<Speed> {
    static constexpr bool needs_command_timeout = true;
    Speed target;
};
template <class Left, class Right> struct hold<Left, Right> {
    static constexpr bool needs_command_timeout = true;
    Left left{};
    Right right{};

    constexpr hold() = default;
    constexpr hold(Left l, Right r) : left{l}, right{r} {}
};
template <class Speed> struct hold<Speed, runs_on_without_line> {
    static constexpr bool needs_command_timeout = true;
    Speed target;
    runs_on_without_line consent;
};
template <class Speed> struct hold<Speed, duration> {
    Speed target;
    duration every; ///< the longest time from one command to the next
};
template <class Speed, class Rise, class Fall> struct hold<Speed, duration, Rise, Fall> {
    Speed target;
    duration every; ///< the longest time from one command to the next
    Rise acceleration;
    Fall deceleration;
};
template <class... What> hold(What...) -> hold<detail::kept<What>...>;
template <class Speed, detail::a_period Period> hold(Speed, Period) -> hold<detail::kept<Speed>, duration>;
template <class Speed, detail::a_period Period, class Rise, class Fall>
hold(Speed, Period, Rise, Fall)
    -> hold<detail::kept<Speed>, duration, detail::kept<Rise>, detail::kept<Fall>>;

/// Limits the travel by software. Errors: `bad_argument` if `lowest` is not below `highest`; of constants it does not
/// compile.
template <class Place> struct limit_travel {
    Place lowest;
    Place highest;

    constexpr limit_travel(std::type_identity_t<Place> low, std::type_identity_t<Place> high)
        : lowest{low}, highest{high} {
        if (std::is_constant_evaluated() && !(low < high))
            detail::the_lowest_place_stands_before_the_highest();
    }
};
template <class Lowest, class Highest>
requires std::same_as<detail::kept<Lowest>, detail::kept<Highest>> limit_travel(Lowest, Highest)
->limit_travel<detail::kept<Lowest>>;

/// Says that the motor, where it is at rest, is at `place`. Nothing moves.
template <class Place> struct declare_position { Place place; };
template <class Place> declare_position(Place) -> declare_position<detail::kept<Place>>;

namespace detail {
// A motion that no target ends: nothing waits for its arrival.
template <class Command> inline constexpr bool has_no_target = false;
template <class... What> inline constexpr bool has_no_target<velocity<What...>> = true;
template <class... What> inline constexpr bool has_no_target<hold<What...>> = true;
} // namespace detail

// No take-over has them.
template <class... What> void moves_or_energises(const move_to<What...>*);
template <class... What> void moves_or_energises(const move_by<What...>*);
template <class... What> void moves_or_energises(const velocity<What...>*);
template <class... What> void moves_or_energises(const hold<What...>*);
template <class Place> void neither_moves_nor_energises(const limit_travel<Place>*);
template <class Place> void neither_moves_nor_energises(const declare_position<Place>*);

namespace commands {
/// A command that is waited for has a target.
template <class Command> constexpr void check_target() {
    static_assert(!servobus::detail::has_no_target<Command>,
                  "a speed has no target, so nothing waits until it is reached");
}

/// A quantity in the unit that a drive counts in. What would have to be rounded does not compile.
template <class Own, unit U, class Rep> [[gnu::always_inline]] constexpr Own exactly(quantity<U, Rep> value) {
    constexpr bool is_same_kind = servobus::detail::same_kind(U, Own::unit_of_count);
    static_assert(is_same_kind, "this drive has no such command: it counts another kind of quantity");
    constexpr bool is_exact = std::convertible_to<quantity<U, Rep>, Own>;
    static_assert(is_exact || !is_same_kind,
                  "this quantity is finer than a count of the drive: it would be rounded");
    if constexpr (is_exact)
        return value;
    else
        return Own{};
}
} // namespace commands

} // namespace servobus
