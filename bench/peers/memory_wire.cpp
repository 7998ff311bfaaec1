// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The wire in memory. It is a separate source file on purpose: see its header.
#include "memory_wire.h"

#include <cstring>

size_t wire_send(void* wire, const uint8_t* bytes, size_t count) {
    auto* const w = static_cast<memory_wire*>(wire);
    std::memcpy(w->request, bytes, count);
    w->request_size = count;
    w->arrived = w->response_size;
    return count;
}

size_t wire_receive(void* wire, uint8_t* bytes, size_t room) {
    auto* const w = static_cast<memory_wire*>(wire);
    if (w->arrived == 0) return 0;
    const size_t count = room < w->arrived ? room : w->arrived;
    std::memcpy(bytes, w->response + (w->response_size - w->arrived), count);
    w->arrived -= count;
    return count;
}

uint32_t wire_now(void* wire) { return static_cast<memory_wire*>(wire)->clock++; }
