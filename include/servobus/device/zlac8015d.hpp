// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D dual hub servo: its registers and its drive. The catalogue for tools is a header of its
// own, zlac8015d/catalogue.hpp.
#pragma once

#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/device/zlac8015d/orders.hpp>
#include <servobus/device/zlac8015d/parameters.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/device/zlac8015d/values.hpp>
