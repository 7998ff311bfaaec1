// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client over a scripted port whose responses are missing, damaged, late or exceptions: a read is retried
// and a write never, a read gives the register's value or none, and both return within their bounds.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace client_retries_tests {

using namespace servobus;
using namespace tests::typed;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;
using tests::operator+;

namespace {

constexpr int failures_of_responses = 9;
// Damages a good response in the way that `how` selects.
void answer_badly(scripted_port& port, const byte_list& good, int how, tests::dice& random) {
    byte_list response = good;
    switch (how) {
    case 0: return; // no response
    case 1: {
        const std::size_t at = random.below(static_cast<std::uint32_t>(response.size()));
        response[at] = static_cast<std::uint8_t>(response[at] ^ (1 + random.below(255)));
        break;
    }
    case 2: response.resize(1 + random.below(static_cast<std::uint32_t>(response.size() - 1))); break;
    case 3:
        response[0] = 2;
        response.resize(response.size() - 2);
        response = framed(response);
        break;
    case 4:
        response = tests::read_response(1, std::vector<std::uint16_t>(1 + good.size() / 2, 0xDEAD));
        break;
    case 5: response = framed({1, 0x2B, 1, 2, 3}); break;
    case 6: response = byte_list(5 + random.below(200), 0x00); break;
    case 7: port.say(100'000 + random.below(99'000), response); return; // late, but within the quarantine
    case 8:                                                             // random bytes
        for (auto& b : response) b = random.byte();
        if (response[0] == 1) response[0] = 3;
        break;
    default: break;
    }
    port.say(500, response);
}

} // namespace

TEST_CASE(
    "G12, G16: only the number by which a device acknowledges, if it has one, says that it has accepted") {
    for (const std::uint8_t acknowledge :
         {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{5}, std::uint8_t{255}}) {
        CAPTURE(acknowledge);
        for (unsigned number = 0; number <= 255; ++number) {
            CAPTURE(number);
            rig r;
            r.drive.node().limits.acknowledge = acknowledge;
            r.port.device = [number](scripted_port& p, const tests::sent_frame& f) {
                p.say(500, tests::exception_response(1, f.data[1], static_cast<std::uint8_t>(number)));
            };
            const bool is_accepted = number == acknowledge && acknowledge != 0; // 0: it has none
            const errc why = is_accepted ? errc::acknowledged : errc::exception;
            REQUIRE(r.drive.write<fixture::time>(1) == status::sent(why, static_cast<std::uint8_t>(number)));
            REQUIRE(r.drive.write<fixture::position>(1).outcome() ==
                    (is_accepted ? outcome::unknown : outcome::refused));
            REQUIRE(r.drive.read<fixture::time>().error() == why);
        }
    }
}

TEST_CASE("G12: an exception reaches the caller with its number, and its read is not repeated") {
    for (unsigned number = 0; number <= 255; ++number) {
        rig r;
        r.port.device = [number](scripted_port& p, const tests::sent_frame& f) {
            p.say(500, tests::exception_response(1, f.data[1], static_cast<std::uint8_t>(number)));
        };
        const auto v = r.drive.read<fixture::time>();
        REQUIRE(v.error() == (number == 5 ? errc::acknowledged : errc::exception));
        REQUIRE(v.exception() == number);
        REQUIRE(r.port.frames.size() == 1);
        const status w = r.drive.write<fixture::position>(1);
        REQUIRE(w.outcome() == (number == 5 ? outcome::unknown : outcome::refused));
        REQUIRE(w.has_response());
        REQUIRE(w.exception() == number);
        REQUIRE(r.port.frames.size() == 2);
    }
}

TEST_CASE("after any bad response a read is repeated as often as its node states, and then returns the last "
          "error") {
    for (const unsigned retries : {0u, 1u, 2u, 5u}) {
        for (int how = 0; how < failures_of_responses; ++how) {
            CAPTURE(retries);
            CAPTURE(how);
            tests::dice random{static_cast<std::uint64_t>(how)};
            rig r;
            r.drive.node().read_retries = static_cast<std::uint8_t>(retries);
            r.port.device = [&](scripted_port& p, const tests::sent_frame& f) {
                answer_badly(p, r.file.response_to(f.data), how, random);
            };
            CHECK_FALSE(r.drive.read<fixture::time>());
            CHECK(r.port.frames.size() == retries + 1);
        }
    }
}

TEST_CASE("a read is not repeated when the port failed") {
    rig r;
    CHECK(r.drive.read<fixture::time>());
    const std::uint64_t calls = r.port.calls;
    for (std::uint64_t n = calls + 1; n < calls + 20; n += 2) {
        rig other;
        CHECK(other.drive.read<fixture::time>());
        const std::size_t sent = other.port.frames.size();
        other.port.lost_from_call = n;
        CHECK(other.drive.read<fixture::time>().error() != errc::ok);
        CHECK(other.port.frames.size() <= sent + 1);
    }
}

TEST_CASE("G15, G16: whatever is wrong with the response, a write is sent exactly once and ends unknown") {
    tests::dice random{15};
    for (int how = 0; how < failures_of_responses; ++how) {
        for (int round = 0; round < 60; ++round) {
            CAPTURE(how);
            CAPTURE(round);
            rig r;
            r.port.device = [&](scripted_port& p, const tests::sent_frame& f) {
                answer_badly(p, tests::acknowledgement(f.data), how, random);
            };
            const status w = round % 3 == 0   ? r.drive.write<fixture::time>(5)
                             : round % 3 == 1 ? r.drive.write<fixture::position>(-5)
                                              : r.drive.write<fixture::time, fixture::speed>(1, 2);
            REQUIRE(w.outcome() == outcome::unknown);
            REQUIRE(r.port.frames.size() == 1);
        }
    }
}

TEST_CASE_TEMPLATE("G15, G16: whichever call of the port fails, a typed write is sent at most once", Port,
                   scripted_port, waiting_scripted_port) {
    std::uint64_t calls = 0;
    for (std::uint64_t n = 0; n <= calls; ++n) {
        for (const bool is_lost : {false, true}) {
            CAPTURE(n);
            rig<device, Port> r;
            r.port.call_us = 50;
            r.drive.node().gaps.quarantine = {};
            (is_lost ? r.port.lost_from_call : r.port.fails_at_call) = n;
            const status w = r.drive.template write<fixture::position>(77);
            if (n == 0) {
                REQUIRE(w);
                calls = r.port.calls;
                continue;
            }
            REQUIRE(r.port.frames.size() <= 1);
            const bool any = r.port.bytes_sent() != 0;
            if (!is_lost && w) continue; // the failure was a garbled character before the request
            REQUIRE(w.outcome() == (!r.port.has_failed ? outcome::done
                                    : any              ? outcome::unknown
                                                       : outcome::not_sent));
        }
    }
    CHECK(calls > 10);
}

TEST_CASE("G2: on a line that damages, cuts, doubles, delays and adds bytes, a read gives the register's "
          "value or none") {
    tests::dice random{2};
    rig r;
    unsigned good = 0;
    unsigned asked = 0;
    std::uint16_t fresh = 0; // every response has its own value, so that an older one is noticed
    r.port.device = [&](scripted_port& p, const tests::sent_frame& f) {
        const byte_list& q = f.data;
        const auto count = static_cast<std::size_t>(q[5]);
        std::vector<std::uint16_t> words;
        ++fresh;
        for (std::size_t i = 0; i < count; ++i)
            words.push_back(static_cast<std::uint16_t>(fresh + 0x1000 * i));
        const byte_list response = tests::read_response(1, words);
        const std::uint32_t fault = random.below(16);
        if (fault < failures_of_responses) {
            answer_badly(p, response, static_cast<int>(fault), random);
        } else if (fault == 9) { // twice, the second one before the next request can have left
            p.say(500, response);
            p.say(500 + 96 * response.size() + random.below(1700), response);
        } else if (fault == 10) {
            p.say(500, byte_list(random.below(5), 0x00) + response);
        } else if (fault == 11) {
            p.say(500, tests::read_response(2, {0xDEAD}) + response);
        } else if (fault == 12) {
            byte_list noise(random.below(40));
            for (auto& b : noise) b = random.byte();
            p.say(500, response + noise);
        } else {
            p.say(500 + random.below(90'000), response);
        }
    };
    for (int i = 0; i < 4000; ++i) {
        ++asked;
        switch (random.below(3)) {
        case 0:
            if (const auto v = r.drive.read<fixture::time>()) {
                ++good;
                REQUIRE(v->count() == fresh);
            }
            break;
        case 1:
            if (const auto v = r.drive.read<fixture::state>()) {
                ++good;
                REQUIRE(*v == fresh);
            }
            break;
        default:
            if (const auto v = r.drive.read<fixture::position>()) {
                ++good;
                REQUIRE(v->count() == static_cast<i32>(u32{fresh} << 16 | static_cast<u16>(fresh + 0x1000)));
            }
        }
        if (random.below(4) == 0) r.port.time += random.below(300'000);
    }
    CHECK(good > asked / 2);
    REQUIRE_FALSE(r.port.ran_away);
}

TEST_CASE_TEMPLATE("G29: a read with its retries, and a write, return within the sum of their bounds", Port,
                   scripted_port, waiting_scripted_port) {
    for (int how = 0; how < failures_of_responses; ++how) {
        tests::dice random{29};
        rig<device, Port> r;
        r.port.call_us = 5;
        r.port.device = [&](scripted_port& p, const tests::sent_frame& f) {
            answer_badly(p, r.file.response_to(f.data), how, random);
        };
        auto& n = r.drive.node();
        std::uint64_t begun = r.port.time;
        (void)r.drive.template read<fixture::time>();
        CHECK(r.port.time - begun <= 3 * (r.on.bound(8, 7, n.limits, n.gaps).us + 100));
        begun = r.port.time;
        (void)r.drive.template write<fixture::time>(1);
        CHECK(r.port.time - begun <= r.on.bound(8, 8, n.limits, n.gaps).us + 100);
    }
}

} // namespace client_retries_tests
