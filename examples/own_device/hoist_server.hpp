// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The device of hoist.hpp: a server on a UART, and the loop around it. Your UART is a port as in examples/ports. The
// firmware's main:
//
//     hoist::firmware<my_uart> hoist{uart, 7}; // node 7
//     for (;;) hoist.step(motor);              // at least once in t3.5, 1.75 ms above 19200 Bd
#pragma once

#include <servobus/server/row_server.hpp>

#include "hoist.hpp"

namespace hoist {

/// All rows of the device, in any order.
using values = servobus::row_values<operating_mode, speed, ramp, target, current_limit, options, status_word,
                                    position, load, fault, temperature, voltage, pump, fan, lamp, horn>;

/// The hooks around a write. A server with hooks has both.
struct hooks {
    bool is_new_target = false;

    /// Refuses a write by an exception number; 0 accepts it. Nothing is stored yet.
    std::uint8_t before_write(const servobus::changes<values>& written) {
        const bool starts =
            written.is_written<operating_mode>() && written.get<operating_mode>() != mode::off;
        return starts && written.get<fault>() != 0 ? 4 : 0;
    }
    void after_write(const servobus::changes<values>& written) {
        if (written.is_written<target>()) is_new_target = true;
    }
};

inline constexpr servobus::identity about[]{{0, "Example works"}, {1, "H-10"}, {2, "1.0"}};

/// The firmware. `Motor` is your drive electronics: `position()` in pulses, `current()` in 0.1 A, `go_to(pulses)`.
template <servobus::port Uart> class firmware {
  public:
    firmware(Uart& uart, std::uint8_t node_address) : server_{uart, values_, node_address, hooks_} {}

    template <class Motor> void step(Motor& motor) {
        server_.step();
        values_.set<position>(motor.position());
        values_.set<load>(servobus::raw(motor.current()));
        if (hooks_.is_new_target && values_.get<operating_mode>() == mode::move) {
            hooks_.is_new_target = false;
            motor.go_to(values_.get<target>());
        }
    }

  private:
    static constexpr auto timing =
        servobus::modbus::timing_at(device::facts.baud, servobus::modbus::timing_mode::strict);

    values values_;
    hooks hooks_;
    servobus::row_server<Uart, values, timing, servobus::with_mask_write,
                         servobus::with_identification<about>, servobus::with_hooks<hooks>>
        server_;
};

} // namespace hoist
