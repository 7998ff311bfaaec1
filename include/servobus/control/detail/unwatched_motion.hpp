// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The motion of a drive without a watchdog: the motor runs on when nothing is sent, as while the port is lost.
//
//     at rest --a motion's first frame--> may move --a stop, or a wait for a standstill, is done--> at rest
//     may move --the port is lost--> runs without port --a stop has left--> may move
#pragma once

namespace servobus::detail {

/// `HasWatchdog`: the drive stops by itself, and nothing is kept.
template <bool HasWatchdog> class unwatched_motion {
  public:
    static constexpr bool runs_without_port() { return false; }
    static constexpr void note_sent() {}
    static constexpr void note_lost_port() {}
    static constexpr void note_stop_sent() {}
    static constexpr void note_rest() {}
};
template <> class unwatched_motion<false> {
  public:
    /// The motor may move, and the port is lost, or came back just now.
    constexpr bool runs_without_port() const { return runs_without_port_; }
    /// A frame of a motion has begun to leave.
    constexpr void note_sent() { may_move_ = true; }
    constexpr void note_lost_port() { runs_without_port_ = may_move_; }
    constexpr void note_stop_sent() { runs_without_port_ = false; }
    constexpr void note_rest() { may_move_ = false; }

  private:
    bool may_move_ = false;
    bool runs_without_port_ = false;
};

} // namespace servobus::detail
