// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The rule by which a command may begin now. It changes nothing. The machine also refuses commands for its address, its
// plan and the model (`admit`).
#pragma once

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/states.hpp>

namespace servobus::detail {

template <class Model>
[[gnu::always_inline]] constexpr errc refusal_of(const typename Model::prepared_command& next,
                                                 const knowledge<Model>& known,
                                                 const command_slot<Model>& slot) {
    if (next.refusal != errc::ok)
        return next.refusal == errc::wrong_state && known.is_faulted() ? errc::faulted : next.refusal;
    if (slot.is_idle() || slot.yields_to(next)) return errc::ok;
    // During a fault's stop every command but a reading of the feedback is refused for the fault.
    const bool is_for_fault = slot.by() == owner::supervisor && known.motion().cause() == stop_cause::fault &&
                              Model::kinds[next.then] != command_kind::refresh;
    return is_for_fault ? errc::faulted : errc::busy;
}

} // namespace servobus::detail
