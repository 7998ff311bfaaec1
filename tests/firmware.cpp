// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Firmware that has common words of its own at global scope. It uses the words of the library and all namespaces of
// devices, and each common word is still its own.
#include <servobus/bus/scheduled_line.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/device/c630s/wiring.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/device/yako/wiring.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/device/zlac8015d/wiring.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/words.hpp>

using namespace servobus::words;
using namespace servobus::zlac8015d;
using namespace servobus::yako;
using namespace servobus::yako::closed_loop;
using namespace servobus::yako::open_loop;
using namespace servobus::c630s;

// --- The firmware's own

int at(int place);
struct reg {
    unsigned bits;
};
struct step {
    int number;
};
enum class bus { up, down };
enum class input { pressed, released };
enum class output { on, off };
struct field {
    int width;
};
struct list {
    field first;
};
struct image {
    int words;
};
struct range {
    int low, high;
};
struct access {};
struct exchange {};
struct profile {};
struct request {};
struct response {};
struct slice {};
struct unit {};
using u8 = unsigned char;

int at(int place) { return place; }
int uses_its_own(bus b, input i, output o) {
    const reg r{1};
    const step s{2};
    const list all{field{3}};
    const image seen{4};
    const range whole{5, 6};
    (void)access{}, (void)exchange{}, (void)profile{}, (void)request{}, (void)response{}, (void)slice{},
        (void)unit{};
    const int plan = at(s.number) + all.first.width + seen.words + whole.low;
    const bool is_on = b == bus::up && i == input::pressed && o == output::on;
    return is_on ? plan + static_cast<int>(r.bits) : u8{0};
}

// --- The library's

namespace lines {
using on_a_bus = scheduled_line<servobus::sim::virtual_line>;
constexpr auto wheels_node = responds_within(node<servobus::zlac8015d::device>{1}, 30_ms);
constexpr auto lift_node = responds_within(node<servobus::yako::closed_loop::device>{2}, 30_ms);
constexpr poll_plan plan{servobus::modbus::timing_at(115200),
                         controlled(wheels_node, {.feedback = 50_ms, .command_timeout = 500_ms}),
                         controlled(lift_node, {.feedback = 100_ms, .command_timeout = no_command_timeout}),
                         cyclic<servobus::zlac8015d::bus_voltage>(wheels_node, 500_ms)};
constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr axis_profile fast{.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms};
} // namespace lines

bool turns_and_lifts(lines::on_a_bus& wire) {
    servobus::zlac8015d::drive wheels{wire, lines::wheels_node, by_plan};
    servobus::yako::closed_loop::axis_drive lift{wire, lines::lift_node, lines::screw, by_plan};
    auto all = make_bus<lines::plan>(wire, wheels, lift);
    if (!all.run(wheels, take_over{with_fault_reset{}}) || !all.run(wheels, enable{})) return false;
    if (!all.run(lift, init{}) || !all.run(lift, limit_travel{-2_mm, 200_mm})) return false;
    if (!all.run(wheels, velocity{30_r_per_min, -30_r_per_min})) return false;
    if (!all.run(lift, move_to{125.5_mm, lines::fast}, wait_reached{})) return false;
    const auto volts = all.latest<servobus::zlac8015d::bus_voltage>(1_s);
    return volts && *volts > 44.5_V && all.run(wheels, disable{});
}
