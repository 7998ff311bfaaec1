// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register's name that a catalogue has no room for.
// EXPECT: a_name_has_at_most_47_characters
// MEND: inline constexpr servobus::label name = "left_position_at_the_last_stop";
#include <servobus/registers/catalogue.hpp>

inline constexpr servobus::label name = "position_of_the_left_wheel_when_it_was_last_stopped"; // wrong

int main() {}
