// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A broadcast that would give all drives of the line one address.
// EXPECT: a setting of the line goes to one node at a time, never to all of them
// MEND: (void)drive.write<zlac::node_address>(2);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.broadcast<zlac::node_address>(2); // wrong
}
