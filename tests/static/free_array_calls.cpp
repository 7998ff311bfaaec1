// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The free calls of arrays of registers, where no earlier code names one of their elements: g++ 12 did not
// find the deduced type of `at` during overload resolution. Compiling this file checks it.
#include <cstddef>

#include <servobus/client/free_calls.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

namespace free_array_calls_tests {

namespace {

using namespace servobus;
using namespace servobus::units;
using axis = client<line<tests::scripted_port>, yako::open_loop::device>;

[[maybe_unused]] status set(axis& of, std::size_t index) {
    return write<yako::open_loop::position_segment_speeds>(of, index, 300 * r_per_min);
}
[[maybe_unused]] status keep(axis& of, std::size_t index) {
    return store<yako::open_loop::speed_segment_speeds>(of, index, 300 * r_per_min);
}

} // namespace

} // namespace free_array_calls_tests
