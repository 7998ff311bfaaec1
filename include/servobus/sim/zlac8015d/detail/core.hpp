// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the state machine of the simulated ZLAC8015D: what a write does, and a tick of the control loop
// with watchdog, faults and stop input. sim/zlac8015d.hpp lists the assumptions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/sim/zlac8015d/detail/axis.hpp>
#include <servobus/sim/zlac8015d/detail/memory.hpp>
#include <servobus/sim/zlac8015d/options.hpp>

namespace servobus::sim {

namespace detail {

class zlac8015d_core {
  public:
    using control_code = zlac::control_code;
    using operating_mode = zlac::operating_mode;

    enum class state : std::uint8_t {
        idle,       ///< motors not powered, or only held by the power-on lock of 2007h
        operating,  ///< enabled
        stopping,   ///< 07h: slowing down, then idle
        quick_stop, ///< slowing down, or held until it is enabled again
    };

    constexpr operating_mode mode() const {
        return static_cast<operating_mode>(memory_[zlac::mode_of_operation.address]);
    }
    constexpr bool is_positioning() const {
        return mode() == operating_mode::relative_position || mode() == operating_mode::absolute_position;
    }
    constexpr bool stands_still() const { return left_.stands() && right_.stands(); }

  protected:
    using memory = zlac8015d_memory;
    using axis = zlac8015d_axis;
    using options_type = zlac8015d_options;

    constexpr explicit zlac8015d_core(const zlac8015d_options& chosen) : options_{chosen} {}

    constexpr void switch_on() {
        is_locked_ = memory_[zlac::shaft_at_power_on.address] != 0;
        left_.switch_on();
        right_.switch_on();
        cut_power();
        since_request_ = 0;
        look_for_faults();
    }

    // Writes

    constexpr void accept(std::uint16_t address, std::uint16_t word) {
        memory_.note(address, word);
        switch (address) {
        case zlac::clear_feedback_position.address:
            if ((word & 1u) != 0) left_.clear_feedback();
            if ((word & 2u) != 0) right_.clear_feedback();
            return;
        case zlac::clear_absolute_position.address:
            if ((word & 1u) != 0) left_.clear_origin();
            if ((word & 2u) != 0) right_.clear_origin();
            return;
        case zlac::restore_parameters.address:
            if (word != 0 && state_ == state::idle) memory_.restore();
            return;
        case zlac::save_parameters.address:
            if (word != 0) memory_.save();
            return;
        case zlac::mode_of_operation.address:
            if (stands_still() && word != memory_[address]) {
                memory_.set(address, word);
                drop_moves();
                if (word == 0) cut_power();
            }
            return;
        case zlac::control_word.address:
            memory_.set(address, word);
            ++commands_[word];
            return obey(static_cast<control_code>(word));
        default: memory_.set(address, word);
        }
    }

    constexpr void obey(control_code code) {
        switch (code) {
        case control_code::undefined: return;
        case control_code::quick_stop:
            if (state_ == state::operating || state_ == state::stopping) begin_quick_stop(false);
            return;
        case control_code::fault_reset:
            left_.reset_faults(left_.causes(memory_, motor_temperature_.left));
            right_.reset_faults(right_.causes(memory_, motor_temperature_.right));
            return;
        case control_code::stop: return begin_stop();
        case control_code::enable: return enable();
        case control_code::start_both: return start(true, true, 1);
        case control_code::start_left: return start(true, false, 0);
        case control_code::start_right: return start(false, true, 0);
        }
    }

    constexpr void enable() {
        look_for_faults();
        const bool has_mode = mode() != operating_mode::undefined || options_.enables_without_mode;
        if (state_ == state::operating || !has_mode || has_fault() || is_input_active()) return;
        drop_moves();
        cut_power();
        is_locked_ = false;
        state_ = state::operating;
        ++enables_;
    }

    constexpr void begin_stop() {
        is_locked_ = false;
        if (state_ != state::operating && state_ != state::quick_stop) return;
        const bool rolls = is_released_ || memory_[zlac::disable_option_code.address] == 0;
        drop_moves();
        cut_power();
        if (!rolls) state_ = state::stopping;
    }

    constexpr void begin_quick_stop(bool by_input) {
        drop_moves();
        state_ = state::quick_stop;
        releases_ = by_input && memory_[zlac::input_stop.address] != 0;
        is_released_ = releases_ && memory_[zlac::quick_stop_option_code.address] ==
                                        static_cast<std::uint16_t>(zlac::quick_stop_option::immediate);
    }

    constexpr void start(bool left, bool right, std::uint16_t synchronisation) {
        const bool fits = options_.position_start == options_type::start::any ||
                          memory_[zlac::position_synchronisation.address] == synchronisation;
        if (state_ != state::operating || !is_positioning() || !fits) return;
        const bool left_starts = left && left_.faults() == 0 && left_.start(memory_);
        const bool right_starts = right && right_.faults() == 0 && right_.start(memory_);
        if (left_starts || right_starts) ++starts_;
    }

    constexpr void drop_moves() {
        left_.drop_move();
        right_.drop_move();
    }
    constexpr void cut_power() {
        state_ = state::idle;
        in_watchdog_stop_ = releases_ = is_released_ = false;
    }

    // Faults and inputs

    constexpr bool has_fault() const { return (left_.faults() | right_.faults()) != 0; }

    constexpr void look_for_faults() {
        left_.latch(left_.causes(memory_, motor_temperature_.left));
        right_.latch(right_.causes(memory_, motor_temperature_.right));
        if (!has_fault()) return;
        if (options_.by_fault == options_type::switched_off::its_wheel &&
            (left_.faults() == 0 || right_.faults() == 0)) {
            (left_.faults() != 0 ? left_ : right_).drop_move();
            return;
        }
        if (state_ != state::idle) drop_moves();
        cut_power();
        is_locked_ = false;
    }

    constexpr bool is_input_active() const {
        constexpr auto emergency = static_cast<std::uint16_t>(zlac::input_function::emergency_stop);
        const unsigned active = inputs_.to_word() ^ unsigned { memory_[zlac::input_polarity.address] };
        return ((active & 1u) != 0 && memory_[zlac::x0_function.address] == emergency) ||
               ((active & 2u) != 0 && memory_[zlac::x1_function.address] == emergency);
    }

    // Time

    constexpr bool is_at_rest() const {
        return left_.is_at_rest() && right_.is_at_rest() &&
               (state_ == state::idle || state_ == state::quick_stop);
    }

    constexpr void tick() {
        since_request_ += wheel::tick.us;
        watch_host();
        look_for_faults();
        if (state_ == state::operating && is_input_active()) begin_quick_stop(true);
        turn(left_);
        turn(right_);
        if (has_fault()) look_for_faults();
        if (!stands_still()) return;
        if (state_ == state::stopping) cut_power();
        if (releases_) is_released_ = true;
    }

    constexpr void watch_host() {
        const std::int64_t limit = 1000 * std::int64_t{memory_[zlac::host_timeout.address]};
        if (limit == 0 && options_.host_timeout == options_type::zero::off) return;
        if (state_ != state::operating || since_request_ <= limit) return;
        if (!options_.resumes_after_watchdog) begin_quick_stop(false);
        in_watchdog_stop_ = true;
    }

    constexpr void turn(axis& a) {
        switch (a.faults() != 0 ? state::idle : state_) {
        case state::idle: return a.roll(memory_, idle_drag());
        case state::stopping: return a.slow_down(memory_);
        case state::quick_stop: return is_released_ ? a.roll(memory_, 1) : a.stop_quickly(memory_);
        case state::operating: return in_watchdog_stop_ ? a.stop_quickly(memory_) : a.operate(memory_);
        }
    }

    // The multiple of the friction: shorted phases brake a turning wheel, the power-on lock stops it.
    constexpr std::int64_t idle_drag() const {
        if (is_locked_) return 100;
        const bool is_shorted = has_fault() && memory_[zlac::pwm_on_alarm.address] != 0;
        return is_shorted || memory_[zlac::parking_mode.address] != 0 ? 10 : 1;
    }

    zlac8015d_options options_;
    memory memory_{options_};
    axis left_{0, options_};
    axis right_{1, options_};
    std::int64_t since_request_ = 0; // us since the last request
    std::array<std::uint32_t, 0x13> commands_{};
    std::uint32_t starts_ = 0;
    std::uint32_t enables_ = 0;
    zlac::inputs inputs_{};
    zlac::motor_temperatures motor_temperature_{31, 32};
    state state_ = state::idle;
    bool in_watchdog_stop_ = false;
    bool releases_ = false;    // the stop by the input ends with a released shaft
    bool is_released_ = false; // by that stop
    bool is_locked_ = false;   // by 2007h
};

} // namespace detail
} // namespace servobus::sim
