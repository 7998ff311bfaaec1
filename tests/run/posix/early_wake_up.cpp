// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Waits that wake early and poll, on a machine in virtual time that wakes a sleeping program late: when they end, how
// long they poll, and what lateness they go by.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/posix/detail/early_wake_up.hpp>

#include <tests/support/scripted_port.hpp>

namespace early_wake_up_tests {

using namespace servobus;
using posix::detail::early_wake_up;
using tests::dice;

namespace {

constexpr std::uint32_t never = ~std::uint32_t{0};

// A poll without sleep takes 1 us. The clock wraps meanwhile.
struct machine {
    std::uint32_t time = 0xFFFF'FF00u;
    std::uint32_t late = 0;          ///< of the next wake-ups
    std::uint32_t byte_in = never;   ///< from now
    std::uint32_t signal_in = never; ///< from the next sleep's begin
    bool clock_stands = false;
    std::uint32_t asked = 0; ///< sum of all sleeps
    std::uint32_t polled = 0;
    std::uint32_t polls = 0;

    constexpr instant now() const { return {clock_stands ? 0 : time}; }
    constexpr void pass(std::uint32_t us) {
        time += us;
        if (byte_in != never) byte_in -= us < byte_in ? us : byte_in;
    }
    constexpr int wait(duration d) {
        if (byte_in == 0) return 1;
        if (d == duration{}) {
            pass(1);
            ++polls;
            ++polled;
            return byte_in == 0;
        }
        asked += d.us;
        const std::uint32_t end = byte_in < d.us ? byte_in : d.us;
        if (signal_in < end) {
            pass(signal_in);
            signal_in = never;
            return 0;
        }
        pass(end + late);
        return byte_in == 0;
    }
};

struct outcome {
    std::uint32_t took;
    std::uint32_t asked;
    std::uint32_t polled;
    bool has_byte;
};
constexpr outcome waited(early_wake_up& early, machine& on, std::uint32_t asked, std::uint32_t due = 0) {
    const std::uint32_t begun = on.time;
    on.asked = on.polled = on.polls = 0;
    const bool has_byte = early.wait(on, duration{asked}, duration{due}) != 0;
    return {on.time - begun, on.asked, on.polled, has_byte};
}

constexpr early_wake_up used_to(std::uint32_t late) {
    early_wake_up early;
    for (int i = 0; i < 200; ++i) early.note(duration{100}, duration{100 + late});
    return early;
}
constexpr std::uint32_t longest_poll = early_wake_up::longest_poll.us;

} // namespace

static_assert(used_to(150).lateness() == microseconds(150));
static_assert(used_to(1999).lateness() == early_wake_up::longest_poll);
static_assert(used_to(2001).lateness() == duration{});

constexpr std::uint32_t took_late(std::uint32_t late) {
    early_wake_up early = used_to(150);
    machine on{.late = late};
    return waited(early, on, 1750).took;
}
static_assert(took_late(150) == 1750 && took_late(0) == 1750 && took_late(190) == 1790);

TEST_CASE("a wait ends on time on a machine that is always as late, and polls no longer than that") {
    for (std::uint32_t late = 0; late <= longest_poll; late += late < 20 ? 1 : 7) {
        CAPTURE(late);
        early_wake_up early = used_to(late);
        for (std::uint32_t asked = 1; asked < early_wake_up::longest_exact.us; asked += 13) {
            CAPTURE(asked);
            machine on{.late = late};
            const outcome w = waited(early, on, asked);
            REQUIRE(w.took == asked);
            REQUIRE(w.polled == (asked <= late ? asked : 0u)); // a wait that is shorter is polled whole
        }
    }
}

TEST_CASE("a wait as long as those into which a line divides a longer one is not polled") {
    early_wake_up early = used_to(60);
    for (const std::uint32_t asked : {5000u, 5001u, 1'000'000u}) {
        machine on{.late = 60};
        const outcome w = waited(early, on, asked);
        CHECK(w.took == asked + 60);
        CHECK(w.polled == 0);
    }
}

TEST_CASE("the pieces of every wait lie within it, and none polls longer than a millisecond") {
    for (std::uint32_t late = 0; late <= 1100; late += late < 10 ? 1 : 9) {
        const early_wake_up early = used_to(late);
        for (std::uint32_t asked = 1; asked < 20'000; asked += asked < 6000 ? 37 : 997) {
            const auto is_sound = [&](const early_wake_up::pieces& p) {
                return p.slept <= p.polled_until && p.polled_until <= duration{asked} &&
                       p.polled_until - p.slept <= early_wake_up::longest_poll;
            };
            REQUIRE(is_sound(early.to_end_of(duration{asked})));
            for (std::uint32_t due = 1; due < asked; due += 1 + due / 5)
                REQUIRE(is_sound(early.to_last_byte(duration{asked}, duration{due})));
        }
    }
}

TEST_CASE(
    "whatever the lateness, no wait sleeps past its end, ends before it or polls longer than a millisecond") {
    dice random{20};
    early_wake_up early;
    for (int i = 0; i < 200'000; ++i) {
        machine on{.time = random.next()};
        on.late = random.below(50) == 0 ? random.below(30'000) : random.below(1 + random.below(1500));
        const std::uint32_t asked = 1 + random.below(random.below(3) == 0 ? 20'000 : 3000);
        if (random.below(2) == 0) on.byte_in = random.below(6000);
        const std::uint32_t byte_in = on.byte_in;
        const std::uint32_t due = random.below(2) * random.below(3000);
        const outcome w = waited(early, on, asked, due);
        CAPTURE(i);
        REQUIRE(w.asked <= asked);
        REQUIRE(w.polled <= longest_poll);
        REQUIRE(early.lateness() <= early_wake_up::longest_poll);
        if (!w.has_byte) REQUIRE(w.took >= asked);
        if (byte_in < asked) REQUIRE(w.has_byte);
        const std::uint32_t end = byte_in < asked ? byte_in : asked;
        REQUIRE(w.took <= end + on.late);
    }
}

TEST_CASE("a byte ends a wait: as late as the system is while it sleeps, at once while it polls") {
    for (std::uint32_t byte_in = 0; byte_in < 2000; ++byte_in) {
        CAPTURE(byte_in);
        early_wake_up early = used_to(150);
        machine on{.late = 10, .byte_in = byte_in}; // so it polls for 140 us
        const outcome w = waited(early, on, 1750);
        REQUIRE(w.has_byte == (byte_in <= 1750));
        const bool is_asleep = byte_in <= 1600;
        const std::uint32_t found = is_asleep ? byte_in + 10 : byte_in < 1610 ? 1610 : byte_in;
        REQUIRE(w.took == (byte_in == 0 ? 0 : byte_in > 1750 ? 1750 : found));
    }
}

TEST_CASE("the lateness that it goes by follows a later machine in 6 wake-ups and an earlier one in 64") {
    early_wake_up early = used_to(60);
    for (int i = 0; i < 6; ++i) early.note(duration{1000}, duration{1500});
    CHECK(early.lateness() >= microseconds(490));
    CHECK(early.lateness() <= microseconds(500));
    for (int i = 0; i < 64; ++i) early.note(duration{1000}, duration{1060});
    CHECK(early.lateness() >= microseconds(60));
    CHECK(early.lateness() <= microseconds(70));
}

TEST_CASE("a single outlier raises the lateness by half of the longest poll at most, and is forgotten") {
    for (std::uint32_t late = 100; late <= early_wake_up::latest.us; ++late) {
        early_wake_up early = used_to(60);
        early.note(duration{1000}, duration{1000 + late});
        REQUIRE(early.lateness() <= microseconds(60) + microseconds(longest_poll / 2));
        const std::uint32_t raised = early.lateness().us - 60;
        REQUIRE(raised != 0);
        std::uint32_t polled = 0; // for nothing
        for (int i = 0; i < 36; ++i) {
            machine on{.late = 60};
            polled += waited(early, on, 1750).polled;
        }
        CAPTURE(late);
        REQUIRE(early.lateness().us - 60 <= raised / 10);
        REQUIRE(polled <= 16 * raised);
    }
    for (const std::uint32_t late : {2001u, 20'000u, 0x7000'0000u}) {
        early_wake_up early = used_to(60);
        early.note(duration{1000}, duration{1000 + late});
        CHECK(early.lateness() == microseconds(60));
    }
}

TEST_CASE("where wake-ups vary, about a quarter of them are later than expected") {
    dice random{7};
    early_wake_up early;
    int later = 0;
    constexpr int all = 20'000;
    for (int i = 0; i < all; ++i) {
        const std::uint32_t late = 100 + random.below(101);
        if (i >= 100 && late > early.lateness().us) ++later;
        early.note(duration{1000}, duration{1000 + late});
    }
    CHECK(later > all / 5);
    CHECK(later < all / 3);
}

TEST_CASE("a sleep that a byte or a signal has ended, or in which the clock went back, tells no lateness") {
    early_wake_up early = used_to(60);
    early.note(duration{1000}, duration{999});
    early.note(duration{1000}, duration{0});
    early.note(duration{1000}, duration{} - microseconds(1));
    CHECK(early.lateness() == microseconds(60));
    machine on{.late = 900, .byte_in = 500};
    CHECK(waited(early, on, 1750).has_byte);
    CHECK(early.lateness() == microseconds(60));
    machine signalled{.late = 60, .signal_in = 500};
    const outcome w = waited(early, signalled, 1750);
    CHECK(w.took == 500); // as without the option
    CHECK(w.polled == 0);
    CHECK(early.lateness() == microseconds(60));
}

TEST_CASE("G29: a wait ends where the clock stands still or jumps") {
    for (const std::uint32_t late : {0u, 60u, 1000u}) {
        for (const std::uint32_t asked : {1u, 60u, 500u, 1750u, 5000u}) {
            for (const std::uint32_t due : {0u, 50u, 300u}) {
                early_wake_up early = used_to(late);
                machine on{.late = late, .clock_stands = true};
                const outcome w = waited(early, on, asked, due);
                CHECK(w.asked <= asked);
                CHECK(on.polls <= longest_poll * early_wake_up::polls_each_us);
            }
        }
    }
    struct jumping : machine {
        std::uint32_t by = 0;
        std::uint32_t reads = 0;
        instant now() { return {time + by * reads++}; }
    };
    for (const std::uint32_t by : {0xFFFF'0000u, 0x8000'0000u, 0x7000'0000u, 100'000u}) {
        early_wake_up early = used_to(1000);
        jumping on{};
        on.by = by;
        (void)early.wait(on, duration{900}, {});
        CHECK(on.polls <= 1);
        CHECK(on.asked == 0);
    }
}

namespace {

// A frame of `size` bytes, one in each `character`, of which the first comes in 1 ms. Returns how late the last one is
// found, and the time that is polled. Each wait that a byte has ended takes what is there.
struct arrival {
    std::uint32_t late = 0;
    std::uint32_t polled = 0;
};
arrival frame_found(std::uint32_t late, std::uint32_t size, std::uint32_t character) {
    early_wake_up early = used_to(late);
    machine on{.late = late};
    const std::uint32_t begun = on.time;
    std::uint32_t taken = 0;
    arrival all{};
    while (taken < size) {
        const std::uint32_t next = 1000 + taken * character;
        const std::uint32_t passed = on.time - begun;
        if (passed >= next) {
            ++taken;
            continue;
        }
        on.byte_in = next - passed;
        all.polled += waited(early, on, 16'000, taken == 0 ? 0 : (size - taken) * character).polled;
    }
    all.late = on.time - begun - (1000 + (size - 1) * character);
    return all;
}

} // namespace

TEST_CASE("the last byte of a frame is found at once, if the first was found before it, by polling for "
          "little more than "
          "twice the lateness") {
    for (const std::uint32_t character : {48u, 96u, 191u, 573u, 1146u}) {
        for (std::uint32_t late = 0; late <= 300; ++late) {
            for (const std::uint32_t size : {2u, 5u, 7u, 9u, 37u}) {
                if ((size - 1) * character < late) continue;
                CAPTURE(character);
                CAPTURE(late);
                CAPTURE(size);
                const arrival found = frame_found(late, size, character);
                REQUIRE(found.late == 0);
                REQUIRE(found.polled <= 2 * late + character);
            }
        }
    }
    CHECK(frame_found(300, 3, 96).late == 300 - 2 * 96); // nothing helps here
}

TEST_CASE("a last byte that comes later than it is due, by up to the lateness, is found at once") {
    for (std::uint32_t byte_in = 96; byte_in <= 96 + 200; ++byte_in) {
        CAPTURE(byte_in);
        early_wake_up early = used_to(200);
        machine on{.late = 200, .byte_in = byte_in};
        const outcome w = waited(early, on, 16'000, 96);
        REQUIRE(w.has_byte);
        REQUIRE(w.took == byte_in);
    }
}

TEST_CASE("a frame whose rest does not come is polled for once, and the wait goes on asleep") {
    early_wake_up early = used_to(60);
    machine on{.late = 60};
    const outcome w = waited(early, on, 16'000, 96);
    CHECK_FALSE(w.has_byte);
    CHECK(w.polled <= 96 + 60);
    CHECK(w.took == 16'000 + 60);
}

} // namespace early_wake_up_tests
