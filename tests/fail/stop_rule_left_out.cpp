// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model that does not say whether its drive is stopped after a restart.
// EXPECT: must_be_stated
// MEND: static constexpr servobus::stop_rules stops{.at_fault = servobus::stop_priority::disable,
//     .after_restart = false,
//     .disable_replaces_quick_stop = false};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    static constexpr stop_rules stops{.at_fault = stop_priority::disable, // wrong
                                      .disable_replaces_quick_stop = false};
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
