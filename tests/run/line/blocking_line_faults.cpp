// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The blocking line when everything fails: ports that report wrong counts, clocks that jump or stop, and the
// same scripts of faults for it and for `line`.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>

namespace blocking_line_faults_tests {

using namespace tests;
using namespace tests::blocking;
using namespace servobus;

TEST_CASE_TEMPLATE("G15, G16: whichever call of the port fails, a blocking line sends a write at most once "
                   "and reports its true outcome",
                   S, setup<scripted_port, timing_at(115200), milliseconds(2)>,
                   setup<waiting_scripted_port, timing_at(115200), milliseconds(2)>) {
    for (const byte_list& q : {read_one, write_one, write_two}) {
        for (const std::size_t most : {std::size_t{1000}, std::size_t{3}, std::size_t{1}}) {
            unsigned not_sent = 0;
            unsigned unknown = 0;
            std::uint64_t calls = ~std::uint64_t{0};
            for (std::uint64_t n = 0; n <= calls; ++n) {
                if (n > 40 && n + 150 < calls && n % 13 != 0) continue; // waiting for the gap
                for (const bool is_lost : {false, true}) {
                    CAPTURE(n);
                    CAPTURE(is_lost);
                    rig<S> r;
                    r.limits.response = milliseconds(2);
                    REQUIRE(r.ask(read_one) == errc::timeout); // in quarantine: the longest way
                    r.port.frames.clear();
                    r.port.device = answering(400);
                    r.port.call_us = 20;
                    r.port.takes_at_most = most;
                    const std::uint64_t before = r.port.calls;
                    if (n != 0) (is_lost ? r.port.lost_from_call : r.port.fails_at_call) = before + n;
                    const auto e = r.run_in_time(q);
                    if (n == 0) calls = r.port.calls - before;
                    const status w = e.why;
                    if (w || !r.port.has_failed) { // no failure, `sent`, or garbled before the request or in
                                                   // its echo
                        REQUIRE(w);
                        REQUIRE((!is_lost || n == 0 || !r.port.has_failed));
                        continue;
                    }
                    REQUIRE(w.outcome() == (e.was_sent ? outcome::unknown : outcome::not_sent));
                    REQUIRE_FALSE(r.on.is_echo_ruled_out()); // after an exchange without a valid response
                    ++(e.was_sent ? unknown : not_sent);
                    r.port.lost_from_call = 0; // the port returns
                    REQUIRE(r.ask(q) == errc::ok);
                }
            }
            CHECK(not_sent > 0);
            CHECK(unknown > 0);
        }
    }
}

TEST_CASE_TEMPLATE("G15, G16: short writes, empty reads and a port that miscounts change nothing", S, polls,
                   sleeps) {
    for (const byte_list& q : {read_one, write_one, write_two}) {
        for (const std::size_t takes : {1u, 2u, 5u, 7u, 1000u}) {
            for (int kind = 0; kind < 4; ++kind) {
                rig<S> r{answering(900)};
                r.port.takes_at_most = takes;
                r.port.takes_only_when_idle = kind == 1;
                r.port.empty_reads = kind == 2 ? 7 : 0;
                r.port.lies_about_counts = kind == 3 && takes == 1000;
                r.port.says_sent_late = kind == 0 ? 800 : 0;
                const auto e = r.run_in_time(q);
                CHECK(e.why.error() == errc::ok);
                CHECK(e.response == good_response(q));
                CHECK(r.last() == q);
            }
        }
    }
}

namespace {

// What may fail for the whole of a call, with the outcome that a write must have.
struct ordeal {
    std::string name;
    std::function<void(scripted_port&)> prepare;
    outcome expected;
};
std::function<void(scripted_port&)> responding(device_script d) {
    return [d](scripted_port& p) { p.device = d; };
}
std::function<void(scripted_port&)> dribbling(std::size_t drop) {
    return responding([drop](scripted_port& p, const sent_frame& f) {
        std::uint64_t t = f.end + 79'000;
        const byte_list response = good_response(f.data);
        for (std::size_t i = 0; i + drop < response.size(); ++i) p.arrive(t += 19'900, response[i]);
    });
}
std::function<void(scripted_port&)> babbling(std::uint8_t step, std::uint64_t after) {
    return responding([=](scripted_port& p, const sent_frame& f) {
        for (std::uint64_t t = after; t < 2'000'000; t += 96)
            p.arrive(f.end + t, static_cast<std::uint8_t>(t * step));
    });
}
const std::vector<ordeal> ordeals{
    {"no response", [](scripted_port&) {}, outcome::unknown},
    {"takes nothing, ever", [](scripted_port& p) { p.takes_nothing_until = ~std::uint64_t{0}; },
     outcome::not_sent},
    {"takes nothing for a while",
     [](scripted_port& p) {
         p.takes_nothing_until = p.time + 10'000;
         p.device = answering(500);
     },
     outcome::done},
    {"takes one byte and no more",
     [](scripted_port& p) {
         p.takes_at_most = 1;
         p.device = nullptr;
         p.never_sent = true;
     },
     outcome::unknown},
    {"never sent", [](scripted_port& p) { p.never_sent = true; }, outcome::unknown},
    {"endless garbled characters", [](scripted_port& p) { p.noisy_until = ~std::uint64_t{0}; },
     outcome::not_sent},
    {"endless noise before it",
     [](scripted_port& p) {
         for (std::uint64_t t = 0; t < 1'000'000; t += 500) p.arrive(p.time + t, 0x55);
     },
     outcome::not_sent},
    {"endless noise after it", babbling(1, 500), outcome::unknown},
    {"endless noise from the timeout on", babbling(3, 99'900), outcome::unknown},
    {"endless zeros after it", babbling(0, 500), outcome::unknown},
    {"endless frames of another node after it", responding([](scripted_port& p, const sent_frame&) {
         for (std::uint64_t t = 0; t < 1'000'000; t += 2000) p.say(500 + t, tests::read_response(2, {1}));
     }),
     outcome::unknown},
    {"a response byte by byte", dribbling(0), outcome::done},
    {"a response byte by byte that stops", dribbling(1), outcome::unknown},
};

} // namespace

TEST_CASE_TEMPLATE("G16, G29: every call of a blocking line returns within its bound, every write with its "
                   "true outcome, whatever the port does",
                   S, polls, sleeps, polls_strict, sleeps_strict, sleeps_slow) {
    for (const ordeal& o : ordeals) {
        for (const byte_list& q : {read_one, write_one, write_two}) {
            for (const std::uint32_t start : {0u, 0xFFFF'0000u, 0xFFFE'5000u, 0x7FFF'F000u}) {
                for (const std::uint32_t cost : {1u, 60u}) { // 60: a call takes longer than a character
                    CAPTURE(o.name);
                    CAPTURE(start);
                    CAPTURE(cost);
                    rig<S> r;
                    r.port.time = 0xFFFF'FFFFull + 1 + (r.port.time & 0xFFFF'FFFFull);
                    r.port.clock = [start](std::uint64_t t) { return static_cast<std::uint32_t>(t) + start; };
                    r.settle();
                    o.prepare(r.port);
                    r.port.call_us = cost;
                    const auto e = r.run_in_time(q);
                    if (cost == 1 && S::timing.character == 96) CHECK(e.why.outcome() == o.expected);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G29: a clock that jumps, at any moment and either way, does not keep a blocking line beyond its bound",
    S, polls, sleeps) {
    for (const std::uint32_t delay : {0u, 30'000u}) {
        for (std::uint64_t when = 0; when < 220'000; when += 17'011) {
            for (const std::int64_t jump : {1000ll, 90'000ll, 3'600'000'000ll, 2'200'000'000ll, -1ll, -1000ll,
                                            -60'000'000ll, -2'000'000'000ll}) {
                CAPTURE(when);
                CAPTURE(jump);
                rig<S> r;
                CHECK(r.ask(read_one) == errc::timeout);
                r.port.frames.clear();
                if (delay != 0) r.port.device = answering(delay);
                const std::uint64_t at = r.port.time + when;
                r.port.clock = [at, jump](std::uint64_t t) {
                    return static_cast<std::uint32_t>(static_cast<std::int64_t>(t) + (t < at ? 0 : jump));
                };
                (void)r.run_in_time(write_one);
            }
        }
    }
}

TEST_CASE_TEMPLATE("G29: a clock that stops, at any moment, ends the call of a blocking line", S, polls,
                   sleeps) {
    for (const std::uint32_t when : {0u, 1000u, 2000u, 30'000u}) { // before, while sending, while waiting
        rig<S> r;
        r.port.most_calls = 60'000'000;
        const std::uint64_t at = r.port.time + when;
        r.port.clock = [at](std::uint64_t t) { return static_cast<std::uint32_t>(t < at ? t : at); };
        const auto e = r.run(write_one);
        CHECK(e.why.error() == errc::clock_stopped);
        CHECK(e.was_sent == (r.port.frames.size() == 1));
        CHECK(e.was_sent == (when > 1500));
    }
}

TEST_CASE_TEMPLATE("G29: a clock that goes back again and again ends the call of a blocking line", S, polls,
                   sleeps) {
    for (const std::uint32_t tick : {1u, 1000u}) {
        for (std::uint64_t start = 0; start < 5000; start += 125) {
            CAPTURE(tick);
            CAPTURE(start);
            rig<S> r;
            CHECK(r.ask(read_one) == errc::timeout);
            r.port.frames.clear();
            const std::uint64_t from = r.port.time;
            r.port.most_calls = 3'000'000;
            r.port.clock = [=](std::uint64_t t) {
                return static_cast<std::uint32_t>(from + (t - from + start) % 5000 / tick * tick);
            };
            CHECK(r.ask(write_one) != errc::ok);
        }
    }
}

TEST_CASE_TEMPLATE("G29: a port that reports bytes which it did not write delays no call, and gives no value",
                   S, polls, sleeps) {
    struct liar : S::port {
        std::uint16_t claims = 0;
        bool is_honest_before = false;
        transfer receive(byte_buffer in) {
            const transfer t = S::port::receive(in);
            const bool lies = claims != 0 && !(is_honest_before && this->frames.empty());
            return t && *t == 0 && lies ? transfer{claims} : t;
        }
    };
    for (const std::uint16_t claims : std::array<std::uint16_t, 4>{1, 7, 40, 0xFFFF}) {
        for (const bool is_honest_before : {false, true}) {
            CAPTURE(claims);
            CAPTURE(is_honest_before);
            rig<setup<liar>> r;
            r.port.most_calls = 3'000'000;
            r.port.claims = claims;
            r.port.is_honest_before = is_honest_before;
            CHECK(r.run_in_time(read_one).why.error() != errc::ok);
        }
    }
}

namespace {

// What the device and the line do to one request: the same for every line under test.
struct fault {
    unsigned kind = 0;
    std::array<unsigned, 4> any{}; // random
    std::uint16_t value = 0;       // of this response only

    static constexpr unsigned kinds = 17;
    bool is_valid(bool is_strict) const { return kind >= 12 || (kind == 11 && !is_strict); }
    bool may_be_valid() const {
        return kind == 10;
    } // after another node's frame, without a gap: the line may accept it

    byte_list good(const byte_list& q) const {
        return q[1] == 3 ? tests::read_response(1, std::vector<std::uint16_t>(q[5], value))
                         : tests::acknowledgement(q);
    }
    void operator()(scripted_port& p, const sent_frame& f) const {
        const byte_list whole = good(f.data);
        const auto size = static_cast<unsigned>(whole.size());
        byte_list response = whole;
        byte_list noise(any[0] % 40, static_cast<std::uint8_t>(any[1]));
        for (auto& b : noise) b = static_cast<std::uint8_t>(b * 5u + any[2]);
        switch (kind) {
        case 0: return;
        case 1: response[any[0] % size] ^= static_cast<std::uint8_t>(1 + any[1] % 255); break;
        case 2: response.resize(1 + any[0] % (size - 1)); break;
        case 3:
        case 4:
        case 5: // another node, function or count, with a good CRC
            response[kind - 3] ^= static_cast<std::uint8_t>(1 + any[0] % 127);
            response = framed({response.begin(), response.end() - 2});
            break;
        case 6: return p.say(100'500 + any[0] % 98'000, response); // late, within the quarantine
        case 7: response = noise; break;
        case 8: response = f.data[1] == 6 ? noise : f.data; break; // an echo
        case 9: response = byte_list(5 + any[0] % 9, any[1] % 2 == 0 ? 0x00 : 0xFF) + whole; break;
        case 10: response = tests::read_response(2, {value}) + whole; break;
        case 11: // a pause of more than t1.5 inside
            p.say(500, {whole.begin(), whole.begin() + 2});
            return p.say(500 + 2 * p.character_us + 2000 + any[0] % 16'000, {whole.begin() + 2, whole.end()});
        case 12: response = byte_list(any[0] % 5, any[1] % 2 == 0 ? 0x00 : 0xFF) + whole; break;
        case 13: response = whole + noise; break;
        case 14: // twice, the second time before the next request: while that leaves it would be another node's frame
            p.say(500, whole);
            return p.say(500 + size * p.character_us + any[0] % 1600, whole);
        default: return p.say(500 + any[0] % 95'000, whole);
        }
        p.say(500 + any[3] % 1000, response);
    }
};

} // namespace

TEST_CASE_TEMPLATE(
    "G2: under the same random faults a blocking line succeeds where `line` does, with the device's value", S,
    polls, sleeps, polls_strict, sleeps_strict) {
    std::mt19937 random{2026};
    const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
    unsigned valid = 0;
    unsigned good = 0;
    std::uint16_t fresh = 0;
    const unsigned scripts = waiting_port<typename S::port> ? 200 : 12;
    for (unsigned script = 0; script < scripts; ++script) {
        rig<S> r;
        typename S::port port;
        port.character_us = S::timing.character;
        line<typename S::port> whole{port, S::timing};
        const auto ask_whole = [&](const byte_list& q, byte_list& response) {
            modbus::exchange x{q, response, whole.timing(), r.limits};
            whole.run(x, bus_gaps{{}, milliseconds(100)});
            return x.status().error();
        };
        byte_list first(7);
        port.device = answering(500);
        REQUIRE(ask_whole(read_one, first) == errc::ok);
        const std::uint32_t empty_reads = below(3);
        r.port.empty_reads = port.empty_reads = empty_reads;
        for (int turn = 0; turn < 8; ++turn) {
            fault f{below(fault::kinds), {}, ++fresh};
            for (unsigned& any : f.any) any = below(1u << 30);
            const auto low = static_cast<std::uint8_t>(below(256));
            const auto words = static_cast<std::uint8_t>(1 + below(3));
            const unsigned code = below(4);
            const byte_list q = code == 0   ? framed({1, 6, 0x20, low, 0, words})
                                : code == 1 ? framed({1, 0x10, 0x20, low, 0, 1, 2, words, low})
                                            : framed({1, 3, 0x20, low, 0, words});
            const unsigned noise_size = below(4) == 0 ? below(9) : 0;
            const byte_list noise(noise_size, static_cast<std::uint8_t>(below(256)));
            for (scripted_port* p : std::initializer_list<scripted_port*>{&r.port, &port}) {
                p->say_at(p->time, noise);
                p->device = f;
            }
            CAPTURE(script);
            CAPTURE(turn);
            CAPTURE(f.kind);
            CAPTURE(q);
            const auto e = r.run(q);
            byte_list response(response_size(q));
            const errc why = ask_whole(q, response);
            valid += f.is_valid(S::is_strict);
            if (!f.may_be_valid()) {
                REQUIRE((e.why.error() == errc::ok) == f.is_valid(S::is_strict));
                REQUIRE((why == errc::ok) == (e.why.error() == errc::ok));
            }
            if (e.why.error() != errc::ok) continue;
            ++good;
            REQUIRE(e.response == f.good(q));
            if (why == errc::ok) REQUIRE(response == e.response);
        }
    }
    CHECK(valid > scripts); // of 8 requests in each, 5 kinds of 17 are
    CHECK(good >= valid);
}

} // namespace blocking_line_faults_tests
