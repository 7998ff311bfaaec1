// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The board of the measured programs, from reset on, for qemu's mps2-an385. It has the user's four
// functions, with a simulated drive at the other end of the line. It runs the job twice: once to warm up
// and once between two marks. The exit status is 0 if both jobs were done. The program prints the stack
// that the measured job used and the requests to which the drive responded. The drive has a separate stack.
// bench/peers/recorded.tsv has figures of other programs on this board, which a change of it makes stale.
#include "board.hpp"

#include <cstddef>

#include "drive.hpp"

int main();

extern "C" {
extern std::uint32_t stack_end[], drive_stack_end[];
extern std::uint32_t data_image[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void (*const constructors_begin[])();
extern void (*const constructors_end[])();
[[noreturn]] void reset();
void measured_job_begins();
void measured_job_ends();
}

namespace {

#ifdef HEARS_ITSELF
constexpr bool has_local_echo = true;
#else
constexpr bool has_local_echo = false;
#endif
simulated_drive::frame response{}; // the part that has not been received yet
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

// Without a division: a Cortex-M0+ needs a function for it, and the library must not need that function.
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

// The other end of the line.
void simulated_drive_takes(const std::uint8_t* data, std::uint32_t size) {
    response = simulated_drive::answer(data, size);
}

// Takes the whole frame, like a DMA controller. The response arrives one call of `uart_receive` later.
[[gnu::noinline]] std::uint32_t uart_send(const std::uint8_t* data, std::uint32_t size) {
    looks = 0;
    register const std::uint8_t* first __asm__("r0") = data;
    register std::uint32_t count __asm__("r1") = size;
    register std::uint32_t* top __asm__("r2") = drive_stack_end;
    __asm__ volatile("mov r4, sp\n\tmov sp, r2\n\tbl simulated_drive_takes\n\tmov sp, r4"
                     : "+r"(first), "+r"(count), "+r"(top)
                     :
                     : "r3", "r4", "r12", "lr", "cc", "memory");
    if (has_local_echo) {
        echo = data;
        echo_end = data + size;
    }
    return size;
}
[[gnu::noinline]] bool uart_sent() { return true; }
[[gnu::noinline]] std::int32_t uart_receive() {
    if (echo != echo_end) return *echo++;
    if (response.begin == response.end || looks++ == 0) return -1;
    return *response.begin++;
}
// Between two readings on an idle line t3.5 has passed, so each wait takes one reading.
[[gnu::noinline]] std::uint32_t clock_us() { return time_us += response.begin == response.end ? 2000u : 50u; }

[[gnu::noinline]] void measured_job_begins() { __asm__ volatile(""); }
[[gnu::noinline]] void measured_job_ends() { __asm__ volatile(""); }

[[noreturn]] void reset() {
    const std::uint32_t* from = data_image;
    for (std::uint32_t* to = data_begin; to != data_end; ++to, ++from) *to = *from;
    for (std::uint32_t* to = bss_begin; to != bss_end; ++to) *to = 0;
    for (const handler* f = constructors_begin; f != constructors_end; ++f) (*f)();
    // Links them into every program, also into the one without the library.
    simulated_drive::set_fault(0);
    (void)(simulated_drive::has_run() || simulated_drive::has_done_all(0, 0));
    bool is_done = job();

    constexpr std::uint32_t untouched = 0xDEAD'BEEF;
    constexpr std::size_t deepest = 512;
    volatile std::uint32_t* top = nullptr; // the stack of the job begins below
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (std::size_t i = 1; i <= deepest; ++i) *(top - i) = untouched;
    const std::uint32_t before = simulated_drive::answered();
    measured_job_begins();
    is_done = job() && is_done;
    measured_job_ends();
    const std::uint32_t requests = simulated_drive::answered() - before;
    std::size_t used = deepest;
    while (used != 0 && *(top - used) == untouched) --used;
    print(static_cast<std::uint32_t>(used * sizeof *top));
    print(requests);
    leave(is_done ? 0 : 1);
}
}
