// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random requests and responses of the functions whose response is fixed by its request, on both lines: a call of
// `transact` succeeds where a judge that is written apart from the library calls the response valid, and nowhere else.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

#include <servobus/servobus.hpp>

#include <tests/support/client_rig.hpp>
#include <tests/support/functions_reference.hpp>
#include <tests/support/random_functions.hpp>

namespace transact_functions_tests {

using namespace servobus;
using namespace tests::typed;
using functions_reference::verdict;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::random_functions::maker;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct any_line {
    using type = servobus::line<tests::waiting_scripted_port>;
    static type on(tests::waiting_scripted_port& port) { return type{port, timing}; }
};
struct small_line {
    using type = blocking_line<tests::waiting_scripted_port, timing>;
    static type on(tests::waiting_scripted_port& port) { return type{port}; }
};

bool is_judged_by_the_line(const byte_list& pdu) {
    if (pdu[0] == 8) return functions_reference::word(pdu, 1) == 0;
    return pdu[0] <= 6 || pdu[0] == 15 || pdu[0] == 16 || pdu[0] == 22 || pdu[0] == 23;
}
/// The length of the valid response, as the standard gives it.
std::size_t length_of_response(const byte_list& pdu) {
    const unsigned quantity = pdu.size() >= 5 ? functions_reference::word(pdu, 3) : 0;
    if (pdu[0] < 3) return 2 + (quantity + 7) / 8;
    if (pdu[0] < 5 || pdu[0] == 23) return 2 + std::size_t{2} * quantity;
    return pdu[0] == 8 || pdu[0] == 22 ? pdu.size() : 5;
}
} // namespace

TEST_CASE_TEMPLATE("G1, G2: a response to any function is accepted where it is what the request demands",
                   Kind, any_line, small_line) {
    maker random{26};
    std::map<unsigned, unsigned> accepted;
    std::map<unsigned, unsigned> refused;
    for (unsigned round = 0; round < 30'000; ++round) {
        CAPTURE(round);
        const byte_list asked = random.request();
        if (functions_reference::exception_of(asked) != 0 || !is_judged_by_the_line(asked)) continue;
        const std::size_t length = length_of_response(asked);
        if (asked.size() > 252 || length > 252) continue; // more than a blocking line has
        byte_list response = random.response(asked);
        if (!random.one_in(3)) response = random.mutated(response);
        if (response.size() > 253) continue;

        tests::waiting_scripted_port port;
        typename Kind::type on = Kind::on(port);
        client device_at_1{on, node<device>{1}};
        port.device = [&](scripted_port& p, const tests::sent_frame& f) {
            if (f.data == framed(byte_list{1} + asked)) p.say(500, framed(byte_list{1} + response));
        };
        std::array<std::uint8_t, 253> room{};
        const status why = device_at_1.transact(asked, byte_buffer{room}.first(length));

        const verdict judged = functions_reference::judge(asked, response);
        // A line leaves the padding of coils to those who read them.
        const bool has_padding_only = asked[0] < 3 && judged == verdict::other_content;
        const bool is_valid = judged == verdict::valid || has_padding_only;
        // Nothing has ruled out an echo on this line yet.
        const bool may_be_echo = response == asked;
        CAPTURE(asked);
        CAPTURE(response);
        const bool is_accepted = why.error() == errc::ok;
        REQUIRE(is_accepted == (is_valid && !may_be_echo));
        if (judged == verdict::exception)
            REQUIRE(why.error() == (why.exception() == 5 ? errc::acknowledged : errc::exception));
        if (is_valid && may_be_echo) REQUIRE(why.error() == errc::own_echo);
        ++(why ? accepted : refused)[asked[0]];
    }
    for (const unsigned code : {1u, 2u, 3u, 4u, 15u, 16u, 23u}) CHECK(accepted[code] > 100);
    for (const unsigned code : {1u, 2u, 3u, 4u, 5u, 6u, 8u, 15u, 16u, 22u, 23u}) CHECK(refused[code] > 100);
}

} // namespace transact_functions_tests
