// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model whose feedback is longer than the buffer that the facade has for a response.
// EXPECT: the feedback of a model is at most 11 registers
// MEND: static constexpr servobus::feedback_blocks blocks{servobus::image_of<zlac::status_word>::block};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    static constexpr feedback_blocks blocks{register_block{zlac::status_word.address, 12}}; // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
