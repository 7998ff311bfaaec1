// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Examines subject, model and simulated drive before sim/conformance.hpp plays them: what is wrong with all runs is
// reported once, in a sentence, and nothing is played.
//
//     // A subject whose `restart` was forgotten:
//     struct forgotten { static void restart(int&) {} };
#pragma once

#include <cstdint>

#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/player.hpp>

namespace servobus::sim {

template <class Subject> class conformance_examination : protected conformance_player<Subject> {
    using base = conformance_player<Subject>;
    using base::broken;
    using typename base::trial_type;

  protected:
    using base::base;

    /// True if runs under this interpretation are worth while.
    bool is_fit(unsigned interpretation) {
        if (base::is_enough()) return false;
        if (examined_ == interpretation + 1) return is_fit_;
        examined_ = interpretation + 1;
        const std::uint32_t before = base::findings();
        examine(interpretation);
        is_fit_ = base::findings() == before;
        base::played_.findings = base::findings();
        return is_fit_;
    }
    /// The same for runs of which only few are without a mishap.
    bool is_fit_for_pairs(unsigned interpretation) {
        if (!is_fit(interpretation)) return false;
        const std::uint32_t before = base::findings();
        for (unsigned c = 0; c < base::cases(); ++c) (void)base::play(c, interpretation, {}, {});
        is_fit_ = base::findings() == before;
        return is_fit_;
    }

  private:
    void examine(unsigned interpretation) {
        trial_type t{interpretation};
        base::begin(t, interpretation, {}, {});
        if (!base::take_over(t)) return;
        examine_image(t);
        if (!Subject::can_be_done(interpretation, "enable") || !t.run(enable{})) return;
        base::now_.command = "restart";
        t.heal();
        Subject::restart(t.machine());
        const bool is_same = t.is_energised();
        t.live(milliseconds(1'500));
        if (Subject::shows(interpretation).restart == restart_shows::never) return;
        if (t.drive().state() != drive_state::enabled) return;
        if (is_same) {
            broken("kit", "restart(machine) changes nothing that shows: it does not switch the drive off and "
                          "on, or no witness changes");
        } else {
            broken("G21", "a restart is not seen, and the subject says that it shows");
        }
    }

    // The facade keeps a frame only if the image has all of it; the author's feedback would read beyond the image.
    void examine_image(trial_type& t) {
        if constexpr (requires { detail::model_of_facade(t.drive()); }) {
            using model = decltype(detail::model_of_facade(t.drive()));
            const unsigned begin = model::blocks.image().address, end = begin + model::blocks.image().words;
            for (const step& s : commands::prepared(read_feedback{}, t.drive().cached()).steps) {
                const unsigned first = s.address, last = first + s.count - 1u;
                if (s.what != step::kind::fetch || first >= end || last < begin) continue;
                if (first < begin || last >= end)
                    broken("kit", "read_feedback reads registers beyond the `image` of the model");
            }
        }
    }

    unsigned examined_ = 0; // the interpretation, from 1
    bool is_fit_ = false;
};

} // namespace servobus::sim
