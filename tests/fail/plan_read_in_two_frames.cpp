// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A cyclic read of registers that do not lie side by side.
// EXPECT: a_cyclic_read_is_one_frame_of_adjacent_rows_of_a_table
// MEND: cyclic<zlac::left_actual_speed, zlac::right_actual_speed>(node<zlac::device>{1}, milliseconds(50))
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac::status_word, zlac::left_actual_speed>(node<zlac::device>{1}, milliseconds(50))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
