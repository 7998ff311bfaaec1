// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line with a local echo must do with it (G4): exactly as many bytes as it sent are the echo, a
// changed byte is a collision, and a missing echo is reported within the time of the frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>

#include "scene.hpp"
#include "timed_sender.hpp"

namespace trial {

class echo_judge {
  public:
    explicit echo_judge(scene& on) : on_{&on} {}

    void expect() { is_expected_ = true; }

    void begins(std::uint64_t at, servobus::bytes frame) {
        if (!is_expected_) return;
        sent_.assign(frame.begin(), frame.end());
        heard_ = 0;
        differs_ = false;
        begun_ = at - on_->stalled_us;
    }
    /// Removes the echo from the received bytes and returns the rest.
    servobus::bytes take(servobus::bytes what) {
        if (!is_expected_) return what;
        const std::size_t size = std::min(what.size(), sent_.size() - heard_);
        for (std::size_t i = 0; i < size; ++i, ++heard_) differs_ = differs_ || what[i] != sent_[heard_];
        return what.subspan(size);
    }

    void concluded(servobus::errc why, std::uint32_t slack_us) const {
        using servobus::errc;
        if (!is_expected_) return;
        const bool is_whole = heard_ == sent_.size();
        if (why == errc::collision && !(is_whole && differs_))
            throw broken{"G4: a collision is reported although the echo did not differ"};
        if (why == errc::no_echo && is_whole)
            throw broken{"G4: the echo is reported missing although it has arrived"};
        if (why == errc::no_echo && !on_->does_clock_lie && !on_->has_jumped_back) check_time(slack_us);
        const bool was_awaited = why == errc::ok || why >= errc::own_echo;
        const bool may_be_given_up = why == errc::timeout && on_->may_end_early;
        if (!was_awaited || may_be_given_up) return;
        if (!is_whole) throw broken{"G4: the echo has not arrived, but the result is: " + said(why)};
        if (differs_) throw broken{"G4: the echo differs from the request, but the result is: " + said(why)};
    }

  private:
    static std::string said(servobus::errc why) { return servobus::text(why); }

    // The time limit: the frame twice, and the pause that the adapter may make. A line sleeps one character
    // at a time.
    void check_time(std::uint32_t slack_us) const {
        const std::uint64_t took = on_->now() - on_->stalled_us - begun_;
        const std::uint64_t most = on_->wire_time(2 * sent_.size()) + on_->timing.inter_byte.us +
                                   on_->timing.t3_5 + on_->wire_time(2) + 2 * slack_us + 20;
        if (took > most)
            throw broken{"G4: a missing echo is reported after " + std::to_string(took) + " us, " +
                         "the limit is " + std::to_string(most)};
    }

    scene* on_;
    byte_list sent_;
    std::uint64_t begun_ = 0;
    std::size_t heard_ = 0;
    bool differs_ = false;
    bool is_expected_ = false;
};

} // namespace trial
