// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line in steps, as a main loop makes them: one exchange at a time, which one is next when several wait,
// a stop that goes ahead of the others, and exchanges that their owners abandon or stop stepping. All times
// are those of a virtual clock.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <tests/support/line_rig.hpp>

namespace line_steps_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list;
using tests::scripted_port;
using tests::waiting_scripted_port;

TEST_CASE("a superloop that makes a step in each iteration gets the same, however long an iteration takes") {
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
            REQUIRE(x.status().error() == errc::ok);
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

TEST_CASE_TEMPLATE(
    "one exchange at a time: another one waits for the line, or ends as busy if it cannot wait", Port,
    scripted_port, waiting_scripted_port) {
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
        CHECK(r.run(read_one).why.error() == errc::busy); // blocking: the other one would not be stepped
        std::array<std::uint8_t, 256> third_room{};
        exchange third{read_one, third_room, r.on.timing(), r.limits};
        r.on.abandon(third); // not the one in progress
        CHECK(third.status().error() == errc::busy);
        CHECK_FALSE(third.was_sent());
        while (!x.done()) {
            r.on.step(other, r.gaps);
            r.on.step(x, r.gaps);
        }
        CHECK(x.status().error() == errc::ok);
        REQUIRE(r.port.frames.size() == 1);
        CHECK(r.port.frames[0].data == write_one);
        while (!other.done()) r.on.step(other, r.gaps);
        CHECK(other.status().error() == errc::ok);
        CHECK(r.port.frames[1].data == write_two);
    }
}

TEST_CASE_TEMPLATE("G25: a stop is the next frame after the one in progress, whichever exchanges wait", Port,
                   scripted_port, waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(5000);
    std::array<std::array<std::uint8_t, 256>, 4> room{};
    exchange first{read_one, room[0], r.on.timing(), r.limits};
    exchange waiting{read_other, room[1], r.on.timing(), r.limits};
    exchange stop{write_one, room[2], r.on.timing(), r.limits, priority::stop};
    exchange later{read_other, room[3], r.on.timing(), r.limits};

    SUBCASE("after a frame in progress") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        while (!stop.done()) {
            r.on.step(waiting, r.gaps);
            r.on.step(stop, r.gaps);
            r.on.step(later, r.gaps);
            r.on.step(first, r.gaps);
        }
        CHECK(first.status().error() == errc::ok);
        REQUIRE(r.port.frames.size() == 2);
        CHECK(r.port.frames[1].data == write_one);
    }
    SUBCASE("an exchange that still waits for its gap, here the quarantine, lets the stop go first") {
        r.port.device = nullptr;
        CHECK(r.run(read_one).why.error() == errc::timeout);
        r.port.device = answering(500);
        r.port.frames.clear();
        const std::uint64_t asked = r.port.time;
        r.on.step(first, r.gaps);
        CHECK_FALSE(r.on.is_free());
        while (!stop.done()) r.on.step(stop, r.gaps);
        CHECK(stop.status().error() == errc::ok);
        CHECK(r.port.frames[0].data == write_one);
        CHECK(r.port.frames[0].begin < asked + r.timing.t3_5 + 100);
        while (!first.done()) r.on.step(first, r.gaps);
        CHECK(first.status().error() == errc::ok);
    }
    SUBCASE("a stop that is abandoned, or not stepped any more, does not hold the line for ever") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        r.on.step(stop, r.gaps);
        bool is_given_up = false;
        SUBCASE("abandoned") { is_given_up = true; }
        SUBCASE("not stepped") {}
        if (is_given_up) r.on.abandon(stop);
        while (!first.done()) r.on.step(first, r.gaps);
        r.port.time += is_given_up ? 0 : 600'000;
        while (!later.done()) r.on.step(later, r.gaps);
        CHECK(later.status().error() == errc::ok);
        CHECK(r.port.frames.size() == 2);
    }
    SUBCASE("two stops are sent in the order in which they came") {
        while (first.state() != exchange::phase::awaiting) r.on.step(first, r.gaps);
        exchange second_stop{write_two, room[1], r.on.timing(), r.limits};
        r.on.step(stop, r.gaps);
        r.on.step(second_stop, r.gaps);
        while (!second_stop.done()) {
            r.on.step(second_stop, r.gaps);
            r.on.step(first, r.gaps);
            r.on.step(stop, r.gaps);
        }
        REQUIRE(r.port.frames.size() == 3);
        CHECK(r.port.frames[1].data == write_one);
        CHECK(r.port.frames[2].data == write_two);
    }
}

TEST_CASE_TEMPLATE(
    "an exchange that its owner does not step any more holds the line for a while and not for ever", Port,
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
        CHECK(r.run(read_one).why.error() == errc::busy);
        r.port.time = begun + 2 * r.bound(write_one, 8);
        const std::uint64_t free_at = r.port.time;
        CHECK(r.run(read_one).why.error() == errc::ok);
        CHECK(r.port.frames.back().begin >= free_at + 100'000 - 10); // whatever became of it: quarantine
        // Its owner returns while another exchange is in progress.
        std::array<std::uint8_t, 256> other_room{};
        exchange other{read_one, other_room, r.on.timing(), r.limits};
        while (other.state() != exchange::phase::awaiting) r.on.step(other, r.gaps);
        r.on.abandon(forgotten);
        CHECK(forgotten.done());
        r.on.run(other, r.gaps);
        CHECK(other.status().error() == errc::ok);
    }
}

TEST_CASE("G21: a broadcast that fails is no miss of any node") {
    rig r;
    r.settle();
    std::array<epoch, 9> before{};
    for (std::uint8_t n = 1; n < 9; ++n) before[n] = r.on.epoch(n);
    r.port.never_sent = true;
    CHECK(r.run(tests::framed({0x00, 0x06, 0x20, 0x0E, 0x00, 0x07})).why.error() == errc::partial_send);
    for (std::uint8_t n = 1; n < 9; ++n) {
        CAPTURE(n);
        CHECK(r.on.epoch(n) == before[n]);
        CHECK(r.on.is_echo_ruled_out(n));
    }
}

TEST_CASE("G1: a stop in a quarantine that gets no response is followed by the quarantine of its own node") {
    for (const std::uint32_t of_stop : {30u, 250u}) {
        CAPTURE(of_stop);
        rig r;
        r.settle();
        r.gaps.quarantine = milliseconds(30);
        CHECK(r.run(read_one).why.error() == errc::timeout);
        r.priority = priority::stop;
        r.gaps.quarantine = milliseconds(of_stop);
        CHECK(r.run(write_one).why.error() == errc::timeout);
        const std::uint64_t ended = r.port.time;
        r.priority = priority::ordinary;
        r.gaps.quarantine = milliseconds(30);
        r.port.device = answering(500);
        CHECK(r.run(read_one).why.error() == errc::ok);
        CHECK(r.port.frames[2].begin >= ended + of_stop * 1000u - 10);
    }
}

TEST_CASE("G21: a request without a response changes the epoch of its node, whatever its address") {
    for (const unsigned address : {1u, 2u, 7u, 8u, 9u, 16u, 100u, 247u}) {
        CAPTURE(address);
        rig r;
        r.settle();
        const auto node = static_cast<std::uint8_t>(address);
        const std::array others{static_cast<std::uint8_t>(address + 1),
                                static_cast<std::uint8_t>(address - 1)};
        const tests::byte_list request = tests::framed({node, 0x03, 0x20, 0xA1, 0x00, 0x01});
        epoch before = r.on.epoch(node);
        const std::array of_others{r.on.epoch(others[0]), r.on.epoch(others[1])};
        for (int i = 0; i < 3; ++i) {
            CHECK(r.run(request).why.error() == errc::timeout);
            CHECK_FALSE(r.on.epoch(node) == before);
            CHECK(r.on.epoch(node).events.losses == before.events.losses);
            before = r.on.epoch(node);
        }
        CHECK(r.on.epoch(others[0]) == of_others[0]);
        CHECK(r.on.epoch(others[1]) == of_others[1]);
    }
}

TEST_CASE("G21: a new epoch of a node is its own, and one of all nodes is that of each") {
    rig r;
    r.settle();
    for (const std::uint8_t node : {std::uint8_t{3}, std::uint8_t{200}}) {
        const epoch own = r.on.epoch(node), after = r.on.epoch(static_cast<std::uint8_t>(node + 1));
        r.on.begin_epoch(node);
        CHECK_FALSE(r.on.epoch(node) == own);
        CHECK(r.on.epoch(static_cast<std::uint8_t>(node + 1)) == after);
    }
    std::array<epoch, 248> before{};
    for (unsigned n = 1; n < 248; ++n) before[n] = r.on.epoch(static_cast<std::uint8_t>(n));
    r.on.begin_epoch(0);
    unsigned same = 0;
    for (unsigned n = 1; n < 248; ++n)
        same += r.on.epoch(static_cast<std::uint8_t>(n)) == before[n] ? 1u : 0u;
    CHECK(same == 0);
}

} // namespace line_steps_tests
