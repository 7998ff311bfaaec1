// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The RAM of one drive's facade: each array is as large as an object. run.sh reads the sizes from the object file.
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"

namespace {
using wire = servobus::line<uart>;
} // namespace

extern "C" {
extern const char facade_of_a_zlac8015d[sizeof(servobus::zlac8015d::drive<wire>)]{};
extern const char facade_of_a_closed_loop_yako[sizeof(servobus::yako::closed_loop::drive<wire>)]{};
extern const char facade_of_an_open_loop_yako[sizeof(servobus::yako::open_loop::drive<wire>)]{};
extern const char facade_of_a_c630s[sizeof(servobus::c630s::drive<wire>)]{};
}
