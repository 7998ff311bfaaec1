// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What most tests include. tests/run.sh compiles it once and puts it in front of each test; a test includes
// what it uses all the same, so that it compiles without this.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

#include <tests/support/scripted_port.hpp>
