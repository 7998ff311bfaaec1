// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Measures every CRC engine at the sizes that Modbus frames have, and one size far beyond. Calls are
// independent: no call waits for the result of the one before, as when frames are checked one by one; the
// length is hidden from the compiler. Absolute times differ between machines, so the table printed at the end
// gives each engine as a ratio to the 256-entry table of the same run. `xor_only` reads the words and
// does nothing else: the floor for every engine here.

#include <servobus/modbus/crc16.hpp>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace servobus::modbus;

constexpr std::array sizes{6, 8, 25, 64, 253, 4096};

/// Has the interface of an engine and the cost of reading the bytes, a word at a time.
struct xor_only {
    struct state {
        std::uint64_t all;
    };
    static constexpr state begin() noexcept { return {0}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept { return {s.all ^ byte}; }
    static constexpr state update(state s, std::span<const std::uint8_t> bytes) noexcept {
        for (; bytes.size() >= 8; bytes = bytes.subspan(8))
            s.all ^= detail::crc_load<std::uint64_t>(bytes.data());
        for (const std::uint8_t byte : bytes) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept { return static_cast<std::uint16_t>(s.all); }
};

template <crc_engine Engine>
[[gnu::noinline, gnu::flatten]] std::uint16_t call(std::span<const std::uint8_t> bytes) {
    return crc16<Engine>(bytes);
}

template <crc_engine Engine> void independent_calls(benchmark::State& state) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(state.range(0)));
    std::uint32_t seed = 1;
    for (std::uint8_t& byte : bytes)
        byte = static_cast<std::uint8_t>((seed = seed * 1664525U + 1013904223U) >> 24);
    std::span<const std::uint8_t> frame = bytes;
    for (auto _ : state) {
        benchmark::DoNotOptimize(frame);
        std::uint16_t crc = call<Engine>(frame);
        benchmark::DoNotOptimize(crc);
    }
    state.SetBytesProcessed(state.iterations() * state.range(0));
}

#define MEASURE(...)                                                                                         \
    BENCHMARK(independent_calls<__VA_ARGS__>)                                                                \
        ->Name(#__VA_ARGS__)                                                                                 \
        ->Apply([](benchmark::internal::Benchmark* all) {                                                    \
            for (const int size : sizes) all->Arg(size);                                                     \
        })
MEASURE(xor_only);
MEASURE(crc_bitwise);
MEASURE(crc_table16);
MEASURE(crc_table256);
MEASURE(crc_slicing8);
MEASURE(crc_trinomial<8>);
MEASURE(crc_trinomial<16>);
MEASURE(crc_trinomial<32>);
MEASURE(crc_trinomial<64>);
#undef MEASURE

/// Prints as usual and keeps the best (or median) time of each benchmark, whose name is `engine/size`.
class keeping_reporter : public benchmark::ConsoleReporter {
  public:
    keeping_reporter() : ConsoleReporter(OO_Tabular) {} // no colours: the output is kept in files

    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type == Run::RT_Aggregate && run.aggregate_name != "median") continue;
            const double ns = run.GetAdjustedCPUTime();
            const auto [kept, is_new] =
                best_.try_emplace(run.run_name.function_name + '/' + run.run_name.args, ns);
            if (!is_new) kept->second = std::min(kept->second, ns);
        }
        ConsoleReporter::ReportRuns(runs);
    }

    void print_ratios() const {
        std::printf("\n%-22s", "ratio to crc_table256");
        for (const int size : sizes) std::printf("%7d B", size);
        std::printf("\n");
        for (const char* engine :
             {"xor_only", "crc_bitwise", "crc_table16", "crc_table256", "crc_slicing8", "crc_trinomial<8>",
              "crc_trinomial<16>", "crc_trinomial<32>", "crc_trinomial<64>"}) {
            std::printf("%-22s", engine);
            for (const int size : sizes) {
                const double own = of(engine, size);
                const double table = of("crc_table256", size);
                if (own > 0 && table > 0)
                    std::printf("%9.2f", own / table);
                else
                    std::printf("%9s", "-");
            }
            std::printf("\n");
        }
    }

  private:
    double of(const std::string& engine, int size) const {
        const auto found = best_.find(engine + '/' + std::to_string(size));
        return found == best_.end() ? 0 : found->second;
    }

    std::map<std::string, double> best_;
};

} // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    keeping_reporter reporter;
    benchmark::RunSpecifiedBenchmarks(&reporter);
    reporter.print_ratios();
    benchmark::Shutdown();
}
