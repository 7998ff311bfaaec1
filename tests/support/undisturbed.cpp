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

struct attempt {
    int status;
    steady_clock::duration longest_standstill;
};

attempt run(char** command) {
    const pid_t child = fork();
    if (child == 0) {
        execvp(command[0], command);
        std::perror(command[0]);
        _exit(127);
    }
    attempt one{127, {}};
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
    return one;
}

} // namespace

int main(int count, char** arguments) {
    if (count < 2) return std::fputs("usage: undisturbed COMMAND ARGUMENT...\n", stderr), 2;
    for (int tries = 1;; ++tries) {
        const attempt one = run(arguments + 1);
        if (one.status == 0 || one.longest_standstill < standstill || tries == 3) return one.status;
        const auto lost = std::chrono::duration_cast<std::chrono::milliseconds>(one.longest_standstill);
        std::printf("failed, but the machine let a program wait for %d ms: once more\n",
                    static_cast<int>(lost.count()));
        std::fflush(stdout);
    }
}
