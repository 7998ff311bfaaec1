// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Compares the positions of a feedback with the shaft of the simulated motor (G36, G39). A restart changes what the
// drive counts from. Until the program has initialised the drive again, a feedback may only have positions of the life
// before, no older than it claims.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "pilot.hpp"

namespace trial {

class position_judge {
  public:
    /// The shaft, in each iteration of the program's loop.
    void note(std::uint64_t now, const places& shaft) {
        places way{};
        for (std::size_t i = 0; !past_.empty() && i < way.size(); ++i) {
            const std::int64_t d = shaft[i] - past_.back().shaft[i];
            way[i] = past_.back().way[i] + (d < 0 ? -d : d);
        }
        past_.push_back({now, shaft, way});
        while (past_.size() > 2 && now - past_[1].at_us > longest_us) past_.pop_front();
    }
    /// The program knows the life in which the drive counts so.
    void learn(const places& shaft, const places& shown) {
        origin_ = places{shaft[0] - shown[0], shaft[1] - shown[1]};
        unseen_ = {};
    }
    /// The drive restarts: of the way since the reading before, the program knows nothing. If that reading was as near
    /// to zero as the next one is, no suspicion arises.
    void restarted(std::uint64_t now, servobus::duration between_two) {
        if (past_.empty()) return;
        for (std::size_t i = 0; i < unseen_.size(); ++i) {
            std::int64_t way = 0;
            for (auto s = past_.rbegin(); s != past_.rend() && now - s->at_us <= 2 * between_two.us; ++s)
                way = past_.back().way[i] - s->way[i];
            unseen_[i] += way;
        }
    }
    void forget() { origin_.reset(); }
    bool is_known() const { return origin_.has_value(); }

    /// The feedback has these positions, which were read at most `oldest` ago. A position that differs from the one
    /// before by no more than the way of the motor in `between_two` readings raises no suspicion.
    void judge(std::uint64_t now, servobus::duration oldest, servobus::duration between_two,
               const places& seen, std::int64_t tolerance) {
        // Positions that have not changed are judged again before they are too old.
        if (seen == judged_ && now - judged_at_ < oldest.us / 8) return;
        judged_ = seen;
        judged_at_ = now;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const std::int64_t place = seen[i] + (*origin_)[i];
            std::int64_t low = past_.back().shaft[i];
            std::int64_t high = low;
            std::int64_t way = 0;
            // The newest sample before that time counts too.
            for (auto s = past_.rbegin(); s != past_.rend(); ++s) {
                const bool is_within = now - s->at_us <= oldest.us;
                low = std::min(low, s->shaft[i]);
                high = std::max(high, s->shaft[i]);
                way = past_.back().way[i] - s->way[i];
                if (!is_within) break;
            }
            const std::int64_t parts = 1 + oldest.us / (between_two.us + 1); // readings within its age
            const std::int64_t unsuspected = tolerance + unseen_[i] + 4 * way / parts;
            if (place >= low - unsuspected && place <= high + unsuspected) continue;
            throw broken{"G39: the feedback has position " + std::to_string(seen[i]) + ", which is " +
                         std::to_string(place < low ? low - place : place - high) +
                         " from all places of the motor within its age"};
        }
    }

  private:
    struct sample {
        std::uint64_t at_us;
        places shaft;
        places way; ///< from the first sample on, in both directions
    };
    static constexpr std::uint64_t longest_us = 12'000'000;

    std::deque<sample> past_;
    places judged_{};
    places unseen_{};
    std::uint64_t judged_at_ = 0;
    std::optional<places> origin_; ///< of the shaft, where the drive counts 0
};

} // namespace trial
