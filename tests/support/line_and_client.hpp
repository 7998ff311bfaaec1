// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Includes the part of servobus.hpp below control, for tests of the lower rooms: a change above compiles none of them.
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/client/free_calls.hpp>
#include <servobus/client/node.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/core/bytes.hpp>
#include <servobus/core/cxx20.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>
#include <servobus/core/version.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/line/echo.hpp>
#include <servobus/line/line.hpp>
#include <servobus/line/observer.hpp>
#include <servobus/line/port.hpp>
#include <servobus/line/ring.hpp>
#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>
#include <servobus/registers/register_value.hpp>
#include <servobus/registers/unit.hpp>
#include <servobus/registers/wire.hpp>
