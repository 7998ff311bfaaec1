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

extern "C" {
extern std::uint32_t stack_end[];
extern std::uint32_t data_image[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void (*const constructors_begin[])();
extern void (*const constructors_end[])();
[[noreturn]] void reset();
void measured_job_begins();
void measured_job_ends();
}

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

[[noreturn]] void fault() {
    for (;;) {}
}
void call_host(std::uint32_t what, const void* with) {
    __asm__ volatile("mov r0, %0\n\tmov r1, %1\n\tbkpt 0xAB" : : "r"(what), "r"(with) : "r0", "r1", "memory");
}
[[noreturn]] void leave(std::uint32_t status) {
    const std::uint32_t block[]{0x20026, status};
    call_host(0x20, block);
    for (;;) {}
}
// Without a division, as in board.cpp.
void print(std::uint32_t number) {
    char digits[6];
    for (std::size_t i = 0; i < 4; ++i) digits[i] = '0';
    digits[4] = '\n';
    digits[5] = '\0';
    std::uint32_t place = 1000;
    for (std::size_t i = 0; i < 4; ++i, place = place == 1000 ? 100 : place == 100 ? 10 : 1) {
        for (; number >= place; number -= place) ++digits[i];
    }
    call_host(0x04, digits);
}

using handler = void (*)();
struct vector_table {
    std::uint32_t* stack;
    handler first[15];
};
[[gnu::section(".vectors"), gnu::used]] constinit const vector_table vectors{
    stack_end,
    {reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault,
     fault}};

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

[[gnu::noinline]] void measured_job_begins() { __asm__ volatile(""); }
[[gnu::noinline]] void measured_job_ends() { __asm__ volatile(""); }

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
    const std::uint32_t* from = data_image;
    for (std::uint32_t* to = data_begin; to != data_end; ++to, ++from) *to = *from;
    for (std::uint32_t* to = bss_begin; to != bss_end; ++to) *to = 0;
    for (const handler* f = constructors_begin; f != constructors_end; ++f) (*f)();
    board_serves(&exchanges[1]); // so that the first response of the list is right
    board_serves(&exchanges[2]);
    board_serves_all();

    constexpr std::uint32_t untouched = 0xDEAD'BEEF;
    constexpr std::size_t deepest = 512;
    volatile std::uint32_t* top = nullptr; // the stack of the requests begins below
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (std::size_t i = 1; i <= deepest; ++i) *(top - i) = untouched;
    board_serves_all();
    std::size_t used = deepest;
    while (used != 0 && *(top - used) == untouched) --used;
    print(static_cast<std::uint32_t>(used * sizeof *top));
    measured_job_begins();
    board_serves(&exchanges[0]);
    measured_job_ends();
    leave(is_wrong ? 1 : 0);
}
}
