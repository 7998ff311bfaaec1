// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A parameter number of the C630S with a digit missing.
// EXPECT: a_parameter_number_looks_like_P0B_17
// MEND: constexpr std::uint16_t address = "P0B-07"_p;
#include <servobus/device/c630s/registers/parameter_number.hpp>

#include "program.hpp"

using namespace servobus::c630s::literals;

int main() {
    constexpr std::uint16_t address = "P0B-7"_p; // wrong
    (void)address;
}
