// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The job of `full` without a client: frames made at compile time, and a line that is stepped.
#include "board.hpp"

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/line/line.hpp>

namespace {

using namespace servobus;

uart port_1;
line<uart, counters, unechoed> line_1{port_1, modbus::timing_at(115200)};

std::uint8_t response[21];

constexpr response_limits limits{};
constexpr bus_gaps gaps{.gap = milliseconds(2), .quarantine = milliseconds(100)};
constexpr auto state = modbus::read_frame(1, zlac8015d::left_faults.address, 8);
constexpr auto speeds = modbus::write_frame(1, zlac8015d::left_target_speed.address, {60, 50});

bool carry(bytes request) {
    modbus::exchange x{request, response, line_1.timing(), limits};
    while (!x.done()) line_1.step(x, gaps);
    return x.status() == errc::ok;
}

} // namespace

extern "C" bool job() {
    if (!carry(state)) return false;
    const words_view words{bytes{response}.subspan(3, 16)};
    const u32 left = join_words(words[2], words[3], word_order::high_first);
    const u32 right = join_words(words[4], words[5], word_order::high_first);
    return left < right && carry(speeds);
}
