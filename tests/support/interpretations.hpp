// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Where a manual states nothing, or can be read in two ways, the simulated drive has a switch. A safety test
// runs under these switches: under every position alone and every pair of positions; under the whole product
// if SERVOBUS_INTERPRETATIONS=whole is set; under the default positions only if SERVOBUS_INTERPRETATIONS=default.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace interpretations {

/// The position of each switch, from 0.
using choice = std::vector<unsigned>;

/// How many switches are not in their default position.
inline std::size_t switched(const choice& c) {
    std::size_t n = 0;
    for (const unsigned position : c) n += position != 0 ? 1u : 0u;
    return n;
}

/// The last position of each switch from `first_of_field` on.
inline choice all_of_field(const std::vector<unsigned>& sizes, std::size_t first_of_field) {
    choice all(sizes.size(), 0);
    for (std::size_t i = first_of_field; i < sizes.size(); ++i) all[i] = sizes[i] - 1;
    return all;
}

/// A small set of choices that contains each position of each switch alone, and each pair of positions of two
/// switches. `sizes` has the number of positions of each switch; from `first_of_field` on they are those that only the
/// field has shown to be open. The first choice is 0 everywhere, the simulator's default. Then come the positions
/// alone, then all that the field has shown together.
inline std::vector<choice> all_pairs(const std::vector<unsigned>& sizes, std::size_t first_of_field) {
    const std::size_t n = sizes.size();
    std::size_t most = 1;
    for (const unsigned size : sizes) most = size > most ? size : most;
    std::vector<bool> seen(n * most * n * most, false);
    const auto index = [&](std::size_t a, unsigned x, std::size_t b, unsigned y) {
        return ((a * most + x) * n + b) * most + y;
    };
    const auto is_new = [&](const choice& c, std::size_t a, std::size_t b) {
        return a != b && !seen[index(a, c[a], b, c[b])];
    };
    std::vector<choice> found;
    const auto keep = [&](const choice& c) {
        for (std::size_t a = 0; a < n; ++a) {
            for (std::size_t b = 0; b < n; ++b) seen[index(a, c[a], b, c[b])] = true;
        }
        found.push_back(c);
    };
    keep(choice(n, 0));
    for (std::size_t a = 0; a < n; ++a) {
        for (unsigned x = 1; x < sizes[a]; ++x) {
            choice alone(n, 0);
            alone[a] = x;
            keep(alone);
        }
    }
    if (first_of_field < n) keep(all_of_field(sizes, first_of_field));
    for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = a + 1; b < n; ++b) {
            for (unsigned x = 0; x < sizes[a]; ++x) {
                for (unsigned y = 0; y < sizes[b]; ++y) {
                    if (seen[index(a, x, b, y)]) continue;
                    choice next(n, 0);
                    next[a] = x;
                    next[b] = y;
                    for (std::size_t other = 0; other < n; ++other) { // the position that adds most new pairs
                        if (other == a || other == b) continue;
                        std::size_t best = 0;
                        unsigned best_position = 0;
                        for (unsigned p = 0; p < sizes[other]; ++p) {
                            next[other] = p;
                            std::size_t adds = 0;
                            for (std::size_t with = 0; with < n; ++with)
                                adds += is_new(next, other, with) ? 1u : 0u;
                            if (adds > best) {
                                best = adds;
                                best_position = p;
                            }
                        }
                        next[other] = best_position;
                    }
                    keep(next);
                }
            }
        }
    }
    return found;
}

/// Every possible choice.
inline std::vector<choice> whole_product(const std::vector<unsigned>& sizes) {
    std::vector<choice> found{choice(sizes.size(), 0)};
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const std::size_t before = found.size();
        for (unsigned p = 1; p < sizes[i]; ++p) {
            for (std::size_t k = 0; k < before; ++k) {
                choice next = found[k];
                next[i] = p;
                found.push_back(next);
            }
        }
    }
    return found;
}

/// The choices under which a safety test runs. `of_field`: the switches that only the field has shown to be open. The
/// whole product is that of `sizes`. In it the switches of the field change from choice to choice, so that each of
/// their positions is there with many choices.
inline std::vector<choice> chosen(const std::vector<unsigned>& sizes,
                                  const std::vector<unsigned>& of_field = {}) {
    std::vector<unsigned> all = sizes;
    all.insert(all.end(), of_field.begin(), of_field.end());
    const char* wanted = std::getenv("SERVOBUS_INTERPRETATIONS");
    const std::string_view how = wanted == nullptr ? "" : wanted;
    if (how == "default") return {choice(all.size(), 0)};
    if (how != "whole") return all_pairs(all, sizes.size());
    std::vector<choice> product = whole_product(sizes);
    const std::vector<choice> beside = whole_product(of_field);
    for (std::size_t i = 0; i < product.size(); ++i) {
        const choice& other = beside[(i * 7) % beside.size()];
        product[i].insert(product[i].end(), other.begin(), other.end());
    }
    if (!of_field.empty()) product.push_back(all_of_field(all, sizes.size()));
    return product;
}

/// For a failure's message: the position of each switch.
inline std::string name(const choice& c) {
    std::string all;
    for (const unsigned p : c) all += (all.empty() ? "" : " ") + std::to_string(p);
    return all;
}

} // namespace interpretations
