// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Promises in the ZLAC8015D's tables. G15: only stops and zero targets may be repeated. S2: every enable
// comes after zero targets that were written and read back, and after the mode.
#include <servobus/device/zlac8015d.hpp>

namespace zlac8015d_routines_tests {

using namespace servobus;
using namespace servobus::zlac8015d;

namespace {

constexpr bool is_harmless_twice(const step& s) {
    if (s.what != step::kind::write || s.slot != step::constant) return false;
    if (s.address == control_word.address) {
        return s.value == static_cast<u16>(control_code::stop) ||
               s.value == static_cast<u16>(control_code::quick_stop);
    }
    return s.value == 0 && s.address >= left_target_speed.address && s.address <= right_target_torque.address;
}

constexpr bool repeats_only_stops(routine steps) {
    for (const step& s : steps) {
        if (s.is_repeatable && !is_harmless_twice(s)) return false;
    }
    return true;
}

constexpr std::size_t place_of(routine steps, step::kind kind, u16 address, u16 value) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
        if (steps[i].what == kind && steps[i].address == address && steps[i].value == value) return i;
    }
    return steps.size();
}

// Writes zero speeds, reads them back, writes the mode, then enables, in this order. The enable is not
// repeatable.
constexpr bool enables_safely(routine steps) {
    const std::size_t zero = place_of(steps, step::kind::write, left_target_speed.address, 0);
    const std::size_t read = place_of(steps, step::kind::expect, left_target_speed.address, 0);
    const std::size_t torque = place_of(steps, step::kind::expect, left_target_torque.address, 0);
    const std::size_t enable =
        place_of(steps, step::kind::write, control_word.address, static_cast<u16>(control_code::enable));
    std::size_t mode = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        if (steps[i].what == step::kind::write && steps[i].address == mode_of_operation.address) mode = i;
    }
    return zero < read && read < mode && torque < mode && mode < enable && enable < steps.size() &&
           !steps[enable].is_repeatable;
}

namespace tables = zlac8015d::routines;

static_assert(enables_safely(tables::enable_velocity) && enables_safely(tables::enable_torque));
static_assert(enables_safely(tables::enable_relative_position) &&
              enables_safely(tables::enable_absolute_position));
static_assert(repeats_only_stops(tables::enable_velocity) && repeats_only_stops(tables::enable_torque));
static_assert(repeats_only_stops(tables::enable_relative_position) &&
              repeats_only_stops(tables::enable_absolute_position));
static_assert(repeats_only_stops(tables::init) && repeats_only_stops(tables::disable));
static_assert(repeats_only_stops(tables::halt_speed) && repeats_only_stops(tables::halt_torque));
static_assert(repeats_only_stops(tables::quick_stop) && repeats_only_stops(tables::quick_stop_after_silence));
static_assert(repeats_only_stops(tables::fault_reset) && repeats_only_stops(tables::stop_both));
static_assert(repeats_only_stops(tables::velocity) && repeats_only_stops(tables::torque));
static_assert(repeats_only_stops(tables::move_both));
static_assert(repeats_only_stops(tables::move_left) && repeats_only_stops(tables::move_right));
static_assert(repeats_only_stops(tables::save) && repeats_only_stops(tables::factory_reset));

// S3: the first frame after a long pause writes zero targets or a stop.
static_assert(is_harmless_twice(tables::init[0]) && is_harmless_twice(tables::disable[0]));
static_assert(is_harmless_twice(tables::quick_stop_after_silence[0]) &&
              is_harmless_twice(tables::stop_both[0]));
static_assert(tables::quick_stop_after_silence[0].address == left_target_speed.address);
// True if any of the leading stops may be the first frame that the drive receives.
constexpr bool begins_with_what_may_be_first(routine steps) {
    for (const step& s : steps) {
        if (!s.is_repeatable) return true;
        const bool may_be_first = s.address == control_word.address || s.address == left_target_speed.address;
        if (may_be_first == s.is_after_stop) return false;
    }
    return true;
}
static_assert(begins_with_what_may_be_first(tables::init) &&
              begins_with_what_may_be_first(tables::stop_both));
static_assert(begins_with_what_may_be_first(tables::disable) &&
              begins_with_what_may_be_first(tables::quick_stop_after_silence));

// Two tables are parts of others.
constexpr routine whole_quick_stop = tables::quick_stop;
static_assert(whole_quick_stop.size() == 4 && whole_quick_stop[0].value == 5);
static_assert(whole_quick_stop.data() + 4 == routine{tables::quick_stop_after_silence}.end());
constexpr routine whole_stop = tables::stop_both;
static_assert(whole_stop.size() == 5 && whole_stop.data() == routine{tables::init}.data());
static_assert(whole_stop[4].what == step::kind::until && whole_stop.end()->what == step::kind::fetch);
static_assert(routine{tables::init}.size() == std::size_t{tables::init_size} + tables::to_set_mark);
static_assert(routine{tables::init}[tables::init_size].address == mode_of_operation.address);

// `start_step` is the step of a move that starts it.
static_assert(tables::move_both[tables::start_step].address == control_word.address);
static_assert(tables::move_left[tables::start_step].address == control_word.address);
static_assert(tables::move_right[tables::start_step].address == control_word.address);

} // namespace

} // namespace zlac8015d_routines_tests
