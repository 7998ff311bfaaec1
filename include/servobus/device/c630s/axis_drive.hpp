// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: a drive that moves an axis, in lengths and speeds of the machine. Programs include it beside or in
// place of servobus/device/c630s.hpp.
//
//     constexpr auto ram = axis::of(lead(5_mm, counts_per_turn{10'000})); // P05-02: reference units of a turn
//     c630s::axis_drive press{wire, 3, ram};
//     if (!press.run(c630s::axis_segment{1, 75_mm, 50_mm_per_s, 100_ms})) return 1;
//     const axis_arrival down = press.run(c630s::start_segment{1}, wait_reached{});
//     if (down.how == arrival_state::stopped_short) std::printf("%ld um above\n", long(down.missing.count()));
#pragma once

#include <cstdint>

#include <servobus/axis/axis_place.hpp>
#include <servobus/control/axis_command.hpp>
#include <servobus/control/axis_commands.hpp>
#include <servobus/control/axis_facade.hpp>
#include <servobus/device/c630s/drive.hpp>
#include <servobus/device/c630s/soft_limits.hpp>

namespace servobus::c630s {

namespace routines {
inline constexpr step stands[] = {must_stand};
/// What a reference unit is worth: P05-02, and the first gear, in one frame.
inline constexpr step reference_units[] = {
    steps::fetch<pulses_per_revolution, position_low_pass_time, position_step, position_average_time,
                 gear_1_numerator, gear_1_denominator>(),
};
/// Words that it reads.
enum reference_word : std::uint8_t { pulses_at = 0, numerator_at = 5, denominator_at = 7 };
} // namespace routines

/// The resolution of the motor's encoder, which the drive does not report: with P05-02 = 0 the gear refers to it.
enum class encoder_counts : std::uint32_t {
    unknown = 0, ///< a drive with P05-02 = 0 is not taken over
    of_17_bits = std::uint32_t{1} << 17,
    of_23_bits = std::uint32_t{1} << 23,
};

/// A prepared command that may be a part of a move of an axis.
struct axis_command : servobus::axis_command<prepared_command> {
    using servobus::axis_command<prepared_command>::axis_command;

    bool starts = false;   ///< the segment that it sets is started then
    std::int32_t target{}; ///< where that ends, if `is_place`
    bool is_place = false;
    soft_limits limits{}; ///< that it sets, or none
};

/// The model of a drive that moves an axis.
class axis_model : public model {
  public:
    using prepared_command = axis_command;

    /// The segment of `move_to` and `move_by`.
    static constexpr segment_number own_segment{16};

    constexpr axis_place& place() { return place_; }
    constexpr const axis_place& place() const { return place_; }
    constexpr void set_encoder(encoder_counts of) { encoder_ = of; }
    constexpr const soft_limits& limits() const { return limits_; }

    constexpr void note(const block_feedback& r, const settings& known) {
        if (r.block == position_block)
            place_.follow(join_words(r.words[0], r.words[1], known.word_order), r.epoch);
    }
    static constexpr prepared_command stop_for(stop_priority priority, const settings& known,
                                               bool has_watchdog_expired) {
        return model::stop_for(priority, known, has_watchdog_expired);
    }
    /// Nothing ends a speed or a run of segments at a limit: the drive has none, and the line may be lost.
    constexpr errc admit(prepared_command& c, duration lost) {
        if (c.starts) preempt(c); // the move before is the last one no more
        const bool is_endless = kinds[c.then] == command_kind::endless_motion || kinds.moves(c.then);
        if (limits_.are_set() && is_endless) return errc::bad_argument;
        if (c.starts && c.is_place && limits_.passed_by(c.target) != travel_end::none)
            return errc::out_of_range;
        return model::admit(c, lost);
    }
    /// Any move, once it has read from where it goes.
    constexpr errc permit(const prepared_command& c, const situation& now, const settings& known) const {
        const errc found = model::permit(c, now, known);
        if (found != errc::ok) return found;
        const bool is_beyond = limits_.passed_by(target_of(now.words, known)) != travel_end::none;
        return is_beyond ? errc::out_of_range : errc::ok;
    }
    /// A drive whose reference units are worth something else than the program says is not taken over.
    constexpr errc learn(prepared_command& c, const ending& e, settings& known) {
        const bool is_look = e.steps.data() == routine{routines::reference_units}.data();
        if (is_look && e.is_done) {
            if (!is_as_said(e.words, known.word_order)) {
                known = unknown;
                return errc::unexpected_value;
            }
            known.state = found_;
            return errc::ok;
        }
        const prepared_command was = c;
        c.starts = c.carries = false;
        c.limits = {};
        const errc found = model::learn(c, e, known);
        if (!e.is_done || found != errc::ok) return found;
        // A gear: what its units are worth is compared by the next `init`.
        if (was.then == effect::pair_set) known = unknown;
        if (was.then == effect::taken_over) {
            found_ = known.state;
            known.state = drive_state::needs_init; // until the units are known
            c = c630s::prepared_command{.steps = routines::reference_units, .then = effect::taken_over};
        } else if (was.starts) {
            c = start_segment{own_segment}.prepare(known);
            c.rest = was.rest;
            c.carries = was.carries;
            if (c.refusal != errc::ok) c.steps = no_steps;
            return c.refusal;
        } else if (was.carries) {
            place_.keep(was.rest);
        } else if (was.limits.are_set()) {
            limits_ = was.limits;
        }
        return errc::ok;
    }

  private:
    constexpr bool is_as_said(slice<const std::uint16_t> w, word_order order) const {
        using namespace routines;
        const auto number = [&](std::size_t at) -> std::uint64_t {
            return join_words(w[at], w[at + 1], order);
        };
        const std::uint64_t said = place_.geometry().counts_of_motor_turn();
        if (number(pulses_at) != 0) return number(pulses_at) == said;
        return encoder_ != encoder_counts::unknown &&
               said * number(numerator_at) == static_cast<std::uint64_t>(encoder_) * number(denominator_at);
    }

    axis_place place_{};
    soft_limits limits_{};
    encoder_counts encoder_ = encoder_counts::unknown;
    drive_state found_ = drive_state::needs_init; // by `init`
};

namespace detail {
/// The speed of a motor in whole r/min.
struct whole_speed {
    std::int32_t value = 0;
    errc error = errc::ok;
};
constexpr whole_speed speed_on(const axis& on, micrometres_per_second wanted) {
    const result<std::int32_t> whole = on.motor_counts_of(wanted, 1);
    if (!whole) return {0, whole.error()};
    return {*whole, *whole == 0 && wanted.count() != 0 ? errc::out_of_range : errc::ok};
}
} // namespace detail

/// Sets a position segment in the machine's units, as `segment`: a place, or a way where `position_segments` says so.
/// Errors: as `segment`; `out_of_range`.
struct axis_segment {
    segment_number number;
    micrometres way;
    micrometres_per_second at; ///< above 0, to the nearest r/min of the motor
    time ramp{10};             ///< 0..65535 ms
    time wait{10};             ///< after it, 0..10000 ms
};
constexpr axis_command plan_on_axis(const axis_segment& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const axis& on = at.geometry();
    const result<std::int32_t> counts = on.counts_of(wanted.way);
    const auto to = detail::speed_on(on, wanted.at);
    const std::int32_t size = on.is_mirrored() ? -to.value : to.value;
    axis_command c =
        segment{wanted.number, distance{counts.value_or(0)}, speed{size}, wanted.ramp, wanted.wait}.prepare(
            known);
    c.refusal = detail::first_error(c.refusal, counts.error(), to.error);
    return c;
}

namespace detail {
/// Sets the axis' own segment and starts it.
constexpr axis_command move_on_axis(const result<std::int32_t>& counts, const axis_profile& by,
                                    displacement_type ways, const axis_place& at,
                                    const cached_settings& known) {
    const axis& on = at.geometry();
    const auto to = speed_on(on, by.top);
    const std::int32_t size = on.is_mirrored() ? -to.value : to.value;
    const bool is_uneven = by.acceleration != by.deceleration || by.start.count() != 0;
    axis_command c = segment{
        axis_model::own_segment, distance{counts.value_or(0)}, speed{size}, by.acceleration,
        time{0}}.prepare(known);
    c.refusal = first_error(start_segment{axis_model::own_segment}.prepare(known).refusal,
                            known.ways == ways ? errc::ok : errc::wrong_state,
                            !by.is_whole() || is_uneven ? errc::bad_argument : errc::ok, counts.error(),
                            first_error(to.error, c.refusal));
    c.starts = true;
    if (c.refusal != errc::ok) c.then = effect::moved; // it ends the arrival of the move before
    return c;
}
} // namespace detail

/// To a place from the drive's home: sets segment 16 and starts it. Both ramps take the same time, and a motor has no
/// speed at which it begins. Errors: as `segment` and `start_segment`; `wrong_state` where segments are ways;
/// `bad_argument` without a profile, or with another one; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_move_to& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const result<std::int32_t> counts = at.geometry().counts_of(wanted.place);
    axis_command c = detail::move_on_axis(counts, wanted.by, displacement_type::absolute, at, known);
    c.target = counts.value_or(0);
    c.is_place = true;
    return c;
}
/// As `move_to`, where segments are ways.
constexpr axis_command plan_on_axis(const axis_move_by& wanted, const axis_place& at,
                                    const cached_settings& known) {
    std::int32_t rest = 0;
    const result<std::int32_t> counts = at.plan(wanted.way, rest);
    axis_command c = detail::move_on_axis(counts, wanted.by, displacement_type::relative, at, known);
    c.rest = rest;
    c.carries = true;
    return c;
}
/// In speed mode, in whole r/min of the motor. Errors: as `velocity`; `out_of_range`.
constexpr axis_command plan_on_axis(const axis_velocity& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const auto to = detail::speed_on(at.geometry(), wanted.target);
    axis_command c = prepare(motor_velocity{speed{to.value}}, known);
    c.refusal = detail::first_error(to.error, c.refusal);
    return c;
}

/// Limits the travel of the axis by software, which the drive cannot. The library refuses each move that would end
/// beyond a limit, also the start of a segment (`out_of_range`; `axis_drive::end_passed_by` names the limit). It
/// refuses each speed (`bad_argument`): nothing would end it there. A place is refused before anything is sent, a way
/// once the drive's position has been read. The limits hold until others are set, also over an `init`. They count
/// from the drive's home, as places do. The command reads the drive's speed: `busy` while it turns. They are not for
/// a `home`, a `set_home`, or pulses of a wired source. Whether the axis has been homed since its power-on is not
/// asked: home it first. Errors: `bad_argument` if `lowest` is not below `highest`; `out_of_range` beyond
/// 1073741824 reference units.
constexpr axis_command plan_on_axis(const limit_travel<micrometres>& wanted, const axis_place& at,
                                    const cached_settings& known) {
    const axis& on = at.geometry();
    const std::int64_t one = on.counts_of(wanted.lowest).value_or(soft_limits::beyond);
    const std::int64_t other = on.counts_of(wanted.highest).value_or(soft_limits::beyond);
    const bool is_known = soft_limits::widest.contains(one) && soft_limits::widest.contains(other);
    axis_command c = prepared_command{.steps = routines::stands, .refusal = detail::needs_init_done(known)};
    c.refusal = detail::first_error(c.refusal, wanted.lowest < wanted.highest ? errc::ok : errc::bad_argument,
                                    is_known ? errc::ok : errc::out_of_range);
    c.limits = soft_limits{one < other ? range{one, other} : range{other, one}};
    return c;
}

/// One C630S on a line that moves an axis. Commands of the drive itself stay in reference units. `init` compares the
/// counts of a turn with P05-02, or, where that is 0, with the first gear and the encoder's counts: `unexpected_value`.
template <class Line> class axis_drive : public axis_facade<basic_drive<Line, axis_model>> {
    using base = axis_facade<basic_drive<Line, axis_model>>;

  public:
    constexpr axis_drive(Line& on, std::uint8_t at, const axis& of, const supervision& by = without_watchdog,
                         encoder_counts encoder = encoder_counts::unknown)
        : axis_drive{on, servobus::node<device>{at}, of, by, encoder} {}
    /// With limits and gaps of its own.
    constexpr axis_drive(Line& on, const servobus::node<device>& at, const axis& of,
                         const supervision& by = without_watchdog,
                         encoder_counts encoder = encoder_counts::unknown)
        : base{of, on, at, by} {
        this->model().set_encoder(encoder);
    }
    axis_drive(Line&, std::uint8_t, const axis&&, const supervision& = without_watchdog,
               encoder_counts = encoder_counts::unknown) = delete; // it is referred to
    axis_drive(Line&, const servobus::node<device>&, const axis&&, const supervision& = without_watchdog,
               encoder_counts = encoder_counts::unknown) = delete;

    /// The end of the travel beyond which a move ends: asked after it was refused by `out_of_range`. `none` where it is
    /// refused for something else. A way counts from where the axis is, by the last feedback.
    constexpr travel_end end_passed_by(const axis_move_to& move) const { return end_beyond(move.place); }
    constexpr travel_end end_passed_by(const axis_move_by& move) const {
        return end_beyond(this->model().place().length() + move.way);
    }

  private:
    constexpr travel_end end_beyond(micrometres place) const {
        const axis& on = this->geometry();
        const travel_end e =
            this->model().limits().passed_by(on.counts_of(place).value_or(soft_limits::beyond));
        if (!on.is_mirrored() || e == travel_end::none) return e;
        return e == travel_end::lowest ? travel_end::highest : travel_end::lowest;
    }
};
template <class Line>
axis_drive(Line&, std::uint8_t, const axis&, const supervision& = without_watchdog,
           encoder_counts = encoder_counts::unknown) -> axis_drive<Line>;
template <class Line>
axis_drive(Line&, const servobus::node<device>&, const axis&, const supervision& = without_watchdog,
           encoder_counts = encoder_counts::unknown) -> axis_drive<Line>;

} // namespace servobus::c630s
