// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the drive as its program sees it. Orders (orders.hpp) are run to their end, or begun and
// stepped in a loop that never waits. The facade keeps what is believed of the drive and drops it when it is
// no longer sure; it is not a safety function.
#pragma once

#include <cstdint>
#include <span>

#include <servobus/device/zlac8015d/orders.hpp>
#include <servobus/node.hpp>

namespace servobus::zlac8015d {

/// What the drive says of itself in one frame.
struct feedback {
    status state{};
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
    static constexpr feedback from_words(std::span<const std::uint16_t> w) {
        constexpr word_order which = device::facts.order;
        feedback f;
        f.state = status::from_word(w[0]);
        f.hall = hall_inputs::from_word(w[1]);
        f.temperature = motor_temperatures::from_word(w[2]);
        f.left_faults = {w[3]};
        f.right_faults = {w[4]};
        f.left_position = servobus::detail::reading_of<left_actual_position>(join_words(w[5], w[6], which));
        f.right_position = servobus::detail::reading_of<right_actual_position>(join_words(w[7], w[8], which));
        f.left_speed = servobus::detail::reading_of<left_actual_speed>(w[9]);
        f.right_speed = servobus::detail::reading_of<right_actual_speed>(w[10]);
        return f;
    }
};

/// Whether a move began whose start was not answered.
enum class motion : std::uint8_t { not_asked, seen, not_seen, unknown };

/// One ZLAC8015D on a line.
///
///     zlac8015d::drive wheels{wire, 1};
///     wheels.run(init{});
///     wheels.run(enable{operating_mode::velocity});
///     wheels.run(velocity{30 * r_per_min, -30 * r_per_min});
///
/// In a superloop `begin(order)` instead of `run`, and `step()` once a turn. After silence longer than the
/// drive's watchdog, an unknown outcome or a restart of the drive the state is `needs_init`, and no motion is
/// ordered until `init` has run: motion never resumes by itself.
template <class Line> class drive {
  public:
    constexpr explicit drive(Line& on, std::uint8_t at = 1) : drive{on, servobus::node<device>{at}} {}
    /// With limits and silences of its own.
    constexpr drive(Line& on, const servobus::node<device>& at)
        : sequence_{on, at.unit, at.limits, at.quiet, at.read_retries}, is_valid_{at.is_valid()} {}

    drive(const drive&) = delete;
    drive& operator=(const drive&) = delete;

    constexpr drive_state state() const { return known_.state; }
    constexpr const beliefs& known() const { return known_; }
    /// The feedback read last.
    constexpr const feedback& seen() const { return seen_; }
    /// After a move ended `unknown`: whether the wheels were found moving or displaced.
    constexpr zlac8015d::motion motion() const { return motion_; }
    /// True if no order is under way.
    constexpr bool is_idle() const { return sequence_.is_idle(); }
    /// How the last order ended; meaningful when idle.
    constexpr const report& last() const { return report_; }

    /// Runs an order to its end. Waits; bounded by the routine's limits.
    template <class Order> constexpr report run(const Order& wanted) {
        const errc refusal = begin(wanted);
        if (refusal != errc::ok) return report::not_sent(refusal);
        while (!sequence_.is_idle()) {
            sequence_.run();
            settle();
        }
        return report_;
    }

    /// Starts an order; `step()` moves it on. A stop cuts another order short and goes out behind the frame
    /// in flight. Errors: the order's own; `busy` if another order is under way; `needs_init`; `bad_argument`
    /// for a node address outside 1..127. Nothing is sent then.
    template <class Order> constexpr errc begin(const Order& wanted) {
        if (!is_valid_) return errc::bad_argument;
        forget_after_silence();
        const order o = wanted.plan(known_);
        if (o.refusal != errc::ok) return o.refusal;
        const bool is_repeated = o.steps.data() == order_.steps.data();
        if (!is_idle() && (!o.is_stop || is_repeated)) return errc::busy;
        if (o.then == effect::motion || o.then == effect::moved) {
            last_command_ = sequence_.line().now();
            is_commanded_ = true;
        }
        motion_ = zlac8015d::motion::not_asked;
        start(o, follow_up::none);
        return errc::ok;
    }

    /// Moves the order under way on, without waiting. When idle it keeps the promises of `watch_commands`.
    /// Returns the time within which nothing happens unless a byte comes.
    constexpr duration step() {
        if (is_idle()) mind_the_application();
        if (is_idle()) return milliseconds(1);
        const duration idle = sequence_.step();
        if (is_idle()) settle();
        return idle;
    }

    /// From now on `step()` orders a halt, once, if the application gives no speed or torque for `limit`, and
    /// keeps the drive's watchdog fed meanwhile by reading feedback. Without it nothing is sent that the
    /// application did not order, and the drive's own watchdog (2000h) stops a forgotten motor. A limit of 0
    /// ends it.
    constexpr void watch_commands(duration limit) {
        command_limit_ = limit;
        last_command_ = sequence_.line().now();
    }

    /// Reads state, faults, positions and speeds in one frame. A fault on one wheel while the drive is
    /// enabled stops both before this returns.
    constexpr result<feedback> read() {
        const report r = run(read_feedback{});
        if (!r) return failure{r.error(), r.exception()};
        return seen_;
    }

  private:
    // What runs on its own behind an order.
    enum class follow_up : std::uint8_t { none, compare_positions, stop_after_fault };

    constexpr void start(const order& o, follow_up kind) {
        order_ = o;
        follow_up_ = kind;
        sequence_.begin(o.steps, o.arguments);
    }

    constexpr void forget() { known_ = {}; }

    // The drive may have stopped by its own watchdog, or have been restarted: nothing is believed any more.
    constexpr void forget_after_silence() {
        if (known_.state != drive_state::needs_init && was_silent()) forget();
    }
    constexpr bool was_silent() const {
        return known_.host_timeout != 0 &&
               since(sequence_.last_answer(), sequence_.line().now()) > milliseconds(known_.host_timeout);
    }

    // Errors of the transport or of a reply: the drive's state is not known any more.
    static constexpr bool voids_beliefs(const report& r) {
        if (r.error() == errc::faulted || r.error() == errc::exception) return false;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init || r.outcome() == outcome::unknown;
    }

    // An order has ended: what is believed now, and whether anything follows by itself.
    constexpr void settle() {
        const report r = sequence_.last();
        if (follow_up_ == follow_up::compare_positions) return judge_motion(r);
        if (follow_up_ == follow_up::stop_after_fault) return after_fault_stop(r);
        report_ = r;
        if (r) return apply();
        const bool start_is_open =
            order_.then == effect::moved && r.step == routines::start_step && r.outcome() == outcome::unknown;
        if (start_is_open && !was_silent()) {
            motion_ = zlac8015d::motion::unknown;
            start({.steps = routines::aftermath}, follow_up::compare_positions);
        } else if (start_is_open) {
            motion_ = zlac8015d::motion::unknown;
        }
        if (voids_beliefs(r)) forget();
    }

    constexpr void apply() {
        const auto words = sequence_.words();
        switch (order_.then) {
        case effect::initialised:
            known_ = {.state = drive_state::disabled,
                      .resolution = words[routines::resolution_word],
                      .max_speed = words[routines::max_speed_word],
                      .host_timeout = words[routines::host_timeout_word]};
            if (!speed_resolution.limits.contains(known_.resolution)) {
                forget();
                report_.result = written{failure{errc::unexpected_value}, true};
            }
            break;
        case effect::enabled:
            known_.state = drive_state::enabled;
            known_.mode = order_.mode;
            known_.starts = static_cast<synchronisation>(order_.arguments[2]);
            is_commanded_ = false;
            break;
        case effect::disabled:
            if (known_.state != drive_state::needs_init) known_.state = drive_state::disabled;
            break;
        case effect::quick_stopped:
            if (known_.state != drive_state::needs_init) known_.state = drive_state::quick_stopped;
            break;
        case effect::timeout_set: known_.host_timeout = order_.arguments[0]; break;
        case effect::resolution_set: known_.resolution = order_.arguments[0]; break;
        case effect::forgotten: forget(); break;
        case effect::seen:
            seen_ = feedback::from_words(words);
            react();
            break;
        case effect::none:
        case effect::moved:
        case effect::motion: break;
        }
    }

    // One wheel's fault stops both. A shaft that is free although the drive was enabled tells of a restart.
    constexpr void react() {
        if (known_.state != drive_state::enabled) return;
        const auto either = [&](shaft_state s) {
            return seen_.state.left.shaft == s || seen_.state.right.shaft == s;
        };
        if (seen_.any_fault() || either(shaft_state::alarm)) {
            start({.steps = routines::stop_both}, follow_up::stop_after_fault);
        } else if (either(shaft_state::emergency_stop)) {
            known_.state = drive_state::quick_stopped;
        } else if (either(shaft_state::released)) {
            forget();
        }
    }

    constexpr void after_fault_stop(const report& r) {
        follow_up_ = follow_up::none;
        if (r) {
            known_.state = drive_state::disabled;
        } else {
            report_ = r;
            forget();
        }
    }

    // A standing servo trembles by a few counts.
    static constexpr std::int32_t stillness = 20;

    constexpr void judge_motion(const report& r) {
        follow_up_ = follow_up::none;
        if (!r) return;
        const auto w = sequence_.words();
        const auto moved = [&](std::size_t i) {
            const u32 before = join_words(w[routines::before_word + i], w[routines::before_word + i + 1],
                                          device::facts.order);
            const u32 after =
                join_words(w[routines::after_word + i], w[routines::after_word + i + 1], device::facts.order);
            const auto way = static_cast<std::int32_t>(after - before);
            return way > stillness || way < -stillness;
        };
        const bool is_running = (w[routines::running_word] & status::running_bits) != 0;
        motion_ = is_running || moved(0) || moved(2) ? zlac8015d::motion::seen : zlac8015d::motion::not_seen;
    }

    constexpr void mind_the_application() {
        forget_after_silence();
        if (command_limit_ == duration{} || known_.state != drive_state::enabled) return;
        const instant now = sequence_.line().now();
        if (is_commanded_ && since(last_command_, now) > command_limit_) {
            is_commanded_ = false;
            const order o = halt{}.plan(known_);
            if (o.refusal == errc::ok) return start(o, follow_up::none);
        }
        if (since(sequence_.last_answer(), now) > milliseconds(known_.host_timeout / 3u))
            start(read_feedback{}.plan(known_), follow_up::none);
    }

    sequence<Line> sequence_;
    beliefs known_{};
    order order_{};
    feedback seen_{};
    report report_{};
    duration command_limit_{};
    instant last_command_{};
    zlac8015d::motion motion_ = zlac8015d::motion::not_asked;
    follow_up follow_up_ = follow_up::none;
    bool is_commanded_ = false;
    bool is_valid_;
};

} // namespace servobus::zlac8015d
