// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The board of the measured programs, from reset on, for qemu's mps2-an385: the user's four functions with a
// drive's answers behind them, and the job, once to warm up and once between two marks. The exit status is 0
// if both jobs were done; the stack that the measured one used, without the user's functions, is printed.
#include "board.hpp"

#include <cstddef>

int main();

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

// The answers: 8 registers, and the echo of the write's header. 01 03 10 ... and 01 10 20 88 00 02.
constexpr std::uint8_t read_reply[] = {0x01, 0x03, 0x10, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00,
                                       0x00, 0x00, 0x02, 0x00, 0x00, 0x32, 0x00, 0x32, 0x94, 0x64};
constexpr std::uint8_t write_reply[] = {0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0xCA, 0x22};

#ifdef HEARS_ITSELF
constexpr bool hears_itself = true;
#else
constexpr bool hears_itself = false;
#endif
const std::uint8_t* next = nullptr;
const std::uint8_t* end = nullptr;
const std::uint8_t* echo = nullptr;
const std::uint8_t* echo_end = nullptr;
std::uint32_t time_us = 0;
std::uint32_t looks = 0;

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

// Without a division, which a Cortex-M0+ has only as a function that the library must not need.
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

// The drive answers a look later.
[[gnu::noinline]] std::uint32_t uart_send(const std::uint8_t* data, std::uint32_t size) {
    next = data[1] == 0x03 ? read_reply : write_reply;
    end = data[1] == 0x03 ? read_reply + sizeof read_reply : write_reply + sizeof write_reply;
    looks = 0;
    if (hears_itself) {
        echo = data;
        echo_end = data + size;
    }
    return size;
}
[[gnu::noinline]] bool uart_sent() { return true; }
[[gnu::noinline]] std::int32_t uart_receive() {
    if (echo != echo_end) return *echo++;
    if (next == end || looks++ == 0) return -1;
    return *next++;
}
// An idle line has been silent for t3.5 at every look, so that each wait is one look.
[[gnu::noinline]] std::uint32_t clock_us() { return time_us += next == end ? 2000u : 50u; }

[[gnu::noinline]] void measured_job_begins() { __asm__ volatile(""); }
[[gnu::noinline]] void measured_job_ends() { __asm__ volatile(""); }

[[noreturn]] void reset() {
    const std::uint32_t* from = data_image;
    for (std::uint32_t* to = data_begin; to != data_end; ++to, ++from) *to = *from;
    for (std::uint32_t* to = bss_begin; to != bss_end; ++to) *to = 0;
    for (const handler* f = constructors_begin; f != constructors_end; ++f) (*f)();
    bool is_done = job();

    constexpr std::uint32_t untouched = 0xDEAD'BEEF;
    constexpr std::size_t deepest = 512;
    volatile std::uint32_t* top = nullptr; // the job's stack begins below
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (std::size_t i = 1; i <= deepest; ++i) *(top - i) = untouched;
    measured_job_begins();
    is_done = job() && is_done;
    measured_job_ends();
    std::size_t used = deepest;
    while (used != 0 && *(top - used) == untouched) --used;
    print(static_cast<std::uint32_t>(used * sizeof *top));
    leave(is_done ? 0 : 1);
}
}
