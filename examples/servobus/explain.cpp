// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus explain: captured frames in words.
#include <servobus/explain/explain.hpp>

#include <cctype>
#include <cstdio>
#include <iostream>

#include "streams.hpp"
#include "tool.hpp"

namespace tool {
namespace {

using servobus::direction;
using frame_bytes = std::vector<std::uint8_t>;

struct captured {
    direction way = direction::unknown;
    frame_bytes frame;
};

bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ':'; }

// Pairs of hex digits; blanks, commas or colons may part the bytes, and 0x may stand before each.
std::optional<captured> parse(std::string_view line) {
    captured c;
    if (line.starts_with('>') || line.starts_with('<')) {
        c.way = line[0] == '>' ? direction::request : direction::response;
        line.remove_prefix(1);
    }
    while (!line.empty()) {
        if (is_separator(line[0])) {
            line.remove_prefix(1);
            continue;
        }
        if (line.starts_with("0x") || line.starts_with("0X")) line.remove_prefix(2);
        if (line.size() < 2) return std::nullopt;
        const std::uint8_t high = servobus::hex_digit(line[0]);
        const std::uint8_t low = servobus::hex_digit(line[1]);
        if (high > 15 || low > 15) return std::nullopt;
        c.frame.push_back(static_cast<std::uint8_t>(high << 4 | low));
        line.remove_prefix(2);
    }
    if (c.frame.empty()) return std::nullopt;
    return c;
}

void print_hex(const captured& c) {
    if (c.way != direction::unknown) (void)std::fputs(c.way == direction::request ? "> " : "< ", stdout);
    for (const std::uint8_t byte : c.frame) std::printf("%02X ", static_cast<unsigned>(byte));
    (void)std::fputs(" ", stdout);
}

// A frame without a direction that repeats the last request is most likely its response.
bool is_new_request(const servobus::explanation& e, direction way, const frame_bytes& frame,
                    const frame_bytes& before) {
    if (!e.is_valid() || way == direction::response) return false;
    return e.way == direction::request || (e.way == direction::unknown && frame != before);
}

} // namespace

int explain(std::span<char* const> words) {
    static constexpr arguments::option known[] = {{"hex", false}};
    const std::optional<arguments> asked = arguments::parse(words, known);
    if (!asked) return usage;
    if (asked->words().size() != 1) return complain(usage, "explain takes one DEVICE");
    const device* of = find_device(asked->words()[0]);
    if (of == nullptr) return usage;

    int status = done;
    frame_bytes last_request;
    std::string line;
    while (std::getline(std::cin, line)) {
        const std::size_t begin = line.find_first_not_of(" \t\r");
        if (begin == line.npos || line[begin] == '#') continue;
        const std::optional<captured> c = parse(std::string_view{line}.substr(begin));
        if (!c) {
            (void)std::puts("invalid: not a frame in hex");
            if (!streams::flush()) return failed;
            status = failed;
            continue;
        }
        char text[16384]; // 125 registers with their names
        const servobus::explanation e = servobus::explain(*of->map, c->way, c->frame, last_request, text);
        if (asked->has("hex")) print_hex(*c);
        std::printf("%.*s\n", static_cast<int>(e.size), text);
        if (!streams::flush()) return failed; // a live capture is explained as it comes
        if (!e.is_valid()) status = failed;
        if (is_new_request(e, c->way, c->frame, last_request)) last_request = c->frame;
    }
    return streams::end_of_input(status);
}

} // namespace tool
