// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The umbrella header, a device and a client, for compilers that only compile it to an object file.
#include <servobus/servobus.hpp>

#include <servobus/device/zlac8015d.hpp>

using namespace servobus;

struct uart {
    transfer send(bytes frame);
    bool sent();
    transfer receive(byte_buffer into);
    instant now();
};

bool job(uart& rs485) {
    line wire{rs485, modbus::timing_at(115200)};
    client<decltype(wire), zlac8015d::device> wheels{wire, node<zlac8015d::device>{1}};
    const auto volts = wheels.read<zlac8015d::bus_voltage>();
    zlac8015d::drive both{wire, 1, unsupervised};
    return volts && both.run(init{}) && both.run(disable{});
}
