// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The part of the HAL that the STM32 ports use: it keeps the caller's pointer, calls back from interrupts,
// and ends reception after an overrun (interrupts) or after any error (DMA).
#pragma once

#include "main.h"

#include "../wire.hpp"

namespace fake::stm32 {

inline DMA_HandleTypeDef dma;
inline UART_HandleTypeDef uart{&dma, HAL_UART_STATE_READY, HAL_UART_STATE_READY, HAL_UART_ERROR_NONE};
inline GPIO_TypeDef bank;
inline TIM_HandleTypeDef timer;

inline bool refuses = false; // refuses the next transmission
inline int locked = 0;       // the number of calls of Receive to refuse
inline bool drives_by_hardware = false;
inline bool is_circular = true;
inline std::uint8_t* to = nullptr; // the receive buffer
inline std::uint16_t room = 0, written = 0;
inline std::uint64_t last = 0;

inline void reset() {
    uart = {&dma, HAL_UART_STATE_READY, HAL_UART_STATE_READY, HAL_UART_ERROR_NONE};
    refuses = drives_by_hardware = false;
    is_circular = true;
    locked = 0;
}

inline void leave(const std::uint8_t* data, std::uint16_t size) {
    if (drives_by_hardware) line().drive(true);
    line().transmit(*data, [data, size] {
        if (size > 1) return leave(data + 1, static_cast<std::uint16_t>(size - 1));
        if (drives_by_hardware) line().drive(false);
        uart.gState = HAL_UART_STATE_READY;
        HAL_UART_TxCpltCallback(&uart);
    });
}

inline HAL_StatusTypeDef transmit(const std::uint8_t* data, std::uint16_t size) {
    if (std::exchange(refuses, false)) return HAL_ERROR;
    if (uart.gState != HAL_UART_STATE_READY) return HAL_BUSY;
    uart.gState = HAL_UART_STATE_BUSY_TX;
    leave(data, size);
    return HAL_OK;
}

inline bool may_receive(std::uint8_t* data, std::uint16_t size) {
    if (locked > 0) return --locked, false;
    if (uart.RxState != HAL_UART_STATE_READY) return false;
    uart.RxState = HAL_UART_STATE_BUSY_RX;
    to = data;
    room = size;
    written = 0;
    uart.ErrorCode = HAL_UART_ERROR_NONE;
    dma.counter = size;
    return true;
}

inline void hear_by_interrupt(std::uint8_t byte, damage how) {
    if (uart.RxState != HAL_UART_STATE_BUSY_RX) return;
    if (how != damage::overrun) {
        *to = byte;
        uart.RxState = HAL_UART_STATE_READY;
        uart.ErrorCode = how == damage::framing ? HAL_UART_ERROR_FE : HAL_UART_ERROR_NONE;
        HAL_UART_RxCpltCallback(&uart);
    } else {
        uart.RxState = HAL_UART_STATE_READY;
    }
    if (how != damage::none) HAL_UART_ErrorCallback(&uart);
}

inline void event() {
    const std::uint16_t at = written;
    if (is_circular && written == room) written = 0;
    dma.counter = static_cast<std::uint32_t>(room - written);
    if (!is_circular) uart.RxState = HAL_UART_STATE_READY;
    HAL_UARTEx_RxEventCallback(&uart, at);
}

inline void hear_by_dma(std::uint8_t byte, damage how) {
    if (uart.RxState != HAL_UART_STATE_BUSY_RX) return;
    if (how != damage::none) {
        uart.RxState = HAL_UART_STATE_READY;
        return HAL_UART_ErrorCallback(&uart);
    }
    to[written++] = byte;
    dma.counter = static_cast<std::uint32_t>(room - written);
    last = line().now;
    if (written == room || (is_circular && written == room / 2)) return event();
    line().in(wire::character, [at = last] {
        if (last == at && written != 0 && uart.RxState == HAL_UART_STATE_BUSY_RX) event();
    });
}

} // namespace fake::stm32

extern "C" {
inline uint32_t stub_timer_counter(const TIM_HandleTypeDef*) {
    return static_cast<std::uint32_t>(fake::line().look());
}
inline uint32_t HAL_GetTick(void) { return static_cast<std::uint32_t>(fake::line().look() / 1000); }
inline void HAL_GPIO_WritePin(GPIO_TypeDef* bank, uint16_t pin, GPIO_PinState state) {
    if (bank == &fake::stm32::bank && pin == GPIO_PIN_1) fake::line().drive(state == GPIO_PIN_SET);
}
inline HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef*, const uint8_t* data, uint16_t size) {
    return fake::stm32::transmit(data, size);
}
inline HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef*, const uint8_t* data, uint16_t size) {
    return fake::stm32::transmit(data, size);
}
inline HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef*, uint8_t* data, uint16_t size) {
    if (!fake::stm32::may_receive(data, size)) return HAL_BUSY;
    fake::line().hears = fake::stm32::hear_by_interrupt;
    return HAL_OK;
}
inline HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_DMA(UART_HandleTypeDef*, uint8_t* data, uint16_t size) {
    if (!fake::stm32::may_receive(data, size)) return HAL_BUSY;
    fake::line().hears = fake::stm32::hear_by_dma;
    return HAL_OK;
}
}
