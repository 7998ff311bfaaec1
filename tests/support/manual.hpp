// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads the manuals' own tables, tests/manuals, as lines of text, and the numbers, ranges and units in them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <servobus/registers/unit.hpp>

namespace tests {

/// The lines of tests/manuals/`name` without comments; empty if there is no such file.
inline std::vector<std::string> manual(const std::string& name) {
    const std::string here = __FILE__;
    std::ifstream file{here.substr(0, here.find_last_of('/') + 1) + "../manuals/" + name};
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) {
        if (!line.empty() && line[0] != '#') lines.push_back(line);
    }
    return lines;
}

/// `line` cut at each `mark`.
inline std::vector<std::string> split(const std::string& line, char mark) {
    std::vector<std::string> parts;
    std::size_t from = 0;
    for (;;) {
        const std::size_t to = line.find(mark, from);
        parts.push_back(line.substr(from, to == std::string::npos ? to : to - from));
        if (to == std::string::npos) return parts;
        from = to + 1;
    }
}

/// A number as printed: decimal, 0x…, or …h; none if the text has anything else in it.
inline std::optional<std::int64_t> number(std::string text) {
    std::int64_t sign = 1;
    if (!text.empty() && (text[0] == '-' || text[0] == '+')) {
        sign = text[0] == '-' ? -1 : 1;
        text = text.substr(1);
    }
    int base = 10;
    if (text.rfind("0x", 0) == 0) {
        base = 16;
        text = text.substr(2);
    } else if (!text.empty() && text.back() == 'h') {
        base = 16;
        text.pop_back();
    }
    std::int64_t value = 0;
    if (text.empty()) return std::nullopt;
    for (const char c : text) {
        const int digit = c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : 99;
        if (digit >= base) return std::nullopt;
        value = value * base + digit;
    }
    return sign * value;
}

struct bounds {
    std::int64_t low, high;
    bool operator==(const bounds&) const = default;
};

/// The lowest and the highest number of a printed range; none if the range has anything but numbers and
/// spans.
inline std::optional<bounds> printed_bounds(const std::string& text) {
    std::optional<bounds> all;
    const auto take = [&](std::int64_t low, std::int64_t high) {
        if (!all) all = bounds{low, high};
        if (low < all->low) all->low = low;
        if (high > all->high) all->high = high;
    };
    for (const std::string& item : split(text, ' ')) {
        if (item == "|") continue;
        const std::size_t dots = item.find("..");
        const std::string from = item.substr(0, dots);
        const std::string to = dots == std::string::npos ? from : item.substr(dots + 2);
        if (from.rfind("Bit", 0) == 0 && to.rfind("Bit", 0) == 0) {
            take(0, (std::int64_t{1} << (number(to.substr(3)).value() + 1)) - 1);
            continue;
        }
        const auto low = number(from);
        const auto high = number(to);
        if (!low || !high) return std::nullopt;
        take(*low, *high);
    }
    return all;
}

/// A unit as printed; none if no manual prints it.
inline std::optional<servobus::unit> printed_unit(const std::string& text) {
    using servobus::measure;
    struct {
        const char* text;
        servobus::unit of;
    } const known[] = {
        {"", {}},
        {"ms", {measure::millisecond}},
        {"10ms", {measure::millisecond, 10, 1}},
        {"r/min", {measure::r_per_min}},
        {"rpm", {measure::r_per_min}},
        {"0.1r/min", {measure::r_per_min, 1, 10}},
        {"0.1°C", {measure::degree_celsius, 1, 10}},
        {"1°C", {measure::degree_celsius}},
        {"1°", {measure::degree}},
        {"%", {measure::percent}},
        {"0.1A", {measure::ampere, 1, 10}},
        {"mA", {measure::milliampere}},
        {"mA/S", {measure::milliampere_per_second}},
        {"0.01V", {measure::volt, 1, 100}},
        {"counts", {measure::count}},
        {"*10counts", {measure::count, 10, 1}},
    };
    for (const auto& k : known) {
        if (text == k.text) return k.of;
    }
    return std::nullopt;
}

inline std::string in_hex(unsigned address) {
    std::string s;
    for (int shift = 12; shift >= 0; shift -= 4) s += "0123456789ABCDEF"[address >> shift & 15];
    return s + "h";
}

/// True if include/servobus/device/`document` has an entry of this number.
inline bool has_erratum(const std::string& document, const std::string& number) {
    const std::string here = __FILE__;
    std::ifstream file{here.substr(0, here.find_last_of('/') + 1) + "../../include/servobus/device/" +
                       document};
    for (std::string line; std::getline(file, line);) {
        if (line.rfind("| " + number + " |", 0) == 0) return true;
    }
    return false;
}

} // namespace tests
