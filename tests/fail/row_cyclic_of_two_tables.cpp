// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A cyclic read of rows of two tables.
// EXPECT: a_cyclic_read_is_one_frame_of_adjacent_rows_of_a_table
// MEND: cyclic<basin::valve, basin::pump>(node<basin::device>{9}, milliseconds(50))
#include "basin.hpp"

using namespace servobus;

inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<basin::valve, basin::level>(node<basin::device>{9}, milliseconds(50))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
