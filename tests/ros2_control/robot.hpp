// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot in virtual time: a simulated ZLAC8015D on a virtual line, the hardware interface over it, and a loop that
// calls the interface as the controller manager does.
#pragma once

#include <doctest/doctest.h>

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include <examples/ros2_control/servobus_zlac8015d_system.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "manager.hpp"

namespace robots {

using namespace servobus;
using manager::primary;
using manager::return_type;

/// A simulated drive whose positions may begin elsewhere than at 0.
struct shifted_drive : sim::zlac8015d {
    using sim::zlac8015d::zlac8015d;
    u32 shift = 0;

    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        const std::uint8_t refusal = sim::zlac8015d::read(address, to);
        if (refusal != 0 || address > 0x20A7 || address + to.size() < 0x20AB) return refusal;
        for (std::size_t wheel = 0; wheel < 2; ++wheel) {
            std::uint16_t* const at = &to[0x20A7u - address + 2 * wheel];
            const u32 there = join_words(at[0], at[1], servobus::zlac8015d::device::facts.word_order) + shift;
            const word_pair words = split_words(there, servobus::zlac8015d::device::facts.word_order);
            at[0] = words.first;
            at[1] = words.second;
        }
        return refusal;
    }
};

/// The port of the interface under test, which opens "/dev/robot": the line of the last world.
class virtual_port {
  public:
    inline static sim::virtual_line* wire = nullptr;
    inline static unsigned opened = 0;

    errc open(const char* path, const posix::serial_settings& how) {
        ++opened;
        CHECK(how.baud == 115200);
        error_ = std::strcmp(path, "/dev/robot") == 0 ? 0 : ENOENT;
        is_open_ = error_ == 0;
        wire_ = wire;
        return is_open_ ? errc::ok : errc::no_such_port;
    }
    void close() { is_open_ = false; }
    bool is_open() const { return is_open_; }
    int os_error() const { return error_; }

    transfer send(bytes out) { return is_open_ ? seen(wire_->send(out)) : transfer{errc::port_lost}; }
    bool sent() { return wire_->sent(); }
    transfer receive(byte_buffer in) {
        return is_open_ ? seen(wire_->receive(in)) : transfer{errc::port_lost};
    }
    instant now() { return wire_->now(); }
    void wait(duration d) { wire_->wait(d); }

  private:
    transfer seen(const transfer& how) {
        if (!how && how.error() == errc::port_lost) {
            is_open_ = false;
            error_ = EIO;
        }
        return how;
    }
    sim::virtual_line* wire_ = nullptr; // of the world in which it was opened
    bool is_open_ = false;
    int error_ = 0;
};

using system = servobus_ros2_control::basic_zlac8015d_system<virtual_port>;

inline hardware_interface::HardwareInfo description() {
    using namespace hardware_interface;
    const auto interface = [](const char* name) {
        InterfaceInfo i{};
        i.name = name;
        return i;
    };
    HardwareInfo info{};
    info.name = "base";
    info.type = "system";
    info.hardware_parameters = {{"port", "/dev/robot"},
                                {"left_counts_per_turn", "4096"},
                                {"right_counts_per_turn", "4096"},
                                {"right_mirrored", "true"}};
    for (const char* name : {"left_wheel_joint", "right_wheel_joint"}) {
        ComponentInfo joint{};
        joint.name = name;
        joint.type = "joint";
        joint.command_interfaces = {interface("velocity")};
        joint.state_interfaces = {interface("position"), interface("velocity")};
        info.joints.push_back(joint);
    }
    ComponentInfo sensor{};
    sensor.name = "drive";
    sensor.type = "sensor";
    sensor.state_interfaces = {interface("is_faulted"), interface("position_gaps")};
    info.sensors = {sensor};
    return info;
}

struct world {
    shifted_drive drive;
    sim::station<shifted_drive> station{drive};
    sim::virtual_line wire;
    system hardware{};
    manager::component component{hardware};

    explicit world(sim::zlac8015d_options options = {}, std::uint64_t seed = 1)
        : drive{options}, wire{115200, seed} {
        drive.store(servobus::zlac8015d::speed_resolution.address, 10); // as an activation before has left it
        drive.power_cycle();
        wire.attach(station);
        virtual_port::wire = &wire;
        virtual_port::opened = 0;
        stand_in::logged().clear();
    }

    void begin(const hardware_interface::HardwareInfo& info = description()) {
        component.initialise(info);
        component.configure();
        component.activate();
    }
    /// One iteration of the framework's loop; then the rest of its period passes. Returns the worse of both results.
    return_type cycle(duration period = milliseconds(10)) {
        const std::uint64_t began = wire.time_us();
        const return_type read = component.read();
        const return_type written = component.write();
        const std::uint64_t took = wire.time_us() - began;
        if (read == return_type::OK && written == return_type::OK && took > longest_us) longest_us = took;
        if (took < period.us) wire.pass(microseconds(period.us - static_cast<std::uint32_t>(took)));
        ++cycles;
        return read == return_type::OK ? written : read;
    }
    /// Cycles for a time, or until an error.
    return_type run(std::uint32_t ms, duration period = milliseconds(10)) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000;
        while (wire.time_us() < end) {
            if (const return_type how = cycle(period); how != return_type::OK) return how;
        }
        return return_type::OK;
    }
    double position(const char* side) const {
        return component.value(std::string{side} + "_wheel_joint/position");
    }
    double velocity(const char* side) const {
        return component.value(std::string{side} + "_wheel_joint/velocity");
    }
    /// Where the wheels really are, in rad forward.
    double left() const { return static_cast<double>(drive.left().position) * turn / 4096; }
    double right() const { return -static_cast<double>(drive.right().position) * turn / 4096; }
    /// The log's errors.
    static std::vector<std::string> errors() {
        std::vector<std::string> all;
        for (const std::string& line : stand_in::logged()) {
            if (line.rfind("ERROR ", 0) == 0) all.push_back(line.substr(6));
        }
        return all;
    }

    static constexpr double turn = 6.283185307179586;
    std::uint64_t longest_us =
        0; // of a read and a write without an error, in virtual time: what calls of the port take
    unsigned cycles = 0;
};

} // namespace robots
