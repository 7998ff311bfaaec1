// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The board of the measured servers, from reset on, for qemu's mps2-an386: a client that sends each request of a list,
// lets t3.5 pass and compares the response. All requests are served twice, the second time with the stack painted; then
// the read of twelve words once between two marks. The exit status is 0 if each response was right. The program prints
// the stack that the requests used.
#include "board.hpp"

#include <cstddef>
#include <cstdint>

#include "machine.hpp"

namespace {

/// A frame without its CRC, which is computed bit by bit.
struct frame {
    std::uint8_t size = 0;
    std::uint8_t data[36]{};

    template <class... Bytes> constexpr frame(Bytes... bytes) {
        ((data[size++] = static_cast<std::uint8_t>(bytes)), ...);
        unsigned crc = 0xFFFF;
        for (std::size_t i = 0; i < size; ++i) {
            crc ^= data[i];
            for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xA001u : 0u);
        }
        data[size++] = static_cast<std::uint8_t>(crc & 0xFFu);
        data[size++] = static_cast<std::uint8_t>(crc >> 8);
    }
};
struct exchange {
    frame request;
    frame response;
};

constexpr exchange exchanges[]{
    {{1, 3, 0, 0, 0, 12},
     {1, 3, 24, 0, 0, 0, 30, 0, 100, 0, 0, 3, 0xE8, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}},
    {{1, 0x10, 0, 1, 0, 4, 8, 0, 30, 0, 100, 0, 0, 3, 0xE8}, {1, 0x10, 0, 1, 0, 4}},
    {{1, 6, 0, 5, 0, 10}, {1, 6, 0, 5, 0, 10}},
    {{1, 6, 0, 5, 1, 44}, {1, 0x86, 3}},
    {{1, 3, 0, 12, 0, 1}, {1, 0x83, 2}},
#ifndef ONLY_HOLDING
    {{1, 0x0F, 0, 0, 0, 4, 1, 5}, {1, 0x0F, 0, 0, 0, 4}},
    {{1, 1, 0, 0, 0, 4}, {1, 1, 1, 5}},
    {{1, 5, 0, 2, 0xFF, 0}, {1, 5, 0, 2, 0xFF, 0}},
    {{1, 4, 0, 0, 0, 2}, {1, 4, 4, 0, 25, 9, 96}},
#endif
};

const exchange* now = exchanges;
std::size_t taken = 0, given = 0;
bool is_wrong = false;
std::uint32_t time_us = 0;

} // namespace

extern "C" {

[[gnu::noinline]] std::uint32_t uart_send(const std::uint8_t* data, std::uint32_t size) {
    for (std::uint32_t i = 0; i < size; ++i, ++given) {
        if (given >= now->response.size || data[i] != now->response.data[given]) is_wrong = true;
    }
    return size;
}
[[gnu::noinline]] bool uart_sent() { return true; }
[[gnu::noinline]] std::int32_t uart_receive() {
    return taken == now->request.size ? -1 : now->request.data[taken++];
}
// After the last byte of a request each reading is later than t3.5.
[[gnu::noinline]] std::uint32_t clock_us() { return time_us += taken == now->request.size ? 2000u : 50u; }

// From the first byte of a request until the response has left and a gap after it has ended.
[[gnu::always_inline]] inline void serve_one(const exchange* next) {
    now = next;
    taken = given = 0;
    for (std::size_t i = 0; i < next->request.size + std::size_t{4}; ++i) is_wrong = !job() || is_wrong;
    is_wrong = is_wrong || given != next->response.size;
}
[[gnu::noinline]] void board_serves(const exchange* next) { serve_one(next); }
[[gnu::noinline]] void board_serves_all() {
    for (const exchange& each : exchanges) serve_one(&each);
}

[[noreturn]] void reset() {
    prepare_memory();
    board_serves(&exchanges[1]); // so that the first response of the list is right
    board_serves(&exchanges[2]);
    board_serves_all();

    const painted_stack stack;
    board_serves_all();
    print(stack.used());
    measured_job_begins();
    board_serves(&exchanges[0]);
    measured_job_ends();
    leave(is_wrong ? 1 : 0);
}
}
