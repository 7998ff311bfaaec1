// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// All single headers in the order opposite to that of one.cpp.
#include <servobus_c630s.hpp>

#include <servobus_yako.hpp>

#include <servobus_zlac8015d.hpp>

#include <servobus.hpp>

#include "tests/packages/single/drives.hpp"

int unanswered_in_one();

int main() { return unanswered() == 3 && unanswered_in_one() == 3 ? 0 : 1; }
