// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0

// Runs a command whose checks are in real time: the programs and the simulators of a test, whose gaps are fractions of
// a second. A failure on a machine that was too busy for them says nothing, so the command runs once more, three times
// in all, and this says so. A failure on another machine is one immediately.
//   undisturbed COMMAND ARGUMENT...     the status is the command's last

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr auto nap = 10ms;
// A busy machine lets a program that wants to run wait for so long; a quiet one for 1 to 4 ms. A tool that does not run
// for some milliseconds after its request discards the response, since it may be the request's own echo.
constexpr auto standstill = 10ms;
// This program sleeps, so it is woken before those that compute: a simulator may have waited for longer. The kernel
// counts the time in which any program waits for a processor.
constexpr int busy_percent = 5;

struct attempt {
    int status;
    steady_clock::duration longest_standstill;
    long percent_waited;
    bool was_disturbed() const { return longest_standstill >= standstill || percent_waited >= busy_percent; }
};

// Microseconds since the start of the machine. 0 on a kernel that does not count.
long long waited() {
    long long us = 0;
    if (std::FILE* const file = std::fopen("/proc/pressure/cpu", "r")) {
        if (std::fscanf(file, "some avg10=%*f avg60=%*f avg300=%*f total=%lld", &us) != 1) us = 0;
        std::fclose(file);
    }
    return us;
}

attempt run(char** command) {
    const auto begun = steady_clock::now();
    const long long waited_before = waited();
    const pid_t child = fork();
    if (child == 0) {
        execvp(command[0], command);
        std::perror(command[0]);
        _exit(127);
    }
    attempt one{127, {}, 0};
    if (child < 0) return one;
    int how = 0;
    auto before = steady_clock::now();
    while (waitpid(child, &how, WNOHANG) == 0) {
        std::this_thread::sleep_for(nap);
        const auto now = steady_clock::now();
        one.longest_standstill = std::max(one.longest_standstill, now - before - nap);
        before = now;
    }
    one.status = WIFEXITED(how) ? WEXITSTATUS(how) : 128 + WTERMSIG(how);
    one.percent_waited = static_cast<long>((waited() - waited_before) * 100 / ((before - begun) / 1us + 1));
    return one;
}

} // namespace

int main(int count, char** arguments) {
    if (count < 2) return std::fputs("usage: undisturbed COMMAND ARGUMENT...\n", stderr), 2;
    for (int tries = 1;; ++tries) {
        const attempt one = run(arguments + 1);
        if (one.status == 0 || !one.was_disturbed() || tries == 3) return one.status;
        std::printf("failed, but a program waited for a processor in %ld %% of the time, this one for %d ms: "
                    "once more\n",
                    one.percent_waited, static_cast<int>(one.longest_standstill / 1ms));
        std::fflush(stdout);
    }
}
