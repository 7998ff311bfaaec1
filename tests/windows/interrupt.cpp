// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs a program on a console without a window, and interrupts it by a Ctrl-C of that console once a file
// exists.
//   interrupt FILE PROGRAM ARGUMENT
// Ends with the program's status.
#include <windows.h>

#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 4) return 90;
    char command[1024];
    if (std::snprintf(command, sizeof command, "\"%s\" %s", argv[2], argv[3]) >= int{sizeof command})
        return 91;
    STARTUPINFOA start{};
    start.cb = sizeof start;
    start.dwFlags = STARTF_USESTDHANDLES;
    start.hStdInput = ::GetStdHandle(STD_INPUT_HANDLE);
    start.hStdOutput = ::GetStdHandle(STD_OUTPUT_HANDLE);
    start.hStdError = ::GetStdHandle(STD_ERROR_HANDLE);
    PROCESS_INFORMATION child{};
    if (::CreateProcessA(nullptr, command, nullptr, nullptr, TRUE, CREATE_NO_WINDOW, nullptr, nullptr, &start,
                         &child) == 0)
        return 92;
    while (::GetFileAttributesA(argv[1]) == INVALID_FILE_ATTRIBUTES) {
        if (::WaitForSingleObject(child.hProcess, 50) == WAIT_OBJECT_0) return 93; // it ended before
    }
    (void)::FreeConsole();
    if (::AttachConsole(child.dwProcessId) == 0) return 94;
    // The event is for all programs of the console, and this one outlives it.
    if (::SetConsoleCtrlHandler([](DWORD) -> BOOL { return TRUE; }, TRUE) == 0) return 95;
    if (::GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0) == 0) return 96;
    DWORD status = 97;
    if (::WaitForSingleObject(child.hProcess, 30'000) != WAIT_OBJECT_0) return 98; // it does not end
    (void)::GetExitCodeProcess(child.hProcess, &status);
    return static_cast<int>(status);
}
