// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the fuzzing targets share: checks that stop the program when a promise is broken, and the input as a
// sequence of bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <servobus/core/bytes.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

using byte_list = std::vector<std::uint8_t>;

/// Prints the broken promise and traps, so that the fuzzer keeps the input.
inline void require(bool is_kept, const char* promise) {
    if (is_kept) return;
    (void)std::fprintf(stderr, "broken: %s\n", promise);
    __builtin_trap();
}

/// The bytes of the fuzzer. After their end it gives zeros.
class input {
  public:
    input(const std::uint8_t* data, std::size_t size) : left_{data, size} {}

    bool empty() const { return left_.empty(); }
    std::uint8_t byte() {
        if (left_.empty()) return 0;
        const std::uint8_t first = left_[0];
        left_ = left_.subspan(1);
        return first;
    }
    std::uint16_t word() {
        const unsigned high = byte();
        return static_cast<std::uint16_t>(high << 8 | byte());
    }
    bool flag() { return (byte() & 1u) != 0; }
    /// At most this many bytes.
    servobus::bytes take(std::size_t most) {
        const servobus::bytes taken = left_.first(most < left_.size() ? most : left_.size());
        left_ = left_.subspan(taken.size());
        return taken;
    }
    servobus::bytes rest() { return take(left_.size()); }
    std::size_t size() const { return left_.size(); }

  private:
    servobus::bytes left_;
};

/// Shortens a frame, but never to nothing.
template <class List> void cut(List& frame, std::size_t by) {
    frame.erase(frame.end() - static_cast<long>(by % frame.size()), frame.end());
}

/// A time from one byte, from 0 to 70 s, with finer steps near the gaps of a line.
inline std::uint32_t time_of(std::uint8_t code) {
    const std::uint32_t fine = code & 0x0Fu;
    switch (code >> 4) {
    case 0: return fine * 10;
    case 1: return fine * 100;
    case 2: return 700 + fine * 10;  // around t1.5
    case 3: return 1700 + fine * 10; // around t3.5
    case 4: return fine * 1000;
    case 5: return 19'990 + fine * 2; // around the longest pause of host timing
    case 6: return 20'000 + fine * 100;
    case 7: return 99'990 + fine * 2; // around the usual time limit of a response
    case 8: return fine * 10'000;
    case 9: return fine * 1'000'000;
    case 10: return 70'000'000 + fine;
    default: return code & 0x7Fu;
    }
}

} // namespace fuzz
