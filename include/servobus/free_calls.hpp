// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Free twins of a client's member templates, for generic code that would otherwise need `.template`.
#pragma once

#include <servobus/client.hpp>

namespace servobus {

/// `c.read<Rs...>()`
template <const auto&... Rs, class Line, class Device> constexpr auto read(client<Line, Device>& c) {
    return c.template read<Rs...>();
}
/// `c.read<Rows>(index)`
template <const auto& Rows, class Line, class Device>
constexpr auto read(client<Line, Device>& c, std::size_t index) {
    return c.template read<Rows>(index);
}
/// `c.write<R>(value)`
template <const auto& R, class Line, class Device>
requires is_register<R>
constexpr written write(client<Line, Device>& c, setting<R> value) { return c.template write<R>(value); }
/// `c.broadcast<R>(value)`
template <const auto& R, class Line, class Device>
constexpr written broadcast(client<Line, Device>& c, setting<R> value) {
    return c.template broadcast<R>(value);
}

} // namespace servobus
