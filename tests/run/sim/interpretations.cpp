// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The choices under which the safety tests run contain every pair of positions.
#include <doctest/doctest.h>

#include <tests/support/interpretations.hpp>

namespace interpretations_tests {

TEST_CASE(
    "interpretations: every pair of positions of two switches occurs, in fewer choices than the product") {
    const std::vector<unsigned> sizes{2, 3, 2, 4, 2, 2};
    const auto choices = interpretations::all_pairs(sizes, 4);
    for (std::size_t a = 0; a < sizes.size(); ++a) {
        for (std::size_t b = 0; b < sizes.size(); ++b) {
            for (unsigned x = 0; x < sizes[a]; ++x) {
                for (unsigned y = 0; y < sizes[b]; ++y) {
                    bool occurs = a == b && x != y;
                    for (const auto& c : choices) occurs = occurs || (c[a] == x && c[b] == y);
                    CAPTURE(a);
                    CAPTURE(b);
                    CHECK(occurs);
                }
            }
        }
    }
    CHECK(interpretations::whole_product(sizes).size() == 2u * 3 * 2 * 4 * 2 * 2);
    CHECK(choices.size() < 20);
    const unsigned alone = 1 + 2 + 1 + 3 + 1 + 1;
    CHECK(choices[1 + alone] == interpretations::choice{0, 0, 0, 0, 1, 1}); // the field's last two together
    CHECK(choices.front() == interpretations::choice(sizes.size(), 0));
}

} // namespace interpretations_tests
