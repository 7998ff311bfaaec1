// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scripted port whose program stalls once: before one call of `now`, `receive` or `wait`.
#pragma once

#include <cstdint>

#include "scripted_port.hpp"

namespace tests {

/// Counts the calls from `sent` on, or from when the test sets `is_armed`.
template <class Base = scripted_port> struct stalling_port : Base {
    std::uint64_t stalls_at = 0; ///< the number of that call; 0: never
    std::uint32_t stall_us = 0;
    std::uint64_t called = 0;
    bool is_armed = false;
    unsigned stalls = 0;
    std::uint64_t stalled = 0; ///< when it did
    bool is_over = false;      ///< it stalled long after the last byte, where it makes no difference

    bool sent() {
        const bool is = Base::sent();
        is_armed = is_armed || (is && stalls_at != 0);
        return is;
    }
    servobus::transfer receive(servobus::byte_buffer in) { return look(), Base::receive(in); }
    servobus::instant now() { return look(), Base::now(); }
    void wait(servobus::duration d) requires servobus::waiting_port<Base> { look(), Base::wait(d); }

  private:
    void look() {
        if (stalls_at == 0 || !is_armed || called++ != stalls_at) return;
        is_over = Base::not_yet_received() == 0 && Base::time > Base::last_heard + 4'000;
        stalled = Base::time;
        Base::time += stall_us;
        ++stalls;
    }
};

} // namespace tests
