// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Promises in the C630S's tables. G15: only stops and zero targets may be repeated. S2: before every enable
// zero targets are written and read back, and everything that factory settings would start is off. S5: P31-00
// is read before each of its bits is set. G18: P0C-13 is read before anything that may be written cyclically.
#include <iterator>
#include <type_traits>

#include <servobus/device/c630s.hpp>

namespace c630s_routines_tests {

using namespace servobus;
using namespace servobus::c630s;

namespace {

namespace tables = c630s::routines;
using kind = step::kind;

constexpr bool is_harmless_twice(const step& s) {
    if (s.what != kind::write || s.slot != step::constant || s.is_element) return false;
    if (s.address == emergency_stop.address) return s.value == 1;
    if (s.address == virtual_input_levels.address && s.value == terminal::marker) return true;
    if (s.address == eeprom_update.address) return s.value == 0; // keeps no write from then on
    return s.value == 0 && (s.address == target_speed.address || s.address == target_torque.address ||
                            s.address == virtual_input_levels.address);
}

constexpr bool repeats_only_stops(routine steps) {
    for (const step& s : steps) {
        if (s.is_repeatable && !is_harmless_twice(s)) return false;
    }
    return true;
}

// The first step of this kind at this address; the number of steps if there is none.
constexpr std::size_t place_of(routine steps, kind what, u16 address) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
        if (steps[i].what == what && steps[i].address == address) return i;
    }
    return steps.size();
}

constexpr bool is_set_and_read_back(routine steps, u16 address, std::size_t before) {
    const std::size_t set = place_of(steps, kind::write, address);
    const std::size_t read = place_of(steps, kind::expect, address);
    return set < read && read < before;
}

constexpr bool enables_safely(routine steps) {
    const std::size_t on = place_of(steps, kind::write, virtual_input_levels.address);
    if (on >= steps.size() || steps[on].is_repeatable) return false;
    const step& look = steps[on - 1]; // S5: no step between
    const bool is_known = look.what == kind::expect && look.address == virtual_input_levels.address &&
                          look.slot == 0 && look.mask == 0xFFFF;
    const step& last = steps[steps.size() - 2]; // confirmed by the status word, and waited for the brake
    return is_known && steps[steps.size() - 1].what == kind::confirm &&
           is_set_and_read_back(steps, target_speed.address, on) &&
           is_set_and_read_back(steps, target_torque.address, on) &&
           is_set_and_read_back(steps, position_segment_mode.address, on) &&
           is_set_and_read_back(steps, speed_segment_mode.address, on) &&
           is_set_and_read_back(steps, homing_control.address, on) &&
           is_set_and_read_back(steps, mode_of_operation.address, on) &&
           place_of(steps, kind::expect, virtual_inputs_at_power_on.address) < on &&
           place_of(steps, kind::expect, power_on_functions_1_to_16.address) < on &&
           steps[0].address == eeprom_update.address && last.what == kind::until &&
           last.address == virtual_output_levels.address && repeats_only_stops(steps);
}
static_assert(enables_safely(tables::enable_speed) && enables_safely(tables::enable_torque));
static_assert(enables_safely(tables::enable_position) && enables_safely(tables::enable_speed_segments));

// Counterexample: the table without the read of P31-00.
constexpr auto without_look = [] {
    auto table = tables::enable_speed;
    for (std::size_t i = 1; i < std::size(table.all); ++i) {
        if (table.all[i].what == kind::write && table.all[i].address == virtual_input_levels.address)
            table.all[i - 1] = table.all[0];
    }
    return table;
}();
static_assert(!enables_safely(without_look));
// Joined tables make a routine. A temporary one is refused, since it would not outlive the run.
static_assert(std::is_constructible_v<routine, const joined_steps<2>&>);
static_assert(!std::is_constructible_v<routine, joined_steps<2>>);
static_assert(!std::is_constructible_v<routine, const joined_steps<2>>);
static_assert(!enables_safely(tables::start) && !enables_safely(tables::disable));

static_assert(repeats_only_stops(tables::init) && repeats_only_stops(tables::disable));
static_assert(repeats_only_stops(tables::disable_marked) && is_harmless_twice(tables::disable_marked[0]));
static_assert(repeats_only_stops(tables::stop_all_marked) && is_harmless_twice(tables::stop_all_marked[0]));
static_assert(repeats_only_stops(tables::quick_stop_of_marked_segments));
static_assert(repeats_only_stops(tables::halt_speed) && repeats_only_stops(tables::halt_torque));
static_assert(repeats_only_stops(tables::halt_jog) && repeats_only_stops(tables::stop_all));
static_assert(repeats_only_stops(tables::stop_all_sparing) && repeats_only_stops(tables::init_again));
static_assert(repeats_only_stops(tables::quick_stop) && repeats_only_stops(tables::fault_reset));
static_assert(repeats_only_stops(tables::velocity) && repeats_only_stops(tables::torque));
static_assert(repeats_only_stops(tables::start) && repeats_only_stops(tables::jog));
static_assert(repeats_only_stops(tables::home) && repeats_only_stops(tables::home_electrically));
static_assert(repeats_only_stops(tables::set_home) && repeats_only_stops(tables::change_inputs));
static_assert(repeats_only_stops(tables::begin_keeping) && repeats_only_stops(tables::end_keeping));
static_assert(repeats_only_stops(tables::keep_one) && repeats_only_stops(tables::keep_two_for_later));
static_assert(repeats_only_stops(tables::reset_encoder) && repeats_only_stops(tables::restart));
static_assert(repeats_only_stops(tables::factory_reset) && repeats_only_stops(tables::change_address));

// The first frame of a routine that stops is a stop.
static_assert(is_harmless_twice(tables::init[0]) && is_harmless_twice(tables::disable[0]));
static_assert(is_harmless_twice(tables::stop_all[0]) && is_harmless_twice(tables::quick_stop[0]));
static_assert(is_harmless_twice(tables::halt_speed[0]) && is_harmless_twice(tables::halt_torque[0]));
static_assert(is_harmless_twice(tables::halt_jog[0]));

// S5: before a bit of P31-00 is set, P31-00 is read and compared with its cached value.
constexpr bool reads_inputs_before_it_sets_them(routine steps) {
    const std::size_t set = place_of(steps, kind::write, virtual_input_levels.address);
    const std::size_t read = place_of(steps, kind::expect, virtual_input_levels.address);
    return set < steps.size() && read < set && steps[read].otherwise == errc::needs_init;
}
static_assert(reads_inputs_before_it_sets_them(tables::start));
static_assert(reads_inputs_before_it_sets_them(tables::jog));
static_assert(reads_inputs_before_it_sets_them(tables::halt_jog));
static_assert(reads_inputs_before_it_sets_them(tables::change_inputs));
static_assert(!reads_inputs_before_it_sets_them(tables::disable));

// G18: a routine for cyclic writes reads P0C-13 first. A routine that stores in the EEPROM leaves P0C-13 at
// 0.
constexpr bool looks_at_the_eeprom(routine steps) {
    return steps[0].what == kind::expect && steps[0].address == eeprom_update.address &&
           steps[0].value == 0 && steps[0].otherwise == errc::needs_init;
}
constexpr bool spares_the_eeprom_afterwards(routine steps) {
    for (std::size_t i = steps.size(); i-- > 1;) {
        if (steps[i].address != eeprom_update.address) continue;
        return steps[i].what == kind::expect && steps[i].value == 0 && steps[i - 1].what == kind::write;
    }
    return false;
}
static_assert(looks_at_the_eeprom(tables::set_one) && looks_at_the_eeprom(tables::set_two));
static_assert(looks_at_the_eeprom(tables::segment) && looks_at_the_eeprom(tables::start));
static_assert(looks_at_the_eeprom(tables::ramps) && looks_at_the_eeprom(tables::gear));
static_assert(looks_at_the_eeprom(tables::jog) && looks_at_the_eeprom(tables::home));
static_assert(!looks_at_the_eeprom(tables::keep_one));
static_assert(spares_the_eeprom_afterwards(tables::keep_one) &&
              spares_the_eeprom_afterwards(tables::keep_two));
static_assert(spares_the_eeprom_afterwards(tables::keep_one_for_later) &&
              spares_the_eeprom_afterwards(tables::keep_two_for_later));
static_assert(spares_the_eeprom_afterwards(tables::end_keeping) &&
              spares_the_eeprom_afterwards(tables::init));
static_assert(!spares_the_eeprom_afterwards(tables::begin_keeping));

// The steps to which the facade's step numbers refer.
constexpr bool starts_at_its_place(routine steps) {
    const step& s = steps[steps.size() - tables::steps_from_start];
    return s.address == virtual_input_levels.address && s.slot == 2 && s.what == kind::write;
}
static_assert(starts_at_its_place(tables::start) && starts_at_its_place(tables::start_step));
static_assert(starts_at_its_place(tables::start_run) && !starts_at_its_place(tables::jog));
static_assert(tables::home.all[tables::home_step].address == homing_control.address);
static_assert(tables::home_electrically.all[tables::home_step].address == homing_control.address);

// Sixteen segments, five addresses apart, each of five words in one frame.
static_assert(tables::segment[3].count == 5 && tables::segment[3].is_element);
static_assert(tables::segment[3].address == 0x110C && position_segment_displacements.stride == 5);
static_assert(segment_number{16}.index() == 15 && segment_number{1}.error() == errc::ok);
static_assert(segment_number{checked(17)}.error() == errc::bad_argument);
static_assert(segment_number{checked(0)}.error() == errc::bad_argument);

// The set-up: each virtual terminal has the function that terminals.hpp states for P31-00 and P17-32.
constexpr bool has_input(std::uint16_t bit, input_function f) {
    for (unsigned n = 0; n < 16; ++n) {
        if (bit == 1u << n) return c630s::detail::virtual_input_uses[n].does == f;
    }
    return false;
}
constexpr bool has_output(std::uint16_t bit, output_function f) {
    for (unsigned n = 0; n < 16; ++n) {
        if (bit == 1u << n) return c630s::detail::virtual_output_uses[n] == f;
    }
    return false;
}
static_assert(has_input(terminal::servo_on, input_function::servo_on));
static_assert(has_input(terminal::for_segment(1), input_function::segment_selection_1));
static_assert(has_input(terminal::for_segment(2), input_function::segment_selection_2));
static_assert(has_input(terminal::for_segment(4), input_function::segment_selection_3));
static_assert(has_input(terminal::for_segment(8), input_function::segment_selection_4));
static_assert(has_input(terminal::segment_start, input_function::position_segment_start));
static_assert(has_input(terminal::step_start, input_function::step_enable));
// A wired reset and a wired homing start keep their terminals.
static_assert(!c630s::detail::is_virtual_input(static_cast<std::uint16_t>(input_function::alarm_reset)));
static_assert(!c630s::detail::is_virtual_input(static_cast<std::uint16_t>(input_function::homing_start)));
// A bit without a function, whose level moves nothing.
static_assert(has_input(terminal::marker, input_function{}));
static_assert(has_input(terminal::jog_forward, input_function::jog_forward));
static_assert(has_input(terminal::jog_reverse, input_function::jog_reverse));
static_assert(has_output(status_flags::ready_bit, output_function::servo_ready));
static_assert(has_output(status_flags::brake_bit, output_function::brake));
static_assert(has_output(status_flags::fault_bit, output_function::fault));
static_assert(has_output(status_flags::completed_bit, output_function::positioning_completed));
static_assert(has_output(status_flags::homed_bit, output_function::home_attained));
static_assert(has_output(status_flags::electrical_bit, output_function::electrical_home_attained));

constexpr std::uint16_t set_up(std::uint16_t address, std::uint16_t held) {
    return c630s::detail::set_up_word(address, held);
}
static_assert(set_up("P03-02"_p, 1) == 0 && set_up("P03-02"_p, 14) == 14); // S-ON is removed, P-OT stays
static_assert(set_up("P03-03"_p, 1) == 1);                                 // a logic, not a function
static_assert(set_up("P03-16"_p, 32) == 32 && set_up("P03-16"_p, 31) == 31 && set_up("P03-16"_p, 28) == 0);
static_assert(set_up("P03-00"_p, 0xFFFF) == 0xFE1E && set_up("P03-01"_p, 0xFFFF) == 0xF7F1);
static_assert(set_up("P05-30"_p, 3) == 0 && set_up("P05-30"_p, 4) == 0 && set_up("P05-30"_p, 1) == 0);
static_assert(set_up("P05-31"_p, 3) == 3);
static_assert(set_up("P0C-09"_p, 0) == 1 && set_up("P0C-10"_p, 1) == 0 && set_up("P0C-11"_p, 0) == 1);
static_assert(set_up("P0C-12"_p, 7) == 7);
static_assert(set_up("P17-02"_p, 2) == 0 && set_up("P17-16"_p, 32) == 0);
static_assert(set_up("P17-00"_p, 0) == 1 && set_up("P17-12"_p, 0) == 28 && set_up("P17-13"_p, 0) == 1);
static_assert(set_up("P17-49"_p, 0) == 9 && set_up("P17-50"_p, 1) == 0 && set_up("P17-63"_p, 0) == 16);

// Two inputs, wired or virtual, may not have the same function; nor may two wired outputs. The blocks that
// are read before an assignment cover each of them once.
using c630s::detail::first_rivals, c630s::detail::next_rivals;
static_assert(excludes("P03-02"_p, "P03-14"_p) && excludes("P03-02"_p, "P17-30"_p));
static_assert(excludes("P17-00"_p, "P03-16"_p) && excludes("P04-00"_p, "P04-10"_p));
static_assert(!excludes("P03-02"_p, "P03-02"_p) && !excludes("P03-02"_p, "P03-03"_p));
static_assert(!excludes("P03-02"_p, "P04-00"_p) && !excludes("P04-00"_p, "P17-33"_p));
static_assert(!excludes("P17-33"_p, "P17-35"_p) && !excludes("P03-02"_p, "P03-00"_p));
constexpr bool blocks_cover(std::uint16_t assigned) {
    unsigned rivals = 0;
    for (unsigned address = 0x0300; address < 0x1800; ++address)
        rivals += excludes(assigned, static_cast<std::uint16_t>(address)) ? 1u : 0u;
    unsigned found = 0;
    for (std::uint16_t block = first_rivals(assigned); block != 0; block = next_rivals(block)) {
        for (unsigned i = 0; i < c630s::detail::block_size; i += 2) {
            const auto address = static_cast<std::uint16_t>(block + i);
            if (address != assigned && !excludes(assigned, address)) return false;
            found += address != assigned ? 1u : 0u;
        }
    }
    return rivals != 0 && found == rivals;
}
static_assert(blocks_cover("P03-02"_p) && blocks_cover("P03-16"_p) && blocks_cover("P17-30"_p));
static_assert(blocks_cover("P04-00"_p) && blocks_cover("P04-10"_p));

} // namespace

} // namespace c630s_routines_tests
