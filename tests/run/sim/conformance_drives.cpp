// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The judges for everybody (sim/conformance.hpp) on the drives of the library: under the simulated drive's default
// interpretation of its manual, or with the label `interpretations` under each other one alone, and under
// all that the field has shown.
#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

#include <tests/support/conformance_interpretations.hpp>
#include <tests/support/conformance_judge.hpp>
#include <tests/support/conformance_subjects.hpp>

namespace conformance_tests {

using zlac8015d_read = subjects::interpretations<subjects::zlac8015d_manual>;
using yako_read = subjects::interpretations<subjects::yako_manual>;
using c630s_read = subjects::interpretations<subjects::c630s_manual>;

TEST_CASE("every single mishap at every request: ZLAC8015D" * doctest::test_suite("interpretations")) {
    judge_interpretations<subjects::wheels<zlac8015d_read>, zlac8015d_read>(1500, 2);
}
TEST_CASE("every single mishap at every request: YAKO, closed loop" *
          doctest::test_suite("interpretations")) {
    judge_interpretations<subjects::closed_axis<yako_read>, yako_read>(1800, 3);
}
TEST_CASE("every single mishap at every request: YAKO, open loop" * doctest::test_suite("interpretations")) {
    judge_interpretations<subjects::open_axis<yako_read>, yako_read>(1800, 3);
}
TEST_CASE("every single mishap at every request: C630S" * doctest::test_suite("interpretations")) {
    judge_interpretations<subjects::servo<c630s_read>, c630s_read>(4700, 7);
}

TEST_CASE("the interpretations of each manual are those of its switches") {
    CHECK(zlac8015d_read::count == zlac8015d_read::alone());
    CHECK(yako_read::count == yako_read::alone());
    CHECK(c630s_read::count == c630s_read::alone());
}

} // namespace conformance_tests
