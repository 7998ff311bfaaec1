// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Keeps the last end of a setpoint loop until the program takes it, and drops a failure that is the same as the one
// before.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/control/loop_report.hpp>

namespace servobus::detail {

class loop_reports {
  public:
    /// True if it is to be taken: a failure is reported once until something else has ended, or the same has succeeded.
    constexpr bool note(const loop_report& ended) {
        if (!ended.how && is_repeated(ended)) return false;
        failed_ = ended.how ? loop_report{} : ended;
        pending_ = ended;
        return true;
    }
    /// Of an end that is not reported. A failure of the same is reported again.
    constexpr void note_success(loop_part what) {
        if (failed_.what == what) failed_ = {};
    }
    constexpr loop_report take() {
        const loop_report ended = pending_;
        pending_ = {};
        return ended;
    }

  private:
    constexpr bool is_repeated(const loop_report& ended) const {
        return ended.what == failed_.what && ended.how.part() == failed_.how.part() &&
               ended.how.setting() == failed_.how.setting() &&
               servobus::status{ended.how} == servobus::status{failed_.how};
    }

    loop_report pending_{};
    loop_report failed_{};
};

} // namespace servobus::detail
