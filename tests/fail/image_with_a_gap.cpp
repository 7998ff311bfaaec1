// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A block of the feedback whose rows are not adjacent: one frame does not read them.
// EXPECT: a_step_is_of_adjacent_registers
// MEND: static constexpr servobus::feedback_blocks blocks{servobus::image_of<zlac::status_word>::block};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    using image = image_of<zlac::status_word, zlac::left_faults>; // wrong
    static constexpr feedback_blocks blocks{image::block};
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
