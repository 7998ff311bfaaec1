// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client on a line over a scripted port in virtual time, and two devices with a few registers each.
#pragma once

#include <cstdint>

#include <tests/support/line_and_client.hpp>

#include "scripted_port.hpp"

namespace tests::typed {

// Two invented devices.
namespace fixture {

using namespace servobus;

struct device {
    static constexpr profile facts{.name = "fixture", .max_read = 4, .max_write = 6, .highest_address = 99};
};
struct switchable {
    static constexpr profile facts{.name = "switchable", .word_order = word_order::unknown};
};

static_assert(device::facts.read_retries == 2); // the default, if a device states no other

enum class colour : std::uint16_t { red = 1, green = 2 };

template <wire_value T> using rw = reg<T, access::rw, device>;
template <wire_value T> using ro = reg<T, access::ro, device>;
template <wire_value T> using open = reg<T, access::rw, switchable>;
using units::ampere, units::millisecond, units::pulse, units::r_per_min;

inline constexpr rw<u16> time{0x0100, {0, 5000}, millisecond, 10};
inline constexpr rw<i16> speed{0x0101, {-300, 300}, r_per_min, 0};
inline constexpr rw<i32> position{0x0102, full<i32>, pulse, 0};
inline constexpr rw<u16> current{0x0104, {0, 300}, ampere / 10, 0};
inline constexpr rw<colour> lamp{0x0105, {1, 2}, no_unit, 1};
inline constexpr rw<left_right<std::int8_t>> heat{0x0106, unstated, no_unit, 0};
inline constexpr ro<u16> state{0x0200, full<u16>, no_unit, no_default};
inline constexpr reg_array<rw<i16>, 4> steps{{0x0300, {-100, 100}, r_per_min, 0}, 6};

inline constexpr open<i32> place{0x0102, full<i32>, pulse, 0};
inline constexpr open<u16> word{0x0104, full<u16>, no_unit, 0};
inline constexpr reg_array<open<i32>, 3> places{{0x0400, {-1000, 1000}, pulse, 0}, 2};

} // namespace fixture

using namespace servobus;
using fixture::device;
using fixture::switchable;

template <class Device = device, class Port = waiting_scripted_port> struct rig {
    Port port;
    register_file file;
    line<Port> on{port, modbus::timing_at(115200)};
    client<line<Port>, Device> drive;

    explicit rig(std::uint8_t node_address = 1) : drive{on, node<Device>{node_address}} {
        for (std::uint16_t a = 0x0100; a < 0x0110; ++a) file.words[a] = 0;
        for (std::uint16_t a = 0x0300; a < 0x0318; ++a)
            file.words[a] = static_cast<std::uint16_t>(a - 0x0300);
        for (std::uint16_t a = 0x0400; a < 0x0406; ++a) file.words[a] = 0;
        file.words[0x0200] = 0xBEEF;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) { file(p, f); };
    }
    rig(const rig&) = delete;
    byte_list last() const { return port.frames.back().data; }
};

} // namespace tests::typed
