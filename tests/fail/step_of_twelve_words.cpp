// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that reads more words than a short frame has.
// EXPECT: a_step_is_one_short_frame
// MEND: inline constexpr servobus::step look = servobus::steps::fetch<servobus::at<places, 0>,
// servobus::at<places, 1>>();
#include "program.hpp"

inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw, zlac::device>, 8>
    places{{0x3000, servobus::full<servobus::u32>, servobus::no_unit, 0}, 2};
inline constexpr servobus::step look =
    servobus::steps::fetch<servobus::at<places, 0>, servobus::at<places, 1>, servobus::at<places, 2>,
                           servobus::at<places, 3>, servobus::at<places, 4>,
                           servobus::at<places, 5>>(); // wrong

int main() {}
