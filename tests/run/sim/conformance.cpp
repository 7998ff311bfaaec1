// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The judges for everybody (sim/conformance.hpp) on the winch of the example: every mishap at every request of every
// command, and random pairs of mishaps.
#include <doctest/doctest.h>

#include <examples/own_device/own_subject.hpp>
#include <tests/support/conformance_judge.hpp>

namespace conformance_tests {

TEST_CASE("every single mishap at every request: the winch of the example") { judge<winch::subject>(600); }

} // namespace conformance_tests
