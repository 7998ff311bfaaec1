// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Complete transactions, from the call to the checked values. In memory only the protocol costs time, for
// the library including all its promises. A socket pair shows unchanged libmodbus with its system calls.
#include <string_view>

#include "measure.hpp"

namespace {

[[maybe_unused]] const bool measured = [] {
    for (const bench::operation& what : bench::operations) {
        if (!std::string_view{what.name}.starts_with("transaction")) continue;
        for (const bench::side* const who :
             {&bench::servobus_side, &bench::hand_written_side, &bench::reading_only_side,
              &bench::libmodbus_side, &bench::libmodbus_socket_side, &bench::socket_only_side})
            bench::measure(*who, what);
    }
    return true;
}();

} // namespace
