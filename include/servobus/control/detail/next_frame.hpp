// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which frame is next: decided here alone, anew in each step until its first byte leaves. It changes nothing.
#pragma once

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

template <class Model, class Line>
constexpr flight next_frame(const knowledge<Model>& known, const command_slot<Model>& slot, instant now,
                            const Line& on) {
    using polls = detail::polling<Model>;
    const polls& polling = known.polling();
    const auto& command = slot.command();
    if (slot.is_idle()) {
        if (known.link().is_expired()) return flight::none;
        if (known.is_refresh_due(now))
            return known.is_witness_due(command, now, on) ? flight::witness : flight::refresh;
        return known.link().is_check_required() && known.is_witness_due(command, now, on) ? flight::witness
                                                                                          : flight::none;
    }
    const routine_run& run = slot.run();
    if (run.is_at_repeatable_step()) return flight::step;
    if (run.is_read_back_due()) return flight::step; // before the witness
    if (run.awaits_witness() || known.is_witness_due(command, now, on)) return flight::witness;
    const auto is_poll_due = [&] {
        if constexpr (polls::has_slower) {
            if (polling.may_wait_for(slot, now)) return false;
        }
        return known.is_refresh_due(now);
    };
    const bool is_too_early = run.is_waiting() && polling.waited_too_little(now) && !is_poll_due();
    if (run.reads(image_block<Model>))
        return is_too_early && !polling.is_slower_due() ? flight::none : flight::refresh;
    const last_frame last = known.last_frame();
    // A command's write is the frame after the read on which it relies: nothing may happen between.
    const bool relies_on_it = (last == last_frame::step_read || last == last_frame::witness) &&
                              run.current().what == step::kind::write;
    if (is_poll_due() && last != last_frame::feedback && !relies_on_it) return flight::refresh;
    if constexpr (polls::has_slower) {
        if (polling.is_slower_for(run))
            return polling.is_early_for(run, now) ? flight::none : flight::refresh;
    }
    return is_too_early ? flight::none : flight::step;
}

} // namespace servobus::detail
