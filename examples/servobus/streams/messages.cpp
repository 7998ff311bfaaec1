// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "messages.hpp"

#include <cstdio>
#include <iostream>

#include "streams.hpp"

namespace tool {
namespace {

std::size_t notes_written = 0;

} // namespace

int complain(int status, const std::string& message) {
    note(message);
    return status;
}

void note(const std::string& message) {
    ++notes_written;
    (void)streams::flush();
    (void)std::fprintf(stderr, "servobus: %s\n", message.c_str());
}

std::size_t note_count() { return notes_written; }

std::string answer_to(const std::string& question) {
    (void)std::fprintf(stderr, "%s", question.c_str());
    (void)std::fflush(stderr);
    std::string answer;
    if (!std::getline(std::cin, answer)) (void)std::fputs("\n", stderr);
    if (answer.ends_with('\r')) answer.pop_back(); // from a console of Windows
    return answer;
}

} // namespace tool
