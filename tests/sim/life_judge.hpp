// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges what a program is told of its drive over restarts, losses and gateway exceptions. It compares the reports of
// the facade with the simulated machine and with what the drive has executed: the ends of moves and waits (G34), the
// positions of the feedback (G36, G39), the drive's restarts (G21, G35), and what a gateway's word is worth (G16, G38).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "life_world.hpp"
#include "position_judge.hpp"

namespace trial {

class life_judge {
  public:
    life_judge(life_place& in, pilot& of) : in_{in}, of_{of} {}

    doing under_way() const { return what_; }

    /// A command of the program has begun.
    void begun(doing what) {
        what_ = what;
        follow_marker();
        of_.place().executed().clear();
        followed_ = 0;
        begun_at_ = now();
        exceptions_ = in_.between().sent();
        was_restarted_in_it_ = false;
        if (what == doing::homing) positions_.forget();
        // A stop hides a restart before it that no reading has shown, as it hides one during it.
        if (what == doing::stop && is_sought_ && !of_.shows_restarts_in_stop()) positions_.forget();
    }
    /// It has ended.
    void ended() {
        const doing what = what_;
        what_ = doing::nothing;
        const servobus::command_status& r = of_.last();
        in_.state().log->remark(now(), "   ended: " + std::string{servobus::text(r.error())} + ", " +
                                           servobus::text(r.outcome()));
        if (r) ++in_.state().count->succeeded;
        judge_outcome(what, r);
        judge_restart(what, r);
        if (what == doing::homing) end_homing(r);
        if (what == doing::arrival || what == doing::standstill) end_wait(what, r);
        if (what == doing::move && !r) of_.forget_goals();
        if (what == doing::init) end_init(r);
        if (what == doing::homing || what == doing::setting) learn_positions();
        enabled_at_ = now();
    }
    /// Something has disturbed the line or the drive.
    void disturbed() { disturbed_at_ = now(); }
    /// The drive restarts now and responds from `up_at` on.
    void restarted(std::uint64_t up_at, bool is_due) {
        follow_marker();
        auto& count = in_.state().count->lives;
        const std::size_t k = kind();
        ++count.restarts[k][played::at(what_ == doing::nothing && is_turning ? doing::turning : what_)];
        if (is_due) ++count.due[k];
        if (up_at > now()) ++count.booting[k];
        if (!of_.shows_restarts()) ++count.hidden[k];
        up_at_ = up_at;
        was_restarted_in_it_ = true;
        if (what_ == doing::save && of_.is_marker_cleared()) {
            if (!was_restarted_) hide_restart();
            return disturbed();
        }
        is_between_ = was_marker_read_ && !was_restarted_;
        was_restarted_ = true;
        is_sought_ = of_.says_enabled();
        positions_.restarted(now(), of_.between_refreshes());
        was_given_ = was_withheld_ = false;
        const bool can_show = is_sought_ ? of_.shows_restarts() : of_.shows_restarts_at_rest();
        if (!can_show || (what_ == doing::stop && !of_.shows_restarts_in_stop())) positions_.forget();
        disturbed();
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        follow_marker();
        positions_.note(now(), of_.shaft());
        hostile_device& device = of_.place().device();
        if (device.is_off() || device.losses() != losses_) disturbed();
        losses_ = device.losses();
        look_at_feedback();
        look_for_restart();
        const bool is_commanded = what_ == doing::move || what_ == doing::homing;
        if (!is_commanded && of_.has_goal() && !is_restart_hidden() &&
            of_.how() == servobus::arrival_state::reached && !of_.is_at_goal())
            throw broken{"G34: the move is said to have reached its target, but the motor is elsewhere"};
    }

    bool is_turning = false; ///< a motion without an end was commanded last

  private:
    using status = servobus::command_status;

    // A restart of a drive that is polled shows within half a second, a feedback period and two frames. One that did
    // not respond may be read once a second.
    static constexpr std::uint64_t restart_shows_us = 2'000'000;
    // Nothing has disturbed the drive for so long that its feedback is regular.
    static constexpr std::uint64_t calm_us = 3'000'000;

    std::uint64_t now() const { return in_.state().now(); }
    std::size_t kind() { return static_cast<std::size_t>(of_.place().kind()); }
    bool is_restart_hidden() const {
        const bool can_show = of_.says_enabled() ? of_.shows_restarts() : of_.shows_restarts_at_rest();
        return was_restarted_ && !can_show;
    }

    // A restart between two adjacent frames, the read of the marker and the write that sets it, cannot show.
    void follow_marker() {
        const auto& executed = of_.place().executed();
        if (followed_ > executed.size()) followed_ = 0; // a scene has cleared it
        for (; followed_ < executed.size(); ++followed_) {
            const execution& e = executed[followed_];
            const bool is_of_marker = of_.marker_register() != 0 && e.address == of_.marker_register();
            if (is_between_ && is_of_marker && e.is_write && of_.hides_restart(e.words)) hide_restart();
            is_between_ = false;
            was_marker_read_ = is_of_marker && !e.is_write;
        }
    }
    void hide_restart() {
        was_restarted_ = is_sought_ = false;
        positions_.forget();
        ++in_.state().count->lives.hidden[kind()];
    }

    // G16: `refused` means that the drive has not executed the step at which the command ended.
    void judge_outcome(doing what, const status& r) {
        if (in_.between().sent() == exceptions_ || r) return;
        const bool is_exception = r.error() == servobus::errc::exception || is_of_gateway(r.error());
        if (!is_exception || r.outcome() != servobus::outcome::refused) return;
        bool was_written = false;
        for (const execution& e : of_.place().executed())
            was_written =
                was_written || (e.is_write && e.refusal == 0 && e.transaction == in_.between().asked_by());
        if (was_written)
            throw broken{
                std::string{"G16: "} + text(what) +
                " ended refused by an exception of the gateway, but the drive has executed that write"};
    }
    // G21: only an init succeeds on a drive that was restarted since the last one.
    void judge_restart(doing what, const status& r) {
        const bool is_motion = what == doing::enable || what == doing::move || what == doing::homing;
        if (!r || !is_motion || !was_restarted_ || !of_.shows_restarts_at_rest() || begun_at_ <= up_at_)
            return;
        throw broken{std::string{"G21: "} + text(what) +
                     " is reported done by a drive that was restarted and has not been initialised"};
    }

    void end_wait(doing what, const status& r) {
        note_wait(what, r);
        if (!r || is_restart_hidden()) return;
        ++in_.state().count->arrivals;
        if (of_.stands() && of_.is_at_goal()) return;
        throw broken{std::string{"G34: "} + text(what) +
                     " is reported done, but the move has not ended at its target"};
    }
    // The first homing that nothing disturbs shows where home is.
    void end_homing(const status& r) {
        note_wait(doing::homing, r);
        if (!r || is_restart_hidden()) return;
        if (!home_ && !was_restarted_in_it_) home_ = of_.shaft()[0];
        if (!home_) return;
        of_.goal[0] = home_;
        const bool is_home = of_.is_at_goal();
        of_.forget_goals();
        if (!is_home) throw broken{"G34: a homing is reported done, but the motor is not at home"};
    }
    void note_wait(doing what, const status& r) {
        using servobus::errc;
        const wait_end e = r                                  ? wait_end::success
                           : r.error() == errc::stopped_short ? wait_end::stopped_short
                           : r.error() == errc::not_reached   ? wait_end::not_reached
                           : r.error() == errc::needs_init    ? wait_end::needs_init
                                                              : wait_end::other;
        in_.state().count->lives.note_wait(what, of_.place().kind(), e);
    }
    void end_init(const status& r) {
        if (!r) return positions_.forget();
        was_restarted_ = is_sought_ = false;
        // After a restart in it, which life it has read is not known.
        if (was_restarted_in_it_) return positions_.forget();
        learn_positions();
    }
    void learn_positions() {
        if (was_restarted_ || of_.needs_init()) return positions_.forget();
        positions_.learn(of_.shaft(), of_.shown());
    }

    void look_at_feedback() {
        if (what_ == doing::homing || !of_.says_enabled()) return;
        const std::optional<places> seen = of_.feedback();
        if (seen && positions_.is_known()) {
            ++in_.state().count->lives.feedback[kind()];
            if (is_sought_) was_given_ = true;
            positions_.judge(now(), of_.oldest(), of_.between_refreshes(), *seen, of_.tolerance);
        }
        if (is_sought_ && !seen) was_withheld_ = true;
        const bool is_calm = what_ == doing::nothing && now() > disturbed_at_ + calm_us &&
                             now() > enabled_at_ + calm_us && now() > looked_at_ + calm_us;
        if (!seen && is_calm) throw broken{"G39: nothing has disturbed the line, but there is no feedback"};
        if (!seen && what_ != doing::nothing) looked_at_ = now();
    }
    void look_for_restart() {
        if (!is_sought_) return;
        if (of_.needs_init()) {
            auto& count = in_.state().count->lives;
            ++count.found[kind()];
            if (was_withheld_) ++count.withheld[kind()];
            is_sought_ = false;
            return;
        }
        const bool is_over = what_ != doing::nothing || !of_.says_enabled();
        if (!of_.says_enabled() && !of_.shows_restarts_at_rest()) {
            is_sought_ = false;
            return positions_.forget();
        }
        if (is_over || of_.has_power() || !of_.shows_restarts()) {
            if (is_over) sought_from_ = now();
            return;
        }
        const std::uint64_t from = sought_from_ > up_at_ ? sought_from_ : up_at_;
        if (now() > from + restart_shows_us && now() > disturbed_at_ + restart_shows_us)
            throw broken{
                "G35: the drive has restarted and has no power, and has been polled for 2 s, but the "
                "facade says that it is enabled"};
    }

    life_place& in_;
    pilot& of_;
    position_judge positions_;
    std::optional<std::int64_t> home_;
    std::uint64_t begun_at_ = 0;
    std::uint64_t up_at_ = 0;
    std::uint64_t disturbed_at_ = 0;
    std::uint64_t enabled_at_ = 0;
    std::uint64_t looked_at_ = 0;
    std::uint64_t sought_from_ = 0;
    std::uint64_t exceptions_ = 0;
    unsigned losses_ = 0;
    doing what_ = doing::nothing;
    std::size_t followed_ = 0;         ///< of what the drive has executed
    bool was_marker_read_ = false;     ///< by the last request that the drive has executed
    bool is_between_ = false;          ///< the drive has restarted since, and executed nothing
    bool was_restarted_ = false;       ///< since the last init that no restart disturbed
    bool was_restarted_in_it_ = false; ///< during the last command
    bool is_sought_ = false;           ///< the drive was enabled, and the restart has not been found yet
    bool was_given_ = false;           ///< a feedback since then
    bool was_withheld_ = false;
};

} // namespace trial
