// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the frame of a drive's machine is for. Its exchange alone records what has left.
//
//     none --load--> waiting --first byte--> on the wire --end--> none
//     waiting --another routine--> dropped; on the wire --another routine--> drained: received, and not used
#pragma once

#include <servobus/control/states.hpp>

namespace servobus::detail {

class drive_frame {
  public:
    constexpr flight purpose() const { return flight_; }

    template <class Exchange> constexpr bool is_waiting(const Exchange& x) const {
        return flight_ != flight::none && x.state() == Exchange::phase::ready;
    }
    template <class Exchange> constexpr bool is_on_the_wire(const Exchange& x) const {
        return flight_ != flight::none && x.state() != Exchange::phase::ready;
    }
    /// The exchange is not wanted any more: the line is to abandon it.
    template <class Exchange> constexpr bool is_dropped(const Exchange& x) const {
        return flight_ == flight::none && !x.done();
    }
    /// A step of the routine has begun to leave.
    template <class Exchange> constexpr bool is_step_sent(const Exchange& x) const {
        return flight_ == flight::step && x.was_sent();
    }

    constexpr void begin(flight what) { flight_ = what; }
    constexpr void drop() { flight_ = flight::none; }
    /// Another routine begins, while the frame of this one is on the wire.
    constexpr void drain(bool is_trigger) { flight_ = is_trigger ? flight::drained_write : flight::drained; }
    /// It has ended. Returns what it was for.
    constexpr flight end() {
        const flight was = flight_;
        flight_ = flight::none;
        return was;
    }

  private:
    flight flight_ = flight::none;
};

} // namespace servobus::detail
