// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How much of a line's time a bus uses: the reads that it makes in a simulated minute beside those for which
// wire time, t3.5 and the drives' own delays leave room. Virtual time, so the same in every run and on every
// machine. The status is 1 if a line is used for less than 98 %.
#include <cstdint>
#include <cstdio>
#include <span>

#include <servobus/bus.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/line.hpp>

using namespace servobus;

namespace {

// Each register holds its own address.
struct store {
    static std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = address++;
        return 0;
    }
    static std::uint8_t write(std::uint16_t, words_view) { return 0; }
};

inline constexpr node<zlac8015d::device> wheels{1};
inline constexpr node<yako::closed_loop::device> lift{2};

// Speeds of two wheels and the state of a lift, every `period`.
consteval auto cycle(std::uint32_t baud, duration period) {
    return poll_plan{modbus::timing_at(baud), drives_with_a_facade{},
                     cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels, period),
                     cyclic<yako::status_word>(lift, period)};
}
// As often as the line allows if both drives answer at once.
consteval auto endless(std::uint32_t baud) {
    const auto slow = cycle(baud, milliseconds(1000));
    return cycle(baud, slow.shortest(slow.polls[0]) + slow.shortest(slow.polls[1]));
}
inline constexpr auto at_9600 = endless(9600);
inline constexpr auto at_57600 = endless(57'600);
inline constexpr auto at_115200 = endless(115'200);

// Tenths of a per cent.
template <const auto& Plan> std::uint64_t used(std::uint32_t baud, duration delay) {
    store registers;
    sim::station<store> first{registers, 1, baud, delay};
    sim::station<store> second{registers, 2, baud, delay};
    sim::virtual_line wire{baud};
    wire.attach(first);
    wire.attach(second);
    line on{wire, Plan.timing()};
    bus<Plan, decltype(on)> all{on};
    constexpr std::uint64_t time = 60'000'000;
    all.run_for(duration{time});
    const duration t3_5{Plan.timing().t3_5};
    duration both{};
    for (const poll& p : Plan.polls)
        both = both + Plan.timing().wire_time(8) + longer_of(delay, t3_5) +
               Plan.timing().wire_time(p.reply_size()) + t3_5;
    const std::uint64_t made = all.count(0) + all.count(1);
    return made * both.us * 1000u / (2u * wire.time_us());
}

template <const auto& Plan> bool print(std::uint32_t baud) {
    std::printf("%12u", baud);
    bool is_enough = true;
    for (const duration delay : {microseconds(0), milliseconds(3), milliseconds(10)}) {
        const std::uint64_t share = used<Plan>(baud, delay);
        std::printf("%14.1f %%", static_cast<double>(share) / 10);
        is_enough = is_enough && share >= 980 && share <= 1000;
    }
    std::printf("%s\n", is_enough ? "" : "  NOT 98 % OF WHAT IS POSSIBLE");
    return is_enough;
}

} // namespace

int main() {
    std::printf("a line's use by a bus of two drives that answer after\n%12s%16s%16s%16s\n", "Bd", "t3.5",
                "3 ms", "10 ms");
    const bool slow = print<at_9600>(9600);
    const bool middle = print<at_57600>(57'600);
    const bool fast = print<at_115200>(115'200);
    return slow && middle && fast ? 0 : 1;
}
