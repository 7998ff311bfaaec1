// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which requests the tests send, test case by test case: requests.py puts calls of it into copies of the simulated
// lines.
#pragma once

#include <cstddef>
#include <cstdint>

namespace recorder {

/// A request leaves, or a part of one that is taken byte by byte.
void request(const std::uint8_t* data, std::size_t size);

/// Tells a simulated clock whether being asked for the time takes time: only if it was asked often at the same time, so
/// that a loop that only asks ends.
class clock_use {
  public:
    bool takes_time(std::uint64_t now) {
        asked_ = now == at_ ? asked_ + 1 : 0;
        at_ = now;
        return asked_ > 500;
    }

  private:
    std::uint64_t at_ = 0;
    unsigned asked_ = 0;
};

} // namespace recorder
