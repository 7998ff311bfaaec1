// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The RP2040 port over a fake SDK.
#include "fakes/rp2040.hpp"

#include "examples/ports/rp2040_uart.hpp"

#include "contract.hpp"

using servobus::ports::rp2040_uart;

namespace {

[[maybe_unused]] constinit rp2040_uart made_without_a_constructor{&fake::rp2040::uart, 2, 115200};

struct rig {
    using port_type = rp2040_uart;
    static constexpr bool tells_errors = true;
    static constexpr bool drives_by_itself = true;
    static constexpr bool can_refuse = true;

    rig() {
        fake::rp2040::reset();
        fake::rp2040::interrupt = [this] { it.on_interrupt(); };
        it.start();
    }
    ~rig() { CHECK(fake::rp2040::lost == 0); }
    rp2040_uart& port() { return it; }
    void refuse_next() { fake::rp2040::refuses = true; }

    rp2040_uart it{&fake::rp2040::uart, fake::rp2040::driver_pin, 115200};
};

} // namespace

TEST_CASE("RP2040 UART") { contract::all<rig>(); }
