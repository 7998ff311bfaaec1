// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames without a line: builds requests of 06, 03 and 10h in a buffer, and checks and parses the response
// to a read of ten registers.
#include <string_view>

#include "measure.hpp"

namespace {

[[maybe_unused]] const bool measured = [] {
    for (const bench::operation& what : bench::operations) {
        if (std::string_view{what.name}.starts_with("transaction")) continue;
        for (const bench::side* const who : {&bench::servobus_side, &bench::hand_written_side})
            bench::measure(*who, what);
    }
    return true;
}();

} // namespace
