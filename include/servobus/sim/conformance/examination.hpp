// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Examines subject, model and simulated drive before sim/conformance.hpp plays them. A fault of all runs is reported
// once, in a sentence, and nothing is played.
//
//     template <class Subject> bool is_fit(sim::conformance_player<Subject>& player) {
//         sim::conformance_examination<Subject> examination;
//         return examination.is_fit(player, 0); // the first interpretation
//     }
#pragma once

#include <cstdint>

#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/time.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/player.hpp>
#include <servobus/sim/conformance/start.hpp>
#include <servobus/sim/conformance/trial.hpp>

namespace servobus::sim {

template <class Subject> class conformance_examination {
  public:
    using player_type = conformance_player<Subject>;

    /// True if runs under this interpretation are worth while.
    bool is_fit(player_type& player, unsigned interpretation) {
        if (player.judge().is_enough()) return false;
        if (examined_ == interpretation + 1) return is_fit_;
        examined_ = interpretation + 1;
        const std::uint32_t before = player.judge().findings();
        examine(player, interpretation);
        is_fit_ = player.judge().findings() == before;
        return is_fit_;
    }
    /// The same for runs of which only few are without a mishap.
    bool is_fit_for_pairs(player_type& player, unsigned interpretation) {
        if (!is_fit(player, interpretation)) return false;
        const std::uint32_t before = player.judge().findings();
        for (unsigned c = 0; c < player.cases(); ++c) (void)player.play(c, interpretation);
        is_fit_ = player.judge().findings() == before;
        return is_fit_;
    }

  private:
    static void examine(player_type& player, unsigned interpretation) {
        auto& judge = player.judge();
        trial<Subject> t{interpretation};
        judge.begin(t, interpretation);
        if (!conformance_start{judge, t}.take_over()) return;
        examine_image(judge, t);
        if (!Subject::can_be_done(interpretation, "enable") || !t.run(enable{})) return;
        judge.name("restart");
        t.heal();
        Subject::restart(t.machine());
        const bool is_same = t.is_energised();
        t.live(milliseconds(1'500));
        if (Subject::shows(interpretation).restart == restart_shows::never) return;
        if (t.drive().state() != drive_state::enabled) return;
        if (is_same) {
            judge.broken("kit",
                         "restart(machine) changes nothing that shows: it does not switch the drive off and "
                         "on, or no witness changes");
        } else {
            judge.broken("G21", "a restart is not seen, and the subject says that it shows");
        }
    }

    // The facade keeps a frame only if the image has all of it; the author's feedback would read beyond the image.
    static void examine_image(conformance_judge<Subject>& judge, trial<Subject>& t) {
        if constexpr (requires { detail::model_of_facade(t.drive()); }) {
            using model = decltype(detail::model_of_facade(t.drive()));
            const unsigned begin = model::blocks.image().address, end = begin + model::blocks.image().words;
            for (const step& s : commands::prepared(read_feedback{}, t.drive().cached()).steps) {
                const unsigned first = s.address, last = first + s.count - 1u;
                if (s.what != step::kind::fetch || first >= end || last < begin) continue;
                if (first < begin || last >= end)
                    judge.broken("kit", "read_feedback reads registers beyond the `image` of the model");
            }
        }
    }

    unsigned examined_ = 0; // the interpretation, from 1
    bool is_fit_ = false;
};

} // namespace servobus::sim
