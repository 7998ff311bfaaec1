// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Lines and stepped calls that are used in the wrong way: an exchange without room, destroyed, replaced,
// moved, stepped too often or after its end, or whose line has gone on without it; a port that takes one byte
// a call, none for a while or no more, or says too early that all has left. The checks are of what the port
// recorded, of how often it was called, and of the memory of buffers and calls.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/line/blocking_line.hpp>

#include <tests/support/client_rig.hpp>
#include <tests/support/line_rig.hpp>

namespace bad_input_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list, tests::framed, tests::scripted_port, tests::waiting_scripted_port;
using tests::operator+;

namespace {

template <class Port> struct odd : Port {
    std::size_t takes_in_all = 1'000'000; ///< bytes, and then none
    std::uint32_t pauses_for = 0;         ///< takes nothing for so long after a call that took some
    bool says_sent_early = false;         ///< `sent` is true while the request leaves

    transfer send(bytes out) {
        const transfer took = Port::send(out.size() < takes_in_all ? out : out.first(takes_in_all));
        if (!took || *took == 0) return took;
        takes_in_all -= *took;
        this->takes_nothing_until = this->time + pauses_for;
        return took;
    }
    bool sent() { return Port::sent() || says_sent_early; }
};

template <class Port, modbus::rtu_timing Timing, bool IsBlocking = false> struct bench {
    using line_type =
        std::conditional_t<IsBlocking, blocking_line<odd<Port>, Timing>, servobus::line<odd<Port>>>;
    odd<Port> port;
    line_type on = [this] {
        if constexpr (IsBlocking) return line_type{port};
        if constexpr (!IsBlocking) return line_type{port, Timing};
    }();
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};

    bench() {
        port.character_us = Timing.character;
        port.call_us = 8;
        port.most_calls = 2'000'000;
        port.device = answering(5000);
        byte_list room(7);
        REQUIRE(run(read_one, room) == errc::ok); // so that no quarantine is pending
        port.frames.clear();
        port.calls = 0;
    }
    bench(const bench&) = delete;

    status run(const byte_list& request, byte_buffer room) {
        using any_function = typename line_type::template exchange_for<response_limits, false, true>;
        any_function x{request, room, on.timing(), limits};
        if constexpr (IsBlocking) return on.run(x, gaps);
        if constexpr (!IsBlocking) return on.run(x, gaps), x.status();
    }
    exchange make(const byte_list& request, byte_buffer room) { return {request, room, on.timing(), limits}; }
    byte_list wire() const { ///< all bytes that were sent
        byte_list all;
        for (const auto& f : port.frames) all = all + f.data;
        return all;
    }
    void loop(exchange& x, int iterations, int steps = 1) {
        for (int i = 0; i < iterations && !x.done(); ++i, port.time += port.character_us) {
            for (int n = 0; n < steps; ++n) on.step(x, gaps);
        }
    }
};
constexpr auto host = timing_at(115200), strict = timing_at(9600, timing_mode::strict);

static_assert(!std::is_move_constructible_v<line<scripted_port>>);
static_assert(!std::is_move_constructible_v<blocking_line<scripted_port, host>>);

namespace fixture = tests::typed::fixture;
using client_rig = tests::typed::rig<>;
using test_client = decltype(client_rig::drive);
using stepped_one = stepped_read<test_client, fixture::time>;
using stepped_two = stepped_read<test_client, fixture::time, fixture::state>; // in two requests
using written_one = stepped_write<test_client, fixture::time>;
using written_two = stepped_write<test_client, fixture::position>;

template <class Call> status begin(Call& call) {
    if constexpr (requires { call.value(); }) return call.begin();
    if constexpr (!requires { call.value(); }) return call.begin(500);
}
template <class Call> void loop(client_rig& r, Call& call, int iterations) {
    for (int i = 0; i < iterations && !call.done(); ++i, r.port.time += 90) (void)call.step();
}
/// Reads the state: nothing but that request is sent.
void check_line(client_rig& r) {
    r.port.frames.clear();
    r.port.takes_at_most = 1000;
    CHECK(*r.drive.read<fixture::state>() == 0xBEEF);
    CHECK(r.port.frames.size() == 1);
    CHECK(r.last() == tests::framed({1, 3, 0x02, 0x00, 0, 1}));
}
static_assert(!std::is_move_constructible_v<stepped_one> && !std::is_move_constructible_v<written_one>);

} // namespace

#define STEPPED bench<scripted_port, host>, bench<scripted_port, strict>
#define BLOCKING bench<scripted_port, host, true>, bench<waiting_scripted_port, strict, true>
#define ALL STEPPED, bench<waiting_scripted_port, host>, BLOCKING

TEST_CASE_TEMPLATE("G10, G32: an exchange without room for its response is refused without a call of the "
                   "port, and no exchange writes outside its room",
                   Bench, ALL) {
    for (const byte_list& request : {read_one, write_one, write_two, framed({1, 0x41, 7})}) {
        Bench r;
        const byte_list response = request[1] == 0x41 ? framed({1, 0x41, 9}) : good_response(request);
        r.port.device = [&](scripted_port& p, const tests::sent_frame&) {
            p.say(5000, response + byte_list(4, 0x77)); // more than there is room for
        };
        byte_list memory(response.size() + 16, 0xA5);
        for (std::size_t size = 0; size < response.size(); ++size)
            CHECK(r.run(request, byte_buffer{memory}.subspan(8, size)) == status{errc::bad_argument});
        CHECK(r.port.calls == 0);
        CHECK(memory == byte_list(memory.size(), 0xA5));
        CHECK(r.run(request, byte_buffer{memory}.subspan(8, response.size())) == errc::ok);
        CHECK(memory == byte_list(8, 0xA5) + response + byte_list(8, 0xA5));
        CHECK(r.wire() == request);
    }
}

TEST_CASE_TEMPLATE("G15, G32: an exchange that has ended moves no byte when it is stepped, run or abandoned, "
                   "also while another one is under way",
                   Bench, STEPPED) {
    for (const bool is_other_under_way : {false, true}) {
        for (const errc how : {errc::ok, errc::timeout, errc::bad_argument}) {
            CAPTURE(static_cast<int>(how));
            Bench r;
            if (how == errc::timeout) r.port.device = nullptr;
            byte_list room(8, 0xA5), other_room(7);
            exchange x = r.make(write_one, byte_buffer{room}.first(how == errc::bad_argument ? 7 : 8));
            r.loop(x, 10'000);
            CHECK(x.status() == how);
            const byte_list before = r.wire(), received = room;
            r.port.device = answering(5000);
            exchange other = r.make(read_one, other_room);
            while (is_other_under_way && other.is_to_leave()) r.on.step(other, r.gaps);
            const std::uint64_t calls = r.port.calls;
            for (int i = 0; i < 5; ++i) {
                CHECK(r.on.step(x, r.gaps) == duration{});
                r.on.run(x, r.gaps);
                r.on.abandon(x);
            }
            CHECK(r.port.calls == calls);
            r.loop(other, 10'000);
            CHECK(x.status() == how);
            CHECK(other_room == one_word);
            CHECK(room == received);
            CHECK(r.wire() == before + read_one);
        }
    }
}

TEST_CASE_TEMPLATE(
    "G15, G33: an exchange that is moved, or destroyed and replaced, after any number of steps "
    "is sent once at most, and nothing is written to its memory after its end",
    Bench, STEPPED) {
    enum class fate { moved, destroyed, replaced };
    for (int begun = 0; begun < 90; ++begun) {
        for (const fate its : {fate::moved, fate::destroyed, fate::replaced}) {
            CAPTURE(begun);
            CAPTURE(static_cast<int>(its));
            Bench r;
            r.port.takes_at_most = 1;
            byte_list request = write_one, room(8), next_room(8, 0xA5);
            std::optional<exchange> x{r.make(request, room)};
            r.loop(*x, begun);
            if (x->done()) break;
            byte_list expected = r.wire() + write_two;
            if (its == fate::moved) {
                exchange moved = std::move(*x);
                r.loop(moved, 10'000, 3);
                CHECK(room == write_one);
                expected = write_one + write_two;
            } else if (its == fate::destroyed && begun != 0) {
                CHECK(r.run(read_one, next_room) == status{errc::busy});
                CHECK(next_room == byte_list(8, 0xA5));
                r.port.time += 2 * r.on.bound(11, 8, r.limits, r.gaps).us;
            }
            request.assign(8, 0xEE); // the memory is used for something else
            room.assign(8, 0x5A);
            x = r.make(write_two, next_room);
            r.loop(*x, 10'000);
            CHECK(next_room == good_response(write_two));
            CHECK(r.wire() == expected);
            CHECK(room == byte_list(8, 0x5A));
        }
    }
}

TEST_CASE_TEMPLATE("G15, G16: a port that moves one byte a call, takes none for a while, or says too early "
                   "that all has left, gets each request once",
                   Bench, ALL) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        for (const unsigned oddity : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u}) {
            CAPTURE(oddity);
            Bench r;
            const bool answers = (oddity & 1u) != 0;
            if (!answers) r.port.device = nullptr;
            r.port.says_sent_early = (oddity & 2u) != 0;
            r.port.pauses_for = (oddity & 4u) != 0 ? 1000 : 0;
            r.port.takes_at_most = r.port.gives_at_most = 1;
            const byte_list response = good_response(request), guard(8, 0xA5);
            byte_list memory(response.size() + 16, 0xA5), next_room(7);
            const status w = r.run(request, byte_buffer{memory}.subspan(8, response.size()));
            CHECK(w == status::sent(answers ? errc::ok : errc::timeout));
            CHECK(memory == guard + (answers ? response : byte_list(response.size(), 0xA5)) + guard);
            r.port.device = answering(5000);
            CHECK(r.run(read_one, next_room) == errc::ok);
            CHECK(r.wire() == request + read_one);
        }
    }
}

TEST_CASE_TEMPLATE("G16, G29: a port that takes some bytes and then no more ends the call in time: "
                   "partial_send, or send_failed if it took none",
                   Bench, BLOCKING) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        for (std::size_t taken = 0; taken < request.size(); ++taken) {
            CAPTURE(taken);
            Bench r;
            r.port.takes_in_all = taken;
            byte_list room(8, 0xA5), next_room(7);
            const std::uint64_t begun = r.port.time;
            const status w = r.run(request, room);
            CHECK(w == (taken == 0 ? status{errc::send_failed} : status::sent(errc::partial_send)));
            CHECK(r.port.time - begun <= r.on.bound(11, 8, r.limits, r.gaps).us + 200);
            CHECK(room == byte_list(8, 0xA5));
            r.port.takes_in_all = 1000;
            CHECK(r.run(read_one, next_room) == errc::ok);
            CHECK(r.port.bytes_sent() == taken + 8);
            CHECK(r.port.frames.back().data == read_one);
        }
    }
}

TEST_CASE_TEMPLATE("G32: the calls of a port grow no faster than the bytes that it moves one by one", Bench,
                   bench<waiting_scripted_port, host>, bench<waiting_scripted_port, strict>,
                   bench<waiting_scripted_port, host, true>) {
    const byte_list response = tests::read_response(1, std::vector<std::uint16_t>(120, 0x1234));
    for (const std::size_t noise : {0u, 64u, 512u, 4000u}) { // bytes that lie there before a request
        CAPTURE(noise);
        Bench r;
        r.port.takes_at_most = r.port.gives_at_most = 1;
        r.port.device = [&](scripted_port& p, const tests::sent_frame&) { p.say(5000, response); };
        for (std::size_t i = 0; i < noise; ++i) r.port.arrive(r.port.time, 0x55);
        byte_list room(response.size());
        CHECK(r.run(framed({1, 3, 0, 0, 0, 120}), room) == errc::ok);
        CHECK(room == response);
        CHECK(r.port.calls <= 6 * (noise + 8 + response.size()));
    }
}

TEST_CASE_TEMPLATE("G15, G33: of a stepped call that is destroyed after any number of steps nothing more is "
                   "sent, and nothing is written to its memory",
                   Call, stepped_one, stepped_two, written_one, written_two) {
    for (int steps = 0; steps < 400; ++steps) {
        CAPTURE(steps);
        client_rig r;
        if (steps % 2 == 0) CHECK(r.drive.read<fixture::state>()); // else a write of 06 is followed by a read
        r.port.takes_at_most = 1;
        alignas(Call) std::array<unsigned char, sizeof(Call)> memory;
        Call* call = ::new (memory.data()) Call{r.drive};
        CHECK(begin(*call) == errc::ok);
        loop(r, *call, steps);
        const bool is_done = call->done();
        call->~Call();
        memory.fill(0xA5);
        check_line(r);
        CHECK(std::count(memory.begin(), memory.end(), 0xA5) == sizeof(Call));
        if (is_done) break;
    }
}

TEST_CASE_TEMPLATE("G15, G33: a stepped write whose line has gone on without it is not sent twice, and "
                   "disturbs no other exchange",
                   Call, written_one, written_two) {
    for (const bool is_cancelled : {false, true}) {
        for (int steps = 0; steps < 60; ++steps) {
            CAPTURE(steps);
            client_rig r;
            CHECK(r.drive.read<fixture::state>());
            r.port.frames.clear();
            r.port.takes_at_most = 1;
            Call call{r.drive};
            CHECK(begin(call) == errc::ok);
            loop(r, call, steps);
            if (call.done()) break;
            const bool has_begun = r.port.bytes_sent() != 0;
            r.port.time += 5'000'000; // no longer kept for it
            check_line(r);
            stepped_read<test_client, fixture::current> other{r.drive};
            CHECK(begin(other) == errc::ok);
            while (r.port.frames.size() == 1) (void)other.step();
            if (is_cancelled) call.cancel();
            loop(r, call, 5);
            loop(r, other, 10'000);
            CHECK(other.value()->count() == 0);
            loop(r, call, 10'000);
            const errc kept = is_cancelled ? errc::busy : errc::ok; // it had not begun to leave
            CHECK(call.status() == (has_begun ? errc::timeout : kept));
            CHECK(r.port.frames.size() == (has_begun || is_cancelled ? 2 : 3)); // two are reads
        }
    }
}

TEST_CASE("G32: blocking calls while a stepped call is under way end as busy: nothing is sent, no buffer "
          "changes, and the stepped call goes on") {
    for (const std::size_t sent : {0u, 1u}) { // while it waits for its gap, or for its response
        client_rig r;
        stepped_one call{r.drive};
        CHECK(call.begin() == errc::ok);
        do (void)call.step();
        while (r.port.frames.size() < sent);
        byte_list room(4, 0xA5);
        std::array<u16, 2> words{7, 7};
        CHECK(r.drive.transact(byte_list{3, 1, 0, 0, 1}, room) == status{errc::busy});
        CHECK(r.drive.read_words(0x0100, words) == status{errc::busy});
        CHECK(r.drive.write_words(0x0100, words) == status{errc::busy});
        CHECK(room == byte_list(4, 0xA5));
        CHECK(words == std::array<u16, 2>{7, 7});
        loop(r, call, 2'000);
        CHECK(call.status() == errc::ok);
        CHECK(r.port.frames.size() == 1);
    }
}

TEST_CASE("G15: an exchange that is moved while it is under way is sent once, though both are stepped") {
    for (const int begun : {1, 20, 26}) { // it waits for its gap, or leaves
        CAPTURE(begun);
        rig<> r;
        r.settle();
        r.port.takes_at_most = 1;
        r.port.device = answering(3000);
        byte_list room(8);
        exchange x{write_one, room, r.on.timing(), r.limits};
        for (int i = 0; i < begun; ++i, r.port.time += 100) r.on.step(x, r.gaps);
        exchange moved = std::move(x);
        for (int i = 0; i < 10'000; ++i, r.port.time += 100) {
            r.on.step(x, r.gaps); // NOLINT: what is tested
            r.on.step(moved, r.gaps);
        }
        CHECK(r.port.bytes_sent() == 8);
        CHECK(moved.status() == errc::ok);
        CHECK(x.status() == errc::bad_argument);
    }
}

} // namespace bad_input_tests
