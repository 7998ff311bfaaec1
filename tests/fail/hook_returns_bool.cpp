// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A hook of a server that returns true for an exception.
// EXPECT: hooks are std::uint8_t before_write(const changes<Values>&) and void after_write of the same
// MEND:     std::uint8_t before_write(const tank_changes&) { return 0; }
//     void after_write(const tank_changes&) {}
#include "served.hpp"

struct hooks {
    bool before_write(const tank_changes&) { return true; } // wrong
    void after_write(const tank_changes&) {}
};

int main() {
    tank_values values;
    hooks own;
    (void)servobus::request_executor<tank_values, servobus::with_hooks<hooks>>{values, own};
}
