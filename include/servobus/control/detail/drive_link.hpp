// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The link to a drive says whether the drive responds, and whether it is still the one that the cached settings
// describe.
//
//     up --no response for the time of the drive's watchdog--> expired --a response--> up
//     verified --a request without a response, or 500 ms--> to be checked --the witness is unchanged--> verified
#pragma once

#include <cstdint>

#include <servobus/control/supervision.hpp>
#include <servobus/core/epoch.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

/// `HasWatchdog`: the drive stops by itself when it gets no request for some time.
template <bool HasWatchdog> class drive_link {
  public:
    /// `watchdog`: the drive's own. Until it responds, it may have passed.
    constexpr explicit drive_link(duration watchdog) : watchdog_{watchdog} {}

    /// The drive's watchdog may have stopped it, and any request may end that: the first one is a stop.
    constexpr bool is_expired() const { return HasWatchdog && is_expired_; }
    /// The time of its watchdog has passed since the last request that got a response.
    constexpr bool is_overdue(instant now) const { return HasWatchdog && since(heard_, now) > watchdog_; }
    constexpr const duration& watchdog() const { return watchdog_; }
    constexpr duration& watchdog() { return watchdog_; }

    /// The drive is heard, and since the last `take_events` neither was the port lost nor a setting written.
    constexpr bool holds(instant now, epoch at) const {
        return events_ == at.events && !is_expired() && !is_overdue(now);
    }
    /// The settings are stale: `port_lost` once after each loss of the port, `needs_init` once after another client has
    /// written one of them. Several such writes between two calls count for all nodes of the line, since `changed_node`
    /// is that of the last one.
    constexpr errc take_events(epoch at, std::uint8_t changed_node, std::uint8_t address) {
        const auto more = static_cast<std::uint8_t>(at.events.changes - events_.changes);
        errc why = more == 0 ? errc::ok : errc::needs_init; // in this order: less code on a small core
        if (more == 1 && changed_node != address) why = errc::ok;
        if (events_.losses != at.events.losses) why = errc::port_lost;
        events_ = at.events;
        return why;
    }
    /// The last change was this facade's own.
    constexpr void skip_change() { ++events_.changes; }
    /// True if the time of the watchdog has passed just now.
    constexpr bool expires(instant now) {
        if (is_expired_ || !is_overdue(now)) return false;
        is_expired_ = true;
        return true;
    }
    /// A request that began to leave at `began` got a response.
    constexpr void note_response(instant began, instant now) {
        has_missed_ = false;
        heard_ = began;
        is_expired_ = is_expired_ && is_overdue(now);
    }

    /// The last request that was sent got no response.
    constexpr bool has_missed() const { return has_missed_; }
    constexpr void note_miss() { has_missed_ = true; }

    constexpr bool is_check_required() const { return is_check_required_; }
    constexpr void require_check() { is_check_required_ = true; }
    constexpr bool is_check_due(epoch at, instant now) const {
        return !is_verified(at) || since(checked_, now) > witness_period;
    }
    /// No request without a response since the last check.
    constexpr bool is_verified(epoch at) const { return !is_check_required_ && misses_ == at.misses; }
    constexpr void end_check() { is_check_required_ = false; }
    /// The witness was unchanged, or a command has set the drive up. The settings are verified as of the load of the
    /// last frame.
    constexpr void verify(std::uint16_t misses_when_loaded, instant now) {
        misses_ = misses_when_loaded;
        checked_ = now;
        is_check_required_ = false;
    }

  private:
    bool is_expired_ = HasWatchdog;
    bool is_check_required_ = false;
    bool has_missed_ = false;
    line_events events_{};
    std::uint16_t misses_ = 0; // of the epoch in which the settings were verified
    duration watchdog_;        // it goes on when the settings are invalid
    instant heard_{};          // when the last request that got a response began to leave
    instant checked_{};
};

} // namespace servobus::detail
