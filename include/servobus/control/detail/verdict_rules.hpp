// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// When the model judges an image, and what follows from its verdict.
#pragma once

#include <cstdint>

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/states.hpp>

namespace servobus::detail {

/// Lets the model judge an image, by which it may change the settings. They must be known, and no command may change
/// them.
template <class Model>
constexpr verdict judged(knowledge<Model>& known, const command_slot<Model>& slot,
                         const std::uint16_t* words) {
    return known.is_known() && !slot.is_changing() ? known.model().judge(words, known.cached())
                                                   : verdict::as_expected;
}

/// The drive has restarted, or was switched off by something else. Its motor has no power or stands, so no command
/// timeout is to stop it.
template <class Model>
[[gnu::noinline]] constexpr void note_restart(knowledge<Model>& known, command_slot<Model>& slot) {
    known.invalidate();
    slot.supervisors().end_watch();
    known.motion().note_cause(stop_cause::restart);
}
/// Notes what a verdict shows. Ends the command if the drive has stopped by itself. Returns why the drive is to be
/// stopped, or ok.
template <class Model>
constexpr errc note_verdict(verdict found, knowledge<Model>& known, command_slot<Model>& slot) {
    switch (found) {
    case verdict::as_expected: break;
    case verdict::held:
        known.motion().note_cause(stop_cause::input);
        [[fallthrough]]; // a restart may look like that
    case verdict::uncertain: known.link().require_check(); break;
    case verdict::disabled:
        note_restart(known, slot);
        if constexpr (Model::stops.after_restart) return errc::needs_init;
        slot.end_unless_reading(errc::needs_init);
        break;
    case verdict::tripped:
        known.motion().set_cause(stop_cause::fault);
        slot.end_unless_reading(errc::faulted);
        break;
    case verdict::faulted:
        if (known.motion().cause() == stop_cause::fault) break; // it was stopped for that
        known.motion().set_cause(stop_cause::fault);
        return errc::faulted;
    }
    return errc::ok;
}

} // namespace servobus::detail
