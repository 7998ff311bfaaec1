// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Makes a benchmark of one operation of one side, named `side/operation`.
#pragma once

#include <benchmark/benchmark.h>

#include <string>

#include "operations.hpp"

namespace bench {

inline void measure(const side& who, const operation& what) {
    if (who.*what.run == nullptr) return;
    const std::string name = std::string{who.name} + '/' + what.name;
    benchmark::RegisterBenchmark(name.c_str(), [&who, &what](benchmark::State& state) {
        task t;
        prepare(t, who, what);
        void (*const run)(task&) = who.*what.run;
        bool all = true;
        for (auto _ : state) {
            t.wire->clock += 5000; // us between two operations
            run(t);
            all = all && t.ok;
            benchmark::ClobberMemory();
        }
        if (!all) state.SkipWithError("an operation failed");
    });
}

} // namespace bench
