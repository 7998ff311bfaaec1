// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// From reset to main(): the vector table, initialised memory, and what happens on a fault.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "mps2_an385.hpp"
#include "semihosting.hpp"
#include "stack.hpp"

int main();

// Defined by the linker script.
extern "C" {
extern std::uint32_t stack_begin[], stack_marked[], stack_end[];
extern std::uint32_t data_image[], data_begin[], data_end[];
extern std::uint32_t bss_begin[], bss_end[];
extern void (*const constructors_begin[])();
extern void (*const constructors_end[])();
[[noreturn]] void reset();
}

namespace {

constexpr std::uint32_t untouched = 0xDEAD'BEEF;

[[noreturn]] void fault() {
    semihosting::out << "a fault of the processor, or an interrupt that nobody handles\n";
    semihosting::exit(1);
}

using handler = void (*)();

struct vector_table {
    std::uint32_t* stack;
    std::array<handler, 15> system;    ///< exceptions 1..15
    std::array<handler, 32> interrupt; ///< of the board
};

constexpr vector_table made_ready() {
    vector_table t{.stack = stack_end, .system = {}, .interrupt = {}};
    t.system.fill(fault);
    t.interrupt.fill(fault);
    t.system[0] = reset;
    t.system[14] = mps2::clock::on_tick;
    t.interrupt[mps2::rs485::received_interrupt] = mps2::rs485::on_received;
    t.interrupt[mps2::rs485::sendable_interrupt] = mps2::rs485::on_sendable;
    return t;
}

[[gnu::section(".vectors"), gnu::used]] constinit const vector_table vectors = made_ready();

} // namespace

// It runs on this stack: the pattern ends 64 bytes below its top.
extern "C" void reset() {
    std::fill(stack_begin, stack_marked, untouched);
    std::copy(data_image, data_image + (data_end - data_begin), data_begin);
    std::fill(bss_begin, bss_end, 0u);
    std::for_each(constructors_begin, constructors_end, [](handler construct) { construct(); });
    semihosting::exit(static_cast<std::uint32_t>(main()));
}

std::size_t stack_used() {
    const auto* lowest = std::find_if(stack_begin, stack_end, [](std::uint32_t w) { return w != untouched; });
    return static_cast<std::size_t>(stack_end - lowest) * sizeof(std::uint32_t);
}
