// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The FreeRTOS mix-in over the interrupt-driven STM32 port.
#include "fakes/freertos.hpp"
#include "fakes/stm32_hal.hpp"

#include "examples/ports/freertos_waiting.hpp"
#include "examples/ports/stm32_hal_it.hpp"

#include "contract.hpp"

namespace {

using waiting_port = servobus::ports::freertos_waiting<servobus::ports::stm32_hal_it>;
static_assert(servobus::waiting_port<waiting_port>);

[[maybe_unused]] constinit waiting_port made_without_a_constructor{fake::stm32::uart};
waiting_port* made = nullptr;

struct rig {
    using port_type = waiting_port;
    static constexpr bool tells_errors = true;
    static constexpr bool drives_by_itself = true;
    static constexpr bool can_refuse = true;

    rig() {
        fake::stm32::reset();
        fake::freertos::task = {};
        made = &it;
        REQUIRE(it.start());
    }
    ~rig() { made = nullptr; }
    waiting_port& port() { return it; }
    void refuse_next() { fake::stm32::refuses = true; }

    waiting_port it{fake::stm32::uart, servobus::ports::rs485_pin{&fake::stm32::bank, GPIO_PIN_1},
                    &fake::stm32::timer};
};

} // namespace

void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) {
    if (made != nullptr) made->on_received(), made->wake_from_isr();
}
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef*, uint16_t) {}
void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) {
    if (made != nullptr) made->on_sent(), made->wake_from_isr();
}
void HAL_UART_ErrorCallback(UART_HandleTypeDef*) {
    if (made != nullptr) made->on_error(), made->wake_from_isr();
}

TEST_CASE("FreeRTOS waiting over STM32 HAL") { contract::all<rig>(); }

TEST_CASE("FreeRTOS waiting: a blocking call sleeps") {
    contract::station<rig> s;
    s.check_works();
    fake::freertos::sleeps = 0;
    s.check_works();
    CHECK(fake::freertos::sleeps >= 2);
    CHECK(fake::freertos::sleeps < 60);
}
