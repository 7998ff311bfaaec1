// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Checks that every side does its operations correctly, runs the benchmarks and prints the ratios.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "operations.hpp"
#include "reporter.hpp"

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    const bool is_sound = bench::is_correct(bench::servobus_side) &&
                          bench::is_correct(bench::hand_written_side) &&
                          bench::works(bench::libmodbus_side) && bench::works(bench::libmodbus_socket_side);
    if (!is_sound) return 1;
    bench::keeping_reporter reporter;
    benchmark::RunSpecifiedBenchmarks(&reporter);

    reporter.print("ns, CRC by bytes",
                   {"xor_only", "crc_bitwise", "crc_table16", "crc_table256", "crc_slicing8",
                    "crc_trinomial<8>", "crc_trinomial<16>", "crc_trinomial<32>", "crc_trinomial<64>",
                    "default_crc", "libmodbus, a frame"},
                   {"6", "8", "25", "64", "253", "4096"}, "crc_table256");
    std::vector<std::string> frames, transactions;
    for (const bench::operation& o : bench::operations) {
        const std::string name{o.name};
        (name.rfind("transaction", 0) == 0 ? transactions : frames).push_back(name);
    }
    reporter.print("ns, frames", {"servobus", "hand-written"}, frames, "hand-written");
    reporter.print("ns, in memory", {"servobus", "hand-written", "only reading", "libmodbus"}, transactions,
                   "hand-written");
    reporter.print("ns, over a socket pair", {"libmodbus, socket pair", "socket pair alone"}, transactions,
                   "socket pair alone");
    benchmark::Shutdown();
}
