// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the example programs need of the system, on Linux and on Windows: its serial port, a flag that an
// interruption sets, a terminal, a signal to the simulator.
#pragma once

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#ifdef _WIN32
#include <io.h>
#include <servobus/windows/serial.hpp>
#else
#include <cstring>
#include <servobus/posix/serial.hpp>
#include <signal.h>
#include <unistd.h>

#include "posix_access.hpp"
#endif

namespace host {

inline volatile std::sig_atomic_t interruption = 0;

/// Ends the program unless a person types MOVE.
inline void ask_for_consent(const char* warning) {
    std::printf("%s\nType MOVE to go on: ", warning);
    std::fflush(stdout);
    char answer[16] = {};
    if (std::fgets(answer, sizeof answer, stdin) != nullptr && std::strcmp(answer, "MOVE\n") == 0) return;
    std::printf("Nothing was sent.\n");
    std::exit(2);
}

/// True for an error of a port that the system's own says better.
inline bool is_of_system(servobus::errc why) {
    return why == servobus::errc::bad_argument || why == servobus::errc::port_lost;
}

/// True after Ctrl-C, or after another request to end the program that `watch_for_interruptions` names.
inline bool is_interrupted() { return interruption != 0; }

#ifdef _WIN32

using servobus::windows::serial;
using servobus::windows::settings_of;
using servobus::windows::sleep_for;

/// Ctrl-C, Ctrl-Break, the end of the console window, of the session and of the system set the flag. Windows
/// ends the program when the handler of the last three returns, or after some seconds. So it does not return:
/// the program ends itself once it has sent its stop.
inline void watch_for_interruptions() {
    (void)::SetConsoleCtrlHandler(
        [](DWORD event) -> BOOL {
            interruption = 1;
            if (event != CTRL_C_EVENT && event != CTRL_BREAK_EVENT) ::Sleep(INFINITE);
            return TRUE;
        },
        TRUE);
}

/// True if the output is a terminal that moves its cursor by escape sequences.
inline bool is_terminal() {
    static const bool has_sequences = [] {
        constexpr DWORD sequences = 0x4; // ENABLE_VIRTUAL_TERMINAL_PROCESSING
        const HANDLE out = ::GetStdHandle(STD_OUTPUT_HANDLE);
        DWORD mode = 0;
        return ::_isatty(::_fileno(stdout)) != 0 && ::GetConsoleMode(out, &mode) != 0 &&
               ::SetConsoleMode(out, mode | sequences) != 0;
    }();
    return has_sequences;
}

/// Why a port is not open.
inline std::string open_failure(const char*, servobus::errc why, unsigned long error) {
    if (!is_of_system(why)) return servobus::text(why);
    return "error " + std::to_string(error) + " of Windows";
}

/// Pulls or plugs in the simulated line; false if this system cannot tell the simulator to.
inline bool toggle_plug(int) { return false; }

#else

using servobus::posix::serial;
using servobus::posix::settings_of;
using servobus::posix::sleep_for;

/// SIGINT (Ctrl-C), SIGTERM and SIGHUP set the flag.
inline void watch_for_interruptions() {
    constexpr auto note = [](int) { interruption = 1; };
    std::signal(SIGINT, note);
    std::signal(SIGTERM, note);
    std::signal(SIGHUP, note);
    std::signal(SIGPIPE, SIG_IGN); // a reader that goes away must not end the program without a stop
}

/// True if the output is a terminal that moves its cursor by escape sequences.
inline bool is_terminal() { return ::isatty(STDOUT_FILENO) == 1; }

/// Why a port is not open, and who may open it.
inline std::string open_failure(const char* path, servobus::errc why, int error) {
    if (is_of_system(why)) return std::strerror(error);
    return servobus::text(why) + (why == servobus::errc::no_permission ? advice_on_access(path) : "");
}

/// Pulls or plugs in the simulated line; false if this system cannot tell the simulator to.
inline bool toggle_plug(int simulator) {
    (void)::kill(simulator, SIGUSR1); // a simulator that has ended does not respond either
    return true;
}

#endif

} // namespace host
