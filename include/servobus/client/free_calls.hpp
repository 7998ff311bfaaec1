// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The member templates of a client as free functions. Generic code includes it, where the type of the
// client depends on a template parameter: a member call needs `.template` there.
//
//     template <class Line> auto voltage_of(client<Line, zlac8015d::device>& wheels) {
//         return read<zlac8015d::bus_voltage>(wheels); // not wheels.template read<zlac8015d::bus_voltage>()
//     }
#pragma once

#include <cstddef>

#include <servobus/client/client.hpp>

namespace servobus {

/// `c.read<Rs...>()`
template <const auto&... Rs, class Line, class Device, class Node>
constexpr auto read(client<Line, Device, Node>& c) {
    return c.template read<Rs...>();
}
/// `c.read<Rows>(index)`
template <const auto& Rows, class Line, class Device, class Node>
constexpr auto read(client<Line, Device, Node>& c, std::size_t index) {
    return c.template read<Rows>(index);
}

/// `c.write<Rs...>(values...)`
template <const auto&... Rs, class Line, class Device, class Node>
requires((is_register<Rs> || is_bit<Rs>)&&...) constexpr status
    write(client<Line, Device, Node>& c, register_value<Rs>... values) {
    return c.template write<Rs...>(values...);
}
/// `c.write<R>(value, token)`
template <const auto& R, class Line, class Device, class Node>
requires is_register<R>
constexpr status write(client<Line, Device, Node>& c, register_value<R> value, ram_only token) {
    return c.template write<R>(value, token);
}
/// `c.write<Rows>(index, value)`
template <const auto& Rows, class Line, class Device, class Node>
requires is_register_array<Rows>
constexpr status write(client<Line, Device, Node>& c, std::size_t index, register_value<at<Rows, 0>> value) {
    return c.template write<Rows>(index, value);
}
/// `c.write<Rows>(index, value, token)`
template <const auto& Rows, class Line, class Device, class Node>
requires is_register_array<Rows>
constexpr status write(client<Line, Device, Node>& c, std::size_t index, register_value<at<Rows, 0>> value,
                       ram_only token) {
    return c.template write<Rows>(index, value, token);
}

/// `c.store<Rs...>(values...)`
template <const auto&... Rs, class Line, class Device, class Node>
requires((is_register<Rs> || is_bit<Rs>)&&...) constexpr status
    store(client<Line, Device, Node>& c, register_value<Rs>... values) {
    return c.template store<Rs...>(values...);
}
/// `c.store<Rows>(index, value)`
template <const auto& Rows, class Line, class Device, class Node>
requires is_register_array<Rows>
constexpr status store(client<Line, Device, Node>& c, std::size_t index, register_value<at<Rows, 0>> value) {
    return c.template store<Rows>(index, value);
}

/// `c.write_if_different<R>(value)`
template <const auto& R, class Line, class Device, class Node>
constexpr status write_if_different(client<Line, Device, Node>& c, register_value<R> value) {
    return c.template write_if_different<R>(value);
}
/// `c.store_if_different<R>(value)`
template <const auto& R, class Line, class Device, class Node>
constexpr status store_if_different(client<Line, Device, Node>& c, register_value<R> value) {
    return c.template store_if_different<R>(value);
}

/// `c.broadcast<Rs...>(values...)`
template <const auto&... Rs, class Line, class Device, class Node>
constexpr status broadcast(client<Line, Device, Node>& c, register_value<Rs>... values) {
    return c.template broadcast<Rs...>(values...);
}

} // namespace servobus
