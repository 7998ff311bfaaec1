// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// SIGINT and SIGTERM as a question that a command asks between two requests.
#pragma once

#include <csignal>

namespace tool {

class interrupts {
  public:
    /// From here on a signal ends no program. It ends a sleep and a wait for input.
    static void arm() {
        struct sigaction act {};
        act.sa_handler = [](int) { came_ = 1; };
        (void)::sigaction(SIGINT, &act, nullptr);
        (void)::sigaction(SIGTERM, &act, nullptr);
    }
    static bool came() { return came_ != 0; }

  private:
    static inline volatile std::sig_atomic_t came_ = 0;
};

} // namespace tool
