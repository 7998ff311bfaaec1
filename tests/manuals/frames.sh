#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Makes zlac8015d_frames.hpp from zlac8015d_frames.csv:
#   sh tests/manuals/frames.sh >tests/manuals/zlac8015d_frames.hpp
set -eu
cd "$(dirname "$0")"
cat <<'HEADER'
// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every frame that the ZLAC8015D's manual prints (RS485 manual V1.07, sections 2 and 3), for the compiler.
// Made by frames.sh from zlac8015d_frames.csv; the tests compare the two.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>

namespace tests {

struct printed_frame {
    bool is_request;
    std::array<std::uint8_t, 17> data;
    std::size_t size;
    const char* meaning;

    constexpr servobus::bytes frame() const { return servobus::bytes{data.data(), size}; }
};

template <std::size_t Chars>
constexpr printed_frame printed(bool is_request, servobus::hex_text<Chars> text, const char* meaning) {
    printed_frame f{is_request, {}, text.size, meaning};
    for (std::size_t i = 0; i < text.size; ++i) f.data[i] = text.data[i];
    return f;
}

using servobus::hex;

// clang-format off
inline constexpr printed_frame zlac8015d_frames[] = {
HEADER
tail -n +2 zlac8015d_frames.csv | sed -e 's/^request,\([^,]*\),\(.*\)$/    printed(true,  hex("\1"), \2),/' \
    -e 's/^response,\([^,]*\),\(.*\)$/    printed(false, hex("\1"), \2),/'
cat <<'FOOTER'
};
// clang-format on

} // namespace tests
FOOTER
