// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Prints like Google Benchmark, stores the times, and prints their ratios within one run. Absolute times
// differ between machines, and on a shared machine from minute to minute.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace bench {

/// The best (or median) time of each benchmark by its name, which is `row/column`.
class keeping_reporter : public benchmark::ConsoleReporter {
  public:
    keeping_reporter() : ConsoleReporter(OO_Tabular) {} // no colours, since the output goes to files

    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type == Run::RT_Aggregate && run.aggregate_name != "median") continue;
            const double ns = run.GetAdjustedCPUTime();
            const std::string& column = run.run_name.args;
            const auto [kept, is_new] =
                best_.try_emplace(run.run_name.function_name + (column.empty() ? "" : '/' + column), ns);
            if (!is_new) kept->second = std::min(kept->second, ns);
        }
        ConsoleReporter::ReportRuns(runs);
    }

    /// Prints a table of times and of their ratios to the row `base`, with a dash for a time that was not
    /// measured.
    void print(const char* title, const std::vector<std::string>& rows,
               const std::vector<std::string>& columns, const std::string& base) const {
        std::printf("\n%-24s", title);
        for (const std::string& column : columns) std::printf("%20s", column.c_str());
        std::printf("\n");
        for (const std::string& row : rows) {
            std::printf("%-24s", row.c_str());
            for (const std::string& column : columns) {
                const double own = of(row, column);
                const double other = of(base, column);
                if (own > 0 && other > 0)
                    std::printf("%11.1f %6.2f x", own, own / other);
                else if (own > 0)
                    std::printf("%11.1f %6s  ", own, "");
                else
                    std::printf("%20s", "-");
            }
            std::printf("\n");
        }
    }

  private:
    double of(const std::string& row, const std::string& column) const {
        const auto found = best_.find(row + '/' + column);
        return found == best_.end() ? 0 : found->second;
    }

    std::map<std::string, double> best_;
};

} // namespace bench
