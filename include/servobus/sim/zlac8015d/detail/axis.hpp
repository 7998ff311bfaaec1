// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: one axis of the simulated ZLAC8015D: a wheel, driven according to its registers, with its faults
// and feedback.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/sim/detail/wheel.hpp>
#include <servobus/sim/zlac8015d/detail/memory.hpp>
#include <servobus/sim/zlac8015d/options.hpp>

namespace servobus::sim::detail {

namespace zlac = servobus::zlac8015d;

class zlac8015d_axis {
  public:
    using memory = zlac8015d_memory;

    /// `number` is 0 for the left axis, 1 for the right one.
    constexpr zlac8015d_axis(std::uint16_t number, const zlac8015d_options& chosen)
        : number_{number}, engaging_code_{chosen.code_1 == zlac8015d_options::brake::engages
                                              ? std::uint16_t{1}
                                              : std::uint16_t{0}},
          keeps_code_{chosen.code == zlac8015d_options::fault_code::until_restart},
          has_curves_{chosen.speed_ramp == zlac8015d_options::ramp::begins_anew} {}

    constexpr const wheel& motor() const { return motor_; }
    constexpr std::uint16_t faults() const { return latched_; }
    /// The value of 20A5h or 20A6h.
    constexpr std::uint16_t fault_code() const { return keeps_code_ ? code_ : latched_; }
    constexpr bool is_brake_engaged(const memory& m) const {
        return word_at(m, zlac::left_brake.address) == engaging_code_;
    }
    constexpr std::uint32_t starts() const { return starts_; }
    constexpr bool stands() const { return motor_.stands(); }
    constexpr bool is_at_rest() const { return motor_.stands() && motor_.current() == 0; }

    constexpr void switch_on() {
        motor_.forget_target();
        latched_ = 0;
        code_ = 0;
        blocked_us_ = 0;
        clear_feedback();
        clear_origin();
    }
    constexpr void clear_feedback() { feedback_zero_ = motor_.position(); }
    constexpr void clear_origin() { origin_ = motor_.position(); }
    constexpr void drop_move() { motor_.forget_target(); }

    // Faults

    constexpr void raise(std::uint16_t bits) { raised_ |= bits; }
    constexpr void end_causes() { raised_ = 0; }
    /// The faults whose cause is present.
    constexpr std::uint16_t causes(const memory& m, std::int8_t temperature) const {
        std::uint16_t wrong = raised_;
        if (10 * temperature > motor_word(m, zlac::left_motor_temperature_limit.address))
            wrong |= bits_of(zlac::fault::motor_overtemperature);
        const std::int64_t fastest = std::int64_t{m[zlac::max_motor_speed.address]} * m.resolution();
        if (mode(m) == zlac::operating_mode::velocity &&
            magnitude(signed_word(m, zlac::left_target_speed.address)) > fastest)
            wrong |= bits_of(zlac::fault::speed_command);
        return wrong;
    }
    constexpr void latch(std::uint16_t bits) {
        latched_ |= bits;
        if (bits != 0) code_ = latched_;
    }
    constexpr void reset_faults(std::uint16_t causes) { latched_ &= causes; }

    // Commands

    /// Begins a move of a position mode. False if the target is out of range.
    constexpr bool start(const memory& m) {
        const std::int64_t wanted = m.pair(at(zlac::left_target_position.address, 2));
        if (mode(m) == zlac::operating_mode::absolute_position) {
            if (magnitude(wanted) > 0x3FFFFFFF) return false;
            motor_.move_to(origin_ + wanted);
        } else {
            motor_.move_to((motor_.is_moving_to_target() ? motor_.target() : motor_.position()) + wanted);
        }
        ++starts_;
        return true;
    }

    // One tick each

    constexpr void roll(const memory& m, std::int64_t drag) {
        if (!begin(m)) motor_.roll(drag);
    }
    /// A stop (07h): by the deceleration time.
    constexpr void slow_down(const memory& m) {
        if (!begin(m)) ramp_to(0, 0, word_at(m, zlac::left_deceleration_time.address));
    }
    /// A quick stop: by the option of 2011h.
    constexpr void stop_quickly(const memory& m) {
        if (begin(m)) return;
        switch (static_cast<zlac::quick_stop_option>(m[zlac::quick_stop_option_code.address])) {
        case zlac::quick_stop_option::immediate: return ramp_to(0, 0, 0);
        case zlac::quick_stop_option::fast_deceleration:
            return ramp_to(0, 0, word_at(m, zlac::left_quick_stop_time.address));
        default: return ramp_to(0, 0, word_at(m, zlac::left_deceleration_time.address));
        }
    }
    constexpr void operate(const memory& m) {
        if (begin(m)) return push_against_brake(m);
        const std::uint16_t acceleration = word_at(m, zlac::left_acceleration_time.address);
        const std::uint16_t deceleration = word_at(m, zlac::left_deceleration_time.address);
        const std::int64_t fastest = wheel::r_per_min * m[zlac::max_motor_speed.address];
        switch (mode(m)) {
        case zlac::operating_mode::velocity: return ramp_to(commanded_speed(m), acceleration, deceleration);
        case zlac::operating_mode::torque:
            return motor_.push(std::int64_t{1000} * signed_word(m, zlac::left_target_torque.address),
                               word_at(m, zlac::left_torque_slope.address), fastest);
        default: break;
        }
        if (!motor_.is_moving_to_target()) return ramp_to(0, acceleration, deceleration);
        motor_.approach_target(
            smaller_of(fastest, wheel::r_per_min * word_at(m, zlac::left_max_speed.address)),
            wheel::r_per_min * motor_word(m, zlac::left_position_start_speed.address), acceleration,
            deceleration);
    }

    // Feedback

    constexpr std::int32_t feedback() const { return low_bits(motor_.position() - feedback_zero_); }
    /// In 0.1 r/min.
    constexpr std::int16_t speed_word() const { return rounded(motor_.speed(), wheel::r_per_min / 10); }
    /// In 0.1 A.
    constexpr std::int16_t current_word() const { return rounded(motor_.current(), 100'000); }
    /// The Hall state: six states over each pair of poles; 0, an invalid one, while the cause of a Hall fault
    /// lasts.
    constexpr std::uint8_t hall(const memory& m) const {
        constexpr std::array<std::uint8_t, 6> states{1, 3, 2, 6, 4, 5};
        if ((raised_ & bits_of(zlac::fault::hall)) != 0) return 0;
        const std::int64_t turn = counts_per_turn(m);
        const std::int64_t sectors = 6 * std::int64_t{motor_word(m, zlac::left_pole_pairs.address)};
        const std::int64_t angle = (motor_.position() % turn + turn) % turn;
        return states[static_cast<std::size_t>(angle * sectors / turn % 6)];
    }

  private:
    constexpr void ramp_to(std::int64_t wanted, std::uint32_t acceleration_ms,
                           std::uint32_t deceleration_ms) {
        if (has_curves_)
            motor_.curve_to(wanted, acceleration_ms, deceleration_ms);
        else
            motor_.ramp_to(wanted, acceleration_ms, deceleration_ms);
    }
    static constexpr std::uint16_t bits_of(zlac::fault f) { return static_cast<std::uint16_t>(f); }
    static constexpr std::int32_t low_bits(std::int64_t v) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(v)));
    }
    static constexpr std::int16_t rounded(std::int64_t v, std::int64_t unit) {
        return static_cast<std::int16_t>((v < 0 ? v - unit / 2 : v + unit / 2) / unit);
    }
    static constexpr zlac::operating_mode mode(const memory& m) {
        return static_cast<zlac::operating_mode>(m[zlac::mode_of_operation.address]);
    }

    // This axis' address, from the left axis' one: the motion rows alternate, the motor blocks are 30h apart.
    constexpr std::uint16_t at(std::uint16_t left, std::uint16_t step) const {
        return static_cast<std::uint16_t>(left + number_ * step);
    }
    constexpr std::uint16_t word_at(const memory& m, std::uint16_t left) const { return m[at(left, 1)]; }
    constexpr std::int64_t signed_word(const memory& m, std::uint16_t left) const {
        return static_cast<std::int16_t>(word_at(m, left));
    }
    constexpr std::uint16_t motor_word(const memory& m, std::uint16_t left) const {
        return m[at(left, 0x30)];
    }

    constexpr std::int64_t counts_per_turn(const memory& m) const {
        const std::uint16_t lines = motor_word(m, zlac::left_encoder_lines.address);
        return 4 * std::int64_t{lines == 0 ? 1024u : lines};
    }
    constexpr std::int64_t commanded_speed(const memory& m) const {
        return signed_word(m, zlac::left_target_speed.address) * wheel::r_per_min / m.resolution();
    }

    // Starts a tick. True if the brake holds the wheel.
    constexpr bool begin(const memory& m) {
        motor_.set_counts_per_turn(counts_per_turn(m));
        motor_.set_current_limit(100'000 * std::int64_t{motor_word(m, zlac::left_max_current.address)});
        if (!is_brake_engaged(m)) {
            blocked_us_ = 0;
            return false;
        }
        motor_.block();
        return true;
    }

    constexpr void push_against_brake(const memory& m) {
        const bool pushes =
            mode(m) == zlac::operating_mode::velocity ? word_at(m, zlac::left_target_speed.address) != 0
            : mode(m) == zlac::operating_mode::torque ? word_at(m, zlac::left_target_torque.address) != 0
                                                      : motor_.is_moving_to_target();
        blocked_us_ = pushes ? blocked_us_ + wheel::tick.us : 0;
        if (blocked_us_ > 10'000 * std::int64_t{motor_word(m, zlac::left_overload_time.address)})
            latch(bits_of(zlac::fault::overload));
    }

    wheel motor_{};
    std::int64_t feedback_zero_ = 0;
    std::int64_t origin_ = 0;
    std::int64_t blocked_us_ = 0;
    std::uint32_t starts_ = 0;
    std::uint16_t number_;
    std::uint16_t engaging_code_; // of 201Ah, 201Bh
    std::uint16_t raised_ = 0;    // by a test
    std::uint16_t latched_ = 0;
    std::uint16_t code_ = 0; // the latest, kept after a reset
    bool keeps_code_;
    bool has_curves_;
};

} // namespace servobus::sim::detail
