// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: what a command is, which settings the facade has cached, and how quantities become
// counts. A command is checked against the cached settings before anything is sent, and becomes a routine
// with its arguments. The headers with its commands include it; programs use the drive's state and its
// quantities.
//
//     if (servo.state() == c630s::drive_state::needs_set_up && !servo.run(c630s::set_up{})) return 1;
//     const c630s::speed top = servo.cached().max_speed * r_per_min; // P06-07
//     const c630s::segment_number chosen = checked(std::getchar() - '0');
//     if (chosen.error() != errc::ok) return 1; // not 1..16
#pragma once

#include <concepts>
#include <cstdint>

#include <servobus/control/command.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/device/c630s/assignments.hpp>
#include <servobus/device/c630s/setting_routines.hpp>

namespace servobus::c630s {

using servobus::disable, servobus::drive_state, servobus::enable, servobus::fault_reset, servobus::halt,
    servobus::init, servobus::quick_stop, servobus::read_feedback, servobus::wait_reached,
    servobus::wait_standstill;

using speed = quantity<units::r_per_min, std::int32_t>;
using time = quantity<units::millisecond, std::int32_t>;
using distance = quantity<units::reference_unit, std::int32_t>;
/// A share of the rated torque, in tenths of a percent: `50 * percent` converts to it.
using torque_share = quantity<units::percent / 10, std::int32_t>;

/// What the program has cached of the drive. Invalid after an unknown outcome or a restart.
struct cached_settings {
    drive_state state = drive_state::needs_init;
    control_mode mode = control_mode::position;
    position_source source = position_source::pulses;      ///< P05-00
    displacement_type ways = displacement_type::relative;  ///< P11-04
    bool runs_speed_segments = false;                      ///< the segments of P12, and not P06-03
    segment_mode run = segment_mode::by_input;             ///< P11-00, or P12-00 with speed segments
    std::uint16_t inputs = 0;                              ///< P31-00
    servobus::word_order word_order = word_order::unknown; ///< P0C-26
    std::uint16_t max_speed = 0;                           ///< P06-07, r/min
    std::uint16_t max_forward = 0;                         ///< P06-08, r/min
    std::uint16_t max_reverse = 0;                         ///< P06-09, r/min
    std::uint16_t positive_torque = 0;                     ///< P07-09, 0.1 %
    std::uint16_t negative_torque = 0;                     ///< P07-10, 0.1 %
    std::uint16_t brake_delay_ms = 0;                      ///< P02-09
    std::uint16_t power_off_delay_ms = 0;                  ///< P02-10

    constexpr bool is_initialised() const { return state != drive_state::needs_init; }
    /// P31-00 holds the marker: a restart shows.
    constexpr bool is_marked() const { return (inputs & terminal::marker) != 0; }
    constexpr bool chooses_speed_segments() const {
        return runs_speed_segments && run == segment_mode::by_input;
    }
    /// Segments run one after the other, without another command.
    constexpr bool runs_by_itself() const { return runs_speed_segments || run != segment_mode::by_input; }
    constexpr bool is_jogging() const {
        return (inputs & (terminal::jog_forward | terminal::jog_reverse)) != 0;
    }
};

/// What becomes of the cached settings once the routine is done.
enum class effect : std::uint8_t {
    none,
    initialised,
    looked,     ///< by `init`: a block of the set-up was read
    examined,   ///< the same by `set_up`
    keeping,    ///< writes go into the EEPROM
    block_set,  ///< a part of the set-up
    set_up,     ///< writes go into the EEPROM no more
    taken_over, ///< the end of `init`
    needs_power_cycle,
    torque_limited,
    speed_limited,
    parameter_set, ///< one word
    pair_set,      ///< two words
    enabled,
    runs_speed_segments,
    stopped, ///< by every means
    disabled,
    disabled_for_reset,
    reset, ///< the faults
    quick_stopped,
    halted,
    jog_halted,
    moved,            ///< a segment or a step was started
    runs_segments,    ///< segments were started that follow each other
    driven,           ///< by a speed or a torque
    jogged,           ///< P31-00 holds argument 1, as for the next
    segment_selected, ///< by speed
    home_looked_at,
    homed,
    home_set, ///< where the motor is
    forgotten,
    seen,    ///< feedback was read
    arrived, ///< the end of a move was waited for
    stood,   ///< and that of any motion in position control
    position_read,
    record_read,
    positions_compared,
    rivals_seen, ///< terminals that may have the function that one is to get
    assigned,    ///< a terminal's function was written
    end
};

/// A command made ready: steps and arguments, or the reason why it is refused here.
struct prepared_command {
    routine steps;
    steps::arguments arguments{};
    effect then = effect::none;
    control_mode mode = control_mode::position;
    errc refusal = errc::ok;
    stop_priority stop = stop_priority::no_stop; ///< a stop is sent in any state and replaces another command
    std::uint16_t shift = 0;
    duration limit{};
};

namespace detail {
// Not constexpr on purpose: a constant number that calls it does not compile.
inline void segments_are_numbered_1_to_16() {}
} // namespace detail

/// A segment of P11 or P12. A constant beyond 1..16 does not compile; a number of the running program enters
/// by `checked(n)`, and the command is refused (`bad_argument`) if there is no such segment.
class segment_number {
  public:
    template <std::integral N> consteval segment_number(N n) { // NOLINT: implicit, `segment{3, ...}`
        servobus::check_count<N>();
        if (n < 1 || n > 16) detail::segments_are_numbered_1_to_16();
        index_ = n >= 1 && n <= 16 ? static_cast<std::uint8_t>(n - 1) : none;
    }
    template <std::integral N>
    constexpr segment_number(checked_value<N> n) // NOLINT: implicit
        : index_{n.value >= 1 && n.value <= 16 ? static_cast<std::uint8_t>(n.value - 1) : none} {
        servobus::check_count<N>();
    }

    constexpr errc error() const { return index_ == none ? errc::bad_argument : errc::ok; }
    /// 0..15
    constexpr unsigned index() const { return index_ & 15u; }
    /// 1..16
    constexpr unsigned number() const { return index() + 1; }

  private:
    static constexpr std::uint8_t none = 0xFF;
    std::uint8_t index_ = 0;
};

namespace detail {
using servobus::commands::count_in, servobus::commands::first_error, servobus::commands::in_range,
    servobus::commands::as_word;

constexpr prepared_command refused(errc why) { return {.steps = no_steps, .refusal = why}; }

constexpr errc needs_init_done(const cached_settings& cached) {
    return cached.is_initialised() ? errc::ok : errc::needs_init;
}
/// The servo is off; set up or not.
constexpr errc needs_servo_off(const cached_settings& cached) {
    if (!cached.is_initialised()) return errc::needs_init;
    const bool is_on = cached.state == drive_state::enabled || cached.state == drive_state::quick_stopped;
    return is_on ? errc::wrong_state : errc::ok;
}
constexpr errc needs_disabled(const cached_settings& cached) {
    if (!cached.is_initialised()) return errc::needs_init;
    return cached.state == drive_state::disabled ? errc::ok : errc::wrong_state;
}
constexpr errc needs_enabled(const cached_settings& cached) {
    if (!cached.is_initialised()) return errc::needs_init;
    return cached.state == drive_state::enabled ? errc::ok : errc::wrong_state;
}
constexpr errc needs_mode(const cached_settings& cached, control_mode mode) {
    if (const errc wrong = needs_enabled(cached); wrong != errc::ok) return wrong;
    return cached.mode == mode && !cached.runs_speed_segments ? errc::ok : errc::wrong_state;
}
constexpr errc needs_positions_from(const cached_settings& cached, position_source source) {
    if (const errc wrong = needs_mode(cached, control_mode::position); wrong != errc::ok) return wrong;
    return cached.source == source ? errc::ok : errc::wrong_state;
}
constexpr errc needs_word_order(const cached_settings& cached) {
    if (!cached.is_initialised()) return errc::needs_init;
    return cached.word_order == word_order::unknown ? errc::needs_word_order : errc::ok;
}
/// P0C-26 as it has to read back: argument 5 of the routines that check it.
constexpr std::uint16_t word_order_value(const cached_settings& cached) {
    return as_word(cached.word_order == word_order::high_first ? word_order_setting::high_first
                                                               : word_order_setting::low_first);
}

/// A speed that the drive's limits let pass in its direction: P06-07 either way, P06-08 forward, P06-09 in
/// reverse.
constexpr errc within_top_speeds(std::int64_t wanted, const cached_settings& cached) {
    const std::int64_t size = wanted < 0 ? -wanted : wanted;
    const std::int64_t most = wanted < 0 ? cached.max_reverse : cached.max_forward;
    return size <= most && size <= cached.max_speed ? errc::ok : errc::out_of_range;
}

/// Two adjacent registers with one rule.
template <const auto& R, unit U>
constexpr prepared_command set_pair(routine steps, quantity<U, std::int32_t> first,
                                    quantity<U, std::int32_t> second, const cached_settings& cached) {
    const auto a = count_in<R>(first);
    const auto b = count_in<R>(second);
    return {.steps = steps,
            .arguments = {as_word(a.count), as_word(b.count)},
            .refusal = first_error(needs_init_done(cached), a.error, b.error)};
}
} // namespace detail

} // namespace servobus::c630s
