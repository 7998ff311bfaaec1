// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: gives their terminals their functions. What the other inputs do is read first: a function is
// at one input. `save` keeps it. Source: manual V2.6.0, section 5.2.
//
//     using enum yako::input_function;
//     if (!axis.run(yako::wire_inputs{.x0 = home, .x1 = positive_limit, .x2 = negative_limit})) return 1;
//     if (!axis.run(yako::wire_outputs{.y0 = yako::output_function::brake}) || !axis.run(yako::save{})) return 1;
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/wiring.hpp>
#include <servobus/device/yako/parameters.hpp>

namespace servobus::yako {

namespace routines {
inline constexpr step look_at_four_inputs[] = {
    same_drive, may_act, steps::fetch<x0_function, x1_function, x2_function, x3_function>(0)};
inline constexpr step look_at_seven_inputs[] = {
    same_drive, may_act,
    steps::fetch<x0_function, x1_function, x2_function, x3_function, open_loop::x4_function,
                 open_loop::x5_function, open_loop::x6_function>(0)};
} // namespace routines

namespace detail {
/// Reads what the inputs do. As a wiring goes on only if the motor is free, it is refused otherwise.
struct look_at_inputs {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = cached.is_closed_loop ? routine{routines::look_at_four_inputs}
                                               : routine{routines::look_at_seven_inputs},
                .needs = requirement::standing | requirement::released,
                .refusal = needs_init_done(cached)};
    }
};
constexpr command_status refused_at(errc why, unsigned terminal) {
    return command_status{why}.at_terminal(static_cast<std::uint16_t>(terminal));
}
} // namespace detail

/// Gives inputs their functions, 0041h to 0047h, while the motor is free and stands. Inputs that are not named keep
/// theirs, but for one that another input is to have: it is freed first, since two inputs with one function contradict
/// each other. Nothing is written if all is so already. Waits.
///
/// Errors, at `register_address()`:
/// - `bad_argument`: one function is named twice, or the drive has no such input (closed loop: up to X3); nothing was
///   sent
/// - `out_of_range`: there is no such function; nothing was sent
/// - `needs_init`, `wrong_state`, `busy`: as of `set_input`; otherwise the drive's own
struct wire_inputs {
    wired<input_function> x0{};
    wired<input_function> x1{};
    wired<input_function> x2{};
    wired<input_function> x3{};
    wired<input_function> x4{};
    wired<input_function> x5{};
    wired<input_function> x6{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive& drive, Run&& run) const {
        constexpr std::size_t inputs = Drive::model_type::is_closed_loop ? 4 : 7;
        const std::uint16_t words[]{x0.word(), x1.word(), x2.word(), x3.word(),
                                    x4.word(), x5.word(), x6.word()};
        commands::wiring all{words};
        for (std::size_t i = 0; i < all.size(); ++i) {
            const errc wrong = i < inputs
                                   ? detail::in_range<x0_function>(static_cast<input_function>(all.wanted(i)))
                                   : errc::bad_argument;
            if (all.is_named(i) && wrong != errc::ok) return detail::refused_at(wrong, address(i));
        }
        if (const std::size_t i = all.twice(); i != all.nowhere)
            return detail::refused_at(errc::bad_argument, address(i));
        if (const command_status looked = run(detail::look_at_inputs{}); !looked) return looked;
        for (std::size_t i = 0; i < inputs; ++i) all.hold(i, drive.machine().slot().run().words()[i]);
        std::uint16_t at = 0;
        const command_status how = all.each([&](std::size_t i, std::uint16_t function) {
            at = address(i);
            return run(set_input{static_cast<input_terminal>(i), static_cast<input_function>(function)});
        });
        return how ? how : how.at_terminal(at);
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return {.steps = no_steps};
    }

  private:
    static constexpr std::uint16_t address(std::size_t i) {
        return static_cast<std::uint16_t>(x0_function.address + i);
    }
};

/// Gives outputs their functions, 004Ch to 004Eh; several may show one. Waits. Errors: as of `set_output`, at
/// `register_address()`; nothing is sent of an output after it.
struct wire_outputs {
    wired<output_function> y0{};
    wired<output_function> y1{};
    wired<output_function> y2{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive&, Run&& run) const {
        const wired<output_function> all[]{y0, y1, y2};
        for (unsigned i = 0; i < 3; ++i) {
            if (all[i].word() == wired<output_function>::as_it_is) continue;
            const set_output one{static_cast<output_terminal>(i),
                                 static_cast<output_function>(all[i].word())};
            if (const command_status how = run(one); !how)
                return how.at_terminal(static_cast<std::uint16_t>(y0_function.address + i));
        }
        return {};
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return {.steps = no_steps};
    }
};

} // namespace servobus::yako
