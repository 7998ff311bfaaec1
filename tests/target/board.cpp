// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The board of the measured programs, from reset on, for qemu's mps2-an385. It has the user's four
// functions, with a simulated drive at the other end of the line. It runs the job twice: once to warm up
// and once between two marks. The exit status is 0 if both jobs were done. The program prints the stack
// that the measured job used and the requests to which the drive responded. The drive has a separate stack.
// bench/peers/recorded.tsv has figures of other programs on this board, which a change of it makes stale.
#include "board.hpp"

#include "drive.hpp"
#include "machine.hpp"

int main();

extern "C" {
extern std::uint32_t drive_stack_end[];
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

[[noreturn]] void reset() {
    prepare_memory();
    // Links them into every program, also into the one without the library.
    simulated_drive::set_fault(0);
    (void)(simulated_drive::has_run() || simulated_drive::has_done_all(0, 0));
    bool is_done = job();

    const painted_stack stack;
    const std::uint32_t before = simulated_drive::answered();
    measured_job_begins();
    is_done = job() && is_done;
    measured_job_ends();
    const std::uint32_t requests = simulated_drive::answered() - before;
    print(stack.used());
    print(requests);
    leave(is_done ? 0 : 1);
}
}
