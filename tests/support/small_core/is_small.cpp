// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tests of this program have the code of small cores.
#include <servobus/line/detail/chunk.hpp>

static_assert(servobus::detail::is_small_core && sizeof(servobus::detail::chunk) == 4);
