// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus: maps, explains, simulates, reads and writes motor drives on Modbus RTU.
//
//     g++ -std=c++20 -Iinclude examples/servobus.cpp -o servobus
#include <cstdio>
#include <string_view>

#include "command_line/arguments.hpp"
#include "commands.hpp"
#include "commands/completion.hpp"
#include "help/help.hpp"
#include "streams/messages.hpp"
#include "streams/streams.hpp"

namespace {

bool is_help(std::string_view word) { return word == "--help" || word == "-h"; }

int print_help(const tool::command* of) {
    const std::string text = of != nullptr ? tool::help_of(*of) : tool::help(tool::commands());
    (void)std::fputs(text.c_str(), stdout);
    return tool::done;
}

int run(std::span<char* const> words) {
    if (words.size() < 2) return tool::complain(tool::usage, "no command; see servobus --help");
    const std::string_view first = words[1];
    if (first == tool::completion_word) return tool::print_candidates(tool::commands(), words.subspan(2));
    if (first == "help") return print_help(words.size() > 2 ? tool::commands().find(words[2]) : nullptr);
    for (const char* word : words.subspan(1)) {
        if (is_help(word)) return print_help(tool::commands().find(first));
        if (std::string_view{word} == "--version") {
            (void)std::printf("servobus %s\n", tool::version_text().c_str());
            return tool::done;
        }
    }
    const tool::command* const wanted = tool::commands().require(first);
    if (wanted == nullptr) return tool::usage;
    const std::optional<tool::arguments> asked = tool::arguments::parse(words.subspan(2), *wanted);
    return asked ? wanted->run(*asked) : tool::usage;
}

} // namespace

int main(int argc, char** argv) {
    tool::streams::prepare();
    return tool::streams::finish(run({argv, static_cast<std::size_t>(argc)}));
}
