// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The port that all sides of the benchmarks stand on: a wire in memory. Sending copies the request and makes
// the prepared response arrive at once; the clock is a counter. Its functions live in a source file of their
// own, so that no side has them inlined, and serve as callbacks in C.
#ifndef SERVOBUS_BENCH_MEMORY_WIRE_H
#define SERVOBUS_BENCH_MEMORY_WIRE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct memory_wire {
    uint8_t request[256]; // what was sent last
    size_t request_size;
    uint8_t response[256]; // what the device answers to any request
    size_t response_size;
    size_t arrived; // bytes of the response that are still to be received
    uint32_t clock; // us; counts on by one at each look
} memory_wire;

size_t wire_send(void* wire, const uint8_t* bytes, size_t count);
size_t wire_receive(void* wire, uint8_t* bytes, size_t room);
uint32_t wire_now(void* wire);

#ifdef __cplusplus
}
#endif

#endif
