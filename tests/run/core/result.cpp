// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a result without a value says of its request: refused, not sent, or perhaps sent.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/core/result.hpp>

namespace result_tests {

using namespace servobus;

namespace {

constexpr outcome outcome_of(errc why) { return result<int>{why}.status().outcome(); }
constexpr bool all_are(outcome wanted, std::initializer_list<errc> those) {
    for (const errc why : those) {
        if (outcome_of(why) != wanted) return false;
    }
    return true;
}
/// Errors with which a call ends before any byte of a request has left.
constexpr bool are_not_sent() {
    return all_are(outcome::not_sent,
                   {errc::out_of_range, errc::inexact, errc::bad_argument, errc::needs_init,
                    errc::needs_word_order, errc::needs_homing, errc::wrong_state, errc::busy, errc::faulted,
                    errc::not_in_plan, errc::line_busy, errc::send_failed});
}
/// Errors of a request of which some or all has left, without a response that tells what became of it.
constexpr bool are_unknown() {
    return all_are(outcome::unknown,
                   {errc::partial_send, errc::receive_failed, errc::port_lost, errc::clock_stopped,
                    errc::no_echo, errc::collision, errc::own_echo, errc::timeout, errc::gateway_exception,
                    errc::truncated_response, errc::bad_crc, errc::wrong_node, errc::wrong_function,
                    errc::wrong_byte_count, errc::too_short, errc::too_long, errc::bad_gap,
                    errc::acknowledged, errc::unexpected_value});
}
static_assert(are_not_sent() && are_unknown());
static_assert(outcome_of(errc::ok) == outcome::done && outcome_of(errc::exception) == outcome::refused);

} // namespace

TEST_CASE("G16: a result's error says whether anything of its request may have been sent") {
    CHECK(are_not_sent());
    CHECK(are_unknown());
    CHECK(outcome_of(errc::exception) == outcome::refused);
    CHECK(result<int>{3}.status().outcome() == outcome::done);
}

TEST_CASE("a result keeps the exception's number, and the value that it had before it failed") {
    result<std::int16_t> r{std::int16_t{7}};
    CHECK(r);
    r.fail(status::sent(errc::exception, 0x55));
    CHECK_FALSE(r);
    CHECK(r.exception() == 0x55);
    CHECK(r.status() == status::sent(errc::exception, 0x55));
    CHECK(*r == 7);
    CHECK(r.value_or(9) == 9);
}

} // namespace result_tests
