// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Tests with a scripted drive and the times of the frames on the wire: the gap after a change of timing and
// after a stop, the age of a bus's value, and its word order after a request without a response.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/bus/bus.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/bus/scheduled_line.hpp>

#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>

namespace wire_times_tests {

using namespace servobus;
using modbus::exchange;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;
using tests::waiting_scripted_port;

namespace {

constexpr std::uint64_t tolerance = 10; // us: the calls of a port's clock

template <class Port> struct wire {
    Port port;
    scheduled_line<Port> on{port, modbus::timing_at(115200)};

    errc ask(std::uint8_t node_address, bus_gaps gaps, priority how = priority::ordinary) {
        const byte_list request = tests::framed({node_address, 0x03, 0x20, 0xA1, 0x00, 0x01});
        std::array<std::uint8_t, 7> response{};
        const response_limits limits{};
        exchange x{request, response, on.timing(), limits, how};
        on.run(x, gaps);
        REQUIRE_FALSE(port.ran_away);
        return x.status().error();
    }
    void answers_all_but(std::uint8_t mute) {
        port.device = [mute](scripted_port& p, const sent_frame& f) {
            if (f.data[0] != mute) p.say(500, tests::read_response(f.data[0], {7}));
        };
    }
    std::uint64_t last_begin() const { return port.frames.back().begin; }
};

// 32-bit values in a switchable word order: register 0 holds it, 2 and 3 are a value.
struct switchable {
    static constexpr profile facts{
        .name = "switchable", .word_order = word_order::unknown, .word_order_register = 0};
};
inline constexpr reg<u16, access::ro, switchable> word{0x0001, full<u16>, no_unit, 0};
inline constexpr reg<u32, access::ro, switchable> pair{0x0002, full<u32>, no_unit, 0};
inline constexpr node<switchable> drive_at_1{1};

inline constexpr poll_plan words_and_pairs{modbus::timing_at(115200),
                                           cyclic<word>(drive_at_1, milliseconds(300)),
                                           cyclic<pair>(drive_at_1, milliseconds(300))};
inline constexpr node<switchable> stated_at_1 = [] {
    node<switchable> n{1};
    n.word_order = word_order::high_first;
    return n;
}();
inline constexpr poll_plan stated_pairs{modbus::timing_at(115200),
                                        cyclic<word>(stated_at_1, milliseconds(300)),
                                        cyclic<pair>(stated_at_1, milliseconds(300))};
inline constexpr poll_plan words_only{modbus::timing_at(115200), cyclic<word>(drive_at_1, milliseconds(300))};

// A drive on a bus that is only read.
template <const auto& Plan> struct polled {
    scripted_port port;
    scheduled_line<scripted_port> on{port, modbus::timing_at(115200)};
    bus<Plan, scheduled_line<scripted_port>> all{on};
    tests::register_file file;

    polled() {
        file.words = {{0, 0}, {1, 5}, {2, 0x0001}, {3, 0x2345}};
        port.device = [this](scripted_port& p, const sent_frame& f) { file(p, f); };
    }
    polled(const polled&) = delete;

    template <class Done> void step_until(Done&& done) {
        while (!done()) {
            (void)all.step();
            REQUIRE_FALSE(port.ran_away);
        }
    }
    void step_for(std::uint64_t us) {
        const std::uint64_t end = port.time + us;
        step_until([&] { return port.time >= end; });
    }
};

} // namespace

TEST_CASE_TEMPLATE("G1: after a change of its timing the line is quiet for the quarantine before a request",
                   Port, scripted_port, waiting_scripted_port) {
    const bus_gaps gaps{{}, milliseconds(100)};
    for (const bool is_retimed : {true, false}) {
        wire<Port> w;
        w.answers_all_but(0);
        REQUIRE(w.ask(1, gaps) == errc::ok);
        REQUIRE(w.ask(1, gaps) == errc::ok);
        const std::uint64_t changed = w.port.time;
        if (is_retimed) REQUIRE(w.on.retime(modbus::timing_at(57600)) == errc::ok);
        w.port.character_us = w.on.timing().character;
        CHECK(w.ask(1, gaps) == errc::ok);
        const std::uint64_t waited = w.last_begin() - changed;
        if (is_retimed) CHECK(waited >= 100'000 - tolerance);
        if (!is_retimed) CHECK(waited < 10'000); // the quarantine is the change's
    }
}

TEST_CASE_TEMPLATE(
    "G1: a stop to one node does not shorten the quarantine of another before the next request", Port,
    scripted_port, waiting_scripted_port) {
    const bus_gaps slow{{}, milliseconds(400)};
    const bus_gaps quick{{}, milliseconds(20)};
    for (const std::uint8_t next : {std::uint8_t{2}, std::uint8_t{3}}) {
        for (const unsigned stops : {1u, 2u}) {
            wire<Port> w;
            w.answers_all_but(1);
            REQUIRE(w.ask(2, slow) == errc::ok);
            REQUIRE(w.ask(1, slow) == errc::timeout);
            const std::uint64_t timed_out = w.port.time;
            for (unsigned i = 0; i < stops; ++i) REQUIRE(w.ask(2, quick, priority::stop) == errc::ok);
            CHECK(w.last_begin() < timed_out + 20'000); // a stop waits for no quarantine
            CHECK(w.ask(next, quick) == errc::ok);
            CHECK(w.last_begin() >= timed_out + 400'000 - tolerance);
            const std::uint64_t ended = w.port.time;
            CHECK(w.ask(next, quick) == errc::ok); // and then it is over
            CHECK(w.last_begin() < ended + 10'000);
        }
    }
}

// The next read of the 16-bit word is lost, since the drive restarts. Its pair has these words then.
template <class Polled>
void restart_in_a_read(Polled& r, bool& is_lost, std::uint16_t first, std::uint16_t second) {
    r.port.device = [&r, &is_lost, first, second](scripted_port& p, const sent_frame& f) {
        if (is_lost || f.data[3] != 1) return r.file(p, f);
        is_lost = true;
        r.file.words[2] = first;
        r.file.words[3] = second;
    };
}

TEST_CASE("G21, G22: a read without a response invalidates the word order for all reads of its drive") {
    polled<words_and_pairs> r;
    r.all.set_word_order(1, word_order::high_first);
    const auto pair_value = [&] { return r.all.latest<pair>(milliseconds(5000)); };
    r.step_until([&] { return r.all.count(0) != 0 && r.all.count(1) != 0; });
    REQUIRE(pair_value());
    CHECK(*pair_value() == 0x0001'2345);
    // The drive restarts, with the other word order, while the 16-bit word is read.
    bool is_lost = false;
    restart_in_a_read(r, is_lost, 0x2345, 0x0001);
    const std::uint32_t before = r.all.count(1);
    r.step_until([&] { return is_lost; });
    const auto wrong = [&] {
        const auto v = pair_value();
        return v && *v != 0x0001'2345;
    };
    r.step_until([&] { return r.all.count(1) >= before + 3 || wrong(); });
    CHECK_FALSE(wrong());
    CHECK(pair_value().error() == errc::needs_word_order);
    CHECK(r.all.latest<word>(milliseconds(1000))); // a 16-bit word has no word order
    r.all.set_word_order(1, word_order::low_first);
    r.step_for(700'000);
    REQUIRE(pair_value());
    CHECK(*pair_value() == 0x0001'2345);
}

TEST_CASE(
    "G22: once the word order that a program gave to a bus is stale, the one that the node was made with "
    "holds again") {
    polled<stated_pairs> r;
    r.file.words[2] = 0x2345; // low word first
    r.file.words[3] = 0x0001;
    r.all.set_word_order(1, word_order::low_first);
    const auto pair_value = [&] { return r.all.latest<pair>(milliseconds(5000)); };
    r.step_until([&] { return r.all.count(0) != 0 && r.all.count(1) != 0; });
    REQUIRE(pair_value());
    CHECK(*pair_value() == 0x0001'2345);
    // The drive restarts while a word is read, and has the order of the factory again.
    bool is_lost = false;
    restart_in_a_read(r, is_lost, 0x0001, 0x2345);
    const std::uint32_t before = r.all.count(1);
    r.step_until([&] {
        const auto v = pair_value();
        if (v) REQUIRE(*v == 0x0001'2345);
        return r.all.count(1) >= before + 3;
    });
    REQUIRE(is_lost);
    CHECK(pair_value());
}

TEST_CASE("G20: the age of a bus's value counts from its request, however long the drive takes to respond") {
    for (const std::uint32_t delay : {1'000u, 20'000u, 80'000u}) {
        CAPTURE(delay);
        polled<words_only> r;
        r.file.delay = delay;
        r.step_until([&] { return r.all.count(0) == 2; });
        const auto age = [&] { return r.port.time - r.port.frames.back().begin; };
        REQUIRE(age() > delay);
        CHECK(r.all.latest<word>(microseconds(static_cast<std::uint32_t>(age()) + 100)));
        CHECK_FALSE(r.all.latest<word>(microseconds(static_cast<std::uint32_t>(age()) - 100)));
    }
}

} // namespace wire_times_tests
