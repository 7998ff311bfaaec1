// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The steps of which a drive's control routine is a table that reads like the manual's: write, expect,
// wait, fetch. The compiler checks them against the registers' rows; a facade runs them. The `routines.hpp`
// of each device includes it, and so does the author of a drive.
//
//     inline constexpr step set_left_ramp[] = {
//         steps::expect_zero<zlac8015d::status_word>(errc::busy, zlac8015d::status_flags::running_bits),
//         steps::write_arguments<zlac8015d::left_acceleration_time>(),
//         steps::expect_arguments<zlac8015d::left_acceleration_time>(), // read back
//     };
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/control/step.hpp>
#include <servobus/control/stop_words.hpp>
#include <servobus/registers/block.hpp>

/// The builders of steps. `R` and `Rs` are rows; several must be adjacent, since a step is one frame.
namespace servobus::steps {

namespace detail {
// Not constexpr on purpose: a step that calls one does not compile, and the error names the rule.
inline void a_step_writes_at_most_6_words() {}
inline void a_step_takes_its_words_from_the_6_arguments() {}
inline void a_step_fetches_into_the_routine_s_16_words() {}
inline void a_repeatable_step_writes_a_constant() {}
inline void a_repeatable_step_stops_the_drive_see_stop_words() {}
inline void a_step_after_a_stop_is_a_stop() {}
inline void a_step_is_of_adjacent_registers() {}
inline void a_step_is_one_short_frame() {}
inline void a_step_writes_no_read_only_register() {}
inline void a_step_reads_no_write_only_register() {}
inline void a_step_has_no_value_that_its_register_refuses() {}
inline void a_constant_of_two_words_needs_the_word_order_of_the_profile() {}
inline void bits_of_a_step_lie_in_one_word_of_its_register() {}
inline void a_step_compares_16_bits_of_registers_of_one_word() {}

// Takes the rows' data and not their types: fewer instances for the compiler.
constexpr step make_of(step::kind what, std::uint8_t slot, const extent* rows, std::size_t count,
                       std::size_t most) {
    if (!servobus::detail::are_adjacent(rows, count)) a_step_is_of_adjacent_registers();
    std::size_t words = 0;
    for (std::size_t i = 0; i < count; ++i) words += rows[i].words;
    if (words > most || words > longest) a_step_is_one_short_frame();
    if (what == step::kind::write && words > max_arguments) a_step_writes_at_most_6_words();
    if (what == step::kind::fetch) {
        if (slot + words > max_words) a_step_fetches_into_the_routine_s_16_words();
    } else if (slot < step::pair && slot + words > max_arguments) {
        a_step_takes_its_words_from_the_6_arguments();
    }
    const step s{.what = what,
                 .is_repeatable = false,
                 .is_after_stop = false,
                 .is_element = false,
                 .is_setpoint = false,
                 .is_within = false,
                 .count = static_cast<std::uint8_t>(words),
                 .slot = slot,
                 .otherwise = errc::unexpected_value,
                 .address = rows[0].address,
                 .value = 0,
                 .mask = 0xFFFF,
                 .limit_ms = 0};
    return s;
}
template <class T, access A, class D> constexpr extent extent_of(const reg<T, A, D>& row) {
    servobus::detail::check_row(row);
    return {row.address, servobus::detail::words_in<T>};
}
template <class... Rows> constexpr step make(step::kind what, std::uint8_t slot, const Rows&... rows) {
    using device = servobus::detail::same_device_of<typename Rows::device...>;
    static_assert(device::value, "a step has registers of one device");
    const bool is_write = what == step::kind::write;
    if (is_write && ((Rows::rights == access::ro) || ...)) a_step_writes_no_read_only_register();
    if (!is_write && ((Rows::rights == access::wo) || ...)) a_step_reads_no_write_only_register();
    const extent extents[] = {extent_of(rows)...};
    return make_of(what, slot, extents, sizeof...(rows), device::device::facts.max_write);
}

// A step takes for `R` a code as it is, which spares the compiler a setting, the price of five rows.
template <const auto& R, class T = typename servobus::row_type<R>::value_type>
using constant_of = std::conditional_t<servobus::wire_integer<T>, register_value<R>, T>;
template <const auto& R> constexpr std::uint32_t bits_of(const constant_of<R>& value) {
    if constexpr (!servobus::wire_integer<typename servobus::row_type<R>::value_type>) {
        const std::uint16_t word = static_cast<std::uint16_t>(servobus::to_bits(value));
        if (!R.limits.contains(word))
            servobus::detail::this_constant_is_outside_the_range_of_the_register<R.limits.low,
                                                                                 R.limits.high>();
        return word;
    } else {
        if (value.error() != errc::ok) a_step_has_no_value_that_its_register_refuses();
        return value.bits();
    }
}
template <const auto& R> inline constexpr bool is_pair = servobus::row_type<R>::words == 2;
template <const auto& R> inline constexpr std::uint32_t all_bits = is_pair<R> ? 0xFFFF'FFFF : 0xFFFF;
template <const auto& R>
inline constexpr word_order fixed_order =
    servobus::has_fixed_word_order<typename servobus::row_type<R>::device>
        ? servobus::row_type<R>::device::facts.word_order
        : word_order::unknown;

/// Puts a constant of two words into a step, in the word order of the profile. Equal words need no order.
constexpr void put_pair(step& s, std::uint32_t bits, word_order order) {
    const word_pair words = split_words(bits, order);
    s.value = words.first;
    if (words.first == words.second) return;
    if (order == word_order::unknown) a_constant_of_two_words_needs_the_word_order_of_the_profile();
    s.slot = step::pair;
    s.limit_ms = words.second;
}
/// Compares bits of a pair: the step reads only the word that has them. Zero in all 32 bits is in both words.
constexpr void put_bits_of_pair(step& s, std::uint32_t mask, std::uint32_t value, word_order order) {
    if (mask == 0xFFFF'FFFF && value == 0) return;
    const std::uint32_t bits = mask | value;
    const bool is_high = (bits & 0xFFFF) == 0;
    if (!is_high && bits > 0xFFFF) bits_of_a_step_lie_in_one_word_of_its_register();
    if (order == word_order::unknown) a_constant_of_two_words_needs_the_word_order_of_the_profile();
    s.count = 1;
    if (is_high == (order == word_order::low_first)) ++s.address;
    s.mask = static_cast<std::uint16_t>(is_high ? mask >> 16 : mask);
    s.value = static_cast<std::uint16_t>(is_high ? value >> 16 : value);
}
constexpr void put_bits(step& s, std::uint32_t mask, std::uint32_t value) {
    if ((mask | value) > 0xFFFF) bits_of_a_step_lie_in_one_word_of_its_register();
    s.mask = static_cast<std::uint16_t>(mask);
    s.value = static_cast<std::uint16_t>(value);
}
// No template: of one that breaks the rule g++ says first that it is no constexpr function.
constexpr void check_single_words(bool has_pair) {
    if (has_pair) a_step_compares_16_bits_of_registers_of_one_word();
}
template <const auto& R> consteval bool may_start(std::uint32_t bits) {
    if constexpr (has(R.flags, flag::trigger | flag::motion)) {
        return !stop_words<R>.contains(bits, all_bits<R>);
    } else {
        return false;
    }
}
} // namespace detail

/// Writes a constant. The words of a 32-bit one are in the word order of the profile; where the drive can switch it,
/// they must be equal.
template <const auto& R> consteval step write(detail::constant_of<R> value) {
    step s = detail::make(step::kind::write, step::constant, R);
    const std::uint32_t bits = detail::bits_of<R>(value);
    if constexpr (detail::is_pair<R>)
        detail::put_pair(s, bits, detail::fixed_order<R>);
    else
        s.value = static_cast<std::uint16_t>(bits);
    if constexpr (has(R.flags, flag::trigger | flag::motion)) // in place: fewer instances for the compiler
        s.mask = stop_words<R>.contains(bits, detail::all_bits<R>) ? std::uint16_t{0xFFFF}
                                                                   : step::never_repeatable;
    return s;
}

/// Writes zero to adjacent registers.
template <const auto&... Rs> consteval step write_zero() {
    step s = detail::make(step::kind::write, step::constant, Rs...);
    if ((detail::may_start<Rs>(0) || ...)) s.mask = step::never_repeatable;
    return s;
}

/// Writes the routine's arguments, from number `slot` on, to adjacent registers.
template <const auto&... Rs> consteval step write_arguments(std::uint8_t slot = 0) {
    return detail::make(step::kind::write, slot, Rs...);
}

/// The same for a target that may be written again without harm, such as a speed: if the write gets no response,
/// the registers and the drive's witness are read. If the registers hold what was written, the step is done. If
/// they hold what the facade wrote before, or zero after an enable, which it remembers of one or two registers, the
/// routine ends with `not_executed`; else its outcome is unknown.
template <const auto&... Rs> consteval step set_arguments(std::uint8_t slot = 0) {
    step s = detail::make(step::kind::write, slot, Rs...);
    s.is_setpoint = true;
    return s;
}

/// Requires that a register holds a constant; otherwise the routine ends with `otherwise`. A 32-bit one is compared
/// whole, in the word order of the profile, as `write` sends it.
template <const auto& R>
consteval step expect(detail::constant_of<R> value, errc otherwise = errc::unexpected_value) {
    step s = detail::make(step::kind::expect, step::constant, R);
    if constexpr (detail::is_pair<R>)
        detail::put_pair(s, detail::bits_of<R>(value), detail::fixed_order<R>);
    else
        s.value = static_cast<std::uint16_t>(detail::bits_of<R>(value));
    s.otherwise = otherwise;
    return s;
}

/// Requires that adjacent registers hold zero in the bits of `mask`. A mask is for registers of one word.
template <const auto&... Rs>
consteval step expect_zero(errc otherwise = errc::unexpected_value, std::uint16_t mask = 0xFFFF) {
    if (mask != 0xFFFF) detail::check_single_words((detail::is_pair<Rs> || ...));
    step s = detail::make(step::kind::expect, step::constant, Rs...);
    s.otherwise = otherwise;
    s.mask = mask;
    return s;
}

/// Requires that adjacent registers hold the arguments from number `slot` on: reads back what was written.
template <const auto&... Rs>
consteval step expect_arguments(std::uint8_t slot = 0, errc otherwise = errc::unexpected_value) {
    step s = detail::make(step::kind::expect, slot, Rs...);
    s.otherwise = otherwise;
    return s;
}

/// Requires bits of a register. The bits of a 32-bit register lie in one of its words, which is read alone; zero in all
/// 32 bits is read in both.
template <const auto& R> consteval step expect_bits(std::uint32_t mask, std::uint32_t value, errc otherwise) {
    step s = detail::make(step::kind::expect, step::constant, R);
    if constexpr (detail::is_pair<R>)
        detail::put_bits_of_pair(s, mask, value, detail::fixed_order<R>);
    else
        detail::put_bits(s, mask, value);
    s.otherwise = otherwise;
    return s;
}

/// Reads a register until its bits are as wanted, at most `limit_ms`, or, with `step::commanded_limit`, as
/// long as the routine began with. A 32-bit register is read as by `expect_bits`; several registers have one word each.
template <const auto&... Rs>
consteval step until_bits(std::uint32_t mask, std::uint32_t value, std::uint16_t limit_ms,
                          errc otherwise = errc::not_reached) {
    step s = detail::make(step::kind::until, step::constant, Rs...);
    if constexpr (sizeof...(Rs) == 1 && (detail::is_pair<Rs> && ...)) {
        (detail::put_bits_of_pair(s, mask, value, detail::fixed_order<Rs>), ...);
    } else {
        detail::check_single_words((detail::is_pair<Rs> || ...));
        detail::put_bits(s, mask, value);
    }
    s.limit_ms = limit_ms;
    s.otherwise = otherwise;
    return s;
}

/// Reads signed registers of one word until each is at most `most` away from zero, at most `limit_ms`: until a motor is
/// at standstill.
template <const auto&... Rs>
consteval step until_within(std::uint16_t most, std::uint16_t limit_ms, errc otherwise = errc::not_reached) {
    step s = detail::make(step::kind::until, step::constant, Rs...);
    detail::check_single_words((detail::is_pair<Rs> || ...));
    s.value = most;
    s.is_within = true;
    s.limit_ms = limit_ms;
    s.otherwise = otherwise;
    return s;
}

/// Requires that signed registers of one word are at most `most` away from zero.
template <const auto&... Rs> consteval step expect_within(std::uint16_t most, errc otherwise) {
    step s = detail::make(step::kind::expect, step::constant, Rs...);
    detail::check_single_words((detail::is_pair<Rs> || ...));
    s.value = most;
    s.is_within = true;
    s.otherwise = otherwise;
    return s;
}

/// Reads adjacent registers into the routine's words from number `slot` on.
template <const auto&... Rs> consteval step fetch(std::uint8_t slot = 0) {
    return detail::make(step::kind::fetch, slot, Rs...);
}

/// Reads the feedback and asks the drive's model whether the command may begin; the model's error ends the
/// routine.
consteval step permit() {
    step s{};
    s.address = step::no_address;
    s.what = step::kind::permit;
    return s;
}

/// Requires that the drive has not restarted, as its witness shows; otherwise the routine ends with
/// `needs_init`, also where nothing is known of it.
consteval step same_drive() {
    step s{};
    s.address = step::no_address;
    s.what = step::kind::witness;
    return s;
}

/// Reads the feedback until the drive's model confirms that the command has been carried out, at most
/// `limit_ms`, or, with `step::commanded_limit`, as long as the routine began with.
consteval step confirm(std::uint16_t limit_ms = step::commanded_limit) {
    step s{};
    s.address = step::no_address;
    s.what = step::kind::confirm;
    s.limit_ms = limit_ms;
    s.otherwise = errc::not_reached;
    return s;
}

/// The same step for the element that the routine's `shift` chooses: the step is written with element 0 of
/// its arrays, and `shift` is added to its address.
consteval step element(step s) {
    s.is_element = true;
    return s;
}

/// The same step, repeated if it gets no response: for stops only, which are safe to repeat. Of a register that may
/// also start something (flag `trigger` or `motion`) only its `stop_words` are taken; a row without a flag is not
/// checked.
consteval step repeatable(step s) {
    if (s.what != step::kind::write || s.slot < step::pair) detail::a_repeatable_step_writes_a_constant();
    if (s.mask == step::never_repeatable) detail::a_repeatable_step_stops_the_drive_see_stop_words();
    s.is_repeatable = true;
    return s;
}

/// The same stop, which is never the first frame that is sent: among several it waits until another was
/// acknowledged.
consteval step after_a_stop(step s) {
    if (!s.is_repeatable) detail::a_step_after_a_stop_is_a_stop();
    s.is_after_stop = true;
    return s;
}
} // namespace servobus::steps
