// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program of a user of a package: the library and a drive are found.
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

int main() {
    return servobus::modbus::write_frame(1, servobus::zlac8015d::control_word.address, 7).size == 8 ? 0 : 1;
}
