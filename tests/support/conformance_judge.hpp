// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plays the judges for everybody (sim/conformance.hpp) on a subject as a test: every single mishap and random pairs.
#pragma once

#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include <servobus/sim/conformance.hpp>

namespace conformance_tests {

namespace sim = servobus::sim;

inline void show(void*, const sim::finding& f) {
    const auto happened = [](const sim::planned_mishap& m) {
        return "request " + std::to_string(m.request) + ": " + sim::text(m.what);
    };
    const std::string all = std::string{f.promise} + ": " + f.what + " (" + f.command + ", " +
                            happened(f.first) + ", " + happened(f.second) + ", reading " +
                            std::to_string(f.reading) + ")";
    MESSAGE(all);
}

/// At least so many runs, and each mishap at least a quarter as often as it was planned.
template <class Subject> void judge(std::uint32_t least_runs) {
    sim::conformance<Subject> kit{&show};
    const sim::played singles = kit.singles(0);
    CHECK(singles.findings == 0);
    CHECK(singles.runs >= least_runs);
    const std::uint32_t of_each = singles.runs / (sizeof sim::all_mishaps / sizeof *sim::all_mishaps);
    for (const sim::mishap m : sim::all_mishaps) {
        const std::string name = sim::text(m);
        CAPTURE(name);
        CHECK(singles.happened[static_cast<unsigned>(m)] >= of_each / 4);
    }
    sim::conformance<Subject> pairs{&show};
    CHECK(pairs.pairs(7, 300).findings == 0);
}

} // namespace conformance_tests
