// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model whose last check before a command has a parameter too few, and would never be called.
// EXPECT: `admit` of the model has another form than device/README.md
// MEND: static constexpr servobus::errc admit(const zlac::prepared_command&, const servobus::response_limits&,
//                                      const servobus::bus_gaps&);
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    static constexpr errc admit(const zlac::prepared_command&, const response_limits&) {
        return errc::ok;
    } // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
