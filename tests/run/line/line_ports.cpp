// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line over a port that fails at any call, moves a few bytes at a time or miscounts them, and over a
// clock that jumps, goes back or stops: every call ends within its bound, and a write is sent once at most.
// All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <tests/support/line_rig.hpp>

namespace line_ports_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;

// A port that fails.

TEST_CASE_TEMPLATE("G15, G16: whichever call of the port fails, a line sends a write at most once and "
                   "reports its true outcome",
                   Port, scripted_port, waiting_scripted_port) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        for (const std::size_t most : {std::size_t{1000}, std::size_t{3}, std::size_t{1}}) {
            std::uint64_t calls = 0;
            {
                rig<Port> healthy;
                healthy.port.call_us = 20;
                healthy.gaps.quarantine = milliseconds(2);
                healthy.port.device = answering(400);
                healthy.port.takes_at_most = most;
                CHECK(healthy.run(request).why.error() == errc::ok);
                calls = healthy.port.calls;
            }
            REQUIRE(calls > 10);
            unsigned not_sent = 0;
            unsigned unknown = 0;
            for (std::uint64_t n = 1; n <= calls; ++n) {
                for (const bool is_lost : {false, true}) {
                    CAPTURE(n);
                    CAPTURE(is_lost);
                    rig<Port> r;
                    r.port.call_us = 20;
                    r.gaps.quarantine = milliseconds(2);
                    r.port.device = answering(400);
                    r.port.takes_at_most = most;
                    (is_lost ? r.port.lost_from_call : r.port.fails_at_call) = n;
                    const auto e = r.run(request);
                    const status w = e.why;
                    REQUIRE(r.port.frames.size() <= 1);
                    REQUIRE(r.port.bytes_sent() <= request.size());
                    REQUIRE(e.was_sent == (r.port.bytes_sent() != 0));
                    if (!r.port.has_failed) continue;            // call n was `sent`, which cannot fail
                    if (!is_lost && e.why.error() == errc::ok) { // garbled before the request, or its echo
                        REQUIRE(r.port.frames.size() == 1);
                        continue;
                    }
                    REQUIRE(e.why.error() != errc::ok);
                    REQUIRE(w.outcome() == (e.was_sent ? outcome::unknown : outcome::not_sent));
                    ++(e.was_sent ? unknown : not_sent);
                    r.port.lost_from_call = 0; // the port returns
                    REQUIRE(r.run(request).why.error() == errc::ok);
                }
            }
            CHECK(not_sent > 0);
            CHECK(unknown > 0);
        }
    }
}

TEST_CASE_TEMPLATE("G15, G16: short writes, empty reads and a port that miscounts change nothing", Port,
                   scripted_port, waiting_scripted_port) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        for (const std::size_t takes : {1u, 2u, 5u, 7u}) {
            for (const bool only_idle : {false, true}) {
                rig<Port> r;
                r.port.device = answering(900);
                r.port.takes_at_most = takes;
                r.port.takes_only_when_idle = only_idle;
                CHECK(r.run(request).why.error() == errc::ok);
                CHECK(r.port.frames.size() == 1);
                CHECK(r.port.frames[0].data == request);
            }
        }
        for (const std::uint32_t empty : {1u, 2u, 7u}) {
            rig<Port> r;
            r.port.device = answering(900);
            r.port.empty_reads = empty;
            r.port.gives_at_most = 1;
            const auto e = r.run(request);
            CHECK(e.why.error() == errc::ok);
            CHECK(e.response == good_response(request));
        }
        rig<Port> r;
        r.port.device = answering(900);
        r.port.lies_about_counts = true;
        CHECK(r.run(request).why.error() == errc::ok);
        for (int i = 0; i < 100; ++i) r.port.arrive(r.port.time, 0x33);
        CHECK(r.run(request).why.error() == errc::ok);
        const byte_list long_response = tests::read_response(1, std::vector<std::uint16_t>(60, 0x1234));
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            for (const std::uint8_t b : long_response) port.arrive(f.end + 2000, b);
        };
        CHECK(r.run(framed({1, 3, 0x20, 0, 0, 60})).response == long_response);
    }
}

namespace {

// What may fail for the whole of a call, each with the outcome that it must have.
template <class Port> struct ordeal {
    std::string name;
    std::function<void(rig<Port>&)> prepare;
    outcome expected; // of a write
};

template <class Port> std::vector<ordeal<Port>> ordeals() {
    using r = rig<Port>;
    const auto device_of = [](auto f) { return [f](r& x) { x.port.device = f; }; };
    using p = scripted_port;
    using q = tests::sent_frame;
    return {
        {"no response", [](r&) {}, outcome::unknown},
        {"takes nothing, ever", [](r& x) { x.port.takes_nothing_until = ~std::uint64_t{0}; },
         outcome::not_sent},
        {"takes nothing for a while",
         [](r& x) {
             x.port.takes_nothing_until = x.port.time + 10'000;
             x.port.device = answering(500);
         },
         outcome::done},
        {"never sent", [](r& x) { x.port.never_sent = true; }, outcome::unknown},
        {"one byte a call",
         [](r& x) {
             x.port.takes_at_most = 1;
             x.port.device = answering(500);
         },
         outcome::done},
        {"empty reads",
         [](r& x) {
             x.port.empty_reads = 3;
             x.port.device = answering(500);
         },
         outcome::done},
        {"endless noise before it",
         [](r& x) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 500) x.port.arrive(x.port.time + t, 0x55);
         },
         outcome::not_sent},
        {"endless noise after it", device_of([](p& port, const q& f) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 96)
                 port.arrive(f.end + t + 500, static_cast<std::uint8_t>(t));
         }),
         outcome::unknown},
        {"endless zeros after it", device_of([](p& port, const q& f) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 96) port.arrive(f.end + t + 500, 0);
         }),
         outcome::unknown},
        {"endless frames of another node after it", device_of([](p& port, const q&) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 2000)
                 port.say(500 + t, tests::read_response(2, {1}));
         }),
         outcome::unknown},
        {"a response byte by byte", device_of([](p& port, const q& f) {
             std::uint64_t t = f.end + 79'000;
             for (const std::uint8_t b : good_response(f.data)) port.arrive(t += 19'900, b);
         }),
         outcome::done},
        {"a response byte by byte that stops", device_of([](p& port, const q& f) {
             std::uint64_t t = f.end + 79'000;
             byte_list response = good_response(f.data);
             response.pop_back();
             for (const std::uint8_t b : response) port.arrive(t += 19'900, b);
         }),
         outcome::unknown},
    };
}

} // namespace

TEST_CASE_TEMPLATE("G16, G29: every call of a line returns within its bound, every write with its true "
                   "outcome, whatever the port does",
                   Port, scripted_port, waiting_scripted_port) {
    for (const auto& o : ordeals<Port>()) {
        for (const byte_list& request : {read_one, write_one, write_two}) {
            for (const std::uint32_t start : {0u, 0xFFFF'0000u, 0xFFFE'5000u, 0x7FFF'F000u}) {
                CAPTURE(o.name);
                CAPTURE(start);
                rig<Port> r;
                r.port.most_calls = 8'000'000;
                r.port.clock = [start](std::uint64_t t) { return static_cast<std::uint32_t>(t) + start; };
                r.settle();
                o.prepare(r);
                const std::uint64_t begun = r.port.time;
                std::array<std::uint8_t, 256> room{};
                exchange x{request, room, r.on.timing(), r.limits};
                r.on.run(x, r.gaps);
                const std::size_t response = request == read_one ? 7 : 8;
                CHECK_FALSE(r.port.ran_away);
                CHECK(r.port.time - begun <= r.bound(request, response) + 200);
                CHECK(x.status().outcome() == o.expected);
                CHECK(r.port.frames.size() <= 1);
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G29: a clock that jumps, at any moment and either way, does not keep a call of a line beyond its bound",
    Port, scripted_port, waiting_scripted_port) {
    for (const bool answers : {false, true}) {
        for (std::uint64_t when = 0; when < 220'000; when += 5501) {
            for (const std::int64_t jump :
                 {std::int64_t{1000}, std::int64_t{90'000}, std::int64_t{3'600'000'000},
                  std::int64_t{2'200'000'000}, std::int64_t{-1}, std::int64_t{-1000},
                  std::int64_t{-60'000'000}, std::int64_t{-2'000'000'000}}) {
                CAPTURE(answers);
                CAPTURE(when);
                CAPTURE(jump);
                rig<Port> r;
                r.port.most_calls = 3'000'000;
                const std::uint64_t at = r.port.time + when;
                r.port.clock = [at, jump](std::uint64_t t) {
                    return static_cast<std::uint32_t>(static_cast<std::int64_t>(t) + (t < at ? 0 : jump));
                };
                if (answers) r.port.device = answering(30'000);
                const std::uint64_t begun = r.port.time;
                std::array<std::uint8_t, 256> room{};
                exchange x{write_one, room, r.on.timing(), r.limits};
                r.on.run(x, r.gaps);
                REQUIRE_FALSE(r.port.ran_away);
                REQUIRE(r.port.time - begun <= r.bound(write_one, 8) + 200);
                REQUIRE(r.port.frames.size() <= 1);
                REQUIRE(x.was_sent() == (r.port.frames.size() == 1));
            }
        }
    }
}

TEST_CASE("G29: a clock that stops, at any moment, ends the call of a line") {
    for (const std::uint64_t when : {0u, 100'500u, 130'000u}) { // before, while sending, while waiting
        CAPTURE(when);
        rig<> r;
        r.port.most_calls = 60'000'000;
        const std::uint64_t at = r.port.time + when;
        r.port.clock = [at](std::uint64_t t) { return static_cast<std::uint32_t>(t < at ? t : at); };
        std::array<std::uint8_t, 256> room{};
        exchange x{write_one, room, r.on.timing(), r.limits};
        r.on.run(x, r.gaps);
        CHECK_FALSE(r.port.ran_away);
        CHECK(x.status().error() == errc::clock_stopped);
        CHECK(x.was_sent() == (when != 0));
    }
}

TEST_CASE("G29: a clock that goes back again and again ends the call of a line") {
    rig<> r;
    r.port.most_calls = 3'000'000;
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t % 5000); };
    const std::uint64_t begun = r.port.time;
    std::array<std::uint8_t, 256> room{};
    exchange x{write_one, room, r.on.timing(), r.limits};
    r.on.run(x, r.gaps);
    CHECK_FALSE(r.port.ran_away);
    CHECK(x.status().error() != errc::ok);
    CHECK(r.port.time - begun <= r.bound(write_one, 8) + 200);
}

TEST_CASE("a clock that ticks in milliseconds is good enough for a line in host timing") {
    rig<waiting_scripted_port> r;
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t / 1000 * 1000); };
    r.port.device = answering(700);
    for (int i = 0; i < 20; ++i) {
        const std::uint64_t heard = r.port.last_heard;
        CHECK(r.run(read_one).why.error() == errc::ok);
        if (i > 0) CHECK(r.port.frames.back().begin + 1000 >= heard + 1750);
    }
}

TEST_CASE("G1: a port that reports bytes which it did not write does not bring back the last response") {
    struct lying_port {
        bool lies = false;
        bool has_request = false;
        std::size_t to_come = 0; // of the response
        bool got_old_bytes = false;
        instant clock{};
        transfer send(bytes b) {
            has_request = true;
            return static_cast<std::uint16_t>(b.size());
        }
        bool sent() {
            if (has_request) to_come = 7;
            has_request = false;
            return true;
        }
        transfer receive(byte_buffer to) {
            for (const std::uint8_t byte : to) got_old_bytes = got_old_bytes || byte != 0;
            const auto response = hex("01 03 02 00 2A 39 9B");
            const bytes whole = response;
            const bytes left = whole.subspan(whole.size() - to_come);
            const std::size_t count = left.size() < to.size() ? left.size() : to.size();
            for (std::size_t i = 0; i < count && !lies; ++i) to[i] = left[i];
            to_come -= count;
            return static_cast<std::uint16_t>(count);
        }
        instant now() {
            clock = clock + microseconds(10);
            return clock;
        }
    } port;
    servobus::line on{port, modbus::timing_at(115200)};
    const response_limits limits{};
    const auto ask = [&] {
        std::array<std::uint8_t, 7> response{};
        const auto request = modbus::read_frame(1, 0x2000, 1);
        modbus::exchange x{request, response, on.timing(), limits};
        on.run(x, {});
        return x.status().error();
    };
    CHECK(ask() == errc::ok);
    port.lies = true;
    CHECK(ask() != errc::ok);
    CHECK_FALSE(port.got_old_bytes); // old bytes could be taken for a response
}

} // namespace line_ports_tests
