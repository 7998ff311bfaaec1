// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The port of all sides of the benchmarks: a wire in memory. Sending copies the request and makes the
// prepared response arrive immediately; the clock is a counter. Its functions are in a separate source
// file, so that no side inlines them, and can be used as callbacks in C.
#ifndef SERVOBUS_BENCH_MEMORY_WIRE_H
#define SERVOBUS_BENCH_MEMORY_WIRE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct memory_wire {
    uint8_t request[256]; // the last request
    size_t request_size;
    uint8_t response[256]; // the response to any request
    size_t response_size;
    size_t arrived; // bytes of the response that are still to be received
    uint32_t clock; // us; increases by one at each reading
} memory_wire;

size_t wire_send(void* wire, const uint8_t* bytes, size_t count);
size_t wire_receive(void* wire, uint8_t* bytes, size_t room);
uint32_t wire_now(void* wire);

#ifdef __cplusplus
}
#endif

#endif
