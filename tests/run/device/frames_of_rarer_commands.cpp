// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The frames of the commands that `frames_of_commands.cpp` leaves out: homings, waits, runs of segments, holds, the
// commands before a set-up, and settings of one word.
#include <memory>
#include <string>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/single_parameters.hpp>
#include <servobus/device/yako/single_parameters.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/watched_drives.hpp>

namespace frames_of_rarer_commands_tests {

using namespace servobus;
using namespace servobus::units;
using namespace frames_of_commands;

namespace {

constexpr auto off = [](auto& r) { return bool{r.drive.run(init{})}; };

/// A stepper on its slide, as from the factory but for the speeds of its homing.
template <class Rig> bool be_on_slide(Rig& r) {
    const u16 bits = r.model.status_bits;
    std::destroy_at(&r.model);
    std::construct_at(&r.model);
    r.model.status_bits = bits;
    r.model.attach(simulated::yako_slide());
    (void)r.drive.run(init{}); // finds the restart
    return r.drive.run(init{}) && r.drive.run(enable{}) &&
           r.drive.run(yako::set_homing_profile{900 * r_per_min, 300 * r_per_min});
}

} // namespace

TEST_CASE("the frames of a YAKO's homings, holds and waits, and what each word that they read decides") {
    using namespace servobus::yako;
    namespace cl = closed_loop;
    simulated::driven_yako<watched<sim::yako_closed_loop>, cl::drive> a;
    simulated::driven_yako<watched<sim::yako_open_loop>, open_loop::drive> o;
    a.model.status_bits = o.model.status_bits = motion_status::moving_bit | motion_status::released_bit |
                                                motion_status::alarm_bit | motion_status::homed_bit;
    const auto ready = [](auto& r) { return be_on_slide(r); };
    const auto enabled = [](auto& r) { return r.drive.run(init{}) && r.drive.run(enable{}); };
    const motion_profile slow{10 * r_per_min, 90 * millisecond, 80 * millisecond, 60 * r_per_min};
    // The offset mode and the method, the offset; the witness before the start, after it, and at the end.
    expect(frames_of(a, ready, cl::home{homing::home_24, 70 * pulse}),
           "0032: needs_init \", 00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", "
           "0030=0001 0018, 0035=0000 0046, 00BA: needs_init \", 0027=0010, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \", 00BA: needs_init \"");
    expect(frames_of(
               o, ready,
               open_loop::home{homing::home_24, -70 * pulse, offset_handling::stay_position_negative_offset}),
           "0032: needs_init \", 00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", "
           "0030=0008 0018, 0035=FFFF FFBA, 00BA: needs_init \", 0027=0010, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \", 00BA: needs_init \"");
    expect(frames_of(a, ready, hold{60 * r_per_min, milliseconds(50)}),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" again \" -, "
           "0020=0000 0064 0064 003C 0000 00FC, 0027=000D, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \"");
    expect(frames_of(a, ready, bounded_jog{-300 * pulse, slow}),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" again \" -, "
           "0020=000A 005A 0050 003C FFFF FED4, 0027=0001, 00BA: needs_init \", "
           "0006: - faulted - \" \" \" \"");
    const auto homed_before = [](auto& r) {
        return be_on_slide(r) && r.drive.run(declare_position{0 * pulse}) && r.drive.run(init{});
    };
    expect(frames_of(a, homed_before, accept_position{}),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" again \" -, "
           "0006: - faulted|the axis must be homed first - \" \" \" \"");
    const auto moving = [&](auto& r) { return be_on_slide(r) && r.drive.run(move_by{20 * pulse, slow}); };
    const char* const arrives = "0006: - faulted - \" again \" -, 0006: - faulted - \" \" \" \", "
                                "0006: - faulted - \" again \" -, 00BA: needs_init \"";
    expect(frames_of(a, moving, wait_reached{}), arrives);
    expect(frames_of(a, moving, wait_standstill{}), arrives);
    const auto placed = [](auto& r) { return be_on_slide(r) && r.drive.run(declare_position{0 * pulse}); };
    expect(frames_of(a, placed, (set_input_move{70'000 * pulse, slow, positioning::absolute})),
           "00BA: needs_init \", 0006: - needs_init - \" \" \" \", 0020=0000 0000 0000 0000 0000 0000, "
           "0050=0001, 0020=000A 005A 0050 003C 0001 1170");
    expect(frames_of(a, enabled, cl::set_outputs{{.y1 = true}}),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 004F=0002");
    expect(frames_of(a, enabled, cl::set_output_polarity{{.y1 = true}}),
           "00BA: needs_init \", 0006: - faulted - \" \" \" \", 004B=0002, 004B: unexpected_value");
    expect(frames_of(a, enabled, (cl::set_collision_homing{50, 100})),
           "00BA: needs_init \", 0006: - faulted|busy - \" \" \" \", 003B=0032 0064, "
           "003B: unexpected_value \"");
    const auto released = [](auto& r) { return r.drive.run(init{}) && r.drive.run(disable{}); };
    expect(frames_of(o, released, (set_input{input_terminal::x6, input_function::stop})),
           "00BA: needs_init \", 0006: - faulted|busy|wrong_state - \" \" \" \", 0047=0005, "
           "0047: unexpected_value");
    expect(frames_of(a, enabled, factory_reset{sole_drive_on_the_line{}}),
           "00BA: needs_init \", 0006: - busy - \" needs_init \" -, 002D=0041, "
           "0006: - not_executed - \" \" \" \"");
    expect(frames_of(a, enabled, (set_node_address{1, sole_drive_on_the_line{}})),
           "00BA: needs_init \", 0006: - busy - \" \" \" \", 0013=0001");
}

TEST_CASE("the frames of a C630S's homings, and what each word that they read decides") {
    using namespace servobus::c630s;
    servo r;
    r.model.status_bits = status_flags::fault_bit | status_flags::brake_bit | status_flags::homed_bit |
                          status_flags::electrical_bit;
    r.model.attach(
        {.home_from = 5'000, .home_to = 60'000, .negative_limit = -900'000, .positive_limit = 900'000});
    const auto before_switch = r.model;
    const auto on_slide = [&](auto& d) {
        d.model = before_switch;
        (void)d.drive.run(init{}); // finds the restart
        return d.drive.run(init{}) &&
               d.drive.run(homing_by{homing_mode::forward_home_switch, 300 * r_per_min, 60 * r_per_min,
                                     100 * millisecond, 30'000}) &&
               d.drive.run(enable_in{control_mode::position});
    };
    expect(frames_of(r, on_slide, home{30 * second}),
           "1720: faulted|needs_init, 0C0D: needs_init, 1720: faulted|needs_init, 0B00: busy - \" \", "
           "3100: needs_init, 051E=0004, 1720: faulted|needs_init, 0B00: again - \" \", 051E=0000, "
           "051E: unexpected_value, 1720: faulted|needs_init, 3100: needs_init");
    // Where the electrical home is attained before, it has to fall first, which it does not.
    expect(frames_of(r, on_slide, home_electrically{30 * second}),
           "1720: faulted|needs_init|the expected state was not reached in time, 0C0D: needs_init, "
           "1720: faulted|needs_init, 0B00: busy - \" \", 3100: needs_init, 051E=0005, "
           "1720: faulted|needs_init, 0B00: again - \" \", 051E=0000, 051E: unexpected_value, "
           "1720: faulted|needs_init, 3100: needs_init");
}

TEST_CASE("the frames of a C630S's runs, waits and stops, and what each word that they read decides") {
    using namespace servobus::c630s;
    servo r;
    r.model.status_bits = status_flags::fault_bit | status_flags::brake_bit | status_flags::ready_bit;
    const auto in = [](const enable_in& how) {
        return [how](auto& d) { return d.drive.run(init{}) && d.drive.run(how); };
    };
    expect(frames_of(r, in({control_mode::position, position_source::segments, segment_mode::single}),
                     start_segments{}),
           "0C0D: needs_init, 1720: faulted|needs_init, 0B00: busy - \" \", 0B07: - \", 0B35: - \" \" \", "
           "3100: needs_init, 3100=8001, 3100: needs_init, 3100=8041, 3100: needs_init, 3100=8001, "
           "0500: needs_init, 0C0D: needs_init");
    const auto moving = [&](auto& d) {
        return in({control_mode::position})(d) &&
               d.drive.run(segment{1, 100 * reference_unit, 60 * r_per_min}) && d.drive.run(start_segment{1});
    };
    // At another place it may have hardly begun: the place is read once more.
    const char* const arrives = "1720: faulted|needs_init, 0B00: again - \" \", 0B07: again \", "
                                "0B35: again \" - \", 0B21: - \", 3100: needs_init";
    expect(frames_of(r, moving, wait_reached{}), arrives);
    expect(frames_of(r, moving, wait_standstill{}), arrives);
    expect(frames_of(r, off, read_status{}), "1720: -");
    expect(frames_of(r, off, read_wide_position{wide_position::load}), "0C1A: needs_init, 0B51: - \" \" \"");
    // A drive that is known to be disabled is stopped by `quick_stop` as by `disable`.
    const char* const disabled =
        "0603=0000 0000, 3100: again, 3100=8000, 3100: again, 0B00: again - \" \", 1720: -";
    expect(frames_of(r, off, quick_stop{}), disabled);
    expect(frames_of(r, off, disable{}), disabled);
    const auto running = [](segment_mode how) {
        return [how](auto& d) { return d.drive.run(init{}) && d.drive.run(run_speed_segments{.run = how}); };
    };
    expect(frames_of(r, running(segment_mode::cyclic), quick_stop{}),
           "0D05=0001, 0B00: again - \" \", 3100: again, 3100=8000, 3100: again, 1720: -");
    expect(frames_of(r, running(segment_mode::by_input), disable{}),
           "0D05=0001, 3100: again, 3100=8000, 3100: again, 0B00: again - \" \", 1720: -");
    expect(frames_of(r, in({control_mode::torque}), quick_stop{}),
           "0D05=0001, 0603=0000 0000, 0703=0000, 0B00: again - \" \"");
    expect(frames_of(r, off, (change_address{1, sole_drive_on_the_line{}})),
           "3100: needs_init, 0B00: busy - \" \", 0C0D=0001, 0C0D: unexpected_value, 0C00=0001");
}

TEST_CASE("the frames of a C630S that is not set up, whose outputs say nothing yet") {
    using namespace servobus::c630s;
    new_servo r;
    expect(frames_of(r, off, disable{}), "3100=0000, 3100: again, 0B00: again - \" \", 1720: -");
    expect(frames_of(r, off, reset_encoder{}),
           "3100: needs_init, 0B00: busy - \" \", 0B21=0000, 0D14=0002, 0D01=0000, 0D01=0001, "
           "0B21: - again, 0D01=0000");
    expect(frames_of(r, off, fault_reset{}),
           "3100=0000, 3100: unexpected_value, 0B00: again - \" \", 1720: -, 3100: needs_init, "
           "0603=0000 0000, 0703=0000, 0B21=0000, 0D05=0000, 0D01=0000, 0D01=0001, 0B21: - again, 0D01=0000");
}

TEST_CASE("the frames of a ZLAC8015D's speeds, currents and settings, and what each word that they read "
          "decides") {
    using namespace servobus::zlac8015d;
    dual_servo r;
    const auto in = [](operating_mode m) {
        return [=](auto& d) { return d.drive.run(init{}) && d.drive.run(enable_in{checked(m)}); };
    };
    const auto turning = in(operating_mode::velocity);
    expect(frames_of(r, turning, (velocity{30 * r_per_min, -40 * r_per_min})), "2088=001E FFD8");
    expect(frames_of(r, turning, left_velocity{30 * r_per_min}), "2088=001E");
    expect(frames_of(r, turning, right_velocity{30 * r_per_min}), "2089=001E");
    const auto pressing = in(operating_mode::torque);
    expect(frames_of(r, pressing, (zlac8015d::torque{1000 * milliampere, -2000 * milliampere})),
           "2090=03E8 F830");
    expect(frames_of(r, pressing, left_torque{1000 * milliampere}), "2090=03E8");
    expect(frames_of(r, pressing, right_torque{1000 * milliampere}), "2091=03E8");
    expect(frames_of(r, in(operating_mode::absolute_position), (move_to{40 * pulse, -70'000 * pulse})),
           "200D: needs_init, 20A2: busy - \" faulted \" - \" \" \" \" \", 208A=0000 0028 FFFE EE90, "
           "200E=0010, 200D: needs_init");
    const auto moving = [&](auto& d) {
        return in(operating_mode::relative_position)(d) && d.drive.run(move_by{40 * pulse, -50 * pulse});
    };
    expect(frames_of(r, moving, wait_reached{}),
           "20A2: again - \" faulted \" again \" \" \" - \", 20A2: again - \" faulted \" - \" \" \" \" \", "
           "20A2: again - \" faulted \" again \" \" \" - \", 200D: needs_init");
    // The position of the right wheel decides nothing for the left one.
    expect(frames_of(r, moving, wait_wheels_reached{wheels::left}),
           "20A2: again - \" faulted \" again \" \" \" - \", 20A2: again - \" faulted \" - \" \" \" \" \", "
           "20A2: again - \" faulted \" again \" - \" \" \", 200D: needs_init");
    expect(frames_of(r, off, (position_speed{30 * r_per_min, 40 * r_per_min})), "208E=001E 0028");
    expect(frames_of(r, off, (brakes{brake{0}, brake{1}})), "201A=0000 0001");
    expect(frames_of(r, off, on_input_stop{input_stop_action{1}}), "2021=0001");
    expect(frames_of(r, off, park{off_on::on}), "200C=0001");
    expect(frames_of(r, off, quick_stop_by{quick_stop_option{5}}), "2011=0005");
    expect(frames_of(r, off, factory_reset{sole_drive_on_the_line{}}),
           "20A2: busy - \" \" \" \" \" \" \" busy \", 2009=0001");
}

} // namespace frames_of_rarer_commands_tests
