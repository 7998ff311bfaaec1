// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests and responses that are told apart among captured frames, at the edges of their lengths.
#include <initializer_list>

#include <doctest/doctest.h>

#include <servobus/explain/direction.hpp>
#include <tests/support/function_cases.hpp>

namespace direction_tests {

using namespace servobus;
using tests::printed_pdu;

TEST_CASE("a response to a coil that is written with another value than FF00h repeats the whole request") {
    struct row {
        printed_pdu request;
        printed_pdu response;
        errc why;
    };
    const row rows[] = {
        {"05 00 07 55 00", "05 00 07 55 00", errc::ok},
        {"05 00 07 55 00", "05 00 07 55 01", errc::wrong_value},
        {"05 00 07 55 00", "05 00 07 FF 00", errc::wrong_value},
        {"05 00 07 55 00", "05 00 08 55 00", errc::wrong_address},
        {"05 00 07 55 00", "05 00 07 55 00 00", errc::too_long},
        {"05 00 07 55 00", "05 00 07 55", errc::too_short},
        {"05 00 07 55 00", "06 00 07 55 00", errc::wrong_function},
        {"05 00 07 55 00", "85 02", errc::exception},
        {"05 00 07 FF 00", "05 00 07 FF 00", errc::ok},
        {"05 00 07 FF 00", "05 00 07 55 00", errc::wrong_value},
    };
    for (const row& r : rows) {
        CAPTURE(&r - rows);
        CHECK(check_seen_response(r.request, r.response).error() == r.why);
    }
}

TEST_CASE("a coil may be written with any value, of five bytes") {
    struct row {
        printed_pdu request;
        errc why;
    };
    for (const row& r : {row{"05 00 07 55 00", errc::ok}, row{"05 00 07 FF 00", errc::ok},
                         row{"05 00 07 55", errc::too_short}, row{"05 00 07 55 00 00", errc::too_long},
                         row{"06 00 07 55 00", errc::ok}})
        CHECK(check_seen_request(r.request) == r.why);
}

TEST_CASE("the content of 2Bh is known for 0Eh only, that of 08 for the standard's sub-functions only") {
    struct row {
        printed_pdu pdu;
        bool is_known;
    };
    for (const row& r : {row{"2B", true}, row{"2B 0E", true}, row{"2B 0D", false}, row{"2B 0D 01", false},
                         row{"08", true}, row{"08 00 05", true}, row{"08 00 05 00 00", false},
                         row{"08 00 00 12 34", true}, row{"14 01", false}, row{"41 01", false}}) {
        CAPTURE(bytes{r.pdu}[0]);
        CHECK(is_of_known_function(r.pdu) == r.is_known);
    }
}

} // namespace direction_tests
