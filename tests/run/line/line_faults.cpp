// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line and its users when something goes wrong between them: an owner that comes back after its turn was
// over, one that gives up in the middle of a frame, numbers that wrap, a clock that goes back.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

using namespace servobus;
using modbus::exchange;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
const byte_list one_word = tests::read_response(1, {0x0960});
const byte_list stop_all = framed({0x00, 0x06, 0x20, 0x0E, 0x00, 0x07});

struct rig {
    scripted_port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};
    line<scripted_port> on{port, modbus::timing_at(115200)};
    std::array<std::array<std::uint8_t, 16>, 3> room{};

    rig() { port.device = answer; }
    rig(const rig&) = delete;

    static void answer(scripted_port& p, const tests::sent_frame& f) {
        if (f.data[0] == 1) p.say(500, f.data[1] == 0x03 ? one_word : tests::acknowledgement(f.data));
    }
    exchange make(const byte_list& request, std::size_t which) {
        return {request, room[which], on.timing(), limits};
    }
    void finish(exchange& x) {
        while (!x.done()) on.step(x, gaps);
    }
    /// The line as it is after a good exchange.
    void settle() {
        exchange x = make(read_one, 2);
        finish(x);
        REQUIRE(x.why() == failure{});
        port.frames.clear();
    }
    std::uint64_t bound() const { return on.bound(8, 8, limits, gaps).us; }
};

} // namespace

TEST_CASE("an exchange that comes back after its turn was over is told so, and the line goes on") {
    for (const bool by_run : {false, true}) {
        CAPTURE(by_run);
        rig r;
        r.settle();
        exchange late = r.make(write_one, 0);
        while (late.state() != exchange::phase::awaiting) r.on.step(late, r.gaps);
        r.port.time += 2 * r.bound();
        exchange next = r.make(read_one, 1);
        while (next.state() != exchange::phase::awaiting) r.on.step(next, r.gaps);
        if (by_run) {
            r.on.run(late, r.gaps);
        } else {
            r.on.step(late, r.gaps);
        }
        CHECK(late.done());
        CHECK(late.why().code == errc::timeout);
        CHECK(late.was_sent()); // so the write is unknown, not undone
        CHECK_FALSE(r.on.is_free());
        r.finish(next);
        CHECK(next.why() == failure{});
        CHECK(same_bytes(next.response(), one_word));
        CHECK(r.port.frames.size() == 2);
    }
}

TEST_CASE("an exchange that comes back to a line which has become free does not take what lies there") {
    for (const bool by_run : {false, true}) {
        CAPTURE(by_run);
        rig r;
        r.settle();
        exchange late = r.make(write_one, 0);
        while (late.state() != exchange::phase::awaiting) r.on.step(late, r.gaps);
        r.port.time += 2 * r.bound();
        CHECK(r.on.is_free()); // it was forgotten
        if (by_run) {
            r.on.run(late, r.gaps);
        } else {
            r.on.step(late, r.gaps);
        }
        CHECK(late.why().code == errc::timeout);
        CHECK(late.was_sent());
        CHECK(r.on.is_free());
        const std::uint64_t over = r.port.time;
        exchange next = r.make(read_one, 1);
        r.finish(next);
        CHECK(same_bytes(next.response(), one_word)); // not the write's, which came before
        CHECK(r.port.frames.back().begin >= over + 100'000 - 20);
    }
}

TEST_CASE("G21: a request that left and was not answered puts its drive in doubt, once, however it ends") {
    rig r;
    r.settle();
    const std::uint16_t before = r.on.doubts(1);
    const std::uint16_t other = r.on.doubts(2);
    exchange x = r.make(read_one, 0);
    unsigned bus_gaps = 1;
    constexpr unsigned all = 0x100; // of all drives, since nobody can say whose it was
    const auto send = [&] {
        while (x.is_to_leave()) r.on.step(x, r.gaps);
    };
    SUBCASE("nobody answers, or the response is damaged") {
        r.port.device = {};
        SUBCASE("nobody") {}
        SUBCASE("damaged") { r.port.say_at(r.port.time + 5000, byte_list(7, 0x01)); }
        r.finish(x);
    }
    SUBCASE("it is cut while it leaves") {
        r.port.never_sent = true;
        r.on.run(x, r.gaps);
        CHECK(x.why().code == errc::partial_send);
    }
    SUBCASE("it is given up while it leaves") {
        while (x.state() != exchange::phase::leaving) r.on.step(x, r.gaps);
        r.on.abandon(x);
    }
    SUBCASE("it is given up behind that") {
        send();
        r.on.abandon(x);
    }
    SUBCASE("its owner is gone, and comes back") {
        send();
        r.port.time += 2 * r.bound();
        CHECK(r.on.is_free());
        bus_gaps = all;
        r.on.step(x, r.gaps);
    }
    SUBCASE("its owner is gone while it leaves") {
        while (x.state() != exchange::phase::leaving) r.on.step(x, r.gaps);
        r.port.time += 2 * r.bound();
        bus_gaps = all;
    }
    SUBCASE("but an answer is none, nor a refusal") {
        bus_gaps = 0;
        SUBCASE("an answer") {}
        SUBCASE("a refusal") {
            r.port.device = [](scripted_port& p, const auto&) {
                p.say(500, tests::exception_response(1, 3, 2));
            };
        }
        r.finish(x);
    }
    SUBCASE("nor is what never left") {
        bus_gaps = 0;
        SUBCASE("the line is never free") {
            r.port.noisy_until = r.port.time + 10'000'000;
            r.on.run(x, r.gaps);
            CHECK(x.why().code == errc::line_busy);
        }
        SUBCASE("it is given up before, or its owner is gone") {
            r.on.step(x, r.gaps);
            REQUIRE_FALSE(r.on.is_sending());
            SUBCASE("given up") { r.on.abandon(x); }
            SUBCASE("gone") { r.port.time += 2 * r.bound(); }
        }
    }
    SUBCASE("nor a broadcast, whole or cut") {
        bus_gaps = 0;
        x = r.make(stop_all, 0);
        SUBCASE("whole") {}
        SUBCASE("cut") { r.port.never_sent = true; }
        r.on.run(x, r.gaps);
        CHECK(x.was_sent());
    }
    CHECK(r.on.is_free());
    CHECK(r.on.doubts(1) == before + bus_gaps);
    CHECK(r.on.doubts(2) == other + (bus_gaps == all ? all : 0));
}

TEST_CASE("G21: a lost port puts all drives in doubt, and no number of silences makes an old number good") {
    rig r;
    r.settle();
    std::array<std::uint16_t, 8> before{};
    for (std::uint8_t unit = 1; unit <= 8; ++unit) before[unit - 1u] = r.on.doubts(unit);
    SUBCASE("the port, of which nothing had left") {
        r.port.lost_from_call = 1;
        exchange x = r.make(read_one, 0);
        r.on.run(x, r.gaps);
        for (std::uint8_t unit = 1; unit <= 8; ++unit) CHECK(r.on.doubts(unit) != before[unit - 1u]);
    }
    SUBCASE("a thousand silences") {
        r.port.device = {};
        r.limits = {.response = milliseconds(1)};
        for (int i = 0; i < 1000; ++i) {
            exchange x = r.make(read_one, 0);
            r.on.run(x, {});
            REQUIRE(r.on.doubts(1) != before[0]);
        }
    }
}

TEST_CASE("a broadcast that is forgotten holds the line for its own time only") {
    rig r;
    r.limits.turnaround = milliseconds(10);
    r.limits.response = milliseconds(5000); // would be a response's
    r.settle();
    exchange forgotten = r.make(stop_all, 0);
    while (forgotten.state() != exchange::phase::awaiting) r.on.step(forgotten, r.gaps);
    CHECK_FALSE(r.on.is_free());
    r.port.time += 1'000'000;
    CHECK(r.on.is_free());
}

TEST_CASE("a request that is given up while it leaves counts as sent, and its rest does not follow") {
    for (std::uint32_t taken = 0; taken < 8; ++taken) {
        CAPTURE(taken);
        rig r;
        r.settle();
        r.port.takes_at_most = 1;
        exchange x = r.make(write_one, 0);
        while (r.port.bytes_sent() < taken) r.on.step(x, r.gaps);
        CHECK(x.state() == (taken == 0 ? exchange::phase::ready : exchange::phase::leaving));
        CHECK(r.on.is_sending() == (taken != 0));
        r.on.abandon(x);
        CHECK(x.done());
        CHECK(x.was_sent() == (taken != 0));
        CHECK(x.why().code == (taken != 0 ? errc::timeout : errc::busy));
        CHECK_FALSE(r.on.is_sending());
        CHECK(r.on.is_free());
        r.on.abandon(x); // once more: nothing
        CHECK(x.was_sent() == (taken != 0));
        const std::uint64_t over = r.port.time;
        r.port.takes_at_most = 1000;
        exchange next = r.make(read_one, 1);
        r.finish(next);
        CHECK(next.why() == failure{});
        CHECK(r.port.frames.back().data == read_one);
        CHECK((r.port.frames.back().begin >= over + 100'000 - 20) == (taken != 0));
        CHECK(r.port.bytes_sent() == taken + read_one.size());
    }
}

TEST_CASE("G2: the response to a request that was given up is dropped, however late it may come") {
    for (const bool leaves_slowly : {false, true}) { // the port has it all, and most of it is still to leave
        for (const std::uint32_t response_after : {500u, 60'000u, 99'000u, 119'000u}) {
            CAPTURE(leaves_slowly);
            CAPTURE(response_after);
            rig r;
            r.gaps.quarantine = milliseconds(20);
            r.port.character_us = leaves_slowly ? 9167 : 96;
            line<scripted_port> on{r.port, modbus::timing_at(leaves_slowly ? 1200 : 115200)};
            unsigned asked = 0;
            r.port.device = [&](scripted_port& p, const tests::sent_frame&) {
                if (asked++ == 0) return p.say(response_after, tests::read_response(1, {0x1111}));
                p.say(500, one_word);
            };
            exchange x{read_one, r.room[0], on.timing(), r.limits};
            while (!on.is_sending()) on.step(x, r.gaps);
            if (!leaves_slowly) {
                while (x.is_to_leave()) on.step(x, r.gaps);
            }
            on.abandon(x);
            exchange next{read_one, r.room[1], on.timing(), r.limits};
            while (!next.done()) on.step(next, r.gaps);
            CHECK(next.why() == failure{});
            CHECK(next.words()[0] == 0x0960);
            CHECK(asked == 2);
        }
    }
}

TEST_CASE("an exchange that has ended stays as it ended, whoever gives it up") {
    rig r;
    exchange x = r.make(read_one, 0);
    r.finish(x);
    REQUIRE(x.why() == failure{});
    const std::uint32_t ended = r.on.observer().responses;
    r.on.abandon(x);
    CHECK(x.why() == failure{});
    CHECK(r.on.step(x, r.gaps) == duration{});
    CHECK(r.on.observer().responses == ended);
    CHECK(r.on.observer().timeouts == 0);
    exchange next = r.make(read_one, 1);
    const std::uint64_t heard = r.port.last_heard;
    r.finish(next);
    CHECK(r.port.frames.back().begin < heard + 1750 + 40); // no quarantine
}

TEST_CASE("G1: a line is nobody's when it is made, and a silence that lasted since then counts") {
    scripted_port port;
    port.time = 0;
    port.call_us = 0; // the first look at the clock shows 0 too
    line<scripted_port> first{port, modbus::timing_at(115200)};
    CHECK(first.is_free());
    rig r;
    r.port.time += 200'000;
    const std::uint64_t asked = r.port.time;
    exchange x = r.make(read_one, 0);
    r.finish(x);
    CHECK(r.port.frames[0].begin <= asked + 20);
}

TEST_CASE("G1, G8: while the port was gone nobody listened: the silence counts from its return") {
    for (const std::uint32_t away_ms : {0u, 5u, 500u, 100'000u}) {
        CAPTURE(away_ms);
        rig r;
        r.settle();
        for (std::uint32_t tries = 0; tries < 3; ++tries) {
            r.port.lost_from_call = r.port.calls + 1;
            exchange x = r.make(read_one, 0);
            r.finish(x);
            CHECK(x.why() == failure{errc::port_lost});
            r.port.time += away_ms * 1000;
        }
        r.port.lost_from_call = 0;
        const std::uint64_t back = r.port.time;
        exchange x = r.make(read_one, 0);
        r.finish(x);
        CHECK(x.why() == failure{});
        CHECK(r.port.frames.back().begin - back >= r.gaps.quarantine.us);
        CHECK(r.port.frames.back().begin - back <= r.gaps.quarantine.us + 100);
        // Once: a silence that was heard counts again.
        r.port.time += 50'000;
        const std::uint64_t again = r.port.time;
        exchange y = r.make(read_one, 1);
        r.finish(y);
        CHECK(r.port.frames.back().begin - again <= 100);
    }
}

TEST_CASE("tickets go on through their wrap, and none is zero") {
    detail::turns turns;
    CHECK_FALSE(turns.is_held());
    CHECK_FALSE(turns.is_held_by(0));
    CHECK_FALSE(turns.is_held_by(1));
    CHECK_FALSE(turns.has_stop());
    std::uint16_t last = turns.new_ticket();
    for (unsigned i = 0; i < 70'000; ++i) {
        const std::uint16_t ticket = turns.new_ticket();
        REQUIRE(ticket != 0);
        REQUIRE(ticket != last);
        REQUIRE(turns.take(ticket, false, {}));
        REQUIRE(turns.is_held_by(ticket));
        REQUIRE_FALSE(turns.is_held_by(last));
        turns.release();
        REQUIRE_FALSE(turns.is_held());
        last = ticket;
    }
}

TEST_CASE(
    "G1, G2: a clock that jumps back while a response is awaited does not shorten the quarantine after it") {
    // The true time of the response: within the time that it has, or within the quarantine after that time.
    for (const std::uint32_t response_after : {60'000u, 101'000u, 150'000u, 198'000u}) {
        for (const std::uint32_t jump : {1u, 500u, 3'000u, 90'000u, 2'000'000u}) {
            for (const std::uint64_t jump_after :
                 {0u, 200u, 900u, 5'000u, 80'000u}) { // the port took the request
                for (const bool is_forgotten : {false, true}) {
                    CAPTURE(response_after);
                    CAPTURE(jump);
                    CAPTURE(jump_after);
                    CAPTURE(is_forgotten);
                    rig r;
                    r.settle();
                    unsigned asked = 0;
                    r.port.device = [&](scripted_port& p, const tests::sent_frame&) {
                        if (asked++ == 0) return p.say(response_after, tests::read_response(1, {0x1111}));
                        p.say(90'000, one_word);
                    };
                    exchange x = r.make(read_one, 0);
                    while (r.port.frames.empty()) r.on.step(x, r.gaps);
                    const std::uint64_t at = r.port.time + jump_after;
                    r.port.clock = [=](std::uint64_t t) {
                        return static_cast<std::uint32_t>(t < at ? t : t - jump);
                    };
                    while (!x.done() && !(is_forgotten && r.port.time > at)) r.on.step(x, r.gaps);
                    // It is asked for another register, of the same length.
                    exchange next = r.make(framed({0x01, 0x03, 0x20, 0xAB, 0x00, 0x01}), 1);
                    r.finish(next);
                    if (next.why() == failure{}) CHECK(next.words()[0] == 0x0960);
                    if (x.done() && x.why() == failure{}) CHECK(x.words()[0] == 0x1111);
                }
            }
        }
    }
}

TEST_CASE("G3: a clock that jumps back does not make a response of what may be an echo") {
    // Well formed as a response, and the beginning of its own request.
    const byte_list echo_like = tests::byte_list{0x06, 0x03, 0x02, 0x12, 0x00, 0x01, 0x24, 0x00};
    for (const bool byte_follows : {false, true}) {
        CAPTURE(byte_follows);
        response_limits limits;
        const modbus::rtu_timing timing = modbus::timing_at(115200);
        std::array<std::uint8_t, 8> room{};
        exchange x{echo_like, room, timing, limits};
        x.sent(instant{1'000'000});
        for (std::size_t i = 0; i < 7; ++i)
            x.feed(echo_like[i], instant{1'001'000 + 96 * static_cast<std::uint32_t>(i)});
        REQUIRE(x.state() == exchange::phase::maybe_echo);
        if (byte_follows) {
            x.feed(echo_like[7], instant{900'000});
        } else {
            x.elapse(instant{900'000});
        }
        CHECK(x.why().code == errc::own_echo);
    }
}

TEST_CASE("G29: eight jumps back are taken for a clock's, the ninth for none") {
    detail::stall_detector guard{{1'000'000}, 100};
    instant now{1'000'000};
    for (int i = 0; i < 8; ++i) {
        now = instant{now.us - 1000};
        CHECK_FALSE(guard.has_failed(now));
        CHECK_FALSE(guard.has_failed(now + microseconds(10)));
    }
    CHECK(guard.has_failed(instant{now.us - 1000}));
}

TEST_CASE("G29: a clock is taken for stopped after so many equal looks, and not while it moves") {
    detail::stall_detector guard{{5}, 100};
    for (int i = 0; i < 100; ++i) CHECK_FALSE(guard.has_failed({5}));
    CHECK_FALSE(guard.has_failed({6}));
    for (int i = 0; i < 100; ++i) CHECK_FALSE(guard.has_failed({6}));
    CHECK(guard.has_failed({6}));
}

TEST_CASE("G4: the echo of a long request is taken whole, however slow the program's loop is") {
    byte_list request{0x01, 0x10, 0x01, 0x00, 0x00, 30, 60};
    for (std::uint8_t i = 0; i < 60; ++i) request.push_back(i);
    request = framed(request);
    for (const std::uint32_t turn_ms : {0u, 9u, 20u, 45u}) {
        CAPTURE(turn_ms);
        scripted_port port;
        port.echoes = port.keeps_echo = true;
        port.device = [](scripted_port& p, const tests::sent_frame& f) {
            p.say(500, tests::acknowledgement(f.data));
        };
        line<scripted_port, counters, echoed> on{port, modbus::timing_at(115200)};
        const response_limits limits{.response = milliseconds(500)};
        std::array<std::uint8_t, 8> room{};
        exchange x{request, room, on.timing(), limits};
        while (!x.done()) {
            (void)on.step(x, bus_gaps{{}, milliseconds(100)});
            port.time += turn_ms * 1000u;
        }
        CHECK(x.why() == failure{});
    }
}
