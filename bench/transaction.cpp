// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whole transactions, from the call to the checked values. In memory only the protocol costs anything, the
// library's with all its promises; a socket pair shows libmodbus as it comes, system calls and all.
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
