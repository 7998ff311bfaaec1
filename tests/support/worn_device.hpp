// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An invented device of which a client must learn everything: its word order, and whether writes wear its EEPROM.
#pragma once

#include <servobus/registers/profile.hpp>

namespace tests {

struct worn_device {
    static constexpr servobus::profile facts{.name = "worn",
                                             .highest_address = 99,
                                             .word_order = servobus::word_order::unknown,
                                             .word_order_register = 0x0019,
                                             .eeprom_switch = 0x0C0D,
                                             .limits = {.corrupted_request = 1}};
};

} // namespace tests
