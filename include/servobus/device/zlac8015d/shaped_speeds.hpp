// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: setpoints of both wheels that change no faster than limits of acceleration and deceleration allow.
// The drive's own ramps cannot do that for a stream of setpoints: they begin anew with each [errata B36].
// zlac8015d/robot_model.hpp and zlac8015d/axes.hpp include it.
//
//     constexpr bool begins_slowly() { // 500 r/min in a second are 10 r/min in the first 20 ms
//         const zlac8015d::shaped_speeds shaped;
//         const auto first = shaped.towards({100, -100, false}, {}, 1, instant{});
//         return first.left_word() == 10 && first.right_word() == 0xFFF6 && !first.is_last;
//     }
#pragma once

#include <cstdint>

#include <servobus/axis/differential.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/device/zlac8015d/prepared_command.hpp>

namespace servobus::zlac8015d {

/// Limits of a wheel, or of both, in 0.1 r/min of the motor.
struct speed_limits {
    std::uint16_t acceleration = 5000; ///< in a second
    std::uint16_t deceleration = 5000; ///< likewise
    std::uint16_t top = 0x7FFF;
    std::uint16_t stop_ms = 500; ///< in which the drive stops without the program: 2084h

    /// The limits of a profile whose top speed is `top` of a motor. Errors: `bad_argument` for a profile that is not
    /// whole or has a start; `out_of_range` above 3276 r/min, 6553 r/min in a second, or 17 s.
    static constexpr result<speed_limits> of(const axis_profile& by, std::int32_t top) {
        if (!by.is_whole() || by.start.count() != 0) return errc::bad_argument;
        constexpr std::int32_t longest = 17'000;
        if (top < 0) top = -top;
        if (top > 0x7FFF || by.acceleration.count() > longest || by.deceleration.count() > longest)
            return errc::out_of_range;
        const auto up = static_cast<std::uint32_t>(by.acceleration.count());
        const auto down = static_cast<std::uint32_t>(by.deceleration.count());
        const std::uint32_t in_a_second = static_cast<std::uint32_t>(top) * 1000;
        const std::uint32_t faster = detail::divided(in_a_second, up).whole;
        const std::uint32_t slower = detail::divided(in_a_second, down).whole;
        if (faster < 1 || slower < 1 || faster > 0xFFFF || slower > 0xFFFF) return errc::out_of_range;
        speed_limits made;
        made.acceleration = static_cast<std::uint16_t>(faster);
        made.deceleration = static_cast<std::uint16_t>(slower);
        made.top = static_cast<std::uint16_t>(top);
        // An S-shaped ramp is 15/8 as steep as a straight one.
        made.stop_ms = static_cast<std::uint16_t>((15 * down + 7) / 8);
        return made;
    }
};

/// Speeds that are ordered next, in 2^-14 counts of 2088h and 2089h: what rounding to counts leaves is kept.
struct shaped_setpoint {
    std::int32_t left = 0;
    std::int32_t right = 0;
    instant begun{};
    duration step{};      ///< after the one before, as far as it counts
    bool is_last = false; ///< these are the wanted speeds

    constexpr std::uint16_t left_word() const { return word_of(left); }
    constexpr std::uint16_t right_word() const { return word_of(right); }

  private:
    static constexpr std::uint16_t word_of(std::int32_t fine) {
        return static_cast<std::uint16_t>((fine + 8192) >> 14);
    }
};

/// Speeds of both wheels as the drive shows them, 20ABh and 20ACh, in 0.1 r/min.
struct measured_speeds {
    std::int16_t left = 0;
    std::int16_t right = 0;
};

/// The last setpoint, and the limits of the next. The changes of both wheels are cut by one factor, so that both arrive
/// together.
class shaped_speeds {
  public:
    /// A setpoint that is begun later than this after the one before changes the speeds no more than one in time.
    static constexpr duration longest_step = milliseconds(100);
    /// The step of a setpoint without one before it.
    static constexpr duration first_step = milliseconds(20);

    /// Steps a drive until the next setpoint of a blocking call is due, which counts as a command of the program. False
    /// if the clock stops.
    template <class Drive> static bool pause(Drive& drive, instant begun) {
        auto guard = drive.line().new_stall_detector();
        while (since(begun, drive.line().now()) < first_step) {
            drive.machine().supervisors().note_command(drive.line().now());
            const duration idle = drive.step();
            if (guard.has_failed(drive.line().now())) return false;
            drive.line().sleep(idle);
        }
        return true;
    }

    constexpr void set_limits(const speed_limits& to) { limits_ = to; }
    constexpr const speed_limits& limits() const { return limits_; }
    /// The top speed in counts. `resolution`: the counts of a r/min.
    constexpr std::uint32_t top_in(std::uint16_t resolution) const {
        return std::uint32_t{limits_.top} * resolution * 6554 >> 16;
    }

    /// The setpoint that is begun now on the way to the wanted speeds, in counts. `resolution`: the counts of a r/min.
    /// Without a setpoint before it the way begins at the measured speeds.
    constexpr shaped_setpoint towards(const wheel_speeds& wanted, const measured_speeds& measured,
                                      std::uint16_t resolution, instant now) const {
        const std::int32_t from_left = is_known_ ? last_.left : fine_of(measured.left, resolution);
        const std::int32_t from_right = is_known_ ? last_.right : fine_of(measured.right, resolution);
        const bool is_timed = is_known_ && is_timed_;
        const duration step = is_timed ? shorter_of(since(last_.begun, now), longest_step) : first_step;
        const changes in_step{change_in(step, limits_.acceleration, resolution),
                              change_in(step, limits_.deceleration, resolution)};
        shaped_setpoint next{wanted.left * one_count, wanted.right * one_count, now, step, true};
        const std::int64_t left = next.left - from_left, right = next.right - from_right;
        const std::uint32_t part = largest_part(size_of(left), in_step.of(from_left, next.left),
                                                size_of(right), in_step.of(from_right, next.right));
        if (part == whole) return next;
        next.left = from_left + static_cast<std::int32_t>(left * part >> bits);
        next.right = from_right + static_cast<std::int32_t>(right * part >> bits);
        next.is_last = false;
        return next;
    }
    constexpr void begin(const shaped_setpoint& s) {
        last_ = s;
        is_known_ = is_timed_ = true;
    }
    /// The drive has acknowledged these words of its own speeds, which were not shaped.
    constexpr void know(std::uint16_t left, std::uint16_t right) {
        last_.left = static_cast<std::int16_t>(left) * one_count;
        last_.right = static_cast<std::int16_t>(right) * one_count;
        last_.is_last = is_known_ = true;
        is_timed_ = false;
    }
    /// Forgets the last setpoint: the speeds that the drive is to have are not known any more.
    constexpr void forget() { is_known_ = false; }
    /// True while the last setpoint leads to other speeds.
    constexpr bool is_changing() const { return is_known_ && !last_.is_last; }

  private:
    static constexpr std::int32_t one_count = 1 << 14;
    static constexpr int bits = 30; // of a part
    static constexpr std::uint32_t whole = std::uint32_t{1} << bits;

    // By how much a wheel may become faster or slower in a step.
    struct changes {
        std::uint32_t faster, slower;

        constexpr std::uint32_t of(std::int32_t from, std::int32_t to) const {
            const std::uint32_t before = size_of(from);
            const bool turns = (from < 0 && to > 0) || (from > 0 && to < 0);
            if (!turns) return size_of(to) < before ? slower : faster;
            if (before >= slower) return slower;
            const std::uint32_t lower = faster < slower ? faster : slower; // through zero
            return lower < before ? before : lower;
        }
    };

    static constexpr std::uint32_t size_of(std::int64_t v) {
        return static_cast<std::uint32_t>(v < 0 ? -v : v);
    }
    // 2^14 / 10
    static constexpr std::int32_t fine_of(std::int16_t tenths, std::uint16_t resolution) {
        return static_cast<std::int32_t>(std::int64_t{tenths} * resolution * 104'858 >> 6);
    }
    // tenths * resolution * 2^14 / 10 in a second: 1638.4e-6 is 109 951 / 2^26.
    static constexpr std::uint32_t change_in(duration step, std::uint16_t tenths, std::uint16_t resolution) {
        return static_cast<std::uint32_t>(std::uint64_t{tenths} * resolution * step.us * 109'951 >> 26);
    }
    // The largest part, in 2^-30, of which neither change exceeds its limit; bit by bit, without a division.
    static constexpr std::uint32_t largest_part(std::uint64_t left, std::uint32_t left_limit,
                                                std::uint64_t right, std::uint32_t right_limit) {
        if (left <= left_limit && right <= right_limit) return whole;
        std::uint32_t part = 0;
        for (std::uint32_t bit = whole >> 1; bit != 0; bit >>= 1) {
            const bool fits =
                left * (part | bit) >> bits <= left_limit && right * (part | bit) >> bits <= right_limit;
            if (fits) part |= bit;
        }
        return part;
    }

    shaped_setpoint last_{};
    speed_limits limits_{};
    bool is_known_ = false;
    bool is_timed_ = false; // the last one was begun at its time
};

} // namespace servobus::zlac8015d
