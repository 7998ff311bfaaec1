// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device with one setting of the line, its address or its baud rate, which takes effect before the response
// to the write, after it, or at power-on; its station on a virtual line, which can lose responses; and the scenes
// of a change that both settings play.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <span>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace tests {

enum class takes_effect { before_its_response, after_its_response, at_power_on };

/// `Setting` has the register's address (`at`), its value in the beginning (`initial`), and the node address
/// and the baud rate that a value means.
template <class Setting> struct settable {
    takes_effect when = takes_effect::after_its_response;
    std::uint16_t held = Setting::initial;
    std::uint16_t in_force = Setting::initial;
    bool is_due = false;
    bool refuses = false;
    unsigned writes = 0;

    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = held;
        return address == Setting::at ? 0 : 2;
    }
    std::uint8_t write(std::uint16_t, servobus::words_view from) {
        ++writes;
        if (refuses) return 4;
        held = from[0];
        is_due = when != takes_effect::at_power_on;
        if (when == takes_effect::before_its_response) in_force = held;
        return 0;
    }
    std::uint8_t address() const { return Setting::address(in_force); }
    std::uint32_t baud() const { return Setting::baud(in_force); }
};

/// Between the device's station and the line: applies what is due after each response.
template <class Setting> struct settable_station final : servobus::sim::line_device {
    settable<Setting>& device;
    servobus::sim::station<settable<Setting>> station{device};
    unsigned lost_responses = 0; ///< to writes
    bool is_gone_after_a_write = false;

    explicit settable_station(settable<Setting>& of) : device{of} {}
    void receive(std::uint8_t byte, bool is_readable, servobus::instant now) override {
        if (!is_gone_after_a_write || device.writes == 0) station.receive(byte, is_readable, now);
    }
    servobus::duration run(servobus::instant now) override { return station.run(now); }
    servobus::bytes send(servobus::instant now) override {
        const servobus::bytes response = station.send(now);
        if (response.empty()) return response;
        if (device.is_due) device.in_force = device.held;
        if (lost_responses == 0 || !servobus::modbus::is_write(response[1])) return response;
        --lost_responses;
        return {};
    }
    std::uint32_t baud() const override { return device.baud(); }
};

/// The device on a line, and its client. What the scenes need of a derived rig: the register (`row`), its value
/// after the change (`wanted`), `change()`, `is_changed()` and `is_unchanged()`, which tell the client's setting,
/// and `follow()`, which gives the client the new one.
template <class Setting, class Device> struct line_setting_rig {
    static constexpr std::uint32_t first_baud = Setting::baud(Setting::initial);

    settable<Setting> device;
    settable_station<Setting> station{device};
    servobus::sim::virtual_line wire{first_baud};
    servobus::line<servobus::sim::virtual_line> line{wire, servobus::modbus::timing_at(first_baud)};
    servobus::client<servobus::line<servobus::sim::virtual_line>, Device> at{line, servobus::node<Device>{1}};

    line_setting_rig() { wire.attach(station); }
};

/// The client follows its drive, whether the response comes in the old setting, the new one, or not at all.
template <class Rig> void play_a_change_in_operation() {
    for (const takes_effect when : {takes_effect::before_its_response, takes_effect::after_its_response}) {
        for (const unsigned lost : {0u, 1u}) {
            CAPTURE(when);
            CAPTURE(lost);
            Rig r;
            r.device.when = when;
            r.station.lost_responses = lost;
            CHECK(r.change());
            CHECK(r.is_changed());
            CHECK(r.device.writes == 1);
            const auto held = r.at.template read<Rig::row>();
            REQUIRE(held);
            CHECK(*held == Rig::wanted);
        }
    }
}

/// A drive that takes the new setting when it starts again is reported as not reached, and works until then.
template <class Rig> void play_a_change_at_power_on() {
    for (const unsigned lost : {0u, 1u}) {
        CAPTURE(lost);
        Rig r;
        r.device.when = takes_effect::at_power_on;
        r.station.lost_responses = lost;
        CHECK(r.change().error() == servobus::errc::not_reached);
        CHECK(r.is_unchanged());
        CHECK(r.device.held == Rig::wanted);
        CHECK(r.at.template read<Rig::row>());
        r.device.in_force = r.device.held;
        r.follow();
        CHECK(r.at.template read<Rig::row>());
    }
}

} // namespace tests
