// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Checks that the board's clock never goes back and never jumps when its SysTick period ends: reads it
// without pause, with interrupts off across the end of a period and with interrupts on. Meant for an emulator
// that counts instructions, where nothing else takes time.
#include "mps2_an385.hpp"
#include "semihosting.hpp"

using namespace servobus;

namespace {

// A read takes about 1 us, an interrupt a little longer.
constexpr duration longest_step = microseconds(20);

class reader {
  public:
    /// Reads the clock until it has counted `time`. False if a step was too long or went back.
    bool reads(duration time) {
        const instant start = last_;
        while (since(start, last_) < time) {
            const instant now = mps2::clock::now();
            const duration step = since(last_, now);
            if (step > longest_step || ++reads_ > most_reads) return false;
            last_ = now;
        }
        return true;
    }

    instant last() const { return last_; }
    std::uint32_t count() const { return reads_; }

  private:
    static constexpr std::uint32_t most_reads = 10'000'000; // more: the clock has stopped

    instant last_ = mps2::clock::now();
    std::uint32_t reads_ = 0;
};

} // namespace

int main() {
    mps2::clock::start();
    reader clock;
    const instant start = clock.last();
    bool is_steady = true;
    // No part is a multiple of the period, so that the ends of periods fall everywhere in it.
    for (std::uint32_t i = 0; i < 100 && is_steady; ++i) {
        {
            const mps2::interrupts_off guard;
            is_steady = clock.reads(microseconds(900 + 10 * (i % 10))); // one end: only one can be pending
        }
        is_steady = is_steady && clock.reads(microseconds(57));
    }
    semihosting::out << "clock_check: " << clock.count() << " reads in " << since(start, clock.last()).us
                     << " us\n";
    semihosting::out << (is_steady ? "clock_check: counts on through every round's end\n"
                                   : "clock_check: FAILED: it went back, jumped or stood still\n");
    return is_steady ? 0 : 1;
}
