// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands that set one parameter of a drive by its row. Each drive has a rule for each row: whether a command may
// set it, and in which states of the drive. The header of a device includes it, and has them in the device's namespace.
//
//     if (!wheels.run(zlac8015d::set<zlac8015d::left_max_current>{12 * ampere})) return 1; // read back
//     if (!wheels.run(zlac8015d::save{})) return 1;                                       // kept, with all others
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/registers/cached_registers.hpp>
#include <servobus/registers/register_value.hpp>

namespace servobus::detail {
struct no_command {
    template <class Command> operator Command() const; // NOLINT: a drive's own; never called
};
} // namespace servobus::detail

namespace servobus::commands {

/// Sets the parameter of row `R` until the power goes, and reads it back. What the facade caches of it follows.
///
/// A row that another command sets does not compile, and its error names the command. Neither do read-only rows,
/// triggers, targets, settings of the line and rows of another device.
///
/// Errors:
/// - `out_of_range`, `inexact`: those of the value; nothing was sent
/// - `needs_init`, `wrong_state`, `busy`: the drive does not take it in its state; nothing was written
/// - `exception`: the drive refuses it
/// - `unexpected_value`: the register holds another value afterwards
template <const auto& R> struct set {
    using device = typename row_type<R>::device;
    static constexpr bool changes_cached_settings =
        is_cached_by_facade<device>(R.address, row_type<R>::words);
    register_value<R> value;
};

/// Sets the parameter of row `R` for good, and reads it back: of a drive that keeps single parameters
/// (`traits.keeps_single_parameters`). Of others it does not compile: `set` the rows, then `save`. Errors: as of `set`.
template <const auto& R> struct keep {
    using device = typename row_type<R>::device;
    static constexpr bool changes_cached_settings =
        is_cached_by_facade<device>(R.address, row_type<R>::words);
    register_value<R> value;
};

/// Refuses a read-only row: its `register_value` does not compile. No other error follows, since nothing is prepared.
template <const auto& R>
requires(row_type<R>::rights == access::ro) struct set<R> {
    register_value<R> value;
    template <class Known> constexpr auto prepare(const Known&) const {
        return servobus::detail::no_command{};
    }
};

/// For the rules of a drive: true for one of these rows.
template <const auto& R, const auto&... Rs>
inline constexpr bool is_one_of = ((R.address == Rs.address) || ...);

} // namespace servobus::commands
