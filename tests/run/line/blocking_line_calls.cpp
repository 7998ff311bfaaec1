// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The blocking line between its calls and in edge cases: what the time between two calls counts for, a slow
// loop, a port without members, and requests that no client makes.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>

namespace blocking_line_calls_tests {

using namespace tests;
using namespace tests::blocking;
using namespace servobus;

namespace {
// A device's own address: the response to its write may be the last one.
constexpr reg<u16, access::rw, device> address{0x0300, {1, 99}, no_unit, 1, flag::communication};

// A device with a switchable word order, which a node of constants cannot store.
struct switched {
    static constexpr profile facts{
        .name = "switched", .word_order = word_order::unknown, .word_order_register = 0x0019};
};
constexpr reg<i32, access::rw, switched> place{0x0102, full<i32>, units::pulse, 0};
constexpr reg<u16, access::rw, switched> lamp{0x0104, full<u16>, no_unit, 0};
} // namespace

TEST_CASE_TEMPLATE("G1, G29: the time between two calls counts as gap, and costs no waiting", S, polls,
                   sleeps, polls_strict, sleeps_strict) {
    for (const std::uint64_t idle : std::initializer_list<std::uint64_t>{
             50'000, 400'000, 5'000'000, 2'100'000'000, 2'150'000'000, 4'294'967'296, 4'294'970'000}) {
        for (const bool is_troubled : {false, true}) {
            for (const int stray : {-1, 0x00, 0x55}) { // a byte that came right before the call
                CAPTURE(idle);
                CAPTURE(is_troubled);
                CAPTURE(stray);
                rig<S> r;
                if (is_troubled) REQUIRE(r.ask(read_one) == errc::timeout);
                r.port.device = answering(500);
                r.port.time += idle;
                const std::uint64_t begun = r.port.time;
                if (stray >= 0) r.port.arrive(begun, static_cast<std::uint8_t>(stray));
                REQUIRE(r.ask(read_one) == errc::ok);
                const std::uint64_t waited = r.port.frames.back().begin - begun;
                const bool is_quiet = idle < 0x8000'0000 && idle >= S::after_trouble + 100'000;
                if (stray == 0x55) CHECK(waited >= S::after_trouble);
                if (stray == 0x00 && (is_quiet || !is_troubled)) CHECK(waited <= S::timing.t3_5 + 40u);
                if (stray >= 0) CHECK(waited >= S::timing.t3_5);
                if (stray < 0 && is_quiet) CHECK(waited <= 10);
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G1, G8: while the port was lost nothing was received: a blocking line counts the gap from its return", S,
    polls, sleeps, polls_strict) {
    rig<S> healthy{answering(500)};
    const std::uint64_t first = healthy.port.calls;
    REQUIRE(healthy.ask(read_one) == errc::ok);
    const std::uint64_t all = healthy.port.calls - first;
    for (const std::uint64_t calls :
         {std::uint64_t{1}, all / 2, all - 3}) { // from before it leaves to its response
        for (const std::uint32_t away_ms : {0u, 5u, 500u, 100'000u}) {
            CAPTURE(calls);
            CAPTURE(away_ms);
            rig<S> r{answering(500)};
            for (unsigned tries = 0; tries < 3; ++tries) {
                r.port.lost_from_call = r.port.calls + (tries == 0 ? calls : 1);
                REQUIRE(r.ask(read_one) == errc::port_lost);
                r.port.time += away_ms * 1000;
            }
            r.port.lost_from_call = 0;
            const std::uint64_t back = r.port.time;
            REQUIRE(r.ask(read_one) == errc::ok);
            CHECK(r.port.frames.back().begin - back >= S::after_trouble);
            // A response that was on its way when the port was lost, and arrives right after its return, is
            // still received.
            const std::uint32_t sounds = away_ms == 0 ? 600 + S::timing.wire_time(15).us : 100u;
            CHECK(r.port.frames.back().begin - back <= S::after_trouble + S::timing.t3_5 + sounds);
            // Only once: the time between two calls counts again.
            r.port.time += 50'000;
            const std::uint64_t again = r.port.time;
            REQUIRE(r.ask(read_one) == errc::ok);
            CHECK(r.port.frames.back().begin - again <= 100);
        }
    }
}

TEST_CASE_TEMPLATE("G25: a stop waits for its node's gap and for no quarantine, whichever is longer", S,
                   polls, sleeps, polls_strict) {
    for (const std::uint32_t gap_ms : {0u, 20u, 99u, 100u, 101u, 140u, 500u}) {
        for (const int stray : {-1, 0x00, 0x55}) { // while it waits
            CAPTURE(gap_ms);
            CAPTURE(stray);
            rig<S> r;
            REQUIRE(r.ask(read_one) == errc::timeout);
            const std::uint64_t begun = r.port.time;
            std::uint64_t sounded = begun;
            r.gaps.gap = milliseconds(gap_ms);
            r.priority = priority::stop;
            if (stray >= 0 && gap_ms != 0) {
                sounded += gap_ms * 1000 - 2000;
                r.port.arrive(sounded, static_cast<std::uint8_t>(stray));
            }
            r.port.device = answering(500);
            REQUIRE(r.ask(write_one) == errc::ok);
            const std::uint64_t waited = r.port.frames.back().begin - sounded;
            const std::uint64_t gap = longer_of(milliseconds(gap_ms), duration{S::timing.t3_5}).us;
            CHECK(waited + 10 >= gap);
            CHECK(waited <= gap + S::timing.character + 100);
            r.gaps = {};
            r.priority = priority::ordinary;
            const std::uint64_t heard = r.port.last_heard;
            REQUIRE(r.ask(read_one) == errc::ok);
            if (gap < S::after_trouble) CHECK(r.port.frames.back().begin >= heard + S::after_trouble);
        }
    }
}

TEST_CASE_TEMPLATE("G1: the first request waits for the whole quarantine, whatever the clock shows by then",
                   S, polls, sleeps) {
    for (const std::uint32_t start : {0u, 1u, 99'000u, 0x7FFF'FFF0u, 0x8000'0000u, 0xFFFF'FFFFu}) {
        CAPTURE(start);
        typename S::port port;
        const std::uint64_t power_up = port.time;
        port.clock = [=](std::uint64_t t) { return static_cast<std::uint32_t>(t - power_up + start); };
        port.device = answering(500);
        typename S::line on{port};
        client<typename S::line, device, fixed_node<device>> drive{on, {}};
        CHECK_FALSE(drive.template read<state>().error() == errc::line_busy);
        REQUIRE_FALSE(port.frames.empty());
        CHECK(port.frames[0].begin >= power_up + S::after_trouble);
        CHECK(port.frames[0].begin <= power_up + S::after_trouble + 2000);
    }
}

TEST_CASE_TEMPLATE("a loop that is delayed finds the response that arrived in time", S, polls, sleeps) {
    for (const std::uint32_t held : {0u, 50'000u, 150'000u, 900'000u}) { // by tasks of higher priority
        struct slow : S::port {
            std::uint32_t held = 0;
            bool was_sent = false;
            bool sent() {
                const bool is_sent = S::port::sent();
                if (is_sent && !was_sent) this->time += held;
                was_sent = is_sent;
                return is_sent;
            }
        };
        rig<setup<slow>> r{answering(20'000)};
        r.port.was_sent = false;
        r.port.held = held;
        CHECK(r.run(read_one).response == one_word);
        r.port.was_sent = false;
        CHECK(r.ask(write_two) == errc::ok);
    }
}

TEST_CASE("a slow loop never sends zero bytes: drivers take a length of 0 for an error") {
    struct strict_port : scripted_port {
        unsigned empty_sends = 0;
        transfer send(bytes out) {
            empty_sends += out.empty();
            return scripted_port::send(out);
        }
    };
    rig<setup<strict_port>> r{answering(5000)};
    r.port.says_sent_late = 3000;
    for (const std::size_t most : {1u, 5u, 1000u}) {
        r.port.takes_at_most = most;
        CHECK(r.ask(write_two) == errc::ok);
    }
    CHECK(r.port.empty_sends == 0);
}

TEST_CASE("a port that takes nothing is distinguished from a line that is never quiet") {
    rig r;
    r.port.takes_nothing_until = ~std::uint64_t{0};
    CHECK(r.run_in_time(read_one).why.error() == errc::send_failed);
    r.port.takes_nothing_until = 0;
    for (std::uint64_t t = 0; t < 2'000'000; t += 500) r.port.arrive(r.port.time + t, 0x55);
    CHECK(r.run_in_time(read_one).why.error() == errc::line_busy);
}

namespace {
// Nothing but static functions, like most ports of boards.
scripted_port hardware;
struct bare {
    static transfer send(bytes out) { return hardware.send(out); }
    static bool sent() { return hardware.sent(); }
    static transfer receive(byte_buffer in) { return hardware.receive(in); }
    static instant now() { return hardware.now(); }
};
} // namespace

TEST_CASE("a port without members costs no pointer") {
    using wire = blocking_line<bare, timing_at(115200)>;
    static_assert(std::is_empty_v<bare>);
    static_assert(sizeof(wire) + sizeof(void*) == sizeof(blocking_line<scripted_port, timing_at(115200)>) ||
                  sizeof(void*) > 4); // alignment to 8 bytes may take up the difference
    static_assert(sizeof(wire) < sizeof(blocking_line<scripted_port, timing_at(115200)>));
    bare port;
    wire on{port};
    client drive{on, fixed_node<device>{}};
    register_file file;
    file.words[0x0200] = 0xBEEF;
    hardware.device = [&](scripted_port& p, const sent_frame& f) { file(p, f); };
    CHECK(*drive.read<state>() == 0xBEEF);
    hardware.device = nullptr;
}

TEST_CASE("an exchange of the program has its words after the first three bytes of the response") {
    rig r{answering(500)};
    byte_list room(9);
    const byte_list read_two = framed({1, 3, 0x01, 0x00, 0, 2});
    r.port.device = saying(framed({1, 3, 4, 0x12, 0x34, 0x56, 0x78}));
    const sleeps::line::exchange_for<response_limits> x{read_two, room, r.on.timing(), r.limits};
    REQUIRE(r.on.run(x, r.gaps).error() == errc::ok);
    CHECK(x.words()[0] == 0x1234);
    CHECK(x.words()[1] == 0x5678);
    CHECK(x.words().size() == 2); // without the CRC
    const sleeps::line::exchange_for<response_limits> none{byte_list{1, 3}, room, r.on.timing(), r.limits};
    CHECK(none.words().size() == 0);
}

TEST_CASE(
    "an exchange of any function needs room for a response that there can be, and a node that responds") {
    using any = sleeps::line::exchange_for<response_limits, false, true>;
    rig r;
    byte_list room(300);
    const auto length = [&](const byte_list& request, std::size_t size) {
        const any x{request, byte_buffer{room}.first(size), r.on.timing(), r.limits};
        if (x.response_size() == 0) CHECK(r.on.run(x, r.gaps).error() == errc::bad_argument);
        return x.response_size();
    };
    const byte_list identify = framed({1, 0x2B, 0x0E, 1, 0});
    CHECK(length(identify, 5) == 5);
    CHECK(length(identify, 255) == 255);
    CHECK(length(identify, 4) == 0);
    CHECK(length(identify, 256) == 0);
    CHECK(length(framed({0, 0x2B, 0x0E, 1, 0}), 9) == 0);
    CHECK(length(framed({248, 0x2B, 0x0E, 1, 0}), 9) == 0);
    CHECK(length(framed({1, 0xAB, 0x0E, 1, 0}), 9) == 0);
    CHECK(r.port.frames.empty());
}

TEST_CASE("requests that no client makes are refused, and nothing is sent") {
    using wire = sleeps::line;
    rig r{answering(500)};
    byte_list room(600);
    const auto refused = [&]<bool IsBroadcast>(std::bool_constant<IsBroadcast>, const byte_list& request,
                                               std::size_t size) {
        const wire::exchange_for<response_limits, IsBroadcast> x{request, byte_buffer{room}.first(size),
                                                                 r.on.timing(), r.limits};
        const status w = r.on.run(x, r.gaps);
        return w.error() == errc::bad_argument && w.outcome() == outcome::not_sent;
    };
    const std::false_type one;
    const std::true_type all;
    CHECK(refused(one, {}, 8));
    CHECK(refused(one, {1, 3, 0, 0, 0, 1, 0x84}, 7));
    CHECK(refused(one, read_one, 6)); // no room
    CHECK(refused(one, write_one, 7));
    CHECK(refused(one, framed({1, 3, 0, 0, 0, 126}), 256)); // 257 bytes
    CHECK(refused(one, framed({1, 3, 0, 0, 0, 126}), 600)); // no frame is so long, whatever the room
    CHECK(refused(one, framed({1, 3, 0, 0, 0, 255}), 600));
    CHECK(refused(one, framed({1, 3, 0, 0, 0, 0}), 600));
    CHECK(refused(one, framed({1, 3, 0, 0, 1, 1}), 600));  // 257 registers
    CHECK(refused(one, framed({1, 3, 0, 0, 0, 1, 0}), 7)); // a read with an extra byte
    CHECK(refused(one, byte_list(256, 0x10), 8));
    CHECK(refused(one, framed({0, 6, 0, 0, 0, 1}), 8));
    CHECK(refused(all, write_one, 8));
    CHECK(refused(all, framed({0, 3, 0, 0, 0, 1}), 7)); // G30
    CHECK(r.port.frames.empty());
    CHECK(r.ask(read_one) == errc::ok);
}

TEST_CASE("G2: a client distinguishes a wrong value from a wrong quantity, and accepts a byte count where "
          "its drive echoes it") {
    rig r;
    r.port.device = saying(framed({1, 6, 0x01, 0x01, 0, 8}));
    CHECK(r.fixed.write<speed>(7).error() == errc::wrong_value);
    CHECK(r.open.write<speed>(7).error() == errc::wrong_value);
    r.port.device = saying(framed({1, 0x10, 0x01, 0x02, 0, 4}));
    CHECK(r.fixed.write<position>(7).error() == errc::wrong_quantity);
    CHECK(r.open.write<position>(7).error() == errc::wrong_quantity);
    r.open.node().limits.echoes_byte_count = true; // the response overwrites the request's byte count
    CHECK(r.open.write<position>(7).outcome() == outcome::done);
    for (const byte_list& counts : {byte_list{0, 6}, byte_list{1, 4}, byte_list{4, 4}}) {
        r.port.device = saying(framed(byte_list{1, 0x10, 0x01, 0x02} + counts));
        CHECK(r.open.write<position>(7).error() == errc::wrong_quantity);
    }
    r.port.device = saying(framed({1, 0x83, 2}));
    CHECK(r.open.write<position>(7).error() == errc::wrong_function);
    r.port.device = saying(framed({1, 0x90, 2}));
    CHECK(r.open.write<position>(7) == status::sent(errc::exception, 2));
}

TEST_CASE("G22: a node of constants with an unknown word order sends no frame for a 32-bit value") {
    rig r{answering(500)};
    client drive{r.on, fixed_node<switched>{}};
    const auto both = drive.read<place, lamp>();
    CHECK(both.error() == errc::needs_word_order);
    CHECK(both->get<lamp>() == 0);
    CHECK(drive.read<place>().error() == errc::needs_word_order);
    CHECK(drive.write<place, lamp>(5, 6).error() == errc::needs_word_order);
    CHECK(r.port.frames.empty());
    CHECK(*drive.read<lamp>() == 0x0960);
}

TEST_CASE("G22: on a blocking line, too, words that arrive after a timeout are not joined in the word order "
          "read before it") {
    rig r{answering(500)};
    client drive{r.on, node<switched>{1}};
    r.port.device = saying(tests::read_response(1, {0}));
    REQUIRE(drive.learn_word_order().error() == errc::ok);
    const auto lose_one = [&] {
        r.port.device = [&r](scripted_port&, const sent_frame&) { r.port.device = answering(500); };
    };
    r.port.device = answering(500);
    REQUIRE(drive.read<place>());
    lose_one();
    SUBCASE("a value") { CHECK(drive.read<place>().error() == errc::needs_word_order); }
    SUBCASE("a block") {
        const auto both = drive.read<place, lamp>();
        CHECK(both.error() == errc::needs_word_order);
        CHECK(both->get<place>().count() == 0);
    }
    CHECK(drive.read<place>().error() == errc::needs_word_order);
    CHECK(*drive.read<lamp>() == 0x0960);
}

TEST_CASE("raw writes that fit no frame are refused, and nothing is sent") {
    rig r{answering(500)};
    const std::array<u16, 7> words{};
    const auto first = [&](std::size_t n) { return std::span<const u16>{words}.first(n); };
    CHECK(r.fixed.write_words(0x2000, first(0)) == errc::bad_argument);
    CHECK(r.fixed.write_words(0x2000, first(7)) == errc::bad_argument); // at most 6
    CHECK(r.fixed.write_words(0xFFFF, first(2)) == errc::bad_argument);
    CHECK(r.fixed.write_words(0xFFFE, first(3)).outcome() == outcome::not_sent);
    CHECK(r.port.frames.empty());
    CHECK(r.fixed.write_words(0xFFFE, first(2)));
    CHECK(r.last() == framed({1, 0x10, 0xFF, 0xFE, 0, 2, 4, 0, 0, 0, 0}));
}

TEST_CASE_TEMPLATE("G1: a failure after a broadcast is followed by a quarantine too", S, polls, sleeps) {
    unsigned garbled = 0;
    constexpr bool is_asleep = waiting_port<typename S::port>; // then few calls are made
    for (unsigned n = 1; n < 2000;
         n += n < 1500 && !is_asleep ? 37 : 1) { // the n-th call finds a garbled one
        rig<S> r;
        r.port.fails_at_call = r.port.calls + n;
        const auto e = r.run(framed({0, 6, 0x20, 0x0E, 0, 7}));
        if (!e.was_sent || e.why.error() == errc::ok) continue; // before the request had left, or not at all
        ++garbled;
        CHECK(e.why.error() == errc::receive_failed);
        const std::uint64_t over = r.port.time;
        r.port.device = answering(500);
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames.back().begin >= over + S::after_trouble - 10);
    }
    CHECK(garbled > 0);
}

TEST_CASE("G1: a request that left late has its own time to leave, and the next one waits for it") {
    using slow = setup<scripted_port, timing_at(9600), milliseconds(100)>;
    byte_list longest{1, 0x10, 0x20, 0x00, 0, 123, 246};
    longest.resize(7 + 246, 0x11);
    longest = framed(longest);
    for (std::uint64_t noise = 700'000; noise < 1'500'000; noise += 13'000) {
        CAPTURE(noise);
        rig<slow> r{answering(5000)};
        for (std::uint64_t t = 0; t < noise; t += 5000) r.port.arrive(r.port.time + t, 0x55);
        const auto e = r.run_in_time(longest);
        CHECK((e.why.error() == errc::ok || e.why.error() == errc::line_busy));
        CHECK(e.was_sent == (e.why.error() == errc::ok));
        r.port.time += 2'000'000; // whatever is left of the noise
        const std::uint64_t end = r.port.frames.empty() ? 0 : r.port.frames.back().end;
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames.back().begin >= end);
    }
}

TEST_CASE_TEMPLATE("a loop that is delayed while it waits for the quarantine still does its write", S, polls,
                   sleeps) {
    for (const std::uint32_t held : {100'000u, 310'000u, 900'000u, 5'000'000u}) {
        CAPTURE(held);
        rig<S> r{answering(500)};
        byte_list bad = one_word;
        bad.back() ^= 1;
        r.port.device = saying(bad);
        CHECK(r.ask(read_one) == errc::bad_crc);
        r.port.device = answering(500);
        const std::uint64_t from = r.port.time + 50'000; // in the middle of the quarantine
        r.port.clock = [=](std::uint64_t t) { return static_cast<std::uint32_t>(t < from ? t : t + held); };
        CHECK(r.ask(write_two) == errc::ok);
    }
}

TEST_CASE("G30: a node whose address no device can have gets no request, for any register") {
    for (const std::uint8_t node_address : std::array<std::uint8_t, 4>{0, 100, 247, 255}) {
        CAPTURE(node_address);
        rig r{answering(500)};
        r.open.node().address = node_address;
        CHECK(r.open.write<speed>(1) == errc::bad_argument);
        CHECK(r.open.write<address>(7) == errc::bad_argument);
        CHECK(r.open.write<ramp, speed>(1, 2) == errc::bad_argument);
        CHECK(r.open.read<state>().error() == errc::bad_argument);
        CHECK(r.port.frames.empty());
    }
}

namespace {
struct only_one : bare {
    only_one() = default;
    only_one(const only_one&) = delete;
};
} // namespace

TEST_CASE("a port without members that must not be copied is not") {
    only_one port;
    blocking_line<only_one, timing_at(115200)> on{port};
    CHECK(&on.port() == &port);
}

} // namespace blocking_line_calls_tests
