// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The whole library but devices, catalogues, simulators and hosted ports, which are included by name.
#pragma once

#include <servobus/bus.hpp>
#include <servobus/bytes.hpp>
#include <servobus/client.hpp>
#include <servobus/drive.hpp>
#include <servobus/echo.hpp>
#include <servobus/free_calls.hpp>
#include <servobus/line.hpp>
#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/node.hpp>
#include <servobus/observer.hpp>
#include <servobus/poll_plan.hpp>
#include <servobus/port.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>
#include <servobus/registers/setting.hpp>
#include <servobus/registers/unit.hpp>
#include <servobus/registers/wire.hpp>
#include <servobus/result.hpp>
#include <servobus/ring.hpp>
#include <servobus/sequence.hpp>
#include <servobus/small_line.hpp>
#include <servobus/step.hpp>
#include <servobus/time.hpp>
