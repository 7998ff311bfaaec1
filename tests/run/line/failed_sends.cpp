// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A blocking line whose port fails while it sends, and a stop that is sent after a response that did not match.
#include <doctest/doctest.h>

#include <servobus/line/blocking_line.hpp>

#include <tests/support/blocking_line_rig.hpp>

namespace failed_sends_tests {

using namespace servobus;
using namespace tests;
using namespace tests::blocking;

namespace {

/// Takes some bytes, fails once, and then receives what would be the response to the whole request.
struct fails_in_send : scripted_port {
    std::size_t takes = 1000;
    errc why = errc::ok; ///< how the next call fails
    byte_list then;      ///< arrives after the failure

    transfer send(bytes out) {
        if (why == errc::ok) return scripted_port::send(out);
        if (takes != 0) return scripted_port::send(out.first(std::exchange(takes, 0)));
        say_at(time + 200, then);
        return std::exchange(why, errc::ok);
    }
};

} // namespace

TEST_CASE("G13, G15, G16: a request that a port did not take whole has no response, whatever is received") {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        for (const errc why : {errc::send_failed, errc::port_lost}) {
            for (const std::size_t taken : {std::size_t{0}, std::size_t{1}, std::size_t{5}}) {
                CAPTURE(taken);
                CAPTURE(text(why));
                rig<setup<fails_in_send>> r;
                r.port.takes = taken;
                r.port.why = why;
                r.port.then = good_response(request);
                const auto e = r.run(request);
                if (taken == 0)
                    CHECK(e.why == status{why});
                else
                    CHECK(e.why == status::sent(why == errc::port_lost ? why : errc::partial_send));
                CHECK(e.response == byte_list(response_size(request), 0xA5));
                CHECK(r.port.bytes_sent() == taken);
                // What came belongs to no later request either.
                r.port.device = answering(500);
                CHECK(r.run(read_one).response == good_response(read_one));
            }
        }
    }
}

TEST_CASE("G16, G25: a stop right after a response that did not match is judged by its own response") {
    const byte_list stop = framed({0x01, 0x06, 0x20, 0x0E, 0x00, 0x07});
    const byte_list other = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x65});
    rig<setup<scripted_port>> r;
    r.port.device = saying(other, 100);
    REQUIRE(r.ask(write_one) == errc::wrong_value);
    r.priority = priority::stop;
    r.port.device = answering(100); // sooner than a gap that would end a frame
    CHECK(r.run(stop).why == status::sent(errc::ok));
}

TEST_CASE(
    "G1: a blocking line refuses a request whose quarantine is longer than its own, and sends nothing") {
    rig<setup<scripted_port>> r;
    r.port.device = answering(500);
    r.gaps.quarantine = milliseconds(101);
    CHECK(r.ask(read_one) == errc::bad_argument);
    r.gaps.quarantine = milliseconds(1000);
    CHECK(r.ask(read_one) == errc::bad_argument);
    CHECK(r.port.bytes_sent() == 0);
    r.gaps.quarantine = milliseconds(100);
    CHECK(r.ask(read_one) == errc::ok);
}

} // namespace failed_sends_tests
