// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The settings that devices share on one line: found for all pairs of the drives, compared with what their registers
// and simulators have, and used for a plan and a port.
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/bus/plan.hpp>
#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace settings_on_one_line_tests {

using namespace servobus;
using enum character_format;
namespace z = servobus::zlac8015d;
namespace y = servobus::yako;
namespace c = servobus::c630s;

namespace {

// Each code of a row has its choice, the factory's is the profile's, and the registers are the rows'.
template <const auto& Rate, class Device> constexpr bool has_all_rates() {
    std::size_t count = 0;
    bool has_factory = false;
    for (const rate_choice& r : Device::on_line.rates) {
        if (!Rate.limits.contains(r.code)) return false;
        if (r.baud == Device::facts.baud) has_factory = r.code == static_cast<std::uint16_t>(Rate.initial);
        ++count;
    }
    return has_factory && Device::on_line.rate_register == Rate.address &&
           count == static_cast<std::size_t>(Rate.limits.high - Rate.limits.low + 1);
}
template <const auto& Format, class Device> constexpr bool has_all_formats() {
    std::size_t count = 0;
    bool has_factory = false;
    for (const format_choice& f : Device::on_line.formats) {
        if (!Format.limits.contains(f.code)) return false;
        if (f.format == Device::facts.format)
            has_factory = f.code == static_cast<std::uint16_t>(Format.initial);
        ++count;
    }
    return has_factory && Device::on_line.format_register == Format.address &&
           count == static_cast<std::size_t>(Format.limits.high - Format.limits.low + 1);
}
static_assert(has_all_rates<z::rs485_baud_rate, z::device>());
static_assert(has_all_rates<y::rs485_baud_rate, y::device>());
static_assert(has_all_rates<c::rs485_baud_rate, c::device>());
static_assert(has_all_formats<y::rs485_format, y::device>());
static_assert(has_all_formats<c::data_format, c::device>());
static_assert(z::device::on_line.formats.is_empty());

// When a code takes effect, and whether it is kept, as far as the rows' flags say it.
static_assert(has(z::rs485_baud_rate.flags, saved) && z::device::on_line.needs_save);
static_assert(has(y::rs485_baud_rate.flags, after_power_cycle) && y::device::on_line.needs_power_cycle);
static_assert(has(y::rs485_format.flags, after_power_cycle));
static_assert(has(c::rs485_baud_rate.flags, immediate) && !c::device::on_line.needs_power_cycle);
static_assert(has(c::data_format.flags, immediate));
static_assert(has(c::rs485_baud_rate.flags, saved_on_write) && !c::device::on_line.needs_save);

// The enumerators' names say the rates.
template <class Code> constexpr std::uint32_t baud_of(const auto& device, Code code) {
    for (const rate_choice& r : device.rates) {
        if (r.code == static_cast<std::uint16_t>(code)) return r.baud;
    }
    return 0;
}
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_128000) == 128'000);
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_115200) == 115'200);
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_57600) == 57'600);
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_38400) == 38'400);
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_19200) == 19'200);
static_assert(baud_of(z::device::on_line, z::baud_rate::baud_9600) == 9600);
static_assert(baud_of(y::device::on_line, y::baud_rate::baud_115200) == 115'200);
static_assert(baud_of(y::device::on_line, y::baud_rate::baud_38400) == 38'400);
static_assert(baud_of(y::device::on_line, y::baud_rate::baud_19200) == 19'200);
static_assert(baud_of(y::device::on_line, y::baud_rate::baud_9600) == 9600);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_2400) == 2400);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_4800) == 4800);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_9600) == 9600);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_19200) == 19'200);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_38400) == 38'400);
static_assert(baud_of(c::device::on_line, c::baud_rate::baud_57600) == 57'600);
template <class Code> constexpr character_format format_of(const line_choices& device, Code code) {
    for (const format_choice& f : device.formats) {
        if (f.code == static_cast<std::uint16_t>(code)) return f.format;
    }
    return n81;
}
static_assert(format_of(y::device::on_line, y::serial_format::n82) == n82);
static_assert(format_of(y::device::on_line, y::serial_format::e81) == e81);
static_assert(format_of(y::device::on_line, y::serial_format::o81) == o81);
static_assert(format_of(c::device::on_line, c::serial_format::n82) == n82);
static_assert(format_of(c::device::on_line, c::serial_format::e81) == e81);
static_assert(format_of(c::device::on_line, c::serial_format::o81) == o81);
static_assert(format_of(c::device::on_line, c::serial_format::n81) == n81);

constexpr node<z::device> wheels{1};
constexpr node<y::closed_loop::device> lift{2};
constexpr node<c::device> press{3};

// --- All three

constexpr auto shared = settings_on_one_line(wheels, lift, press);
static_assert(shared.baud == 38'400 && shared.format == n81);
static_assert(shared.changes[0].rate && shared.changes[0].rate.address == 0x2002 &&
              shared.changes[0].rate.code == 4);
static_assert(!shared.changes[0].format && shared.changes[0].needs_save &&
              shared.changes[0].needs_power_cycle);
static_assert(shared.changes[1].rate.address == 0x0014 && shared.changes[1].rate.code == 1);
static_assert(!shared.changes[1].format && shared.changes[1].needs_save &&
              shared.changes[1].needs_power_cycle);
static_assert(shared.changes[2].rate.address == 0x0C02 && shared.changes[2].rate.code == 4);
static_assert(shared.changes[2].format.address == 0x0C03 && shared.changes[2].format.code == 3);
static_assert(!shared.changes[2].needs_save && !shared.changes[2].needs_power_cycle);
constexpr poll_plan plan{modbus::timing_at(shared.baud),
                         controlled(responds_within(wheels, milliseconds(30)),
                                    {.feedback = milliseconds(50), .command_timeout = milliseconds(500)})};
static_assert(plan.timing().character == modbus::timing_at(38'400).character);
static_assert(posix::settings_of(shared).baud == 38'400 && posix::settings_of(shared).format == n81);

// --- Pairs

constexpr auto wheels_and_lift = settings_on_one_line(wheels, lift);
static_assert(wheels_and_lift.baud == 115'200 && wheels_and_lift.format == n81);
static_assert(!wheels_and_lift.changes[0] && !wheels_and_lift.changes[1]);
static_assert(!wheels_and_lift.changes[0].needs_save && !wheels_and_lift.changes[0].needs_power_cycle);
constexpr auto wheels_and_press = settings_on_one_line(wheels, press);
static_assert(wheels_and_press.baud == 57'600 && wheels_and_press.format == n81);
static_assert(!wheels_and_press.changes[1].rate && wheels_and_press.changes[1].format.code == 3);
constexpr auto lift_and_press = settings_on_one_line(lift, press);
static_assert(lift_and_press.baud == 38'400 && lift_and_press.format == n81);
// Two of a kind keep their format; a limit is one of the port.
static_assert(settings_on_one_line(press, press, lift).format == n82);
static_assert(settings_on_one_line(press, press).format == n82 &&
              !settings_on_one_line(press, press).changes[1]);
static_assert(settings_on_one_line(wheels).baud == 128'000);
static_assert(settings_on_one_line<115'200>(wheels).baud == 115'200);
static_assert(settings_on_one_line<30'000>(wheels, lift, press).baud == 19'200);
// Devices and constant nodes too; a family has what its variants have.
static_assert(settings_on_one_line(z::device{}, fixed_node<y::open_loop::device, 4>{}).baud == 115'200);

// --- A device of a program's own: with choices, and with those of its profile only

struct sensor {
    static constexpr profile facts{.name = "sensor", .baud = 19'200, .format = e81};
};
static_assert(settings_on_one_line(node<sensor>{9}, lift, press).baud == 19'200);
static_assert(settings_on_one_line(node<sensor>{9}, lift, press).format == e81);
static_assert(settings_on_one_line(press, lift, node<sensor>{9}).baud == 19'200, "in any order");
static_assert(settings_on_one_line(lift, node<sensor>{9}).format == e81);
static_assert(!settings_on_one_line(node<sensor>{9}, lift).changes[0]);
struct winch {
    static constexpr profile facts{.name = "winch", .baud = 9600};
    static constexpr rate_choice rates[] = {{9600, 0}, {57'600, 7}};
    static constexpr line_choices on_line{.rates = rates, .rate_register = 2, .needs_power_cycle = true};
};
static_assert(settings_on_one_line(node<winch>{}, press).baud == 57'600);
static_assert(settings_on_one_line(node<winch>{}, press).changes[0].rate.code == 7);
static_assert(settings_on_one_line(node<winch>{}, press).changes[0].needs_power_cycle);
static_assert(settings_on_one_line(node<winch>{}, lift).baud == 9600); // which both have
static_assert(settings_on_one_line(node<winch>{}, lift).changes[1].rate.code == 3);
// A device with choices has these, whatever its factory setting is.
struct hoist {
    static constexpr profile facts{.name = "hoist", .baud = 9600};
    static constexpr rate_choice rates[] = {{19'200, 1}};
    static constexpr line_choices on_line{.rates = rates, .rate_register = 2};
};
struct slow_sensor {
    static constexpr profile facts{.name = "slow sensor", .baud = 9600};
};
// A format that no device has from its factory.
struct fan {
    static constexpr profile facts{.name = "fan", .baud = 9600, .format = n82};
    static constexpr format_choice formats[] = {{n82, 0}, {o81, 4}};
    static constexpr line_choices on_line{.formats = formats, .format_register = 6, .needs_save = true};
};
struct pump {
    static constexpr profile facts{.name = "pump", .baud = 9600, .format = e81};
    static constexpr format_choice formats[] = {{e81, 1}, {o81, 2}};
    static constexpr line_choices on_line{.formats = formats, .format_register = 7};
};
constexpr auto fan_and_pump = settings_on_one_line(node<fan>{1}, node<pump>{2});
static_assert(fan_and_pump.format == o81 && fan_and_pump.baud == 9600);
static_assert(fan_and_pump.changes[0].format.address == 6 && fan_and_pump.changes[0].format.code == 4);
static_assert(!fan_and_pump.changes[0].rate && fan_and_pump.changes[0].needs_save);
static_assert(fan_and_pump.changes[1].format.address == 7 && fan_and_pump.changes[1].format.code == 2);
constexpr device_on_line hoist_and_sensor[] = {on_line<hoist>(), on_line<slow_sensor>()};
static_assert(find_settings_on_one_line(hoist_and_sensor).error() == errc::bad_argument);

} // namespace

TEST_CASE("devices that are known at run time share settings, or there is an error") {
    const device_on_line three[] = {on_line<z::device>(), on_line<y::open_loop::device>(),
                                    on_line<c::device>()};
    const auto found = find_settings_on_one_line(three);
    REQUIRE(found);
    CHECK(found->baud == 38'400);
    CHECK(found->format == n81);
    const device_on_line no_format[] = {on_line<z::device>(), on_line<sensor>()};
    CHECK(find_settings_on_one_line(no_format).error() == errc::bad_argument);
    const device_on_line no_rate[] = {on_line<winch>(), on_line<sensor>()};
    CHECK(find_settings_on_one_line(no_rate).error() == errc::bad_argument);
    CHECK(find_settings_on_one_line(three, 9000).error() == errc::bad_argument);

    const device_on_line without_its_rate[] = {on_line<slow_sensor>(), on_line<hoist>()};
    CHECK(find_settings_on_one_line(without_its_rate).error() == errc::bad_argument);
    // Of constants too, where a program computes them.
    const auto by_type = settings_on_one_line(wheels, lift, press);
    CHECK(by_type.baud == 38'400);
    const auto by_format = settings_on_one_line(node<fan>{1}, node<pump>{2});
    CHECK(static_cast<bool>(by_format.changes[1]));
    CHECK(by_format.format == o81);

    device_on_line twins[] = {on_line<z::device>(), on_line<z::device>()};
    const auto same = find_settings_on_one_line(twins, 115'200);
    REQUIRE(same);
    CHECK(same->baud == 115'200);
    CHECK_FALSE(static_cast<bool>(same->changes[0]));
    CHECK_FALSE(static_cast<bool>(same->changes[1].format));
    CHECK(posix::settings_of(*same).baud == 115'200);
    CHECK(posix::settings_of(*same).format == n81);
}

TEST_CASE("each code sets the rate of the simulated drive") {
    const auto set = [](auto& model, std::uint16_t address, std::uint16_t code) {
        const std::uint8_t word[] = {static_cast<std::uint8_t>(code >> 8),
                                     static_cast<std::uint8_t>(code & 0xFFu)};
        return model.write(address, words_view{word});
    };
    unsigned played = 0;
    for (const rate_choice& r : z::device::on_line.rates) {
        sim::zlac8015d model;
        REQUIRE(set(model, z::device::on_line.rate_register, r.code) == 0);
        REQUIRE(set(model, 0x2010, 1) == 0); // save
        model.power_cycle();
        CHECK(model.baud() == r.baud);
        ++played;
    }
    for (const rate_choice& r : y::device::on_line.rates) {
        sim::yako_closed_loop model;
        REQUIRE(set(model, y::device::on_line.rate_register, r.code) == 0);
        REQUIRE(set(model, 0x002D, 0x0042) == 0); // save
        model.power_cycle();
        CHECK(model.baud() == r.baud);
        ++played;
    }
    for (const rate_choice& r : c::device::on_line.rates) {
        sim::c630s model;
        REQUIRE(set(model, c::device::on_line.rate_register, r.code) == 0);
        CHECK(model.baud() == r.baud);
        ++played;
    }
    CHECK(played == 16);
}

TEST_CASE("a format has a text") {
    CHECK(text(n81) == doctest::String("8N1"));
    CHECK(text(n82) == doctest::String("8N2"));
    CHECK(text(e81) == doctest::String("8E1"));
    CHECK(text(o81) == doctest::String("8O1"));
    CHECK(text(static_cast<character_format>(9)) == doctest::String("unknown"));
}

} // namespace settings_on_one_line_tests
