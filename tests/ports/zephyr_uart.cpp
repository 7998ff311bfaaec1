// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The Zephyr port over a fake kernel and driver.
#include <array>

#include "fakes/zephyr.hpp"

#include "examples/ports/zephyr_uart.hpp"

#include "contract.hpp"

using servobus::ports::zephyr_uart;

namespace {

[[maybe_unused]] constinit zephyr_uart made_without_a_constructor{&fake::zephyr::uart, nullptr, 115200};

struct rig {
    using port_type = zephyr_uart;
    static constexpr bool tells_errors = true;
    static constexpr bool drives_by_itself = true;
    static constexpr bool can_refuse = true;

    rig() {
        fake::zephyr::reset();
        REQUIRE(it.start());
    }
    zephyr_uart& port() { return it; }
    void refuse_next() { fake::zephyr::refuses = true; }

    zephyr_uart it{&fake::zephyr::uart, &fake::zephyr::pin, 115200};
};

} // namespace

TEST_CASE("Zephyr UART") { contract::all<rig>(); }

TEST_CASE("Zephyr UART: reception that could not restart in the event restarts later") {
    contract::station<rig> s;
    s.check_works();
    fake::zephyr::deaf = 1;
    fake::line().damaged = 0;
    fake::line().how = fake::damage::framing;
    fake::line().arrive({0});
    fake::line().advance(1000);
    fake::line().damaged = SIZE_MAX;
    std::array<std::uint8_t, 4> in{};
    CHECK(s.rig.port().receive(in).error() == servobus::errc::receive_failed);
    s.check_works();
}
