// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Where the moves of one motor must end (G34): by what the application commanded, and where the simulated motor was
// when the request that starts the move began to leave.
#pragma once

#include <cstdint>

namespace trial {

class expected_end {
  public:
    /// The application has commanded a move, by a way or to a place.
    void command(std::int64_t number, bool is_place = false) {
        number_ = number;
        is_place_ = is_place;
        has_started_ = is_endless_ = false;
        is_commanded_ = true;
    }
    /// The application has commanded a motion without an end.
    void command_endless() {
        command(0);
        is_endless_ = true;
    }
    /// The start begins to leave. `place`: of the motor. `shown`: the same as the drive counts it.
    void start(std::int64_t place, std::int64_t shown) {
        if (!is_commanded_) return;
        if (is_endless_) return forget();
        next_ = place + number_ - (is_place_ ? shown : 0);
        has_started_ = true;
    }
    /// The command was reported to have ended. A start that may have failed leaves two ends that are possible.
    void end(bool is_done) {
        if (is_commanded_ && has_started_) {
            other_ = is_done || !is_known_ ? next_ : goal_;
            goal_ = next_;
            is_known_ = true;
            is_certain_ = is_done;
        } else if (is_commanded_) {
            is_certain_ = false; // the last motion that was commanded never began
        }
        is_commanded_ = false;
    }
    /// The motor has been commanded to do something else.
    void forget() { is_known_ = is_certain_ = is_commanded_ = false; }

    bool is_known() const { return is_known_; }
    /// The last move was reported done.
    bool is_certain() const { return is_certain_ && !is_commanded_; }
    bool is_end(std::int64_t place, std::int64_t window) const {
        return is_known_ && (is_near(place, goal_, window) || is_near(place, other_, window));
    }

  private:
    static bool is_near(std::int64_t a, std::int64_t b, std::int64_t window) {
        return a - b <= window && b - a <= window;
    }

    std::int64_t number_ = 0;
    std::int64_t next_ = 0;
    std::int64_t goal_ = 0;
    std::int64_t other_ = 0;
    bool is_place_ = false;
    bool is_commanded_ = false;
    bool is_endless_ = false;
    bool has_started_ = false;
    bool is_known_ = false;
    bool is_certain_ = false;
};

} // namespace trial
