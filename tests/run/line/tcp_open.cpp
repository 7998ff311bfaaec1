// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A host has several addresses: how long each is tried, and which error is returned.
#include <doctest/doctest.h>

#include <servobus/line/tcp_open.hpp>

namespace tcp_open_tests {
namespace {

using namespace servobus;

struct address {
    errc answer;
    duration takes; ///< never more than the share that it is given
    const address* ai_next = nullptr;
};

/// Connects within 3 s by a clock that wraps meanwhile.
struct attempt {
    instant now{0xFFFF'FF00u};
    duration shares[3]{};
    unsigned tried = 0;

    constexpr errc to(const address* first) {
        return connect_to_first(
            first, milliseconds(3000), [this] { return now; },
            [this](const address& a, duration within) {
                shares[tried++] = within;
                now = now + shorter_of(a.takes, within);
                return a.answer;
            });
    }
};

constexpr bool each_gets_its_share_and_the_last_error_stays() {
    const address last{errc::port_lost, {}};
    const address slow{errc::timeout, milliseconds(5000), &last};
    const address refused{errc::port_lost, milliseconds(400), &slow};
    attempt a;
    return a.to(&refused) == errc::port_lost && a.tried == 3 && a.shares[0] == milliseconds(1000) &&
           a.shares[1] == milliseconds(1300) && a.shares[2] == milliseconds(1300);
}

constexpr bool the_first_that_connects_ends_it() {
    const address never_tried{errc::port_lost, {}};
    const address good{errc::ok, milliseconds(1), &never_tried};
    const address slow{errc::timeout, milliseconds(5000), &good};
    attempt a;
    return a.to(&slow) == errc::ok && a.tried == 2;
}

constexpr bool an_address_after_the_end_gets_no_time() {
    const address last{errc::timeout, {}};
    const address stalled{errc::port_lost, {}, &last};
    attempt a;
    const errc why = connect_to_first(
        &stalled, milliseconds(3000), [&a] { return a.now; },
        [&a](const address& to, duration within) {
            a.shares[a.tried++] = within;
            a.now = a.now + milliseconds(4000); // a program that was held up
            return to.answer;
        });
    return why == errc::timeout && a.shares[1] == duration{};
}

TEST_CASE("the addresses of a host share the time to connect, and the last error is returned") {
    static_assert(each_gets_its_share_and_the_last_error_stays());
    CHECK(each_gets_its_share_and_the_last_error_stays());
    static_assert(the_first_that_connects_ends_it());
    CHECK(the_first_that_connects_ends_it());
    static_assert(an_address_after_the_end_gets_no_time());
    CHECK(an_address_after_the_end_gets_no_time());
    CHECK(attempt{}.to(nullptr) == errc::port_lost);
    CHECK(tcp_settings{}.connect_within == milliseconds(3000));
    CHECK(tcp_settings{}.baud == 0);
}

} // namespace
} // namespace tcp_open_tests
