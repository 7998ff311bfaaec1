// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line over a scripted port: the silences before a request, quarantine after trouble, rubbish on the
// wire, a transport that fails at any call and a clock that cannot be trusted. All times are those of a
// virtual clock.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;
using tests::operator+;
using modbus::exchange;
using modbus::timing_at;
using modbus::timing_mode;

namespace {

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list read_other = framed({0x01, 0x03, 0x20, 0xA5, 0x00, 0x01});
const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
const byte_list write_two = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04, 0x00, 0x64, 0x00, 0x64});
const byte_list one_word = tests::read_response(1, {0x0960});

byte_list good_response(const byte_list& request) {
    return request[1] == 0x03 ? tests::read_response(1, {0x0960}) : tests::acknowledgement(request);
}

/// Answers every request to unit 1 after `delay` us.
auto answering(std::uint32_t delay) {
    return [delay](auto& port, const tests::sent_frame& f) { port.say(delay, good_response(f.data)); };
}

template <class Port = scripted_port> struct rig {
    Port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};
    modbus::rtu_timing timing;
    line<Port> on;

    explicit rig(modbus::rtu_timing t = timing_at(115200), Port p = {})
        : port{std::move(p)}, timing{t}, on{port, t} {
        port.character_us = t.character;
    }

    struct ended {
        failure why;
        bool was_sent;
        byte_list response;
    };
    ended run(const byte_list& request) {
        std::array<std::uint8_t, 256> room{};
        exchange x{request, room, on.timing(), limits};
        on.run(x, gaps);
        REQUIRE_FALSE(port.ran_away);
        REQUIRE(x.done());
        return {x.why(), x.was_sent(), {x.response().begin(), x.response().end()}};
    }
    /// One good exchange, so that the line is not in trouble any more.
    void settle() {
        const auto device = port.device;
        port.device = answering(500);
        REQUIRE(run(read_one).why.code == errc::ok);
        port.device = device;
        port.frames.clear();
    }
    std::uint64_t bound(const byte_list& request, std::size_t response) const {
        return on.bound(request.size(), response, limits, gaps).us;
    }
};

} // namespace

TEST_CASE_TEMPLATE("a healthy line: read, write, and what was sent", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.port.device = answering(800);
    for (const byte_list& request : {read_one, write_one, write_two}) {
        const auto e = r.run(request);
        CHECK(e.why == failure{});
        CHECK(e.was_sent);
        CHECK(e.response == good_response(request));
        CHECK(r.port.frames.back().data == request);
    }
    CHECK(r.port.frames.size() == 3);
    CHECK(r.on.observer().requests == 3);
    CHECK(r.on.observer().responses == 3);
    CHECK(r.on.observer().unexpected_bytes == 0);
}

TEST_CASE_TEMPLATE("G1: nothing is sent before the line has been silent once", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    const std::uint64_t begun = r.port.time;
    r.port.device = answering(500);
    CHECK(r.run(read_one).why.code == errc::ok);
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
            CHECK((e.why.code == errc::ok) == (i == 7));
            const std::uint64_t over = r.port.time;
            const std::uint64_t heard = r.port.last_arrival();
            r.port.device = answering(500);
            CHECK(r.run(read_one).why.code == errc::ok);
            const std::uint64_t silence =
                longer_of(microseconds(quarantine), r.timing.visible_silence()).us; // host timing: G7
            CHECK(r.port.frames[1].begin >= (i == 7 ? heard : over) + silence - 10);
            CHECK(r.port.frames[1].begin >= heard + silence);
        }
    }
}

TEST_CASE_TEMPLATE("G1: a second response in the same burst is trouble like one that comes by itself", Port,
                   scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = [](auto& port, const tests::sent_frame& f) {
        for (const std::uint8_t b : one_word + one_word) port.arrive(f.end + 2000, b);
    };
    CHECK(r.run(read_one).why.code == errc::ok);
    CHECK(r.on.observer().unexpected_bytes == one_word.size());
    r.port.device = answering(500);
    CHECK(r.run(read_one).why.code == errc::ok);
    CHECK(r.port.frames[1].begin >= r.port.frames[0].end + 2000 + 100'000);
}

TEST_CASE_TEMPLATE(
    "G1: up to four bytes of 00 or FF between frames are the driver switching, more are trouble", Port,
    scripted_port, waiting_scripted_port) {
    for (const std::uint8_t value : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x01}) {
        for (std::size_t n = 0; n <= 6; ++n) {
            CAPTURE(value);
            CAPTURE(n);
            rig<Port> r;
            r.settle();
            r.port.device = answering(500);
            const std::uint64_t end = r.port.time + n * 96;
            r.port.say_at(r.port.time, byte_list(n, value));
            CHECK(r.run(read_one).why.code == errc::ok);
            const bool is_trouble = value == 0x01 ? n > 0 : n > 4;
            CHECK((r.port.frames[0].begin >= end + 100'000) == is_trouble);
            CHECK(r.on.observer().unexpected_bytes == n);
        }
    }
}

TEST_CASE_TEMPLATE("G1: the driver may switch before every request without ever adding up to trouble", Port,
                   scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    for (int i = 0; i < 10; ++i) {
        r.port.say_at(r.port.time, {0x00, 0xFF, 0x00});
        const std::uint64_t heard = r.port.last_arrival();
        CHECK(r.run(read_one).why.code == errc::ok);
        CHECK(r.port.frames.back().begin <= heard + 1750 + 40);
    }
}

TEST_CASE_TEMPLATE("a port that learns late that all has left, as behind USB, is waited for", Port,
                   scripted_port, waiting_scripted_port) {
    for (const std::uint32_t late : {100u, 5000u, 18'000u}) {
        rig<Port> r;
        r.port.says_sent_late = late;
        r.port.device = answering(30'000);
        CHECK(r.run(write_one).why.code == errc::ok);
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
        CHECK(r.run(write_one).why == failure{errc::exception, 2});
        if (i > 0) {
            const std::uint64_t response_end = r.port.frames[r.port.frames.size() - 2].end + 500 + 5 * 96;
            CHECK(r.port.frames.back().begin >= response_end + 1750);
            CHECK(r.port.frames.back().begin <= response_end + 1750 + 40);
        }
    }
}

TEST_CASE_TEMPLATE("an urgent request waits for t3.5 and not for the quarantine", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    CHECK(r.run(read_one).why.code == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.gaps.is_urgent = true;
    r.port.device = answering(500);
    CHECK(r.run(write_one).why.code == errc::ok);
    CHECK(r.port.frames[1].begin >= over + 1750 - 10);
    CHECK(r.port.frames[1].begin <= over + 1750 + 100);
    // The quarantine is not forgiven: what is not urgent still waits for it.
    r.gaps.is_urgent = false;
    const std::uint64_t heard = r.port.last_heard;
    CHECK(r.run(read_one).why.code == errc::ok);
    CHECK(r.port.frames[2].begin >= heard + 100'000);
}

TEST_CASE_TEMPLATE("G1: a response to an older request that comes while ours still leaves is not ours", Port,
                   scripted_port, waiting_scripted_port) {
    // Up to two characters before the last bit has left: the line looks at the port once a character at most.
    const byte_list stale = tests::read_response(1, {0xDEAD});
    for (std::uint64_t before = 2 * 96; before < 16 * 96; before += 7) {
        CAPTURE(before);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) { port.say_at(f.end - before, stale); };
        const auto e = r.run(read_one);
        CHECK(e.why.code != errc::ok);
    }
}

TEST_CASE_TEMPLATE("G2: a doubled response that begins before the next request has left is never that one's",
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
        CHECK((e.why.code != errc::ok || e.response == one_word));
        CHECK(r.on.observer().unexpected_bytes <= 7);
    }
}

TEST_CASE_TEMPLATE("G2: a response that begins within the quarantine after a time-out is dropped and counted",
                   Port, scripted_port, waiting_scripted_port) {
    const byte_list stale = tests::read_response(1, {0xDEAD});
    for (std::uint32_t late = 200; late < 99'800; late += 3319) {
        CAPTURE(late);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            port.say(f.data == read_one ? 100'000 + late : 500, f.data == read_one ? stale : one_word);
        };
        CHECK(r.run(read_one).why.code == errc::timeout);
        const auto e = r.run(read_other);
        CHECK(e.why.code == errc::ok); // it costs a second silence, not the exchange
        CHECK(e.response == (e.why.code == errc::ok ? one_word : byte_list{}));
        CHECK(r.on.observer().unexpected_bytes == stale.size());
    }
}

TEST_CASE_TEMPLATE(
    "G8: a request follows the response before it after t3.5, or the node's gap, and little more", Port,
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
                    REQUIRE(r.run(i % 3 == 0 ? write_one : read_one).why.code == errc::ok);
                    REQUIRE(r.port.frames.back().begin >= heard + needed);
                    REQUIRE(r.port.frames.back().begin <= heard + needed + cycle / 100 + 12);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE("G8: no byte was heard within t3.5 before a request, however slow the port is", Port,
                   scripted_port, waiting_scripted_port) {
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

TEST_CASE_TEMPLATE("G9: whatever came before, 0..4096 bytes of anything, the next exchange succeeds", Port,
                   scripted_port, waiting_scripted_port) {
    tests::dice random{9};
    for (const std::size_t n :
         {0u, 1u, 2u, 5u, 8u, 31u, 32u, 33u, 64u, 255u, 256u, 257u, 1000u, 4095u, 4096u}) {
        for (int kind = 0; kind < 5; ++kind) {
            CAPTURE(n);
            CAPTURE(kind);
            byte_list junk;
            while (junk.size() < n) {
                if (kind == 0) junk.push_back(0x00);
                if (kind == 1) junk.push_back(0xFF);
                if (kind == 2) junk.push_back(random.byte());
                if (kind == 3) junk = junk + tests::read_response(1, {0xDEAD});
                if (kind == 4) junk = junk + read_one;
            }
            junk.resize(n);
            for (const bool is_settled : {false, true}) {
                for (const bool is_old : {false, true}) {
                    rig<Port> r;
                    if (is_settled) r.settle();
                    r.port.device = answering(500);
                    for (const std::uint8_t b : junk) r.port.arrive(r.port.time, b);
                    if (is_old) r.port.time += 1750;
                    const auto e = r.run(read_one);
                    REQUIRE(e.why.code == errc::ok);
                    REQUIRE(e.response == one_word);
                    if (!is_settled || n > 0) REQUIRE(r.port.frames[0].begin >= 1750);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G9: rubbish of 4096 bytes at the line's own speed makes busy at most, and then all is well", Port,
    scripted_port, waiting_scripted_port) {
    tests::dice random{10};
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    byte_list junk(4096);
    for (auto& b : junk) b = random.byte();
    r.port.say_at(r.port.time, junk);
    const auto e = r.run(write_one);
    CHECK(e.why.code == errc::line_busy);
    CHECK_FALSE(e.was_sent);
    CHECK(r.port.frames.empty());
    r.port.time = r.port.last_arrival() + 1750;
    CHECK(r.run(write_one).why.code == errc::ok);
}

TEST_CASE_TEMPLATE("G6: trailing bytes, many 00 too, do not disturb the next exchange", Port, scripted_port,
                   waiting_scripted_port) {
    tests::dice random{6};
    for (const std::size_t n : {1u, 4u, 5u, 40u, 300u}) {
        for (int kind = 0; kind < 3; ++kind) {
            CAPTURE(n);
            CAPTURE(kind);
            byte_list tail(n, kind == 0 ? std::uint8_t{0} : std::uint8_t{0xFF});
            if (kind == 2) {
                for (auto& b : tail) b = random.byte();
            }
            rig<Port> r;
            r.settle();
            bool is_first = true;
            r.port.device = [&](auto& port, const tests::sent_frame& f) {
                port.say(500, is_first ? good_response(f.data) + tail : good_response(f.data));
                is_first = false;
            };
            CHECK(r.run(read_one).response == one_word);
            const auto e = r.run(read_one);
            CHECK(e.why.code == errc::ok);
            CHECK(e.response == one_word);
        }
    }
}

TEST_CASE_TEMPLATE("G11: foreign frames before a request and inside its wait neither complete nor abort it",
                   Port, scripted_port, waiting_scripted_port) {
    const byte_list foreign = tests::read_response(2, {0x1111, 0x2222});
    byte_list broken = foreign;
    broken[4] ^= 1;
    for (const byte_list& f :
         {foreign, broken, tests::exception_response(3, 6, 1), framed({9, 6, 0x20, 0x88, 0, 0x64})}) {
        for (const std::uint32_t at : {100u, 3000u, 20'000u}) {
            rig<Port> r;
            r.settle();
            r.port.say_at(r.port.time, f); // before
            r.port.device = [&](auto& port, const tests::sent_frame& q) {
                port.say(at, f);
                port.say(at + 30'000, good_response(q.data));
            };
            const auto e = r.run(write_one);
            CHECK(e.why.code == errc::ok);
            CHECK(r.port.frames.size() == 1);
            r.port.device = [&](auto& port, const tests::sent_frame&) { port.say(at, f); };
            const std::uint64_t expected_end = 100'000;
            const auto alone = r.run(write_one);
            CHECK(alone.why.code == errc::timeout);
            CHECK(r.port.time >= r.port.frames[1].end + expected_end);
            CHECK(r.port.time <= r.port.frames[1].end + expected_end + 100);
        }
    }
}

TEST_CASE_TEMPLATE("a character that came garbled before the request spoils nothing", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    const std::uint64_t garbled_until = r.port.time + 30'000;
    r.port.noisy_until = garbled_until;
    const auto e = r.run(write_one);
    CHECK(e.why.code == errc::ok);
    CHECK(r.port.frames.size() == 1);
    // Somebody may have talked: quarantine. A port that sleeps looks every 5 ms.
    CHECK(r.port.frames[0].begin >= garbled_until + 100'000 - 6000);
}

TEST_CASE_TEMPLATE("a receiver that fails for ever makes busy, within the bound", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.noisy_until = ~std::uint64_t{0};
    const std::uint64_t begun = r.port.time;
    const auto e = r.run(read_one);
    CHECK(e.why.code == errc::line_busy);
    CHECK_FALSE(e.was_sent);
    CHECK(r.port.time - begun <= r.bound(read_one, 7));
}

TEST_CASE_TEMPLATE(
    "G2: a late response within its node's quarantine is dropped, whoever was asked in between", Port,
    scripted_port, waiting_scripted_port) {
    const byte_list stale = tests::read_response(1, {0xDEAD});
    const byte_list read_two = framed({0x02, 0x03, 0x20, 0xA1, 0x00, 0x01});
    for (std::uint32_t late = 22'000; late < 30'000; late += 97) {
        CAPTURE(late);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            if (f.data == read_one) port.say(100'000 + late, stale);
            if (f.data == read_two) port.say(500, tests::read_response(2, {7}));
        };
        CHECK(r.run(read_one).why.code == errc::timeout);
        r.gaps.quarantine = milliseconds(20); // the other node's
        (void)r.run(read_two);
        r.gaps.quarantine = milliseconds(100);
        CHECK(r.run(read_other).why.code != errc::ok);
    }
}

TEST_CASE_TEMPLATE("our own echo is dropped while the request leaves, and is no response", Port,
                   scripted_port, waiting_scripted_port) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        rig<Port> r;
        r.port.echoes = true;
        r.settle();
        CHECK(r.run(request).why.code == errc::timeout);
        r.port.device = answering(500);
        CHECK(r.run(request).why.code == errc::ok);
    }
}

TEST_CASE_TEMPLATE("G7: in host timing a response in bursts of any size, 16 ms apart, is one response", Port,
                   scripted_port, waiting_scripted_port) {
    for (std::size_t size = 1; size <= 7; ++size) {
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            std::uint64_t at = f.end + 1000;
            for (std::size_t i = 0; i < one_word.size(); ++i) {
                if (i % size == 0) at += 16'000;
                port.arrive(at, one_word[i]);
            }
        };
        const auto e = r.run(read_one);
        CHECK(e.why.code == errc::ok);
        CHECK(e.response == one_word);
    }
}

TEST_CASE_TEMPLATE("G7: in strict timing the line rejects a response with a gap above t1.5", Port,
                   scripted_port, waiting_scripted_port) {
    for (std::size_t cut = 1; cut < one_word.size(); ++cut) {
        for (const std::uint32_t gap : {0u, 1000u, 1600u, 1900u, 4000u, 50'000u}) {
            CAPTURE(cut);
            CAPTURE(gap);
            rig<Port> r{timing_at(9600, timing_mode::strict)};
            r.settle();
            const auto middle = one_word.begin() + static_cast<std::ptrdiff_t>(cut);
            r.port.device = [&](auto& port, const tests::sent_frame& f) {
                port.say(5000, byte_list(one_word.begin(), middle));
                const auto first = static_cast<std::uint32_t>(cut) * r.timing.character;
                port.say_at(f.end + 5000 + first + gap, byte_list(middle, one_word.end()));
            };
            const auto e = r.run(read_one);
            CHECK(e.why.code == (gap <= r.timing.t1_5 ? errc::ok : errc::bad_gap));
        }
    }
}

TEST_CASE("a superloop that takes a step a turn gets the same, whatever its turn takes") {
    for (const std::uint32_t turn : {1u, 50u, 300u, 1000u, 7000u, 15'000u}) {
        CAPTURE(turn);
        rig<> r;
        r.port.device = answering(900);
        for (int i = 0; i < 10; ++i) {
            std::array<std::uint8_t, 256> room{};
            const byte_list& request = i % 2 == 0 ? read_one : write_one;
            exchange x{request, room, r.on.timing(), r.limits};
            for (int n = 0; n < 1'000'000 && !x.done(); ++n) {
                r.on.step(x, r.gaps);
                r.port.time += turn;
            }
            REQUIRE(x.done());
            REQUIRE(x.why().code == errc::ok);
            REQUIRE(same_bytes(x.response(), good_response(request)));
        }
        CHECK(r.port.frames.size() == 10);
    }
}

TEST_CASE_TEMPLATE(
    "an exchange that was abandoned leaves the line in quarantine, and its late response is dropped", Port,
    scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(5000);
    std::array<std::uint8_t, 256> room{};
    exchange x{write_one, room, r.on.timing(), r.limits};
    while (x.state() != exchange::phase::awaiting) r.on.step(x, r.gaps);
    r.on.abandon(x);
    CHECK(x.done());
    CHECK(x.was_sent());
    CHECK(r.run(read_one).response == one_word);
    CHECK(r.port.frames[1].begin >= r.port.frames[0].end + 5000 + 8 * 96 + 100'000);
    CHECK(r.on.observer().unexpected_bytes == 8);
}

TEST_CASE_TEMPLATE("one exchange at a time: another one waits for its turn, or is busy if it cannot wait",
                   Port, scripted_port, waiting_scripted_port) {
    for (const bool has_left : {false, true}) {
        rig<Port> r;
        r.settle();
        r.port.device = answering(5000);
        std::array<std::uint8_t, 256> room{};
        std::array<std::uint8_t, 256> other_room{};
        exchange x{write_one, room, r.on.timing(), r.limits};
        r.on.step(x, r.gaps);
        while (has_left && x.state() != exchange::phase::awaiting) r.on.step(x, r.gaps);
        exchange other{write_two, other_room, r.on.timing(), r.limits};
        CHECK(r.on.step(other, r.gaps) > duration{});
        CHECK(other.state() == exchange::phase::ready);
        CHECK_FALSE(r.on.is_free());
        CHECK(r.run(read_one).why.code == errc::busy); // blocking: nobody would move the other one on
        std::array<std::uint8_t, 256> third_room{};
        exchange third{read_one, third_room, r.on.timing(), r.limits};
        r.on.abandon(third); // not the one that is under way
        CHECK(third.why().code == errc::busy);
        CHECK_FALSE(third.was_sent());
        while (!x.done()) {
            r.on.step(other, r.gaps);
            r.on.step(x, r.gaps);
        }
        CHECK(x.why().code == errc::ok);
        REQUIRE(r.port.frames.size() == 1);
        CHECK(r.port.frames[0].data == write_one);
        while (!other.done()) r.on.step(other, r.gaps);
        CHECK(other.why().code == errc::ok);
        CHECK(r.port.frames[1].data == write_two);
    }
}

TEST_CASE_TEMPLATE("G25: a stop is the next frame after the one in flight, whoever else waits", Port,
                   scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(5000);
    bus_gaps at_once = r.gaps;
    at_once.is_urgent = true;
    std::array<std::array<std::uint8_t, 256>, 4> room{};
    exchange first{read_one, room[0], r.on.timing(), r.limits};
    exchange waiting{read_other, room[1], r.on.timing(), r.limits};
    exchange stop{write_one, room[2], r.on.timing(), r.limits};
    exchange later{read_other, room[3], r.on.timing(), r.limits};

    SUBCASE("in flight") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        while (!stop.done()) {
            r.on.step(waiting, r.gaps);
            r.on.step(stop, at_once);
            r.on.step(later, r.gaps);
            r.on.step(first, r.gaps);
        }
        CHECK(first.why().code == errc::ok);
        REQUIRE(r.port.frames.size() == 2);
        CHECK(r.port.frames[1].data == write_one);
    }
    SUBCASE("one that still waits for its silence, here the quarantine, lets the stop go first") {
        r.port.device = nullptr;
        CHECK(r.run(read_one).why.code == errc::timeout);
        r.port.device = answering(500);
        r.port.frames.clear();
        const std::uint64_t asked = r.port.time;
        r.on.step(first, r.gaps);
        CHECK_FALSE(r.on.is_free());
        while (!stop.done()) r.on.step(stop, at_once);
        CHECK(stop.why().code == errc::ok);
        CHECK(r.port.frames[0].data == write_one);
        CHECK(r.port.frames[0].begin < asked + r.timing.t3_5 + 100);
        while (!first.done()) r.on.step(first, r.gaps);
        CHECK(first.why().code == errc::ok);
    }
    SUBCASE("a stop that is given up, or forgotten, holds nobody up for ever") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        r.on.step(stop, at_once);
        bool is_given_up = false;
        SUBCASE("given up") { is_given_up = true; }
        SUBCASE("forgotten") {}
        if (is_given_up) r.on.abandon(stop);
        while (!first.done()) r.on.step(first, r.gaps);
        r.port.time += is_given_up ? 0 : 600'000;
        while (!later.done()) r.on.step(later, r.gaps);
        CHECK(later.why().code == errc::ok);
        CHECK(r.port.frames.size() == 2);
    }
    SUBCASE("two stops go in the order in which they came") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        exchange second_stop{write_two, room[1], r.on.timing(), r.limits};
        r.on.step(stop, at_once);
        r.on.step(second_stop, at_once);
        while (!second_stop.done()) {
            r.on.step(second_stop, at_once);
            r.on.step(first, r.gaps);
            r.on.step(stop, at_once);
        }
        REQUIRE(r.port.frames.size() == 3);
        CHECK(r.port.frames[1].data == write_one);
        CHECK(r.port.frames[2].data == write_two);
    }
}

TEST_CASE_TEMPLATE("an exchange whose owner forgot it holds the line for a while and not for ever", Port,
                   scripted_port, waiting_scripted_port) {
    for (const bool has_left : {false, true}) {
        CAPTURE(has_left);
        rig<Port> r;
        r.settle();
        const std::uint64_t begun = r.port.time;
        std::array<std::uint8_t, 256> room{};
        exchange forgotten{write_one, room, r.on.timing(), r.limits};
        r.on.step(forgotten, r.gaps);
        while (has_left && forgotten.state() != exchange::phase::awaiting) r.on.step(forgotten, r.gaps);
        r.port.device = answering(5000);
        CHECK(r.run(read_one).why.code == errc::busy);
        r.port.time = begun + 2 * r.bound(write_one, 8);
        const std::uint64_t free_at = r.port.time;
        CHECK(r.run(read_one).why.code == errc::ok);
        CHECK(r.port.frames.back().begin >= free_at + 100'000 - 10); // whatever became of it: quarantine
        // Its owner comes back, while another exchange is under way.
        std::array<std::uint8_t, 256> other_room{};
        exchange other{read_one, other_room, r.on.timing(), r.limits};
        while (other.state() != exchange::phase::awaiting) r.on.step(other, r.gaps);
        r.on.abandon(forgotten);
        CHECK(forgotten.done());
        r.on.run(other, r.gaps);
        CHECK(other.why().code == errc::ok);
    }
}

TEST_CASE_TEMPLATE("G8: the silence is kept in full when the clock jumps back before a request", Port,
                   scripted_port, waiting_scripted_port) {
    for (const std::uint32_t jump : {1u, 5000u, 1'000'000u, 2'000'000'000u}) {
        for (const bool is_troubled : {false, true}) {
            CAPTURE(jump);
            CAPTURE(is_troubled);
            rig<Port> r;
            r.port.time = 3'000'000'000;
            r.settle();
            if (is_troubled) CHECK(r.run(read_one).why.code == errc::timeout);
            const std::uint64_t at = r.port.time;
            r.port.clock = [at, jump](std::uint64_t t) {
                return static_cast<std::uint32_t>(t < at ? t : t - jump);
            };
            r.port.device = answering(500);
            CHECK(r.run(read_one).why.code == errc::ok);
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
    CHECK(e.why.code == errc::ok);
    CHECK(e.was_sent);
    CHECK(r.port.frames.size() == 1);
    CHECK(r.port.time >= r.port.frames[0].end + 25'000);
    CHECK(r.port.time <= r.port.frames[0].end + 25'000 + 60);
    const auto read = r.run(framed({0, 3, 0x20, 0x0E, 0, 1}));
    CHECK(read.why.code == errc::bad_argument);
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("an observer sees each request once and each end once") {
    struct trace {
        int requests = 0;
        int responses = 0;
        std::size_t strays = 0;
        void on_request(bytes) { ++requests; }
        void on_response(bytes, failure) { ++responses; }
        void on_unexpected(bytes b) { strays += b.size(); }
    };
    for (const std::uint64_t busy : {0u, 200u, 20'000u}) {
        CAPTURE(busy);
        scripted_port port;
        port.device = answering(500);
        port.takes_nothing_until = 101'000 + busy; // the port is not ready at once
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

// A transport that fails.

namespace {
template <class Port> rig<Port> brisk() {
    rig<Port> r;
    r.port.call_us = 20;
    r.gaps.quarantine = milliseconds(2);
    r.limits.response = milliseconds(3);
    r.port.device = answering(400);
    return r;
}
} // namespace

TEST_CASE_TEMPLATE(
    "G15, G16: whichever call of the port fails, a write is on the wire once at most and ends as what it is",
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
                CHECK(healthy.run(request).why.code == errc::ok);
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
                    const written w{e.why, e.was_sent};
                    REQUIRE(r.port.frames.size() <= 1);
                    REQUIRE(r.port.bytes_sent() <= request.size());
                    REQUIRE(e.was_sent == (r.port.bytes_sent() != 0));
                    if (!r.port.has_failed) continue;         // call n was `sent`, which cannot fail
                    if (!is_lost && e.why.code == errc::ok) { // garbled before the request, or its echo
                        REQUIRE(r.port.frames.size() == 1);
                        continue;
                    }
                    REQUIRE(e.why.code != errc::ok);
                    REQUIRE(w.outcome() == (e.was_sent ? outcome::unknown : outcome::not_sent));
                    ++(e.was_sent ? unknown : not_sent);
                    r.port.lost_from_call = 0; // it comes back
                    REQUIRE(r.run(request).why.code == errc::ok);
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
                CHECK(r.run(request).why.code == errc::ok);
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
            CHECK(e.why.code == errc::ok);
            CHECK(e.response == good_response(request));
        }
        rig<Port> r;
        r.port.device = answering(900);
        r.port.lies_about_counts = true;
        CHECK(r.run(request).why.code == errc::ok);
        for (int i = 0; i < 100; ++i) r.port.arrive(r.port.time, 0x33);
        CHECK(r.run(request).why.code == errc::ok);
        const byte_list long_response = tests::read_response(1, std::vector<std::uint16_t>(60, 0x1234));
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            for (const std::uint8_t b : long_response) port.arrive(f.end + 2000, b);
        };
        CHECK(r.run(framed({1, 3, 0x20, 0, 0, 60})).response == long_response);
    }
}

namespace {

// What may go wrong for the whole of a call, each with the outcome that it must have.
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
        {"silence", [](r&) {}, outcome::unknown},
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
        {"rubbish without end before it",
         [](r& x) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 500) x.port.arrive(x.port.time + t, 0x55);
         },
         outcome::not_sent},
        {"rubbish without end after it", device_of([](p& port, const q& f) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 96)
                 port.arrive(f.end + t + 500, static_cast<std::uint8_t>(t));
         }),
         outcome::unknown},
        {"zeros without end after it", device_of([](p& port, const q& f) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 96) port.arrive(f.end + t + 500, 0);
         }),
         outcome::unknown},
        {"foreign frames without end after it", device_of([](p& port, const q&) {
             for (std::uint64_t t = 0; t < 1'000'000; t += 2000)
                 port.say(500 + t, tests::read_response(2, {1}));
         }),
         outcome::unknown},
        {"a response that dribbles", device_of([](p& port, const q& f) {
             std::uint64_t t = f.end + 79'000;
             for (const std::uint8_t b : good_response(f.data)) port.arrive(t += 19'900, b);
         }),
         outcome::done},
        {"a response that dribbles and stops", device_of([](p& port, const q& f) {
             std::uint64_t t = f.end + 79'000;
             byte_list response = good_response(f.data);
             response.pop_back();
             for (const std::uint8_t b : response) port.arrive(t += 19'900, b);
         }),
         outcome::unknown},
    };
}

} // namespace

TEST_CASE_TEMPLATE(
    "G16, G29: every call returns within its bound, and every write as what it is, whatever the port does",
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
                CHECK(written{x.why(), x.was_sent()}.outcome() == o.expected);
                CHECK(r.port.frames.size() <= 1);
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G29: a clock that jumps, at any moment and either way, does not keep a call beyond its bound", Port,
    scripted_port, waiting_scripted_port) {
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

TEST_CASE("G29: a clock that stands still, from any moment on, ends the call") {
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
        CHECK(x.why().code == errc::clock_stopped);
        CHECK(x.was_sent() == (when != 0));
    }
}

TEST_CASE("G29: a clock that goes back again and again ends the call") {
    rig<> r;
    r.port.most_calls = 3'000'000;
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t % 5000); };
    const std::uint64_t begun = r.port.time;
    std::array<std::uint8_t, 256> room{};
    exchange x{write_one, room, r.on.timing(), r.limits};
    r.on.run(x, r.gaps);
    CHECK_FALSE(r.port.ran_away);
    CHECK(x.why().code != errc::ok);
    CHECK(r.port.time - begun <= r.bound(write_one, 8) + 200);
}

TEST_CASE("a clock that ticks in milliseconds will do in host timing") {
    rig<waiting_scripted_port> r;
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t / 1000 * 1000); };
    r.port.device = answering(700);
    for (int i = 0; i < 20; ++i) {
        const std::uint64_t heard = r.port.last_heard;
        CHECK(r.run(read_one).why.code == errc::ok);
        if (i > 0) CHECK(r.port.frames.back().begin + 1000 >= heard + 1750);
    }
}

TEST_CASE("G1: a port that claims bytes which it did not write does not bring back the last response") {
    struct lying_port {
        bool lies = false;
        bool has_request = false;
        bool has_response = false;
        bool got_old_bytes = false;
        instant clock{};
        transfer send(bytes b) {
            has_request = true;
            return static_cast<std::uint16_t>(b.size());
        }
        bool sent() {
            has_response = has_request;
            has_request = false;
            return true;
        }
        transfer receive(byte_buffer to) {
            if (!has_response) return std::uint16_t{0};
            has_response = false;
            for (const std::uint8_t byte : to) got_old_bytes = got_old_bytes || byte != 0;
            const auto response = hex("01 03 02 00 2A 39 9B");
            const bytes frame = response;
            for (std::size_t i = 0; i < frame.size() && !lies; ++i) to[i] = frame[i];
            return static_cast<std::uint16_t>(frame.size());
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
        return x.why().code;
    };
    CHECK(ask() == errc::ok);
    port.lies = true;
    CHECK(ask() != errc::ok);
    CHECK_FALSE(port.got_old_bytes); // whatever lay there could be taken for a response
}
