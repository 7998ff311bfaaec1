// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How often a program's own requests beside a bus are sent to nodes that do not respond. Judged by the frames on the
// wire.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <servobus/bus/bus.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/device/yako.hpp>

#include <tests/support/loop_bound.hpp>
#include <tests/support/scripted_port.hpp>

namespace absent_own_requests_tests {

using namespace servobus;
using tests::waiting_scripted_port;

namespace {

using sensor = yako::closed_loop::device;
using wire = scheduled_line<waiting_scripted_port>;

constexpr node<sensor> at(std::uint8_t address) {
    node<sensor> n{address};
    n.limits.response = milliseconds(20);
    n.gaps.quarantine = milliseconds(10);
    return n;
}
/// The bus reads node 2. Node 3 has reads and own requests, nodes 9 and 10 own requests only.
template <std::uint32_t RetryMs>
constexpr poll_plan plan{modbus::timing_at(115200),
                         cyclic<yako::status_word>(at(2), milliseconds(100)),
                         cyclic<yako::status_word>(at(3), milliseconds(200)),
                         own_requests(at(3), milliseconds(50), 1),
                         own_requests(at(9), milliseconds(50), 1),
                         own_requests(at(10), milliseconds(50), 1),
                         back_off{.retry_every = milliseconds(RetryMs)}};

/// A program that reads a node every 100 ms.
struct asking {
    client<wire, sensor> node;
    stepped_read<client<wire, sensor>, yako::error_code> read{node};
    std::uint64_t next = 0;

    asking(wire& on, std::uint8_t address) : node{on, at(address)} {}

    duration step(std::uint64_t now) {
        if (!read.done()) return read.step();
        if (now < next) return milliseconds(1);
        next = now + 100'000;
        REQUIRE(read.begin() == errc::ok);
        return {};
    }
};

/// A program beside the bus of a plan, and the nodes that respond.
template <std::uint32_t RetryMs> struct rig {
    waiting_scripted_port port;
    wire on{port, modbus::timing_at(115200)};
    bus<plan<RetryMs>, wire> all{on};
    asking both{on, 3};
    asking first{on, 9};
    asking second{on, 10};
    bool responds[11]{};

    rig() {
        responds[2] = true;
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) {
            if (responds[f.data[0]]) p.say(500, tests::read_response(f.data[0], {0}));
        };
    }
    rig(const rig&) = delete;
    rig& operator=(const rig&) = delete;

    void run_for(std::uint32_t ms) {
        for (const std::uint64_t end = port.time + std::uint64_t{ms} * 1000; port.time < end;) {
            duration idle = all.step();
            for (asking* a : {&both, &first, &second}) idle = shorter_of(idle, a->step(port.time));
            port.wait(longer_of(idle, microseconds(50)));
        }
    }
    /// Requests of the program, which reads another register than the bus.
    std::size_t asked(std::uint8_t address) const {
        std::size_t n = 0;
        for (const tests::sent_frame& f : port.frames)
            n += f.data[0] == address && f.data[3] == (yako::error_code.address & 0xFFu) ? 1u : 0u;
        return n;
    }
};

template <std::uint32_t RetryMs> void judge() {
    CAPTURE(RetryMs);
    rig<RetryMs> r;
    r.run_for(1000); // until all but node 2 count as absent
    REQUIRE(r.asked(9) >= 3);
    REQUIRE(r.asked(10) >= 3);
    r.port.frames.clear();
    constexpr std::size_t expected = 12'000 / RetryMs;
    r.run_for(12'000);
    for (const std::uint8_t node_address : {std::uint8_t{9}, std::uint8_t{10}}) {
        CAPTURE(static_cast<int>(node_address));
        // A window is kept to about 0.13 s.
        CHECK(r.asked(node_address) >= 12'000 / (RetryMs + 200));
        CHECK(r.asked(node_address) <= expected + expected / 4 + 1);
    }
    CHECK(r.all.is_absent(3));
    CHECK(r.asked(3) >= 80); // one that the bus reads too is not held back
    r.responds[9] = true;
    r.run_for(RetryMs + 300);
    r.port.frames.clear();
    r.run_for(2000);
    CHECK(r.asked(9) >= 18); // at its own rate again, and it alone
    CHECK(r.asked(10) <= 2000 / RetryMs + 2);
}

} // namespace

TEST_CASE("G28: nodes of own requests that are gone are asked once in each retry period of the plan, each of "
          "them") {
    judge<500>();
    judge<1000>();
    judge<2000>();
}

TEST_CASE(
    "G25: a request beside the bus may have the gaps of its plan and shorter ones, and no longer ones") {
    struct scene {
        bus_gaps wanted;
        bool is_sent;
    };
    static constexpr node<sensor> asked = at(9);
    constexpr bus_gaps own = asked.gaps;
    for (const scene& s : {scene{own, true},
                           {{.gap = own.gap, .quarantine = {}}, true},
                           {{.gap = own.gap, .quarantine = own.quarantine + microseconds(1)}, false},
                           {{.gap = own.gap + microseconds(1), .quarantine = own.quarantine}, false}}) {
        CAPTURE(s.wanted.gap.us);
        CAPTURE(s.wanted.quarantine.us);
        rig<1000> r;
        r.responds[9] = true;
        std::uint8_t response[7]{};
        const auto request = modbus::read_frame(9, yako::error_code.address, 1);
        modbus::exchange x{request, response, r.on.timing(), asked.limits};
        for (tests::loop_bound left{"a request"}; !x.done(); left.use()) {
            const duration idle = shorter_of(r.on.step(x, s.wanted), r.all.step());
            r.port.wait(longer_of(idle, microseconds(50)));
        }
        CHECK(x.status().error() == (s.is_sent ? errc::ok : errc::not_in_plan));
        CHECK(r.asked(9) == (s.is_sent ? 1u : 0u));
    }
}

TEST_CASE(
    "G28: a node of own requests is gone after three misses in a row, and after one response it is not") {
    rig<2000> r;
    r.responds[9] = true;
    r.run_for(500);
    r.responds[9] = false;
    r.port.frames.clear();
    r.run_for(500); // five requests at its own rate
    // The fourth request is that of the window in which it has not been asked yet.
    CHECK(r.asked(9) >= 3);
    CHECK(r.asked(9) <= 4);
    for (int round = 0; round < 4; ++round) {
        CAPTURE(round);
        r.responds[9] = true;
        r.run_for(2500);
        r.port.frames.clear();
        for (int lost = 0; lost < 2; ++lost) {
            const std::size_t before = r.asked(9);
            r.responds[9] = false;
            for (tests::loop_bound left{"a request"}; r.asked(9) == before; left.use()) r.run_for(1);
            r.run_for(50); // its response is overdue
        }
        r.responds[9] = true;
        r.run_for(1000);
        CHECK(r.asked(9) >= 10);
    }
}

} // namespace absent_own_requests_tests
