// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs a safety test under the switches of its simulated drive. Such a test is in the test suite "interpretations",
// so that the tests of CTest with the label "interpretations" have it:
//
//     TEST_CASE("S1: ..." * doctest::test_suite("interpretations")) {
//         interpretations::under("zlac8015d", sizes, [](const interpretations::choice& c) {
//             ...              // builds a simulated drive from the choice, plays scenes
//             return scenes;   // how many
//         });
//     }
#pragma once

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/interpretations.hpp>

namespace interpretations {

/// Plays `scenes(choice)` under each choice, which has the positions of `of_field` behind those of `sizes`. Prints the
/// number of choices and scenes if SERVOBUS_INTERPRETATIONS is set.
template <class Scenes>
void under(const char* drive, const std::vector<unsigned>& sizes, const Scenes& scenes,
           const std::vector<unsigned>& of_field = {}) {
    const std::vector<choice> all = chosen(sizes, of_field);
    std::size_t played = 0;
    for (const choice& c : all) {
        const std::string positions = name(c);
        CAPTURE(positions);
        const std::size_t n = scenes(c);
        CHECK(n > 0);
        played += n;
    }
    if (std::getenv("SERVOBUS_INTERPRETATIONS") != nullptr)
        std::printf("interpretations: %s: %zu choices, %zu scenes: %s\n", drive, all.size(), played,
                    doctest::getContextOptions()->currentTest->m_name);
}

} // namespace interpretations
