// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G33: from the first byte that the port takes, a request is sent for good. The program stalls while one
// leaves, and another user takes the line first. The tests check what is on the wire, not what the library
// reports.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/line/line.hpp>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/scripted_port.hpp>

namespace sent_for_good_tests {

using namespace servobus;
using namespace servobus::units;
using modbus::exchange;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list start_move = framed({0x01, 0x06, 0x20, 0x0E, 0x00, 0x10});
const byte_list one_word = tests::read_response(1, {0x0960});

/// What other users do with the line after the stall, before the owner of the leaving request does anything.
enum class intruder { asks, steps, runs, gives_up, retimes, none };
constexpr intruder intruders[]{intruder::asks,     intruder::steps,   intruder::runs,
                               intruder::gives_up, intruder::retimes, intruder::none};

struct rig {
    scripted_port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};
    line<scripted_port> on{port, modbus::timing_at(115200)};
    std::array<std::array<std::uint8_t, 16>, 3> room{};

    rig() {
        port.device = [](scripted_port& p, const tests::sent_frame& f) {
            p.say(500, f.data[1] == 0x03 ? one_word : tests::acknowledgement(f.data));
        };
    }
    rig(const rig&) = delete;
    exchange make(const byte_list& request, std::size_t which) {
        return {request, room[which], on.timing(), limits};
    }
    void finish(exchange& x) {
        while (!x.done()) on.step(x, gaps);
    }
    void intrude(intruder how, exchange& leaving) {
        exchange other = make(read_one, 1);
        switch (how) {
        case intruder::asks: (void)on.is_free(); return;
        case intruder::steps: on.step(other, gaps); return on.abandon(other);
        case intruder::runs: return on.run(other, gaps);
        case intruder::gives_up: return on.abandon(leaving);
        case intruder::retimes: return void(on.retime(modbus::timing_at(115200)));
        case intruder::none: return;
        }
    }
    /// Bytes on the wire that belong to a start: whole frames, and the beginnings of truncated ones.
    std::size_t bytes_of_starts() const {
        std::size_t n = 0;
        for (const tests::sent_frame& f : port.frames) n += f.data[1] == 0x06 ? f.data.size() : 0;
        return n;
    }
};

} // namespace

TEST_CASE(
    "G33: a request of which the port has taken a byte is sent once, whoever uses the line after a stall") {
    for (const std::uint32_t at_once : {1000u, 3u}) { // bytes that the port takes in one call
        for (const std::uint64_t stall_ms : {0u, 100u, 400u, 700u, 5'000u, 120'000u}) {
            for (const intruder how : intruders) {
                CAPTURE(at_once);
                CAPTURE(stall_ms);
                CAPTURE(static_cast<int>(how));
                rig r;
                exchange settled = r.make(read_one, 2);
                r.finish(settled);
                REQUIRE(settled.status() == errc::ok);
                r.port.frames.clear();

                r.port.takes_at_most = at_once;
                exchange x = r.make(start_move, 0);
                while (r.port.bytes_sent() == 0) r.on.step(x, r.gaps);
                const std::size_t taken = r.port.bytes_sent();
                r.port.time += stall_ms * 1000;
                r.port.takes_at_most = 1000;
                r.intrude(how, x);
                r.finish(x);

                CHECK(x.was_sent());
                CHECK(x.status().outcome() != outcome::not_sent);
                if (x.status().error() != errc::ok) CHECK(x.status().outcome() == outcome::unknown);
                CHECK((r.bytes_of_starts() == taken || r.bytes_of_starts() == 8));
                std::size_t starts = 0;
                for (const tests::sent_frame& f : r.port.frames) starts += f.data == start_move ? 1u : 0u;
                CHECK(starts <= 1);
                // And the line still works: a read gets its own response.
                exchange next = r.make(read_one, 1);
                r.finish(next);
                CHECK(next.status() == errc::ok);
                CHECK(next.words()[0] == 0x0960);
                CHECK((r.bytes_of_starts() == taken || r.bytes_of_starts() == 8));
            }
        }
    }
}

TEST_CASE("G33: a stall alone loses nothing: the response that arrived meanwhile is accepted") {
    rig r;
    exchange x = r.make(start_move, 0);
    while (r.port.bytes_sent() == 0) r.on.step(x, r.gaps);
    r.port.time += 10'000'000;
    r.finish(x);
    CHECK(x.status() == errc::ok);
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("G33: a request that is leaving takes no bytes and has no timeout, and counts as sent") {
    rig r;
    exchange x = r.make(start_move, 0);
    CHECK(x.state() == exchange::phase::ready);
    CHECK_FALSE(x.was_sent());
    x.begin_leaving();
    CHECK(x.state() == exchange::phase::leaving);
    CHECK(x.was_sent());
    CHECK(x.feed(start_move, instant{10}) == 0);
    CHECK(x.elapse(instant{2'000'000'000}) == duration{});
    CHECK(x.state() == exchange::phase::leaving);
    exchange left = r.make(start_move, 0);
    left.begin_leaving();
    left.sent(instant{20});
    CHECK(left.state() == exchange::phase::awaiting);
    left.begin_leaving(); // too late
    CHECK(left.state() == exchange::phase::awaiting);
    x.abort(errc::port_lost, false);
    CHECK(x.status().outcome() == outcome::unknown);
    x.begin_leaving(); // and after its end
    CHECK(x.done());
}

namespace {

/// Counts whole frames on the wire that begin a move of the lift: 0027h with bit 0 set.
struct start_counter {
    byte_list last;
    std::uint64_t last_at = 0;
    std::size_t starts = 0;

    static void note(void* self, const sim::wire_byte& b) {
        auto& me = *static_cast<start_counter*>(self);
        if (!b.is_from_client) return;
        if (b.at_us > me.last_at + 1500) me.last.clear();
        me.last_at = b.at_us;
        me.last.push_back(b.value);
        if (me.last.size() == 8 && me.is_control_word() && (me.last[5] & 1u) != 0) ++me.starts;
    }
    /// True once the last frame shows that it is a write of 0027h.
    bool is_control_word() const {
        return last.size() >= 4 && last[0] == 2 && last[1] == 0x06 && last[2] == 0x00 && last[3] == 0x27;
    }
};

} // namespace

TEST_CASE("G15, G33: a move under a bus is sent once, at whichever byte of its start the program stalls") {
    for (const std::uint32_t stall_ms : {30u, 400u, 650u, 900u, 3'000u}) {
        for (std::size_t at_byte = 4; at_byte <= 9; ++at_byte) { // 9: one loop iteration after the last byte
            for (std::uint32_t turns = 0; turns < 2; ++turns) {
                CAPTURE(stall_ms);
                CAPTURE(at_byte);
                tests::wheels_and_lift machine;
                tests::wheels_and_lift_program p{machine.wire};
                REQUIRE(p.command(p.wheels, init{}));
                REQUIRE(p.command(p.lift, init{}));
                REQUIRE(p.command(p.lift, enable{}));
                start_counter counter;
                machine.wire.set_hook(&start_counter::note, &counter);
                const std::int64_t before = machine.lift_model.view().commanded;
                REQUIRE(p.lift.begin(move_by{5000 * pulse}) == errc::ok);
                while (!counter.is_control_word() || counter.last.size() < (at_byte < 8 ? at_byte : 8))
                    p.turn();
                for (std::uint32_t i = 0; i < turns + at_byte / 9; ++i) p.turn();
                machine.wire.pass(milliseconds(stall_ms));
                p.run(500);
                while (machine.lift_model.view().is_moving) p.run(100);
                CHECK(counter.starts == 1);
                CHECK(machine.lift_model.view().commanded - before == 5000);
                CHECK(p.lift.is_idle());
                if (!p.lift.last()) CHECK(p.lift.last().outcome() == outcome::unknown);
            }
        }
    }
}

TEST_CASE("G21: a start without a response that a stop cuts short leaves the drive to be initialised") {
    for (const bool is_heard : {false, true}) {
        CAPTURE(is_heard);
        tests::wheels_and_lift machine;
        tests::wheels_and_lift_program p{machine.wire};
        REQUIRE(p.command(p.wheels, init{}));
        REQUIRE(p.command(p.lift, init{}));
        REQUIRE(p.command(p.lift, enable{}));
        start_counter counter;
        machine.wire.set_hook(&start_counter::note, &counter);
        REQUIRE(p.lift.begin(move_by{5000 * pulse}) == errc::ok);
        while (!counter.is_control_word()) p.turn();
        if (!is_heard) { // it restarts while the start leaves, and responds again to the stop
            machine.wire.set_connected(1, false);
            machine.lift_model.power_cycle();
        }
        REQUIRE(p.lift.begin(disable{}) == errc::ok);
        p.run(40); // the start's response is overdue by then
        machine.wire.set_connected(1, true);
        while (!p.lift.is_idle()) p.turn();
        CHECK(p.lift.last());
        p.run(2000);
        CHECK((p.lift.state() == yako::drive_state::needs_init) == !is_heard);
        CHECK((p.lift.begin(enable{}) == errc::ok) == is_heard);
    }
}

} // namespace sent_for_good_tests
