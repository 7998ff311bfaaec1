// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: gives its terminals their functions. `save` keeps it.
// Source: RS485 manual V1.07, sections 3.6, 3.7 and 4.
//
//     using zlac8015d::input_function, zlac8015d::output_function;
//     if (!wheels.run(zlac8015d::wire_inputs{.x0 = input_function::undefined})) return 1; // a stop from the factory
//     if (!wheels.run(zlac8015d::wire_outputs{.y0 = output_function::alarm})) return 1;
//     if (!wheels.run(zlac8015d::save{})) return 1;
#pragma once

#include <cstdint>

#include <servobus/control/wiring.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>

namespace servobus::zlac8015d {

namespace detail {
/// Sets the function of terminal `R`, if it is named.
template <const auto& R, class Function, class Run>
constexpr command_status wire(const wired<Function>& to, Run& run) {
    if (to.word() == wired<Function>::as_it_is) return {};
    const command_status how = run(set<R>{checked(static_cast<Function>(to.word()))});
    return how ? how : how.at_terminal(R.address);
}
} // namespace detail

/// Gives the inputs their functions, 2017h and 2018h; while disabled, at standstill. Both may stop the drive. An input
/// that is not named keeps its function. Waits. Errors: as of `set`, at `register_address()`.
struct wire_inputs {
    wired<input_function> x0{};
    wired<input_function> x1{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive&, Run&& run) const {
        const command_status first = detail::wire<x0_function>(x0, run);
        return first ? detail::wire<x1_function>(x1, run) : first;
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return {.steps = no_steps};
    }
};

/// Gives the outputs their functions, 201Ch and 201Dh; likewise. Both may show one. The brakes have outputs of their
/// own.
struct wire_outputs {
    wired<output_function> y0{};
    wired<output_function> y1{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive&, Run&& run) const {
        const command_status first = detail::wire<y0_function>(y0, run);
        return first ? detail::wire<y1_function>(y1, run) : first;
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return {.steps = no_steps};
    }
};

} // namespace servobus::zlac8015d
