// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One call of a client as a machine: every sequence of ends of up to four requests, for each kind of call, with each
// number of retries, and with an echo ruled out before any of them. What must follow is stated here by itself.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/client/node.hpp>
#include <servobus/client/request_machine.hpp>

namespace request_machine_tests {

using namespace servobus;
using stage = request_machine::stage;

namespace {

struct device {
    static constexpr profile facts{.name = "fixture", .limits = {.corrupted_request = 9}};
};

constexpr status exception(std::uint8_t number) {
    status s = status::sent(errc::exception);
    s.set_exception(number);
    return s;
}
// How a request can end: a response, a damaged one, none, the device's word that the request was damaged, a refusal, an
// acknowledgement, and a port that failed before and after the first byte.
const std::array<status, 8> ends{status::sent(errc::ok),
                                 status::sent(errc::bad_crc),
                                 status::sent(errc::timeout),
                                 exception(9),
                                 exception(4),
                                 status::sent(errc::acknowledged),
                                 status{errc::port_lost},
                                 status::sent(errc::port_lost)};
constexpr unsigned most = 4;

struct course {
    std::vector<stage> requests;
    status end;
};

// Plays the machine: request number `i` ends with `script[i]`; an echo is ruled out from request `proven` on.
course played(request_machine call, const std::array<unsigned, most>& script, unsigned retries, bool repeats,
              unsigned proven) {
    node<device> of{1};
    of.read_retries = static_cast<std::uint8_t>(retries);
    course c;
    for (unsigned i = 0; i < most; ++i) {
        c.requests.push_back(call.now());
        c.end = ends[script[i]];
        if (!call.goes_on(c.end, of, repeats, i >= proven)) {
            CHECK(call.done());
            return c;
        }
        CHECK_FALSE(call.done());
    }
    c.requests.push_back(call.now());
    return c;
}

// A response that is worth another request: damaged, missing, or to a request that the device received damaged.
bool is_hurt(unsigned end) { return end == 1 || end == 2 || end == 3; }

template <class Check> void each_script(const Check& check) {
    std::array<unsigned, most> script{};
    for (unsigned n = 0; n < 8u * 8 * 8 * 8; ++n) {
        for (unsigned i = 0, left = n; i < most; ++i, left /= 8) script[i] = left % 8;
        for (unsigned retries = 0; retries < 3; ++retries) {
            for (unsigned proven = 0; proven <= most; ++proven) check(script, retries, proven);
        }
    }
}

} // namespace

TEST_CASE(
    "a read is repeated while its response is hurt, as often as the node says, and ends as its last one") {
    each_script([](const auto& script, unsigned retries, unsigned proven) {
        const course c = played(request_machine::read(), script, retries, false, proven);
        unsigned requests = 1;
        while (requests <= retries && is_hurt(script[requests - 1])) ++requests;
        REQUIRE(c.requests == std::vector<stage>(requests, stage::reading));
        REQUIRE(c.end == ends[script[requests - 1]]);
    });
}

TEST_CASE("G3, G15: a write leaves once; a response that may be its echo is followed by reads until one is "
          "no echo") {
    each_script([](const auto& script, unsigned retries, unsigned proven) {
        for (const bool repeats : {false, true}) {
            const course c = played(request_machine::write(), script, retries, repeats, proven);
            std::vector<stage> requests{stage::writing};
            status end = ends[script[0]];
            if (repeats && proven > 0 && end.error() == errc::ok) {
                const unsigned reads = proven <= retries + 1 ? proven : retries + 1;
                requests.insert(requests.end(), reads, stage::checking);
                end = status::sent(proven <= retries + 1 ? errc::ok : errc::own_echo);
            }
            if (requests.size() > most) continue; // longer than the script
            REQUIRE(c.requests == requests);
            REQUIRE(c.end == end);
        }
    });
}

TEST_CASE("G3: a write of a setting of the line leaves once an echo is ruled out, or never") {
    each_script([](const auto& script, unsigned retries, unsigned proven) {
        const course c = played(request_machine::write(true), script, retries, true, proven);
        const bool is_proven = proven <= retries;
        const unsigned reads = is_proven ? proven + 1 : retries + 1;
        if (reads >= most) return;
        std::vector<stage> requests(reads, stage::asking_first);
        if (is_proven) requests.push_back(stage::writing);
        REQUIRE(c.requests == requests);
        REQUIRE(c.end == (is_proven ? ends[script[reads]] : status{errc::own_echo}));
    });
}

TEST_CASE("G3: any other function is sent once, and its response is refused if it may be an echo") {
    each_script([](const auto& script, unsigned retries, unsigned proven) {
        for (const bool repeats : {false, true}) {
            const course c = played(request_machine::transaction(), script, retries, repeats, proven);
            REQUIRE(c.requests == std::vector<stage>{stage::transacting});
            const bool may_be_echo = repeats && proven > 0 && script[0] == 0;
            REQUIRE(c.end == (may_be_echo ? status::sent(errc::own_echo) : ends[script[0]]));
        }
    });
}

TEST_CASE("a call that is over, or was never begun, goes on with nothing and keeps its status") {
    for (const status& end : ends) {
        node<device> of{1};
        of.read_retries = 2;
        for (const bool is_ruled_out : {false, true}) {
            request_machine none;
            status why = end;
            CHECK_FALSE(none.goes_on(why, of, true, is_ruled_out));
            CHECK(why == end);
            CHECK(none.done());
            request_machine over = request_machine::write();
            (void)over.goes_on(why, of, false, false);
            why = end;
            CHECK_FALSE(over.goes_on(why, of, true, is_ruled_out));
            CHECK(why == end);
        }
    }
}

TEST_CASE("a look is repeated once, and only if what came was no response") {
    struct answer {
        status end;
        bool has_received;
        bool is_garbled;
    };
    const answer answers[] = {
        {status::sent(errc::ok), true, false},
        {exception(4), true, false},
        {status::sent(errc::acknowledged), true, false},
        {status::sent(errc::gateway_exception), true, false},
        {status::sent(errc::timeout), false, false},
        {status::sent(errc::timeout), true, true},
        {status::sent(errc::bad_crc), true, true},
        {status::sent(errc::wrong_byte_count), true, true},
        {status::sent(errc::receive_failed), true, true},
        {status::sent(errc::receive_failed), false, true},
        {status{errc::port_lost}, false, false},
        {status::sent(errc::port_lost), true, false},
        {status{errc::busy}, true, false},
    };
    for (const answer& first : answers) {
        for (const answer& second : answers) {
            request_machine call = request_machine::look();
            CHECK(call.now() == stage::looking);
            CHECK(call.looks_again(first.end, first.has_received) == first.is_garbled);
            CHECK(call.done() == !first.is_garbled);
            if (!first.is_garbled) continue;
            CHECK_FALSE(call.looks_again(second.end, second.has_received));
            CHECK(call.done());
        }
    }
}

TEST_CASE("G16: a call that is given up says what is known of its write") {
    request_machine read = request_machine::read();
    CHECK(read.given_up(errc::busy) == status{errc::busy});
    CHECK(read.done());
    CHECK(request_machine::write().given_up(status::sent(errc::timeout)) == status::sent(errc::timeout));
    // Nothing of the write itself was sent, whatever the read before it got.
    CHECK(request_machine::write(true).given_up(status::sent(errc::timeout)) == status{errc::busy});
    CHECK(request_machine::check().given_up(errc::busy) == status::sent(errc::own_echo));
    static_assert(sizeof(request_machine) == 2 && request_machine{}.done());
}

} // namespace request_machine_tests
