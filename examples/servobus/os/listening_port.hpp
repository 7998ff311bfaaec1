// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port that cannot transmit: it has no function that does, and a serial device is opened for reading only, so
// that the system refuses it too.
#pragma once

#include "port.hpp"

namespace tool {

class listening_port {
  public:
    /// Returns `done`, or the exit status after a complaint.
    int open(const char* name, serial_settings settings) {
        settings.receive_only = true;
        return port_.open(name, settings);
    }
    const any_port& port() const { return port_; }
    servobus::transfer receive(servobus::byte_buffer in) { return port_.receive(in); }
    servobus::instant now() const { return port_.now(); }
    void wait(servobus::duration d) { port_.wait(d); }

  private:
    any_port port_{};
};

template <class Port>
concept can_transmit = requires(Port& p, servobus::bytes out) {
    p.send(out);
};
static_assert(can_transmit<any_port> && !can_transmit<listening_port>);

} // namespace tool
