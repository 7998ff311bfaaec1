// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model whose check before a command has a parameter too few, and would never be called.
// EXPECT: a model has each part of device/README.md, in the form that it has there
// MEND: static constexpr servobus::errc admit(const zlac::prepared_command&, servobus::duration) {
//     return servobus::errc::ok;
// }
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    static constexpr errc admit(const zlac::prepared_command&) { return errc::ok; } // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
