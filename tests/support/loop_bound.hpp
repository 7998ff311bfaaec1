// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The bound of a loop whose end depends on the library: a loop that does not end fails by what it waits for, and does
// not hang.
//
//     for (tests::loop_bound left{"the end of a command"}; !drive.is_idle(); left.use()) turn();
#pragma once

#include <string>

#include <doctest/doctest.h>

namespace tests {

class loop_bound {
  public:
    static constexpr unsigned long most =
        5'000'000; ///< turns: some hundred times what a loop of a test needs

    explicit loop_bound(const char* waits_for) : waits_for_{waits_for} {}
    void use() {
        if (++used_ > most) FAIL("after ", most, " turns still waiting for: ", std::string{waits_for_});
    }

  private:
    const char* waits_for_;
    unsigned long used_ = 0;
};

} // namespace tests
