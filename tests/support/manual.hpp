// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The manuals' own tables, tests/manuals, as lines of text.
#pragma once

#include <fstream>
#include <string>
#include <vector>

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

} // namespace tests
