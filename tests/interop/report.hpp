// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How these programs report their results: one line for each check, which peers.py counts.
#pragma once

#include <cstdio>
#include <string>

namespace interop {

inline int failed = 0;

inline void check(bool is_good, const std::string& what) {
    std::printf("%s %s\n", is_good ? "ok     " : "FAILED ", what.c_str());
    (void)std::fflush(stdout);
    if (!is_good) ++failed;
}

inline std::string hex(unsigned value) {
    char text[16];
    (void)std::snprintf(text, sizeof text, "%04X", value);
    return text;
}

} // namespace interop
