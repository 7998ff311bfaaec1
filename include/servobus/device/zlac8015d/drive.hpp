// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the facade of a drive. Commands (commands.hpp) are run to their end, or begun and
// stepped in a loop that never waits. The facade caches the settings of the drive and invalidates them
// when they may have changed; it is not a safety function. servobus/device/zlac8015d.hpp includes it.
//
//     zlac8015d::drive wheels{wire, 1};
//     if (!wheels.run(zlac8015d::init{})) return 1;
//     const result<zlac8015d::feedback> seen = wheels.read(); // one request
//     if (!seen || seen->any_fault()) return 1;
//     if (seen->left_speed > 10 * r_per_min) std::puts("the left wheel turns");
#pragma once

#include <cstdint>

#include <servobus/control/drive.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/device/zlac8015d/commands.hpp>

namespace servobus::zlac8015d {

/// What the drive says of itself in one frame.
struct feedback {
    status_flags state{};
    hall_inputs hall{};
    motor_temperatures temperature{}; ///< degC
    faults left_faults{};
    faults right_faults{};
    reading<left_actual_position> left_position{};
    reading<right_actual_position> right_position{};
    reading<left_actual_speed> left_speed{};   ///< counts of 0.1 r/min
    reading<right_actual_speed> right_speed{}; ///< counts of 0.1 r/min

    constexpr bool any_fault() const { return left_faults.any() || right_faults.any(); }

    /// Takes the eleven words of 20A2h..20ACh.
    static constexpr feedback from_words(slice<const std::uint16_t> w) {
        constexpr word_order which = device::facts.word_order;
        feedback f;
        f.state = status_flags::from_word(w[0]);
        f.hall = hall_inputs::from_word(w[1]);
        f.temperature = motor_temperatures::from_word(w[2]);
        f.left_faults = {w[3]};
        f.right_faults = {w[4]};
        f.left_position = servobus::reading_of<left_actual_position>(join_words(w[5], w[6], which));
        f.right_position = servobus::reading_of<right_actual_position>(join_words(w[7], w[8], which));
        f.left_speed = servobus::reading_of<left_actual_speed>(w[9]);
        f.right_speed = servobus::reading_of<right_actual_speed>(w[10]);
        return f;
    }
};

/// One ZLAC8015D on a line.
///
///     zlac8015d::drive wheels{wire, 1};
///     if (!wheels.run(init{})) ...
///     if (!wheels.run(enable{operating_mode::velocity})) ...
///     if (!wheels.run(velocity{30 * r_per_min, -30 * r_per_min})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` once a turn. After silence longer than the
/// drive's watchdog, an unknown outcome or a restart of the drive the state is `needs_init`, and no motion is
/// ordered until `init` has run: motion never resumes by itself. (Silence is measured by a clock that wraps
/// after 71 minutes: a program that may rest as long calls `step()` meanwhile, or `init` first.)
template <class Line> class drive : public drive_base<drive<Line>, Line, prepared_command> {
    using base = drive_base<drive<Line>, Line, prepared_command>;
    friend base;

  public:
    constexpr explicit drive(Line& on, std::uint8_t at = 1) : drive{on, servobus::node<device>{at}} {}
    /// With limits and silences of its own.
    constexpr drive(Line& on, const servobus::node<device>& at) : base{on, at} {}

    constexpr drive_state state() const { return cached_.state; }
    constexpr const cached_settings& cached() const { return cached_; }
    /// The feedback read last.
    constexpr const feedback& seen() const { return seen_; }
    /// After a move ended `unknown`: whether a wheel was found running, or more than 20 counts from its
    /// place; `unknown` if the drive was restarted.
    constexpr motion_check motion() const { return motion_; }

    /// Reads state, faults, positions and speeds in one frame. A fault on one wheel while the drive is
    /// enabled stops both before this returns. Twice a second the mode is read as well, so that a drive that
    /// was restarted is found out.
    result<feedback> read() {
        const routine_status r = this->run(read_feedback{});
        if (!r) return r.status;
        return seen_;
    }

  private:
    template <class Wanted> constexpr prepared_command plan(const Wanted& wanted) const {
        return wanted.plan(cached_);
    }

    constexpr errc admit(prepared_command& o) {
        if (o.then == effect::timeout_set && o.arguments[0] != 0 && o.arguments[0] < shortest_watchdog_ms())
            return errc::out_of_range;
        if (o.then == effect::seen && is_powered()) check_mode_now_and_then(o);
        motion_ = motion_check::not_asked;
        return errc::ok;
    }

    // Before the application's next command is taken the drive is unknown again.
    constexpr void forget() { cached_ = {}; }

    static constexpr bool takes_over(const prepared_command& o) { return o.then == effect::initialised; }
    static constexpr bool is_command(const prepared_command& o) {
        return o.then == effect::motion || o.then == effect::moved;
    }
    static constexpr bool leaves_doubt(const prepared_command& o) {
        return o.then != effect::none && o.then != effect::seen && !is_command(o);
    }
    constexpr bool is_powered() const { return cached_.state == drive_state::enabled; }

    /// A halt, or a quick stop in the position modes, which have none.
    constexpr prepared_command watch_stop() const {
        const prepared_command o = halt{}.plan(cached_);
        return o.refusal == errc::ok ? o : quick_stop{}.plan(cached_);
    }
    constexpr duration keep_alive_interval() const { return {watchdog().us / 3}; }
    constexpr prepared_command keep_alive() const { return read_feedback{}.plan(cached_); }
    static constexpr bool restarts_on_traffic = true;
    constexpr duration watchdog() const { return silence_limit(host_timeout_); }
    static constexpr prepared_command first_stop() { return {.steps = routines::stop_after_silence}; }

    // A little shorter than the drive's own, which counts from the request it heard last. A drive that was
    // stored with 0 is taken to have the factory's second.
    static constexpr duration silence_limit(std::uint16_t host_timeout_ms) {
        const std::uint32_t ms = host_timeout_ms == 0 ? 1000u : host_timeout_ms;
        return milliseconds(ms - ms / 16);
    }
    // One lost frame must not use it up.
    constexpr std::uint32_t shortest_watchdog_ms() const {
        return (this->runner().limits().response.us + this->runner().gaps().quarantine.us) / 1000 + 50;
    }

    constexpr void check_mode_now_and_then(prepared_command& o) {
        const instant now = this->runner().line().now();
        if (since(mode_checked_, now) < milliseconds(500)) return;
        mode_checked_ = now;
        o.steps = routines::feedback_and_mode;
        o.arguments[0] = static_cast<std::uint16_t>(cached_.mode);
    }

    constexpr void fail(const prepared_command& o, const routine_status& r) {
        if (o.then == effect::positions_compared) return;
        if (o.then == effect::stopped_after_fault) {
            this->report_as(r);
            return forget();
        }
        if (o.then == effect::moved && r.step >= routines::start_step && r.outcome() == outcome::unknown) {
            motion_ = motion_check::unknown;
            if (!this->runner().was_silent())
                this->follow({.steps = routines::post_check,
                              .arguments = {static_cast<std::uint16_t>(cached_.mode)},
                              .then = effect::positions_compared});
        }
        // The drive may have it all the same, and then the shorter one counts.
        if (o.then == effect::timeout_set && r.outcome() == outcome::unknown)
            set_host_timeout(shorter_timeout(host_timeout_, o.arguments[0]));
        if (base::is_in_doubt(r)) forget();
        // Enabled perhaps, and its status does not say so [errata B30].
        if (o.then == effect::enabled && r.error() == errc::not_reached) stop_both(effect::none);
    }
    constexpr void stop_both(effect then) {
        this->follow({.steps = routines::stop_both, .then = then, .stop = stop_priority::disable});
    }

    constexpr void set_host_timeout(std::uint16_t ms) {
        host_timeout_ = ms;
        this->runner().set_silence_limit(watchdog());
    }
    static constexpr std::uint16_t shorter_timeout(std::uint16_t a, std::uint16_t b) {
        return silence_limit(a) < silence_limit(b) ? a : b;
    }

    constexpr void apply(const prepared_command& o) {
        const auto words = this->runner().words();
        switch (o.then) {
        case effect::initialised:
            this->await_first_command();
            cached_ = {.state = drive_state::disabled,
                       .resolution = words[routines::resolution_word],
                       .max_speed = words[routines::max_speed_word],
                       .host_timeout = words[routines::host_timeout_word]};
            set_host_timeout(cached_.host_timeout);
            mode_checked_ = this->runner().line().now();
            if (!speed_resolution.limits.contains(cached_.resolution)) {
                forget();
                this->report_as({status::sent(errc::unexpected_value)});
            }
            break;
        case effect::enabled:
            cached_.state = drive_state::enabled;
            cached_.mode = o.mode;
            cached_.starts = static_cast<synchronisation>(o.arguments[2]);
            this->await_first_command();
            break;
        case effect::disabled:
            if (cached_.state != drive_state::needs_init) cached_.state = drive_state::disabled;
            break;
        case effect::quick_stopped:
            if (cached_.state != drive_state::needs_init) cached_.state = drive_state::quick_stopped;
            break;
        case effect::timeout_set:
            cached_.host_timeout = o.arguments[0];
            set_host_timeout(o.arguments[0]);
            break;
        case effect::resolution_set: cached_.resolution = o.arguments[0]; break;
        case effect::forgotten: forget(); break;
        case effect::seen:
            seen_ = feedback::from_words(words);
            react();
            break;
        case effect::positions_compared: judge_motion(); break;
        case effect::stopped_after_fault: cached_.state = drive_state::disabled; break;
        case effect::none:
        case effect::moved:
        case effect::motion: break;
        }
    }

    // One wheel's fault stops both. A shaft that is free at standstill, although the drive was enabled, tells
    // of a restart; one that is driven may read as free, and then the mode tells [errata B30].
    constexpr void react() {
        if (!is_powered()) return;
        const auto either = [&](shaft_state s) {
            return seen_.state.left.shaft == s || seen_.state.right.shaft == s;
        };
        if (seen_.any_fault() || either(shaft_state::alarm)) {
            stop_both(effect::stopped_after_fault);
        } else if (either(shaft_state::emergency_stop)) {
            cached_.state = drive_state::quick_stopped;
        } else if (either(shaft_state::released)) {
            if (cached_.mode != operating_mode::torque && !seen_.state.is_running()) return forget();
            this->follow(
                {.steps = routines::same_mode, .arguments = {static_cast<std::uint16_t>(cached_.mode)}});
        }
    }

    // A standing servo trembles by a few counts.
    static constexpr std::int32_t stillness = 20;

    constexpr void judge_motion() {
        const auto w = this->runner().words();
        const auto moved = [&](std::size_t i) {
            const u32 before = join_words(w[routines::before_word + i], w[routines::before_word + i + 1],
                                          device::facts.word_order);
            const u32 after = join_words(w[routines::after_word + i], w[routines::after_word + i + 1],
                                         device::facts.word_order);
            const auto way = static_cast<std::int32_t>(after - before);
            return way > stillness || way < -stillness;
        };
        const bool is_running = (w[routines::running_word] & status_flags::running_bits) != 0;
        motion_ = is_running || moved(0) || moved(2) ? motion_check::seen : motion_check::not_seen;
    }

    cached_settings cached_{};
    feedback seen_{};
    instant mode_checked_{};
    std::uint16_t host_timeout_ = 0; // ms, the last that was known; 0: none
    motion_check motion_ = motion_check::not_asked;
};

} // namespace servobus::zlac8015d
