// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any value of any Modbus device: floats, 64 bits, text, parts of a register, offsets, codes that mean "no value",
// scales in other registers. It has any_device.hpp too. Programs without such values pay nothing for it.
//
//     client meter{wire, node<sdm120::device>{1}}; // sdm120::voltage: an input_reg<f32, device>, in volts
//     if (const auto voltage = meter.read<sdm120::voltage>()) {
//         if (const auto millivolts = voltage->rounded(units::millivolt)) show(*millivolts); // none: a NaN
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/any_device.hpp>
#include <servobus/registers/values.hpp>
