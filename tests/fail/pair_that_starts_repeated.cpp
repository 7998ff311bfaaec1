// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A repeatable step with a 32-bit value of which only the low word is that of a stop.
// EXPECT: a_repeatable_step_stops_the_drive_see_stop_words
// MEND: inline constexpr servobus::step stopped = servobus::steps::repeatable(servobus::steps::write<travel>(0x1'0000));
#include "program.hpp"
#include "travel.hpp"

inline constexpr servobus::step stopped =
    servobus::steps::repeatable(servobus::steps::write<travel>(0x2'0000)); // wrong

int main() {}
