// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the wrong programs of servers have in common: the rows of a tank, and its values.
#pragma once

#include <cstdint>

#include <servobus/server/row_server.hpp>

namespace tank {
struct device {
    static constexpr servobus::profile facts{.name = "tank"};
};
template <class T, servobus::access Rights> using row = servobus::reg<T, Rights, device>;

inline constexpr row<servobus::u16, servobus::access::rw> limit{0x0000, {0, 900}, servobus::no_unit, 900};
inline constexpr row<servobus::u32, servobus::access::rw> dose{0x0001, {0, 90'000}, servobus::no_unit, 0};
inline constexpr row<servobus::u16, servobus::access::ro> level{0x0002, {0, 1000}, servobus::no_unit, 0};
inline constexpr row<servobus::u16, servobus::access::ro> flow{0x0003, {0, 1000}, servobus::no_unit, 0};
inline constexpr servobus::coil<servobus::access::rw, device> valve{0x0000};

inline servobus::u16 measured_flow() { return 5; }
} // namespace tank

struct silent_port {
    servobus::transfer send(servobus::bytes) { return std::uint16_t{0}; }
    bool sent() { return false; }
    servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
    servobus::instant now() { return {}; }
};

namespace pump {
struct device {
    static constexpr servobus::profile facts{.name = "pump"};
};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, device> speed{
    0x0010, {0, 3000}, servobus::no_unit, 0};
} // namespace pump

namespace scale {
struct device {
    static constexpr servobus::profile facts{
        .name = "scale", .word_order = servobus::word_order::unknown, .word_order_register = 0x0001};
};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, device> pair_word_order{
    0x0001, {0, 1}, servobus::no_unit, 0};
inline constexpr servobus::reg<servobus::u32, servobus::access::ro, device> weight{
    0x0010, {0, 90'000}, servobus::no_unit, 0};
} // namespace scale

using tank_values = servobus::row_values<tank::limit, tank::flow, tank::valve>;
using tank_changes = servobus::changes<tank_values>;
