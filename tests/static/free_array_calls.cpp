// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The free calls of arrays of registers, where nothing has named one of their elements before: g++ 12 did not
// find the type of `at`, a deduced one, while it chose an overload. It is checked by compiling it.
#include <cstddef>

#include <servobus/client/free_calls.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

namespace {

using namespace servobus;
using namespace servobus::units;
using axis = client<line<tests::scripted_port>, yako::open_loop::device>;

[[maybe_unused]] written set(axis& of, std::size_t index) {
    return write<yako::open_loop::position_segment_speeds>(of, index, 300 * r_per_min);
}
[[maybe_unused]] written keep(axis& of, std::size_t index) {
    return store<yako::open_loop::speed_segment_speeds>(of, index, 300 * r_per_min);
}

} // namespace
