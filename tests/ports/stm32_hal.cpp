// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The STM32 ports over a fake HAL, with the callbacks of a user's program.
#include "fakes/stm32_hal.hpp"

#include "examples/ports/stm32_hal_dma.hpp"
#include "examples/ports/stm32_hal_it.hpp"

#include "contract.hpp"

using namespace servobus::ports;

namespace {

stm32_hal_it* by_interrupt = nullptr;
stm32_hal_dma* by_dma = nullptr;

[[maybe_unused]] constinit stm32_hal_it made_without_a_constructor{fake::stm32::uart};
[[maybe_unused]] constinit stm32_hal_dma this_one_too{fake::stm32::uart};

template <class Port> struct rig_of {
    using port_type = Port;
    static constexpr bool tells_errors = true;
    static constexpr bool drives_by_itself = true;
    static constexpr bool can_refuse = true;

    explicit rig_of(rs485_pin pin = {&fake::stm32::bank, GPIO_PIN_1},
                    TIM_HandleTypeDef* timer = &fake::stm32::timer)
        : it{fake::stm32::uart, pin, timer} {
        fake::stm32::reset();
        if constexpr (std::is_same_v<Port, stm32_hal_it>)
            by_interrupt = &it;
        else
            by_dma = &it;
        REQUIRE(it.start());
    }
    ~rig_of() {
        by_interrupt = nullptr;
        by_dma = nullptr;
    }
    Port& port() { return it; }
    void refuse_next() { fake::stm32::refuses = true; }

    Port it;
};

/// The clock is HAL_GetTick, in milliseconds, and the USART switches the driver.
template <class Port> struct plain_rig : rig_of<Port> {
    plain_rig() : rig_of<Port>{{}, nullptr} { fake::stm32::drives_by_hardware = true; }
};

/// A receive DMA that is not circular.
struct normal_mode_rig : rig_of<stm32_hal_dma> {
    normal_mode_rig() { fake::stm32::is_circular = false; }
};

} // namespace

void HAL_UART_RxCpltCallback(UART_HandleTypeDef*) {
    if (by_interrupt != nullptr) by_interrupt->on_received();
}
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef*, uint16_t) {
    if (by_dma != nullptr) by_dma->on_received();
}
void HAL_UART_TxCpltCallback(UART_HandleTypeDef*) {
    if (by_interrupt != nullptr) by_interrupt->on_sent();
    if (by_dma != nullptr) by_dma->on_sent();
}
void HAL_UART_ErrorCallback(UART_HandleTypeDef*) {
    if (by_interrupt != nullptr) by_interrupt->on_error();
    if (by_dma != nullptr) by_dma->on_error();
}

TEST_CASE("STM32 HAL by interrupt, DE pin, 1 MHz timer") { contract::all<rig_of<stm32_hal_it>>(); }
TEST_CASE("STM32 HAL by interrupt, DE by the USART, HAL_GetTick") {
    contract::all<plain_rig<stm32_hal_it>>();
}
TEST_CASE("STM32 HAL by DMA, DE pin, 1 MHz timer") { contract::all<rig_of<stm32_hal_dma>>(); }
TEST_CASE("STM32 HAL by DMA, DE by the USART, HAL_GetTick") { contract::all<plain_rig<stm32_hal_dma>>(); }
TEST_CASE("STM32 HAL by DMA in normal mode") { contract::all<normal_mode_rig>(); }

TEST_CASE("STM32 HAL: reception that the HAL refused in an interrupt restarts") {
    contract::station<rig_of<stm32_hal_it>> s;
    s.check_works();
    fake::stm32::locked = 1;
    fake::line().arrive({0});
    fake::line().advance(1000);
    s.check_works();
}

TEST_CASE("STM32 HAL: after a transmission that the HAL gives up the driver is off") {
    fake::line() = {};
    rig_of<stm32_hal_dma> rig;
    REQUIRE(*rig.port().send(contract::request) == 8);
    fake::line().advance(100);
    fake::stm32::uart.gState = HAL_UART_STATE_READY; // as after a DMA error
    HAL_UART_ErrorCallback(&fake::stm32::uart);
    CHECK(rig.port().sent());
    CHECK_FALSE(fake::line().driver);
}
