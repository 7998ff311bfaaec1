// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random requests and responses of all functions, valid ones and those with a byte changed, lengthened or shortened: a
// judge that is written apart from the library says the same of each. A response's length is known at each of its bytes
// as the judge knows it, and no byte makes its rule ask for more than a PDU.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <map>

#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>

#include <tests/support/functions_reference.hpp>
#include <tests/support/random_functions.hpp>

namespace functions_random_tests {

using namespace servobus;
using functions_reference::byte_list;
using functions_reference::verdict;
using tests::random_functions::maker;

namespace {

unsigned exception_for(errc e) {
    if (e == errc::ok) return 0;
    return e == errc::wrong_function ? 1 : e == errc::wrong_address ? 2 : 3;
}

verdict verdict_of(errc e) {
    switch (e) {
    case errc::ok: return verdict::valid;
    case errc::exception: return verdict::exception;
    case errc::wrong_function: return verdict::other_function;
    case errc::too_short:
    case errc::too_long:
    case errc::wrong_byte_count: return verdict::other_length;
    default: return verdict::other_content;
    }
}
/// Objects that do not fill an identification are a wrong length to the library, a wrong content to the judge.
bool agree(const byte_list& asked, errc e, verdict judged) {
    if (verdict_of(e) == judged) return true;
    return asked[0] == 43 && (e == errc::too_short || e == errc::too_long) &&
           judged == verdict::other_content;
}

/// The length at each byte is the judge's, whether bytes come one by one or in pieces.
void check_length(maker& random, const byte_list& asked, const byte_list& response) {
    modbus::growing_response by_bytes{asked};
    modbus::growing_response in_pieces{asked};
    for (std::size_t have = 0; have <= response.size(); ++have) {
        const byte_list begun{response.begin(), response.begin() + static_cast<std::ptrdiff_t>(have)};
        const std::size_t least = by_bytes.least_length(begun);
        REQUIRE(least == functions_reference::least(asked, begun));
        if (random.one_in(5)) REQUIRE(in_pieces.least_length(begun) == least);
    }
}

/// Fed as it asks, it ends within so many steps, and never asks for more than a PDU has.
void check_work(const byte_list& asked, byte_list line) {
    line.resize(300);
    modbus::growing_response growing{asked};
    std::size_t have = 0;
    unsigned steps = 0;
    for (; steps < 130; ++steps) {
        const std::size_t least = growing.least_length(bytes{line}.first(have));
        REQUIRE((least >= have && least <= modbus::max_pdu));
        if (least == have) break;
        have = least;
    }
    REQUIRE(steps < 130);
}

} // namespace

TEST_CASE("100000 random requests, valid and mutated, are judged as the standard's rules say") {
    maker random{37};
    std::map<unsigned, unsigned> seen;
    for (unsigned round = 0; round < 100'000; ++round) {
        CAPTURE(round);
        byte_list pdu = random.request();
        for (unsigned i = random.below(3); i != 0; --i) pdu = random.mutated(pdu);
        const unsigned expected = functions_reference::exception_of(pdu);
        REQUIRE(exception_for(modbus::check_request(pdu).error()) == expected);
        ++seen[expected];
    }
    for (unsigned number = 0; number < 4; ++number) CHECK(seen[number] > 500);
}

TEST_CASE("100000 random responses, valid and mutated, are judged as their requests demand, and so are their "
          "lengths") {
    maker random{2026};
    std::map<verdict, unsigned> seen;
    std::map<unsigned, unsigned> valid;
    for (unsigned round = 0; round < 100'000; ++round) {
        CAPTURE(round);
        const byte_list asked = random.request();
        if (functions_reference::exception_of(asked) != 0) {
            REQUIRE(modbus::check_response(asked, random.some(random.below(12))) == errc::bad_argument);
            continue;
        }
        byte_list response = random.response(asked);
        const bool is_mutated = !random.one_in(3);
        if (is_mutated) response = random.mutated(response);
        if (random.one_in(100)) response = random.response(random.request());
        const errc found = modbus::check_response(asked, response).error();
        const verdict judged = functions_reference::judge(asked, response);
        REQUIRE(agree(asked, found, judged));
        ++seen[judged];
        if (judged == verdict::valid) ++valid[asked[0]];
        check_length(random, asked, response);
        if (judged == verdict::valid || judged == verdict::exception)
            REQUIRE(modbus::growing_response{asked}.least_length(response) == response.size());
        check_work(asked, response);
    }
    CHECK(seen.size() == 5);
    for (const auto& [judged, count] : seen) CHECK(count > 500);
    CHECK(valid.size() == functions_reference::forms().size());
    for (const auto& [code, count] : valid) CHECK(count > 500);
}

TEST_CASE("any bytes at all: no check reads outside them, and the length rule ends") {
    maker random{8};
    for (unsigned round = 0; round < 20'000; ++round) {
        const byte_list asked = random.one_in(2) ? random.request() : random.some(random.below(20));
        byte_list response = random.some(random.below(random.one_in(4) ? 300 : 16));
        if (!response.empty() && !asked.empty() && random.one_in(2)) response[0] = asked[0];
        const errc found = modbus::check_response(asked, response).error();
        if (functions_reference::exception_of(asked) == 0)
            REQUIRE(agree(asked, found, functions_reference::judge(asked, response)));
        else
            REQUIRE(found == errc::bad_argument);
        check_length(random, asked, response);
        check_work(asked, response);
    }
}

} // namespace functions_random_tests
