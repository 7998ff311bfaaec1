// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: gives its terminals their functions for good. What the others do, hidden ones (DI5 to DI8, DO5, DO6,
// the virtual inputs P17) included, is read first: no function may be there twice.
// Source: manual V24.111, sections 6.4.1, 6.4.2, 7.3, 7.4.
//
//     using enum c630s::input_function;
//     if (!servo.run(c630s::wire_inputs{.di1 = positive_overtravel, .di2 = negative_overtravel})) return 1;
//     if (!servo.run(c630s::wire_outputs{.do1 = c630s::output_function::servo_ready})) return 1;
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/wiring.hpp>
#include <servobus/device/c630s/single_parameters.hpp>

namespace servobus::c630s {

namespace routines {
/// Four terminals: function, logic, function ... The shift chooses the first.
inline constexpr step look_at_four[] = {
    steps::element(steps::fetch<di1_function, di1_logic, di2_function, di2_logic, di3_function, di3_logic,
                                di4_function, di4_logic>(0))};
/// Two, since there are six outputs.
inline constexpr step look_at_two[] = {
    steps::element(steps::fetch<di1_function, di1_logic, di2_function, di2_logic>(0))};
inline constexpr step open_keeping[] = {inputs_are_off, must_stand, keep, are_kept};
/// After a restart the write would not go into the EEPROM.
inline constexpr step keep_word[] = {are_kept, steps::element(steps::write_arguments<target_speed>()),
                                     steps::element(steps::expect_arguments<target_speed>())};
} // namespace routines

namespace detail {
/// The parts of a wiring. Each is refused unless the servo is off.
struct look_at_terminals {
    std::uint16_t first;
    bool are_four;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = are_four ? routine{routines::look_at_four} : routine{routines::look_at_two},
                .refusal = needs_servo_off(cached),
                .shift = as_word(first - di1_function.address)};
    }
};
struct open_keeping {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {
            .steps = routines::open_keeping, .then = effect::assigned, .refusal = needs_servo_off(cached)};
    }
};
struct keep_function {
    std::uint16_t address;
    std::uint16_t function;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::keep_word,
                .arguments = {function},
                .then = effect::assigned,
                .refusal = needs_servo_off(cached),
                .shift = as_word(address - target_speed.address)};
    }
};
struct close_keeping {
    bool was_done;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = was_done ? routine{routines::end_keeping} : routine{routines::give_up_keeping},
                .then = effect::assigned,
                .refusal = needs_servo_off(cached)};
    }
};

/// The wired terminals of one kind, `Count` of them from `First` on, and the rivals after them, `Rivals` from
/// `FirstRival` on. Each has two registers, function and logic.
template <std::uint16_t First, std::size_t Count, std::uint16_t FirstRival, std::size_t Rivals>
struct wiring_of {
    static constexpr std::uint16_t address(std::size_t i) { return after(First, i); }

    template <class Drive, class Run>
    static constexpr command_status run(commands::wiring& all, const Drive& drive, Run& run_part) {
        if (const std::size_t i = all.twice(); i != all.nowhere)
            return refused(errc::bad_argument, address(i));
        for (std::size_t i = 0; i < Count;) {
            const std::size_t some = Count - i < 4 ? 2 : 4;
            const command_status looked = run_part(look_at_terminals{address(i), some == 4});
            if (!looked) return looked.at_terminal(address(i));
            for (std::size_t k = 0; k < some; ++k, ++i) all.hold(i, word_of(drive, 2 * k));
        }
        for (std::size_t i = 0; i < Rivals;) {
            const command_status looked = run_part(look_at_terminals{after(FirstRival, i), true});
            if (!looked) return looked.at_terminal(after(FirstRival, i));
            for (std::size_t k = 0; k < 4; ++k, ++i) {
                if (all.place_of(word_of(drive, 2 * k)) != all.nowhere)
                    return refused(errc::already_assigned, after(FirstRival, i));
            }
        }
        if (all.is_as_wanted()) return {};
        if (const command_status opened = run_part(open_keeping{}); !opened) return opened;
        std::uint16_t at = 0;
        const command_status how = all.each([&](std::size_t i, std::uint16_t function) {
            at = address(i);
            return run_part(keep_function{at, function});
        });
        const command_status closed = run_part(close_keeping{static_cast<bool>(how)});
        if (how && !closed)
            (void)run_part(close_keeping{false}); // it may be the look before it that was refused
        if (!how) return how.at_terminal(at);
        return closed;
    }
    static constexpr command_status refused(errc why, std::uint16_t at) {
        return command_status{why}.at_terminal(at);
    }

  private:
    static constexpr std::uint16_t after(std::uint16_t first, std::size_t terminals) {
        return static_cast<std::uint16_t>(first + 2 * terminals);
    }
    template <class Drive> static constexpr std::uint16_t word_of(const Drive& drive, std::size_t i) {
        return drive.machine().slot().run().words()[i];
    }
};
using wiring_of_inputs =
    wiring_of<di1_function.address, 8, virtual_input_functions.first.address, virtual_input_functions.size>;
using wiring_of_outputs = wiring_of<do1_function.address, 6, 0, 0>;
} // namespace detail

/// Gives wired inputs their functions, P03-02 to P03-16, for good; with the servo off. Inputs that are not named keep
/// theirs, but for one that another input is to have: it is freed first. The writes are one session of P0C-13 = 1, and
/// nothing is written if all is so already. It takes effect when the motor stops next. Waits.
///
/// Errors, at `register_address()`:
/// - `bad_argument`: one function is named twice; nothing was sent
/// - `out_of_range`: there is no such function, or it is servo-on, which only a command gives; nothing was sent
/// - `already_assigned`: a virtual input has the function (P17), by which the facade commands the drive, or another
///   program's; nothing was written
/// - `needs_init`, `wrong_state`: as of `keep`; otherwise the drive's own. P0C-13 is 0 again unless the line has
///   failed.
struct wire_inputs {
    wired<input_function> di1{};
    wired<input_function> di2{};
    wired<input_function> di3{};
    wired<input_function> di4{};
    wired<input_function> di5{};
    wired<input_function> di6{};
    wired<input_function> di7{};
    wired<input_function> di8{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive& drive, Run&& run) const {
        using all_of = detail::wiring_of_inputs;
        const std::uint16_t words[]{di1.word(), di2.word(), di3.word(), di4.word(),
                                    di5.word(), di6.word(), di7.word(), di8.word()};
        commands::wiring all{words};
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto does = static_cast<input_function>(all.wanted(i));
            const bool is_wrong =
                does == input_function::servo_on || detail::in_range<di1_function>(does) != errc::ok;
            if (all.is_named(i) && is_wrong) return all_of::refused(errc::out_of_range, all_of::address(i));
        }
        return all_of::run(all, drive, run);
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return detail::refused(errc::bad_argument);
    }
};

/// Gives wired outputs their functions, P04-00 to P04-10, for good; as `wire_inputs`. A virtual output may show what a
/// wired one shows.
struct wire_outputs {
    wired<output_function> do1{};
    wired<output_function> do2{};
    wired<output_function> do3{};
    wired<output_function> do4{};
    wired<output_function> do5{};
    wired<output_function> do6{};

    static constexpr bool is_made_of_commands = true;
    template <class Drive, class Run> constexpr command_status run_by(const Drive& drive, Run&& run) const {
        using all_of = detail::wiring_of_outputs;
        const std::uint16_t words[]{do1.word(), do2.word(), do3.word(), do4.word(), do5.word(), do6.word()};
        commands::wiring all{words};
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto does = static_cast<output_function>(all.wanted(i));
            if (all.is_named(i) && detail::in_range<do1_function>(does) != errc::ok)
                return all_of::refused(errc::out_of_range, all_of::address(i));
        }
        return all_of::run(all, drive, run);
    }
    template <class Known> constexpr prepared_command prepare(const Known&) const {
        commands::is_run_by_a_facade<Known>();
        return detail::refused(errc::bad_argument);
    }
};

} // namespace servobus::c630s
