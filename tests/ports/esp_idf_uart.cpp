// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ESP-IDF port over a fake UART driver.
#include "fakes/esp_idf.hpp"

#include "examples/ports/esp_idf_uart.hpp"

#include "contract.hpp"

using servobus::ports::esp_idf_uart;

namespace {

[[maybe_unused]] constinit esp_idf_uart made_without_a_constructor{UART_NUM_1};

struct rig {
    using port_type = esp_idf_uart;
    static constexpr bool tells_errors = true;
    static constexpr bool drives_by_itself = true;
    static constexpr bool can_refuse = true;

    rig() {
        fake::esp_idf::reset();
        REQUIRE(it.start({115200, UART_PARITY_DISABLE, UART_STOP_BITS_1}, 17, 16, 4));
    }
    esp_idf_uart& port() { return it; }
    void refuse_next() { fake::esp_idf::refuses = true; }

    esp_idf_uart it{UART_NUM_1};
};

} // namespace

TEST_CASE("ESP-IDF UART") { contract::all<rig>(); }
