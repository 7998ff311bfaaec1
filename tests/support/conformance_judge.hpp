// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plays the judges for everybody (sim/conformance.hpp) on a subject as a test: every single mishap and random pairs.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <servobus/sim/conformance.hpp>

#include <tests/support/interpretations.hpp>

namespace conformance_tests {

namespace sim = servobus::sim;

inline void show(void*, const sim::finding& f) {
    const auto happened = [](const sim::planned_mishap& m) {
        return "request " + std::to_string(m.request) + ": " + sim::text(m.what);
    };
    const std::string all = std::string{f.promise} + ": " + f.what + " (" + f.command + ", " +
                            happened(f.first) + ", " + happened(f.second) + ", interpretation " +
                            std::to_string(f.interpretation) + ")";
    MESSAGE(all);
}

/// Each mishap has happened at least a quarter as often as it was planned.
inline void check_counts(const sim::played& all) {
    const std::uint32_t of_each = all.runs / (sizeof sim::all_mishaps / sizeof *sim::all_mishaps);
    for (const sim::mishap m : sim::all_mishaps) {
        const std::string name = sim::text(m);
        CAPTURE(name);
        CHECK(all.happened[static_cast<unsigned>(m)] >= of_each / 4);
        CHECK(all.happened[static_cast<unsigned>(m)] > 0);
    }
}

/// Under the first interpretation: at least so many runs.
template <class Subject> void judge(std::uint32_t least_runs) {
    sim::conformance<Subject> kit{&show};
    const sim::played singles = kit.singles(0);
    CHECK(singles.findings == 0);
    CHECK(singles.runs >= least_runs);
    check_counts(singles);
    sim::conformance<Subject> pairs{&show};
    CHECK(pairs.pairs(7, 300).findings == 0);
}

/// Under each interpretation alone, and all of the field's: of the single mishaps one of `parts`, from interpretation
/// to interpretation another. All of them with SERVOBUS_INTERPRETATIONS=whole; only the first interpretation with
/// SERVOBUS_INTERPRETATIONS=default. Prints what was played.
template <class Subject, class Interpretations>
void judge_interpretations(std::uint32_t least_runs, std::uint32_t parts) {
    const char* wanted = std::getenv("SERVOBUS_INTERPRETATIONS");
    const std::string_view how = wanted == nullptr ? "" : wanted;
    if (how == "default") {
        judge<Subject>(least_runs);
        return;
    }
    if (how == "whole") parts = 1;
    sim::conformance<Subject> kit{&show};
    sim::played all{};
    unsigned few = 0;
    for (unsigned interpretation = 1; interpretation < Interpretations::alone_and_field(); ++interpretation) {
        const std::string positions = interpretations::name(Interpretations::choices()[interpretation]);
        CAPTURE(positions);
        const std::uint32_t before = all.runs;
        all = kit.singles(interpretation, {interpretation % parts, parts});
        CHECK(all.runs > before);
        few += all.runs - before < least_runs / parts * 3 / 4 ? 1u : 0u;
    }
    CHECK(all.findings == 0);
    CHECK(few <= 1); // under one interpretation of the C630S no enable can be confirmed
    check_counts(all);
    std::printf("interpretations: %s: %u alone or of the field, one of %u single mishaps: %u runs;",
                doctest::getContextOptions()->currentTest->m_name, Interpretations::alone_and_field() - 1,
                parts, all.runs);
    for (const sim::mishap m : sim::all_mishaps)
        std::printf(" %s: %u;", sim::text(m), all.happened[static_cast<unsigned>(m)]);
    std::printf("\n");
}

} // namespace conformance_tests
