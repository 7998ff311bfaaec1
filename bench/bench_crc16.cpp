// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Measures every CRC engine at the sizes of Modbus frames, and at one much larger size. Calls are
// independent: no call needs the result of the one before, as when frames are checked one by one. The
// length is hidden from the compiler. `xor_only` only reads the words: the lower limit for every engine
// here.

#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/crc_tables.hpp>

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sides/side_libmodbus.hpp"

namespace {

using namespace servobus::modbus;

constexpr std::array sizes{6, 8, 25, 64, 253, 4096};

/// Has the interface of an engine, but only reads the bytes, a word at a time.
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
MEASURE(default_crc);
#undef MEASURE

// The CRC and the copies around it, since the CRC of libmodbus cannot be called alone.
void libmodbus_frames(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes(static_cast<std::size_t>(state.range(0)), 0x5A);
    bool all = true;
    for (auto _ : state) all = all && bench::libmodbus_sends(bytes.data(), bytes.size());
    if (!all) state.SkipWithError("libmodbus sent nothing");
}
BENCHMARK(libmodbus_frames)->Name("libmodbus, a frame")->Arg(6)->Arg(8)->Arg(25)->Arg(64)->Arg(253);

} // namespace
