// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: compares the counts of a turn that a program states with the drive's encoder lines, once it is
// taken over. zlac8015d/robot_model.hpp and zlac8015d/axes.hpp include it.
//
//     static_assert(zlac8015d::counted_model::counts_in(1024) == 4096); // 2030h, 2060h
#pragma once

#include <cstdint>

#include <servobus/device/zlac8015d/model.hpp>

namespace servobus::zlac8015d {

namespace routines {
/// What the positions count in a turn of each wheel.
inline constexpr step encoder_lines[] = {
    steps::fetch<left_encoder_lines>(0),
    steps::fetch<right_encoder_lines>(1),
};

/// Ramps that follow a stream of setpoints. The watchdog's stop, a wired one and 05h take 2084h and 2085h instead.
inline constexpr step shaped_ramps[] = {
    steps::write_arguments<left_acceleration_time, right_acceleration_time, left_deceleration_time,
                           right_deceleration_time, left_quick_stop_time, right_quick_stop_time>(),
    steps::expect_arguments<left_acceleration_time, right_acceleration_time, left_deceleration_time,
                            right_deceleration_time, left_quick_stop_time, right_quick_stop_time>(),
    steps::write<quick_stop_option_code>(quick_stop_option::fast_deceleration),
    steps::expect<quick_stop_option_code>(quick_stop_option::fast_deceleration)};
} // namespace routines

/// The model of a drive whose counts have lengths.
class counted_model : public model {
  public:
    /// Four counts a line follow from the manual's example, 20480 for five turns of 4096 (section 3.2). 0 lines count
    /// as the factory's 1024.
    static constexpr std::uint32_t counts_in(std::uint16_t lines) {
        return 4u * (lines == 0 ? 1024u : lines);
    }

  protected:
    /// The times in which the drive stops without the program, 2084h and 2085h. `init` writes them with short ramps.
    struct stop_times {
        std::uint16_t left_ms = 0; ///< 0: the ramps stay as they are
        std::uint16_t right_ms = 0;
    };

    /// As `learn`; after `init` the lines are read, and a drive that counts otherwise is not taken over.
    constexpr errc learn_counts(prepared_command& c, const ending& e, settings& known, std::uint32_t left,
                                std::uint32_t right, const stop_times& by) {
        if (e.steps.data() == routine{routines::shaped_ramps}.data()) {
            if (e.is_done) known.state = drive_state::disabled;
            return errc::ok;
        }
        if (e.steps.data() == routine{routines::encoder_lines}.data()) {
            if (!e.is_done) return errc::ok;
            const bool is_as_said = counts_in(e.words[0]) == left && counts_in(e.words[1]) == right;
            if (is_as_said && by.left_ms == 0) known.state = drive_state::disabled;
            if (is_as_said && by.left_ms != 0) {
                constexpr std::uint16_t ms = 10; // shorter than any period of setpoints on this line
                c = {.steps = routines::shaped_ramps,
                     .arguments = {ms, ms, ms, ms, by.left_ms, by.right_ms},
                     .then = effect::initialised};
            }
            return is_as_said ? errc::ok : errc::unexpected_value;
        }
        const bool is_initialised = e.is_done && c.then == effect::initialised;
        const errc found = model::learn(c, e, known);
        if (!is_initialised || known.state != drive_state::disabled) return found;
        known.state = drive_state::needs_init; // until the lines are known
        c = {.steps = routines::encoder_lines, .then = effect::initialised};
        return errc::ok;
    }
};

} // namespace servobus::zlac8015d
