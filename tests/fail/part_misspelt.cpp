// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model in which a name is misspelt: it would forget no target.
// EXPECT: a model has each part of device/README.md, in the form that it has there
// MEND: static constexpr void preempt(const zlac::prepared_command&) {}
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

class model : public zlac::model {
    using zlac::model::preempt; // not of the facade

  public:
    static constexpr void prempt(const zlac::prepared_command&) {} // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
