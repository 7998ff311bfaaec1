// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The job of the programs: it reads the faults, positions and speeds of both wheels, 8 registers from
// 20A5h, in one frame, and writes both target speeds, 2 registers at 2088h, in one frame.
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

template <class Client> static bool read_and_write(Client& drive) {
    using namespace servobus::zlac8015d;
    const auto state = drive.template read<left_faults, right_faults, left_actual_position,
                                           right_actual_position, left_actual_speed, right_actual_speed>();
    if (!state) return false;
    const bool is_left_behind =
        state->template get<left_actual_position>() < state->template get<right_actual_position>();
    return is_left_behind &&
           drive.template write<left_target_speed, right_target_speed>(servobus::raw(60), servobus::raw(50));
}
