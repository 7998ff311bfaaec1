// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device that is said to give more registers in a read than a frame has room for.
// EXPECT: a frame has room for 125 registers that are read
// MEND: static constexpr servobus::profile facts{.name = "talkative", .max_read = 125};
#include "program.hpp"

struct talkative {
    static constexpr servobus::profile facts{.name = "talkative", .max_read = 126}; // wrong
};

servobus::client<servobus::line<some_port>, talkative>* drive = nullptr;

int main() { return drive->node().address(); }
