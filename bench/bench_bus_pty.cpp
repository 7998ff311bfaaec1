// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How much of a line's time a bus uses through this machine's kernel: the reads that it makes in a few
// seconds over a pseudo-terminal, with `posix::serial`, as a share of those that wire time and gaps allow
// at 115200 Bd, without `wakes_early` and with it. A pseudo-terminal has no baud rate. So the other side, a
// separate process, sends no byte of a response before request, gap and the bytes up to it would have passed on
// a wire. The time is real, so the share differs between runs and is smaller on a busy machine. No figure makes
// the program fail.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <csignal>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/posix/serial.hpp>

#include "bus_plan.hpp"

using namespace servobus;

namespace {

constexpr std::uint32_t baud = 115'200;
constexpr const auto& plan = bench::at_115200;
constexpr duration t3_5{plan.timing().t3_5};

// A wire is never late, but a sleeping process wakes late. So this function polls for the last 50 us; not
// longer, since the bus may need the same processor.
void wait_until(instant due) {
    constexpr duration polled = microseconds(50);
    for (instant now = posix::monotonic_now(); went_back(due, now); now = posix::monotonic_now()) {
        const duration left = since(now, due);
        if (left > polled) posix::sleep_for(left - polled);
    }
}

// Makes the response of either drive to a read: each register holds its own address. Returns 0 for any other
// request.
std::size_t answer(bytes request, byte_buffer response) {
    if (request.size() != 8 || request[1] != 0x03 || request[5] > 16) return 0;
    response[0] = request[0];
    response[1] = request[1];
    response[2] = static_cast<std::uint8_t>(2 * request[5]);
    const unsigned first = request[2] * 256u + request[3];
    for (std::size_t i = 0; i < request[5]; ++i)
        store_word(response, 3 + 2 * i, static_cast<std::uint16_t>(first + i));
    return modbus::close_frame(response, 2u + 2u * request[5]);
}

// Serves both drives at the other end of the line. Runs until the process is killed. A wire waits for no
// processor: the process has real-time priority, if it may.
[[noreturn]] void serve(posix::pseudo_terminal& wire) {
    sched_param above_others{};
    above_others.sched_priority = 10;
    (void)::sched_setscheduler(0, SCHED_FIFO, &above_others);
    for (;;) {
        std::uint8_t request[64];
        std::uint8_t response[64];
        const transfer came = wire.receive(request);
        if (!came) std::_Exit(1);
        const instant begun = wire.now();
        const std::size_t size = answer(bytes{request}.first(*came), response);
        if (size == 0) {
            wire.wait(milliseconds(5));
            continue;
        }
        const instant begins = begun + plan.timing().wire_time(*came) + t3_5;
        for (std::size_t i = 0; i < size; ++i) {
            wait_until(begins + plan.timing().wire_time(i + 1));
            (void)wire.send(bytes{response}.subspan(i, 1));
        }
    }
}

// Prints how late `serial::wait` ends, in us: the median and the 99th percentile.
void print_lateness(posix::serial& port, duration asked) {
    std::vector<std::uint32_t> late;
    for (int i = 0; i < 500; ++i) {
        const instant start = port.now();
        port.wait(asked);
        const duration took = since(start, port.now());
        late.push_back(took > asked ? took.us - asked.us : 0);
    }
    std::sort(late.begin(), late.end());
    std::printf("serial::wait of %4u us ends later by %u us in the median, %u us in one of a hundred\n",
                asked.us, late[late.size() / 2], late[late.size() * 99 / 100]);
}

double cpu_seconds() {
    timespec t{};
    (void)::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

int measure_line(const char* path, bool wakes_early) {
    posix::serial port;
    if (port.open(path, {.baud = baud, .wakes_early = wakes_early}) != errc::ok) return 1;
    std::printf("%s\n", wakes_early ? "with wakes_early" : "without wakes_early");
    print_lateness(port, microseconds(200));
    print_lateness(port, microseconds(1000));
    scheduled_line wire{port, plan.timing()};
    bus<plan, decltype(wire)> all{wire};
    all.run_for(milliseconds(200));
    const std::uint32_t before[] = {all.count(0), all.count(1)};
    const instant start = port.now();
    const double cpu = cpu_seconds();
    all.run_for(milliseconds(4000));
    const duration took = since(start, port.now());
    const double cpu_took = cpu_seconds() - cpu;
    std::uint64_t needed = 0;
    std::uint32_t made = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const std::uint32_t good = all.count(i) - before[i];
        needed += std::uint64_t{good} * bench::least_time(plan, plan.polls[i], t3_5).us;
        made += good;
    }
    std::printf(
        "a line's use over a pseudo-terminal that is paced at %u Bd: %u reads in %.2f s, %.1f %% of what is "
        "possible, for %.1f %% of a core\n",
        baud, made, took.us * 1e-6, 100.0 * static_cast<double>(needed) / took.us,
        100.0 * cpu_took / (took.us * 1e-6));
    return made == 0;
}

} // namespace

int main() {
    posix::pseudo_terminal wire;
    if (wire.open() != errc::ok) {
        std::fprintf(stderr, "bus_pty: no pseudo-terminal here\n");
        return 1;
    }
    const pid_t parent = ::getpid();
    const pid_t drives = ::fork();
    if (drives < 0) return 1;
    if (drives == 0) {
        (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != parent) std::_Exit(1);
        serve(wire);
    }
    const std::string path = wire.path();
    const bool fails = measure_line(path.c_str(), false) != 0 || measure_line(path.c_str(), true) != 0;
    (void)::kill(drives, SIGKILL);
    (void)::waitpid(drives, nullptr, 0);
    return fails ? 1 : 0;
}
