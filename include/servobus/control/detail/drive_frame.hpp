// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The purpose of a machine's frame, and what becomes of a frame whose routine is replaced. The exchange alone records
// what has left.
//
//     none --load--> waiting --first byte--> on the wire --end--> none
//     waiting --another routine--> dropped
//     a step on the wire --another routine--> drained: received, and not used; any other read goes on, and is used
#pragma once

#include <servobus/control/states.hpp>
#include <servobus/core/epoch.hpp>

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
    /// True if the line is to abandon the exchange.
    template <class Exchange> constexpr bool is_dropped(const Exchange& x) const {
        return flight_ == flight::none && !x.done();
    }
    /// True if a step of the routine has begun to leave.
    template <class Exchange> constexpr bool is_step_sent(const Exchange& x) const {
        return flight_ == flight::step && x.was_sent();
    }

    constexpr void begin(flight what, epoch at) {
        flight_ = what;
        misses_ = at.misses;
    }
    /// The misses of the node when the last frame was loaded.
    constexpr std::uint16_t misses_when_loaded() const { return misses_; }
    constexpr void drop() { flight_ = flight::none; }
    /// Lets the frame on the wire end unused, since another routine has begun.
    constexpr void drain(bool is_trigger) { flight_ = is_trigger ? flight::drained_write : flight::drained; }
    /// Ends the frame. Returns its purpose.
    constexpr flight end() {
        const flight was = flight_;
        flight_ = flight::none;
        return was;
    }

  private:
    flight flight_ = flight::none;
    std::uint16_t misses_ = 0;
};

} // namespace servobus::detail
