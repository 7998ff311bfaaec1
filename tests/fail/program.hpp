// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the wrong programs have in common: a port that does nothing, a ZLAC8015D on it, and a second device.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/servobus.hpp>

namespace zlac = servobus::zlac8015d;
namespace units = servobus::units;
using servobus::checked, servobus::clamped, servobus::raw;

struct some_port {
    servobus::transfer send(servobus::bytes) { return std::uint16_t{0}; }
    bool sent() { return false; }
    servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
    servobus::instant now() { return {}; }
};

struct some_drive : servobus::client<servobus::line<some_port>, zlac::device> {
    some_drive() : client{wire, servobus::node<zlac::device>{1}} {}

  private:
    some_port port;
    servobus::line<some_port> wire{port, servobus::modbus::timing_at(115200)};
};

inline int some_number() { return 500; }

namespace other {
struct device {
    static constexpr servobus::profile facts{.name = "other"};
};
inline constexpr servobus::reg<servobus::i16, servobus::access::rw, device> speed{
    0x2090, {-100, 100}, units::r_per_min, 0};
inline constexpr servobus::reg<servobus::i16, servobus::access::rw, device> next_speed{
    0x2091, {-100, 100}, units::r_per_min, 0};
inline constexpr servobus::reg_array<servobus::reg<servobus::i16, servobus::access::rw, device>, 2> speeds{
    {0x2090, {-100, 100}, units::r_per_min, 0}, 1};
} // namespace other
