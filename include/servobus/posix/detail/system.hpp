// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: what the POSIX ports use of the system. Each of the two headers is empty on the other's systems.
#pragma once

#include <servobus/posix/detail/system_linux.hpp>
#include <servobus/posix/detail/system_portable.hpp>
