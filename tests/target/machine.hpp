// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The parts that the boards of the measured programs have in common: the vector table for qemu, memory at reset, text
// and the exit status for the host, and the stack that a job uses. One source of a program includes it.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {
extern std::uint32_t stack_end[];
extern std::uint32_t data_image[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void (*const constructors_begin[])();
extern void (*const constructors_end[])();
[[noreturn]] void reset();
// The two marks between which instructions are counted.
void measured_job_begins();
void measured_job_ends();
}

namespace {

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

[[gnu::always_inline]] inline void prepare_memory() {
    const std::uint32_t* from = data_image;
    for (std::uint32_t* to = data_begin; to != data_end; ++to, ++from) *to = *from;
    for (std::uint32_t* to = bss_begin; to != bss_end; ++to) *to = 0;
    for (const handler* f = constructors_begin; f != constructors_end; ++f) (*f)();
}

/// The stack below the function that makes one. Inlined, so that no call lies between.
class painted_stack {
  public:
    [[gnu::always_inline]] painted_stack() {
        __asm__ volatile("mov %0, sp" : "=r"(top_));
        for (std::size_t i = 1; i <= deepest; ++i) *(top_ - i) = untouched;
    }
    /// In bytes, since then.
    [[gnu::always_inline]] std::uint32_t used() const {
        std::size_t words = deepest;
        while (words != 0 && *(top_ - words) == untouched) --words;
        return static_cast<std::uint32_t>(words * sizeof *top_);
    }

  private:
    static constexpr std::uint32_t untouched = 0xDEAD'BEEF;
    static constexpr std::size_t deepest = 512; // words

    volatile std::uint32_t* top_ = nullptr;
};

} // namespace

extern "C" {
[[gnu::noinline]] void measured_job_begins() { __asm__ volatile(""); }
[[gnu::noinline]] void measured_job_ends() { __asm__ volatile(""); }
}
