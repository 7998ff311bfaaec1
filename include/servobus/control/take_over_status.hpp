// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Says which part of a take-over failed, and how. control/take_over.hpp includes it.
//
//     void print(const take_over_status& done) { // "setting 2: no response"
//         if (done.setting() == 0) return (void)std::printf("%s: %s\n", text(done.part()), text(done.error()));
//         std::printf("%s %u: %s\n", text(done.part()), done.setting(), text(done.error()));
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/control/routine_status.hpp>

namespace servobus {

/// The parts of a take-over, and what a drive may lack at its end.
enum class take_over_part : std::uint8_t {
    init,        ///< stops the drive, reads its settings
    fault_reset, ///< of a drive with a fault, if it was asked for
    setting,     ///< a command of the list
    reading,     ///< of the feedback
    power_cycle, ///< what was set up works once the drive has been switched off and on
    set_up,      ///< the drive cannot be used before its set-up, which was not among the settings
};

constexpr const char* text(take_over_part p) {
    switch (p) {
    case take_over_part::init: return "init";
    case take_over_part::fault_reset: return "fault reset";
    case take_over_part::setting: return "setting";
    case take_over_part::reading: return "reading";
    case take_over_part::power_cycle: return "power cycle";
    case take_over_part::set_up: return "set-up";
    }
    return "unknown";
}

/// The end of a take-over.
class [[nodiscard]] take_over_status {
  public:
    constexpr take_over_status(take_over_part part, std::uint8_t setting, const routine_status& how)
        : how_{how}, part_{part}, setting_{setting} {}

    constexpr explicit operator bool() const { return static_cast<bool>(how_); }
    /// The part where it ended; `reading` if it is done.
    constexpr take_over_part part() const { return part_; }
    /// The number of the setting that failed, from 1; 0 for another part.
    constexpr unsigned setting() const { return setting_; }
    constexpr errc error() const { return how_.error(); }
    constexpr servobus::outcome outcome() const { return how_.outcome(); }
    /// The end of that part's command, with its step and register.
    constexpr routine_status command() const { return how_; }

  private:
    routine_status how_;
    take_over_part part_;
    std::uint8_t setting_;
};

} // namespace servobus
