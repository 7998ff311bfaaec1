// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Prints the last frames of a run in words, by the library's `explain`.
#pragma once

#include <array>
#include <cstdio>
#include <map>
#include <vector>

#include <servobus/explain/explain.hpp>

#include "record.hpp"

namespace trial {

/// The catalogue that is used for each node.
using vocabulary = std::map<std::uint8_t, const servobus::catalogue*>;

inline void print(const record& of, const vocabulary& maps, const servobus::catalogue& otherwise) {
    std::vector<std::uint8_t> request;
    for (const record::note& n : of.notes()) {
        std::printf("%12llu us  ", static_cast<unsigned long long>(n.begin_us));
        if (!n.remark.empty()) {
            std::printf("   %s\n", n.remark.c_str());
            continue;
        }
        std::printf("%s", n.is_from_client ? "-> " : "<- ");
        for (std::size_t i = 0; i < n.data.size() && i < 24; ++i) std::printf(" %02X", n.data[i]);
        if (n.data.size() > 24) std::printf(" ... (%zu bytes)", n.data.size());
        std::array<char, 160> said{};
        const auto known = maps.find(n.data[0]);
        const servobus::catalogue& map = known == maps.end() ? otherwise : *known->second;
        const servobus::direction way =
            n.is_from_client ? servobus::direction::request : servobus::direction::response;
        const servobus::bytes asked = n.is_from_client ? servobus::bytes{} : servobus::bytes{request};
        const auto found = servobus::explain(map, way, n.data, asked, said);
        std::printf("   %.*s\n", static_cast<int>(found.size), said.data());
        if (n.is_from_client) request = n.data;
    }
}

} // namespace trial
