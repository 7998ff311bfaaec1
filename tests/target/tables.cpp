// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What each call for rows of other tables adds to a program that reads and writes holding registers. CALLS is a sum of
// the numbers below; LINE is 1 for a line, 0 for a blocking line. run.sh compares the sizes; the program is not run.
#if CALLS >= 128
#include <servobus/any_value.hpp>
#else
#include <servobus/any_device.hpp>
#endif
#include <servobus/line/blocking_line.hpp>

#include "board.hpp"

namespace hoist {
using namespace servobus;

struct device {
    static constexpr profile facts{.name = "hoist", .baud = 115200};
};
inline constexpr reg<u16, access::rw, device> ramp{0x0002, {10, 5000}, units::millisecond, 500};
inline constexpr reg<i32, access::rw, device> target{0x0003, {-1'000'000, 1'000'000}, units::pulse, 0};
inline constexpr reg<u16, access::rw, device> current_limit{0x0005, {0, 250}, units::ampere / 10, 100};
inline constexpr reg<u16, access::rw, device> options{0x0006, full<u16>, no_unit, 0};
inline constexpr reg<i32, access::ro, device> position{0x0008, full<i32>, units::pulse, 0};
inline constexpr reg<u16, access::ro, device> load{0x000A, full<u16>, units::ampere / 10, 0};
inline constexpr input_reg<i16, device> temperature{0x0000, full<i16>, no_unit, 25};
inline constexpr input_reg<u16, device> voltage{0x0001, full<u16>, units::volt / 100, 2400};
inline constexpr coil<access::rw, device> pump{0x0000};
inline constexpr coil<access::rw, device> fan{0x0001};
inline constexpr coil<access::rw, device> lamp{0x0002};
#if CALLS >= 128
inline constexpr input_reg<f32, device> power{0x0010, full<f32>, units::watt, no_default};
inline constexpr input_reg<f32, device> current{0x0012, full<f32>, units::ampere, no_default};
inline constexpr input_reg<u64, device> energy{0x0014, full<u64>, units::watt_hour, no_default};
inline constexpr input_reg<with<u16, bits<4, 15>>, device> level{0x0018, full<u16>, no_unit, no_default};
inline constexpr input_reg<i16, device> exponent{0x0019, full<i16>, no_unit, no_default};
inline constexpr input_reg<with<i16, ten_to<exponent>>, device> flow{0x001A, full<i16>, units::litre,
                                                                     no_default};
#endif
} // namespace hoist

namespace {
using namespace servobus;
using namespace servobus::units;

uart port_1;
#if LINE
line<uart> wire{port_1, modbus::timing_at(115200)};
client io{wire, node<hoist::device>{1}};
#else
blocking_line<uart, modbus::timing_at(115200)> wire{port_1};
client io{wire, fixed_node<hoist::device, 1>{}};
#endif
volatile bool is_on;
volatile int number;
} // namespace

extern "C" bool job() {
    using namespace hoist;
    if (const auto r = io.read<position, load>()) number = r->get<position>().count();
    bool is_done = io.write<ramp, target>(500 * millisecond, raw(100)).error() == errc::ok;
    if constexpr ((CALLS & 1) != 0) { // function 04
        if (const auto r = io.read<temperature, voltage>()) number = r->get<temperature>();
    }
    if constexpr ((CALLS & 2) != 0) { // function 01
        if (const auto r = io.read<pump, fan, lamp>()) is_on = r->get<fan>();
    }
    if constexpr ((CALLS & 4) != 0) is_done &= io.write<pump>(bool{is_on}).error() == errc::ok; // 05
    if constexpr ((CALLS & 8) != 0)
        is_done &= io.write<pump, fan>(bool{is_on}, true).error() == errc::ok;                        // 0F
    if constexpr ((CALLS & 16) != 0) is_done &= io.change_bits<options, 0x0C>(4).error() == errc::ok; // 16h
    if constexpr ((CALLS & 32) != 0) {                                                                // 17h
        const auto r = io.write_then_read<rows<position, load>, ramp, target>(500 * millisecond, raw(100));
        if (r) number = r->get<position>().count();
    }
    if constexpr ((CALLS & 64) != 0)
        is_done &= io.write<current_limit>(raw(10)).error() == errc::ok; // function 06
#if CALLS >= 128
    if constexpr ((CALLS & 128) != 0) {
        if (const auto r = io.read<power, current>())
            number = r->get<current>().rounded(milliampere).value_or(-1);
    }
    if constexpr ((CALLS & 256) != 0) {
        if (const auto r = io.read<power, current>()) number = r->get<current>().in(milliampere) > 1.5f;
    }
    if constexpr ((CALLS & 512) != 0) {
        if (const auto r = io.read<energy>()) number = r->in(watt_hour);
    }
    if constexpr ((CALLS & 1024) != 0) {
        if (const auto r = io.read<level>()) number = *r;
    }
    if constexpr ((CALLS & 2048) != 0) {
        if (const auto r = io.read<flow, exponent>()) {
            if (const auto now = r->get<flow>()) number = now->rounded(litre);
        }
    }
#endif
    return is_done;
}
