// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives both wheels of a ZLAC8015D over Serial1; pin 2 switches the RS-485 driver. The wheels turn slowly as long as
// pin 3 is connected to ground, and stop when it is not. No call waits.
#include <servobus.h>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/ports/arduino_stream.hpp>

namespace zlac = servobus::zlac8015d;
using servobus::command_status;
using servobus::errc;
using servobus::units::r_per_min;

constexpr uint32_t baud = zlac::device::facts.baud;
constexpr uint8_t run_switch = 3;

servobus::ports::arduino_stream rs485{Serial1, 2, baud};
servobus::line wire{rs485, servobus::modbus::timing_at(baud)};
zlac::drive wheels{wire, 1, {.command_timeout = servobus::milliseconds(500)}};

enum class commands { init, enable, turn, disable };
commands command = commands::init;
command_status begun; // false: the command was refused
uint32_t begun_at = 0;
constexpr uint32_t period = 100; // ms from one command to the next: below the command timeout

command_status begin(commands next) {
    switch (next) {
    case commands::init: return wheels.begin(servobus::init{});
    case commands::enable: return wheels.begin(servobus::enable{});
    case commands::turn: return wheels.begin(servobus::velocity{30 * r_per_min, -30 * r_per_min});
    case commands::disable: return wheels.begin(servobus::disable{});
    }
    return errc::bad_argument;
}

// After a refusal or a failure everything begins again with init, which reads the drive's state.
commands next_command(bool is_to_turn) {
    if (!begun || !wheels.last()) return commands::init;
    const bool is_enabled = command == commands::enable || command == commands::turn;
    if (is_to_turn) return is_enabled ? commands::turn : command == commands::init ? commands::enable : commands::init;
    return is_enabled ? commands::disable : commands::init;
}

void setup() {
    pinMode(run_switch, INPUT_PULLUP);
    Serial1.begin(baud);
    rs485.start();
    begun = begin(command);
}

void loop() {
    wheels.step();
    if (!wheels.is_idle() || static_cast<uint32_t>(millis()) - begun_at < period) return;
    begun_at = millis();
    command = next_command(digitalRead(run_switch) == LOW);
    begun = begin(command);
}
