// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of a device whose profile has neither a word order nor a register that switches it.
// EXPECT: a server has one word order, or a register that switches it: state it in the device's profile
// MEND: (void)servobus::row_values<tank::dose>{};
#include "served.hpp"

namespace odd {
struct device {
    static constexpr servobus::profile facts{.name = "odd", .word_order = servobus::word_order::unknown};
};
inline constexpr servobus::reg<servobus::u32, servobus::access::rw, device> dose{
    0x0001, {0, 90'000}, servobus::no_unit, 0};
} // namespace odd

int main() {
    (void)servobus::row_values<odd::dose>{}; // wrong
}
