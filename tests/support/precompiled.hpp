// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The headers that most tests include, compiled once for all groups of sources. A test still includes what it uses,
// so that it compiles alone.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>
