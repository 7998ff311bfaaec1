// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// All single headers in one order; two.cpp has them in the other, and is linked with this.
#include <servobus.hpp>

#include <servobus_zlac8015d.hpp>

#include <servobus_yako.hpp>

#include <servobus_c630s.hpp>

#include "tests/packages/single/drives.hpp"

int unanswered_in_one() { return unanswered(); }
