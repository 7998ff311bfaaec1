// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G27: `look_for` distinguishes at an address no response, a response and a collision, and a port that fails.
#include <doctest/doctest.h>

#include <cstdint>
#include <functional>

#include <servobus/client/scan.hpp>

#include <tests/support/scripted_port.hpp>

namespace scan_tests {

using namespace servobus;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {

template <class Echo = unechoed> struct rig {
    scripted_port port;
    response_limits limits;
    line<scripted_port, counters, Echo> on{port, modbus::timing_at(115200)};

    rig() { limits.response = milliseconds(20); }
    rig(const rig&) = delete;
    finding look(std::uint8_t node_address = 1, std::uint16_t address = 0x2000) {
        const finding f = look_for(on, node_address, limits, address);
        REQUIRE_FALSE(port.ran_away);
        return f;
    }
};

const byte_list good = tests::read_response(1, {0xBEEF});

} // namespace

TEST_CASE("G27: without a response the finding has no word but the reason, after one request") {
    rig r;
    const finding f = r.look();
    CHECK(f.what == presence::no_response);
    CHECK_FALSE(f.has_word);
    CHECK(f.word == 0);
    CHECK(f.why.error() == errc::timeout);
    REQUIRE(r.port.frames.size() == 1);
    CHECK(r.port.frames[0].data == tests::framed({1, 3, 0x20, 0x00, 0, 1}));
    const finding none; // before any request
    CHECK_FALSE(none.has_word);
    CHECK(none.what == presence::no_response);
}

TEST_CASE("G27: the next look waits for the gaps that are given, and for no quarantine without them") {
    const auto pause_after_no_response = [](const bus_gaps& gaps) {
        rig r;
        (void)look_for(r.on, 1, r.limits, 0, gaps);
        (void)look_for(r.on, 2, r.limits, 0, gaps);
        REQUIRE(r.port.frames.size() == 2);
        return r.port.frames[1].begin - r.port.frames[0].end;
    };
    const auto without = pause_after_no_response({});
    CHECK(without < 50'000);
    CHECK(pause_after_no_response({.quarantine = milliseconds(100)}) >= 120'000);
    CHECK(pause_after_no_response({.gap = milliseconds(50)}) >= 50'000);
}

TEST_CASE("G27: a drive that is present responds with a word, or with an exception, which has none") {
    rig r;
    r.port.device = [](scripted_port& p, const sent_frame&) { p.say(500, good); };
    const finding f = r.look();
    CHECK(f.what == presence::present);
    CHECK(f.has_word);
    CHECK(f.word == 0xBEEF);
    CHECK(f.why == errc::ok);
    r.port.device = [](scripted_port& p, const sent_frame&) {
        p.say(500, tests::exception_response(1, 3, 2));
    };
    const finding refused = r.look();
    CHECK(refused.what == presence::present);
    CHECK_FALSE(refused.has_word);
    CHECK(refused.why == status::sent(errc::exception, 2));
    CHECK(r.port.frames.size() == 2); // one request each
}

TEST_CASE("G27: two invalid responses are a collision, or another baud rate") {
    rig r;
    byte_list collided = good;
    collided[3] = 0x00;
    SUBCASE("a wrong CRC") {}
    SUBCASE("a piece of a response") { collided.resize(3); }
    SUBCASE("bytes of any kind") { collided = byte_list(9, 0x5A); }
    SUBCASE("another node's response") { collided = tests::read_response(2, {5}); }
    r.port.device = [&](scripted_port& p, const sent_frame&) { p.say(500, collided); };
    const finding f = r.look();
    CHECK(f.what == presence::garbled);
    CHECK_FALSE(f.has_word);
    CHECK(f.why.error() != errc::ok);
    CHECK(r.port.frames.size() == 2);
}

TEST_CASE("G27: framing errors, which collisions and other baud rates cause, do not count as a failed port") {
    rig r;
    int noisy = 0;
    SUBCASE("each time") { noisy = 2; }
    SUBCASE("once") { noisy = 1; }
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (noisy-- > 0) {
            p.noisy_until = f.end + 1000;
        } else {
            p.say(500, good);
        }
    };
    const bool is_garbled = noisy == 2;
    const finding f = r.look();
    CHECK(f.what == (is_garbled ? presence::garbled : presence::present));
    CHECK(f.has_word == !is_garbled);
    CHECK(f.why.error() == (is_garbled ? errc::receive_failed : errc::ok));
    CHECK(r.port.frames.size() == 2);
}

TEST_CASE("G27: after one invalid response a second request decides") {
    rig r;
    int asked = 0;
    bool is_there = false;
    SUBCASE("a drive responds") { is_there = true; }
    SUBCASE("no drive responds, and it was noise") {}
    r.port.device = [&](scripted_port& p, const sent_frame&) {
        if (asked++ == 0) p.say(500, byte_list(9, 0x5A));
        if (asked > 1 && is_there) p.say(500, good);
    };
    const finding f = r.look();
    CHECK(f.what == (is_there ? presence::present : presence::no_response));
    CHECK(f.has_word == is_there);
    CHECK(r.port.frames.size() == 2);
}

TEST_CASE("a port that fails is not taken for an absent node") {
    rig r;
    finding f;
    SUBCASE("lost") {
        r.port.lost_from_call = 1;
        f = r.look();
        CHECK(f.why.error() == errc::port_lost);
    }
    SUBCASE("takes nothing") {
        r.port.takes_nothing_until = ~std::uint64_t{0};
        f = r.look();
        CHECK(f.why.error() == errc::send_failed);
    }
    SUBCASE("never quiet") {
        r.port.noisy_until = ~std::uint64_t{0};
        f = r.look();
        CHECK(f.why.error() == errc::line_busy);
    }
    SUBCASE("an address that no node can have") {
        f = r.look(248);
        CHECK(f.why.error() == errc::bad_argument);
    }
    CHECK(f.what == presence::failed);
    CHECK_FALSE(f.has_word);
    CHECK(r.port.bytes_sent() == 0);
}

TEST_CASE("G4, G27: an echo that does not arrive is an error of the adapter and no collision") {
    rig<echoed> r;
    const finding f = r.look();
    CHECK(f.what == presence::failed);
    CHECK(f.why.error() == errc::no_echo);
    r.port.echoes = r.port.keeps_echo = true;
    CHECK(r.look().what == presence::no_response);
    r.port.corrupts_echo = true;
    CHECK(r.look().what == presence::garbled); // another device was sending
}

} // namespace scan_tests
