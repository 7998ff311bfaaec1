// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line over a scripted port: a healthy line, the gap before each request, the quarantine after anything
// but one valid response, broadcasts, and what an observer gets. All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/line_rig.hpp>

namespace line_gaps_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;
using tests::operator+;

TEST_CASE_TEMPLATE("on a healthy line reads and writes succeed, and each is sent once", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.port.device = answering(800);
    for (const byte_list& request : {read_one, write_one, write_two}) {
        const auto e = r.run(request);
        CHECK(e.why == errc::ok);
        CHECK(e.was_sent);
        CHECK(e.response == good_response(request));
        CHECK(r.port.frames.back().data == request);
    }
    CHECK(r.port.frames.size() == 3);
    CHECK(r.on.observer().requests == 3);
    CHECK(r.on.observer().responses == 3);
    CHECK(r.on.observer().unexpected_bytes == 0);
}

TEST_CASE_TEMPLATE("G1: a line sends nothing before its first quarantine", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    const std::uint64_t begun = r.port.time;
    r.port.device = answering(500);
    CHECK(r.run(read_one).why.error() == errc::ok);
    CHECK(r.port.frames[0].begin >= begun + 100'000 - 10);
}

TEST_CASE_TEMPLATE("G1: after anything but one valid response nothing is sent before the quarantine is over",
                   Port, scripted_port, waiting_scripted_port) {
    byte_list bad_crc = one_word;
    bad_crc.back() ^= 1;
    const byte_list cut(one_word.begin(), one_word.begin() + 4);
    const std::vector<byte_list> responses{{},
                                           bad_crc,
                                           cut,
                                           tests::read_response(2, {1}),
                                           tests::read_response(1, {1, 2}),
                                           tests::acknowledgement(write_one),
                                           byte_list(40, 0x55),
                                           one_word + one_word};
    for (const std::uint32_t quarantine : {1000u, 30'000u, 250'000u}) {
        for (std::size_t i = 0; i < responses.size(); ++i) {
            CAPTURE(quarantine);
            CAPTURE(i);
            rig<Port> r;
            r.settle();
            r.gaps.quarantine = microseconds(quarantine);
            r.port.device = [&](auto& port, const tests::sent_frame&) { port.say(500, responses[i]); };
            const auto e = r.run(read_one);
            CHECK((e.why.error() == errc::ok) == (i == 7));
            const std::uint64_t over = r.port.time;
            const std::uint64_t heard = r.port.last_arrival();
            r.port.device = answering(500);
            CHECK(r.run(read_one).why.error() == errc::ok);
            const std::uint64_t silence =
                longer_of(microseconds(quarantine), r.timing.visible_gap()).us; // host timing: G7
            CHECK(r.port.frames[1].begin >= (i == 7 ? heard : over) + silence - 10);
            CHECK(r.port.frames[1].begin >= heard + silence);
        }
    }
}

TEST_CASE_TEMPLATE("G1: a second response in the same burst causes a quarantine like a separate one", Port,
                   scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = [](auto& port, const tests::sent_frame& f) {
        for (const std::uint8_t b : one_word + one_word) port.arrive(f.end + 2000, b);
    };
    CHECK(r.run(read_one).why.error() == errc::ok);
    r.port.device = answering(500);
    CHECK(r.run(read_one).why.error() == errc::ok);
    CHECK(r.on.observer().unexpected_bytes == one_word.size());
    CHECK(r.port.frames[1].begin >= r.port.frames[0].end + 2000 + 100'000);
}

TEST_CASE_TEMPLATE(
    "G1: up to four bytes 00 or FF between frames come from a driver that switches, more cause a quarantine",
    Port, scripted_port, waiting_scripted_port) {
    for (const std::uint8_t value : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x01}) {
        for (std::size_t n = 0; n <= 6; ++n) {
            CAPTURE(value);
            CAPTURE(n);
            rig<Port> r;
            r.settle();
            r.port.device = answering(500);
            const std::uint64_t end = r.port.time + n * 96;
            r.port.say_at(r.port.time, byte_list(n, value));
            CHECK(r.run(read_one).why.error() == errc::ok);
            const bool is_trouble = value == 0x01 ? n > 0 : n > 4;
            CHECK((r.port.frames[0].begin >= end + 100'000) == is_trouble);
            CHECK(r.on.observer().unexpected_bytes == n);
        }
    }
}

TEST_CASE_TEMPLATE(
    "G1: a driver may switch before every request without its bytes ever adding up to a quarantine", Port,
    scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    for (int i = 0; i < 10; ++i) {
        r.port.say_at(r.port.time, {0x00, 0xFF, 0x00});
        const std::uint64_t heard = r.port.last_arrival();
        CHECK(r.run(read_one).why.error() == errc::ok);
        CHECK(r.port.frames.back().begin <= heard + 1750 + 40);
    }
}

TEST_CASE_TEMPLATE("the line waits for a port that reports late that all has left, as over USB", Port,
                   scripted_port, waiting_scripted_port) {
    for (const std::uint32_t late : {100u, 5000u, 18'000u}) {
        rig<Port> r;
        r.port.says_sent_late = late;
        r.port.device = answering(30'000);
        CHECK(r.run(write_one).why.error() == errc::ok);
    }
}

TEST_CASE_TEMPLATE("G1: a valid response, an exception too, is followed by t3.5 only", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = [](auto& port, const tests::sent_frame& f) {
        port.say(500, tests::exception_response(1, f.data[1], 2));
    };
    for (int i = 0; i < 5; ++i) {
        CHECK(r.run(write_one).why == status::sent(errc::exception, 2));
        if (i > 0) {
            const std::uint64_t response_end = r.port.frames[r.port.frames.size() - 2].end + 500 + 5 * 96;
            CHECK(r.port.frames.back().begin >= response_end + 1750);
            CHECK(r.port.frames.back().begin <= response_end + 1750 + 40);
        }
    }
}

TEST_CASE_TEMPLATE("a stop frame waits for t3.5 and not for the quarantine", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    CHECK(r.run(read_one).why.error() == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.priority = priority::stop;
    r.port.device = answering(500);
    CHECK(r.run(write_one).why.error() == errc::ok);
    CHECK(r.port.frames[1].begin >= over + 1750 - 10);
    CHECK(r.port.frames[1].begin <= over + 1750 + 100);
    // The quarantine is still pending: requests that are no stop wait for it.
    r.priority = priority::ordinary;
    const std::uint64_t heard = r.port.last_heard;
    CHECK(r.run(read_one).why.error() == errc::ok);
    CHECK(r.port.frames[2].begin >= heard + 100'000);
}

TEST_CASE_TEMPLATE(
    "G1: a response to an older request that arrives while the next one leaves is not a response to that one",
    Port, scripted_port, waiting_scripted_port) {
    // Up to two characters before the last bit has left: the line checks the port once a character at most.
    const byte_list stale = tests::read_response(1, {0xDEAD});
    for (std::uint64_t before = 2 * 96; before < 16 * 96; before += 7) {
        CAPTURE(before);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) { port.say_at(f.end - before, stale); };
        const auto e = r.run(read_one);
        CHECK(e.why.error() != errc::ok);
    }
}

TEST_CASE_TEMPLATE(
    "G2: a doubled response that begins before the next request has left is never the response to that one",
    Port, scripted_port, waiting_scripted_port) {
    const byte_list stale = tests::read_response(1, {0xDEAD});
    for (std::uint32_t behind = 0; behind < 2600; behind += 13) { // the next request has left 2518 us later
        if (behind > 2300) break;
        CAPTURE(behind);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            if (f.data == read_one) {
                port.say(500, stale);
                port.say(500 + 7 * 96 + behind, stale);
            } else {
                port.say(500, one_word);
            }
        };
        CHECK(r.run(read_one).response == stale);
        const auto e = r.run(read_other);
        CHECK((e.why.error() != errc::ok || e.response == one_word));
        CHECK(r.on.observer().unexpected_bytes <= 7);
    }
}

TEST_CASE_TEMPLATE("G2: a response that begins within the quarantine after a timeout is dropped and counted",
                   Port, scripted_port, waiting_scripted_port) {
    const byte_list stale = tests::read_response(1, {0xDEAD});
    for (std::uint32_t late = 200; late < 99'800; late += 3319) {
        CAPTURE(late);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            port.say(f.data == read_one ? 100'000 + late : 500, f.data == read_one ? stale : one_word);
        };
        CHECK(r.run(read_one).why.error() == errc::timeout);
        const auto e = r.run(read_other);
        CHECK(e.why.error() == errc::ok); // it costs a second quarantine, not the exchange
        CHECK(e.response == (e.why.error() == errc::ok ? one_word : byte_list{}));
        CHECK(r.on.observer().unexpected_bytes == stale.size());
    }
}

TEST_CASE_TEMPLATE(
    "G8: a line sends a request t3.5, or the node's gap, after the last response, and little later", Port,
    scripted_port, waiting_scripted_port) {
    for (const std::uint32_t baud : {1200u, 9600u, 19200u, 115200u}) {
        for (const std::uint32_t gap : {0u, 500u, 5000u, 40'000u}) {
            for (const timing_mode mode : {timing_mode::host, timing_mode::strict}) {
                CAPTURE(baud);
                CAPTURE(gap);
                rig<Port> r{timing_at(baud, mode)};
                r.limits.response = milliseconds(300);
                r.settle();
                r.gaps.gap = microseconds(gap);
                r.port.device = answering(r.timing.t3_5);
                const std::uint64_t needed = gap > r.timing.t3_5 ? gap : r.timing.t3_5;
                const std::uint64_t cycle = 15u * r.timing.character + r.timing.t3_5 + needed;
                for (int i = 0; i < 20; ++i) {
                    const std::uint64_t heard = r.port.last_heard;
                    REQUIRE(r.run(i % 3 == 0 ? write_one : read_one).why.error() == errc::ok);
                    REQUIRE(r.port.frames.back().begin >= heard + needed);
                    REQUIRE(r.port.frames.back().begin <= heard + needed + cycle / 100 + 12);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE("G8: a line has received no byte within t3.5 before a request, however slow the port is",
                   Port, scripted_port, waiting_scripted_port) {
    struct watched : Port {
        std::uint64_t heard_before_request = 0;
        transfer send(bytes out) {
            if (this->frames.empty() || this->frames.back().complete) heard_before_request = this->last_heard;
            return Port::send(out);
        }
    };
    for (const std::uint32_t cost : {0u, 40u, 300u, 600u}) {
        for (std::uint32_t seed = 0; seed < 40; ++seed) {
            CAPTURE(cost);
            CAPTURE(seed);
            rig<watched> r{timing_at(115200, timing_mode::strict)};
            r.settle();
            r.gaps.quarantine = {};
            r.port.device = answering(2000);
            r.port.receive_us = cost;
            r.port.gives_at_most = seed % 2 == 0 ? 1 : 1000;
            tests::dice random{seed};
            std::uint64_t at = r.port.time;
            for (int i = 0; i < 20; ++i) {
                at += random.below(i < 4 ? 4000 : 500);
                r.port.say_at(at, byte_list(1 + random.below(3), random.byte()));
            }
            (void)r.run(read_one);
            REQUIRE(r.port.frames.size() == 1);
            REQUIRE(r.port.heard_before_request != 0);
            REQUIRE(r.port.frames[0].begin >= r.port.heard_before_request + 1750);
        }
    }
}

TEST_CASE_TEMPLATE("G8: a line keeps the gap in full when the clock jumps back before a request", Port,
                   scripted_port, waiting_scripted_port) {
    for (const std::uint32_t jump : {1u, 5000u, 1'000'000u, 2'000'000'000u}) {
        for (const bool is_troubled : {false, true}) {
            CAPTURE(jump);
            CAPTURE(is_troubled);
            rig<Port> r;
            r.port.time = 3'000'000'000;
            r.settle();
            if (is_troubled) CHECK(r.run(read_one).why.error() == errc::timeout);
            const std::uint64_t at = r.port.time;
            r.port.clock = [at, jump](std::uint64_t t) {
                return static_cast<std::uint32_t>(t < at ? t : t - jump);
            };
            r.port.device = answering(500);
            CHECK(r.run(read_one).why.error() == errc::ok);
            CHECK(r.port.frames.back().begin >= at + (is_troubled ? 100'000 : 1750) - 10);
        }
    }
}

TEST_CASE_TEMPLATE("G30: a broadcast returns after the turnaround and awaits nothing", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.limits.turnaround = milliseconds(25);
    const byte_list all = framed({0, 6, 0x20, 0x0E, 0, 7});
    const auto e = r.run(all);
    CHECK(e.why.error() == errc::ok);
    CHECK(e.was_sent);
    CHECK(r.port.frames.size() == 1);
    CHECK(r.port.time >= r.port.frames[0].end + 25'000);
    CHECK(r.port.time <= r.port.frames[0].end + 25'000 + 60);
    const auto read = r.run(framed({0, 3, 0x20, 0x0E, 0, 1}));
    CHECK(read.why.error() == errc::bad_argument);
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("an observer gets each request once and each end once") {
    struct trace {
        int requests = 0;
        int responses = 0;
        std::size_t strays = 0;
        void on_request(bytes) { ++requests; }
        void on_response(bytes, status) { ++responses; }
        void on_unexpected(bytes b) { strays += b.size(); }
    };
    for (const std::uint64_t busy : {0u, 200u, 20'000u}) {
        CAPTURE(busy);
        scripted_port port;
        port.device = answering(500);
        port.takes_nothing_until = 101'000 + busy; // the port is not ready immediately
        line<scripted_port, both<counters, trace>> on{port, timing_at(115200)};
        std::array<std::uint8_t, 256> room{};
        const response_limits limits;
        exchange x{write_one, room, on.timing(), limits};
        on.run(x, bus_gaps{{}, milliseconds(100)});
        CHECK(on.observer().trace::requests == 1);
        CHECK(on.observer().counters::requests == 1);
        CHECK(on.observer().trace::responses == 1);
    }
}

} // namespace line_gaps_tests
