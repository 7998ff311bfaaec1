// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0

// Runs a check, and adds a line to a table: its name, CPU seconds, seconds of the clock, and how often it ran.
//   run_check computing|real_time NAME TABLE COMMAND ARGUMENT...     the status is the command's last
// One that computes gets a lower priority than those in real time, whose gaps are fractions of a second.
// A failure in real time on a machine that was too busy is no finding: the check runs once more, three times in all,
// and this prints it. If the machine was not busy, the first failure counts.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
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
constexpr int skipped = 77; // as CTest knows it

struct attempt {
    int status;
    steady_clock::duration longest_standstill;
    long percent_waited;
    bool was_disturbed() const { return longest_standstill >= standstill || percent_waited >= busy_percent; }
    bool counts() const { return status == 0 || status == skipped || !was_disturbed(); }
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

pid_t start(char** command) {
    const pid_t child = fork();
    if (child == 0) {
        execvp(command[0], command);
        std::perror(command[0]);
        _exit(127);
    }
    return child;
}

int status_of(int how) { return WIFEXITED(how) ? WEXITSTATUS(how) : 128 + WTERMSIG(how); }

int compute(char** command) {
    (void)setpriority(PRIO_PROCESS, 0, 10);
    int how = 0;
    const pid_t child = start(command);
    return child > 0 && waitpid(child, &how, 0) == child ? status_of(how) : 127;
}

attempt watch(char** command) {
    const auto begun = steady_clock::now();
    const long long waited_before = waited();
    attempt one{127, {}, 0};
    const pid_t child = start(command);
    if (child < 0) return one;
    int how = 0;
    auto before = steady_clock::now();
    while (waitpid(child, &how, WNOHANG) == 0) {
        std::this_thread::sleep_for(nap);
        const auto now = steady_clock::now();
        one.longest_standstill = std::max(one.longest_standstill, now - before - nap);
        before = now;
    }
    one.status = status_of(how);
    one.percent_waited = static_cast<long>((waited() - waited_before) * 100 / ((before - begun) / 1us + 1));
    return one;
}

double cpu_seconds() {
    rusage used{};
    (void)getrusage(RUSAGE_CHILDREN, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) / 1e6;
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

// In one write, since checks that run side by side share the table.
void record(const char* table, const char* name, double seconds, int times) {
    char line[256];
    const int size =
        std::snprintf(line, sizeof line, "%s\t%.2f\t%.2f\t%d\n", name, cpu_seconds(), seconds, times);
    const int file = open(table, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (file < 0 || size < 0 || write(file, line, static_cast<std::size_t>(size)) != size) std::perror(table);
    if (file >= 0) close(file);
}

} // namespace

int main(int count, char** arguments) {
    const bool is_real_time = count > 4 && std::strcmp(arguments[1], "real_time") == 0;
    if (!is_real_time && (count <= 4 || std::strcmp(arguments[1], "computing") != 0))
        return std::fputs("usage: run_check computing|real_time NAME TABLE COMMAND ARGUMENT...\n", stderr), 2;
    const auto begun = steady_clock::now();
    int times = 1;
    int status = 0;
    if (!is_real_time) status = compute(arguments + 4);
    for (; is_real_time; ++times) {
        const attempt one = watch(arguments + 4);
        status = one.status;
        if (one.counts() || times == 3) break;
        std::printf("failed, but a program waited for a processor in %ld %% of the time, this one for %d ms: "
                    "once more\n",
                    one.percent_waited, static_cast<int>(one.longest_standstill / 1ms));
        std::fflush(stdout);
    }
    record(arguments[3], arguments[2], std::chrono::duration<double>(steady_clock::now() - begun).count(),
           times);
    return status;
}
