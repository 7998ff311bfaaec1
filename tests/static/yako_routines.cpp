// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Promises in the YAKOTEC tables. G15: only stops and releases may be repeated, and a start is the last step
// of its table. S1: `init` sends a stop and then only reads. One table serves both variants, so their rows
// must have the same addresses and ranges.
#include <servobus/device/yako.hpp>

namespace yako_routines_tests {

using namespace servobus;
using namespace servobus::yako;

namespace {

namespace tables = yako::routines;
namespace cl = closed_loop;
namespace ol = open_loop;
using enum positioning;
using enum while_moving;

constexpr routine all[] = {
    tables::init_closed_loop,
    tables::init_open_loop,
    tables::mark,
    tables::accept_position,
    tables::wait_reached,
    tables::after_start,
    tables::feedback,
    tables::stop,
    tables::quick_stop,
    tables::release,
    tables::enable,
    tables::fault_reset,
    tables::clear_position,
    tables::save,
    tables::factory_reset,
    tables::move<relative, ignore>,
    tables::move<relative, interrupt>,
    tables::move<absolute, ignore>,
    tables::move<absolute, interrupt>,
    tables::stored_move<relative, ignore>,
    tables::stored_move<relative, interrupt>,
    tables::stored_move<absolute, ignore>,
    tables::stored_move<absolute, interrupt>,
    tables::jog,
    tables::home,
    tables::relative_input_move,
    tables::absolute_input_move,
    tables::set_profile,
    tables::set_homing_profile,
    tables::set_position_segment,
    tables::set_speed_segment,
    tables::set_pv_trigger,
    tables::set_input,
    tables::set_output,
    tables::set_input_polarity,
    tables::set_output_polarity,
    tables::set_outputs,
    tables::limit_travel,
    tables::unlimit_travel,
    tables::set_over_travel_stop,
    tables::set_word_order,
    tables::set_speed_resolution,
    tables::set_node_address,
    tables::set_baud_rate,
    tables::set_serial_format,
    tables::wait_standstill,
};

constexpr bool is_write_to(const step& s, u16 address) {
    return s.what == step::kind::write && address >= s.address && address < s.address + s.count;
}
constexpr bool is_start(const step& s) {
    return is_write_to(s, motion_command.address) &&
           (s.slot != step::constant || motion_code::from_word(s.value).is_start());
}
constexpr bool is_harmless_twice(const step& s) {
    if (s.what != step::kind::write || s.slot != step::constant || s.count != 1) return false;
    if (s.address == auxiliary_command.address) return s.value == static_cast<u16>(auxiliary::release);
    return s.address == motion_command.address && motion_code::from_word(s.value).is_stop() && !is_start(s);
}

template <class Rule> constexpr bool every_step(Rule rule) {
    for (const routine table : all) {
        for (const step& s : table) {
            if (!rule(s)) return false;
        }
    }
    return true;
}

// G15
static_assert(every_step([](const step& s) { return !s.is_repeatable || is_harmless_twice(s); }));
static_assert(every_step([](const step& s) { return !is_start(s) || !s.is_repeatable; }));
// A trigger is a constant of its table: no computed value is written to these two registers.
static_assert(every_step([](const step& s) {
    const bool is_trigger =
        is_write_to(s, motion_command.address) || is_write_to(s, auxiliary_command.address);
    return !is_trigger || (s.slot == step::constant && s.count == 1);
}));
// A stop is repeated until it gets a response.
static_assert(tables::stop[0].is_repeatable && tables::quick_stop[0].is_repeatable);
static_assert(tables::release[0].is_repeatable && tables::release[2].is_repeatable);
static_assert(tables::stop[0].value == 0x0100 && tables::quick_stop[0].value == 0x0200);

// S4: before a start the marker is read, then the feedback; after it nothing is written, and both are read
// again.
constexpr bool is_checked(routine table, std::size_t start) {
    using enum step::kind;
    bool is_same = false;
    bool may_act = false;
    for (std::size_t i = 0; i < start; ++i) {
        is_same = is_same || table[i].what == witness;
        may_act = may_act || (is_same && table[i].what == permit);
    }
    // A homing ends well by its feedback alone, so the witness is read again.
    const bool is_home = start == tables::home_start_step && table.data() == tables::home;
    return may_act && start + (is_home ? 4 : 3) == table.size() && table[start + 1].what == witness &&
           table[start + 2].what == confirm && table[table.size() - 1].what == (is_home ? witness : confirm);
}
constexpr bool starts_are_checked() {
    for (const routine table : all) {
        for (std::size_t i = 0; i < table.size(); ++i) {
            if (is_start(table[i]) && !is_checked(table, i)) return false;
        }
    }
    return true;
}
static_assert(starts_are_checked());
static_assert(is_start(tables::jog[tables::start_step]) && is_start(tables::home[tables::home_start_step]));
static_assert(tables::move<relative, ignore>[tables::start_step].value == 0x0001);
static_assert(tables::move<relative, interrupt>[tables::start_step].value == 0x0009);
static_assert(tables::move<absolute, ignore>[tables::start_step].value == 0x0005);
static_assert(tables::stored_move<absolute, interrupt>[tables::stored_start_step].value == 0x000D);
// The marker is no longer there when the parameters are saved.
static_assert(tables::save[2].address == 0x00BA && tables::save[2].value == 0 &&
              tables::save[4].value == 0x0042);

// G35: after the motor has come to rest a wait looks at the alarm itself, whichever frame has read the status.
constexpr bool looks_at_alarm(const step& s) {
    return s.what == step::kind::expect && s.address == status_word.address && s.value == 0 &&
           s.mask == motion_status::alarm_bit && s.otherwise == errc::faulted;
}
static_assert(tables::wait_standstill[0].what == step::kind::until &&
              looks_at_alarm(tables::wait_standstill[1]));

// S1: the only write is the stop, and it is the first frame.
constexpr bool only_stops_and_reads(routine table) {
    for (std::size_t i = 0; i < table.size(); ++i) {
        if ((table[i].what == step::kind::write) != (i == 0)) return false;
    }
    return is_harmless_twice(table[0]) && table[0].value == 0x0100;
}
static_assert(only_stops_and_reads(tables::init_closed_loop) && only_stops_and_reads(tables::init_open_loop));

// 4.1: start speed, ramps, speed and target in one frame, 0020h..0025h; status in one, 0006h..000Ch.
static_assert(tables::write_move.address == 0x0020 && tables::write_move.count == 6);
static_assert(tables::feedback[0].address == 0x0006 && tables::feedback[0].count == 7);
// One frame reads at most 16 registers of the drive.
static_assert(every_step([](const step& s) { return s.count <= 16; }));

// Rows that differ between the variants have the same addresses, and the same ranges where a command checks
// them.
template <const auto& A, const auto& B> constexpr bool lie_alike() {
    return A.address == B.address && A.limits.low == B.limits.low && A.limits.high == B.limits.high;
}
static_assert(lie_alike<cl::input_state, ol::input_state>() &&
              lie_alike<cl::output_state, ol::output_state>());
static_assert(lie_alike<cl::actual_speed, ol::actual_speed>() && lie_alike<cl::jog_speed, ol::jog_speed>());
static_assert(lie_alike<cl::start_speed, ol::start_speed>());
static_assert(lie_alike<cl::positioning_speed, ol::positioning_speed>());
static_assert(lie_alike<cl::homing_fast_speed, ol::homing_fast_speed>());
static_assert(lie_alike<cl::homing_slow_speed, ol::homing_slow_speed>());
static_assert(cl::homing_method.address == ol::homing_method.address);
static_assert(lie_alike<cl::input_polarity, ol::input_polarity>());
static_assert(lie_alike<cl::output_polarity, ol::output_polarity>());
static_assert(lie_alike<cl::user_outputs, ol::user_outputs>());
static_assert(ol::x4_function.address == x0_function.address + 4 &&
              ol::x6_function.address == x0_function.address + 6);
static_assert(ol::y2_function.address == y0_function.address + 2);
static_assert(lie_alike<at<cl::position_segment_speeds, 0>, at<ol::position_segment_speeds, 0>>());
static_assert(lie_alike<at<cl::position_segment_acceleration_times, 0>,
                        at<ol::position_segment_acceleration_times, 0>>());
static_assert(lie_alike<at<cl::position_segment_deceleration_times, 0>,
                        at<ol::position_segment_deceleration_times, 0>>());
static_assert(lie_alike<at<cl::speed_segment_speeds, 15>, at<ol::speed_segment_speeds, 15>>());
static_assert(
    lie_alike<at<cl::speed_segment_acceleration_times, 15>, at<ol::speed_segment_acceleration_times, 15>>());
static_assert(
    lie_alike<at<cl::speed_segment_deceleration_times, 15>, at<ol::speed_segment_deceleration_times, 15>>());

// A variant refuses homing methods that only the other variant has.
template <class Device> constexpr bool takes(homing m) {
    return closed_loop::home{checked(m)}.by.error() == errc::ok &&
           homing_choice<Device>{checked(m)}.error() == errc::ok;
}
static_assert(takes<cl::device>(homing::home_24) && takes<ol::device>(homing::home_24));
static_assert(takes<cl::device>(homing::index_negative) && !takes<ol::device>(homing::index_negative));
static_assert(!takes<cl::device>(homing::mechanical_stop_1));
static_assert(closed_loop::home{homing::mechanical_stop_1}.by.error() == errc::ok);

} // namespace

} // namespace yako_routines_tests
