// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The judges for everybody (sim/conformance.hpp) on the drives of the library.
#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

#include <tests/support/conformance_judge.hpp>
#include <tests/support/conformance_subjects.hpp>

namespace conformance_tests {

TEST_CASE("every single mishap at every request: ZLAC8015D") { judge<subjects::wheels<>>(1800); }
TEST_CASE("every single mishap at every request: YAKO, closed loop") { judge<subjects::closed_axis<>>(1500); }
TEST_CASE("every single mishap at every request: YAKO, open loop") { judge<subjects::open_axis<>>(1500); }
TEST_CASE("every single mishap at every request: C630S") { judge<subjects::servo<>>(4500); }

} // namespace conformance_tests
