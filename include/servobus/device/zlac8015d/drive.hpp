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

/// Whether a move began whose start was not answered: `seen` if a wheel runs or has left its place by more
/// than 20 counts, `not_seen` otherwise, which a very short move may be as well.
enum class motion : std::uint8_t { not_asked, seen, not_seen, unknown };

/// One ZLAC8015D on a line.
///
///     zlac8015d::drive wheels{wire, 1};
///     if (!wheels.run(init{})) ...
///     if (!wheels.run(enable{operating_mode::velocity})) ...
///     if (!wheels.run(velocity{30 * r_per_min, -30 * r_per_min})) ...
///
/// In a superloop `begin(order)` instead of `run`, and `step()` once a turn. After silence longer than the
/// drive's watchdog, an unknown outcome or a restart of the drive the state is `needs_init`, and no motion is
/// ordered until `init` has run: motion never resumes by itself. (Silence is measured by a clock that wraps
/// after 71 minutes: a program that may rest as long calls `step()` meanwhile, or `init` first.)
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
    constexpr bool is_idle() const { return sequence_.is_idle() || is_own_; }
    /// How the last order ended; meaningful when idle.
    constexpr const report& last() const { return report_; }

    /// Runs an order to its end. Waits; bounded by the routine's limits. Errors: the order's own; `cut_short`
    /// if a stop took its place meanwhile (`watch_commands`).
    template <class Order> report run(const Order& wanted) {
        const errc refusal = begin(wanted);
        if (refusal != errc::ok) return report::not_sent(refusal);
        const std::uint8_t mine = number_;
        auto guard = sequence_.line().new_guard();
        while (!is_idle()) {
            const duration idle = step();
            if (guard.has_failed(sequence_.line().now())) {
                sequence_.give_up(errc::clock_stopped);
                settle();
                break;
            }
            sequence_.line().sleep(idle);
        }
        return number_ == mine ? report_ : report{written{failure{errc::cut_short}, true}};
    }

    /// Starts an order; `step()` moves it on. A stop cuts a less urgent order short and goes out behind the
    /// frame in flight. Errors: the order's own; `busy` if another order is under way; `needs_init`;
    /// `bad_argument` for a node address outside 1..127. Nothing is sent then.
    template <class Order> [[nodiscard]] constexpr errc begin(const Order& wanted) {
        if (!is_valid_) return errc::bad_argument;
        if (sequence_.was_silent()) forget();
        order o = wanted.plan(known_);
        if (o.refusal != errc::ok) return o.refusal;
        if (o.then == effect::timeout_set && o.arguments[0] < shortest_watchdog_ms())
            return errc::out_of_range;
        if (!is_idle() && !is_own_) {
            if (o.stop == urgency::no_stop || o.stop <= order_.stop) return errc::busy;
            if (changes_beliefs(order_.then)) { // half done: what the drive is like now is open
                forget();
                if (o.stop == urgency::halt) o = wanted.plan(known_);
            }
        }
        if (o.then == effect::motion || o.then == effect::moved) {
            last_command_ = sequence_.line().now();
            is_commanded_ = true;
        }
        if (o.then == effect::seen && known_.state == drive_state::enabled) check_mode_now_and_then(o);
        motion_ = zlac8015d::motion::not_asked;
        tries_ = 0;
        ++number_;
        start(o, follow_up::none, false);
        return errc::ok;
    }

    /// Moves the order under way on, without waiting, and keeps the promises of `watch_commands`. Returns the
    /// time within which nothing happens unless a byte comes.
    constexpr duration step() {
        mind_the_application();
        if (sequence_.is_idle()) return milliseconds(1);
        const duration idle = sequence_.step();
        if (sequence_.is_idle()) settle();
        return idle;
    }

    /// From now on `step()` stops the drive, once, if the application gives no speed, torque or move for
    /// `limit`, whatever else it orders: by a halt, or a quick stop in the position modes. It also keeps the
    /// drive's watchdog fed by reading feedback when nothing else is under way. Without this nothing is sent
    /// that the application did not order, and the drive's own watchdog (2000h) stops a forgotten motor. A
    /// limit of 0 ends it.
    constexpr void watch_commands(duration limit) {
        command_limit_ = limit;
        last_command_ = sequence_.line().now();
    }

    /// Reads state, faults, positions and speeds in one frame. A fault on one wheel while the drive is
    /// enabled stops both before this returns. Twice a second the mode is read as well, so that a drive that
    /// was restarted is found out.
    result<feedback> read() {
        const report r = run(read_feedback{});
        if (!r) return failure{r.error(), r.exception()};
        return seen_;
    }

  private:
    // What runs on its own behind an order.
    enum class follow_up : std::uint8_t { none, compare_positions, stop_after_fault };

    // `own`: not the application's; its end is not reported, and any order may take its place.
    constexpr void start(const order& o, follow_up kind, bool own) {
        order_ = o;
        follow_up_ = kind;
        is_own_ = own;
        sequence_.begin(o.steps, o.arguments);
    }

    // Before the application's next order is taken the drive is unknown again.
    constexpr void forget() {
        known_ = {};
        sequence_.set_silence_limit({});
    }

    // A little shorter than the drive's own, which counts from the request it heard last. A drive that was
    // stored with 0 is taken to have the factory's second.
    static constexpr duration silence_limit(std::uint16_t host_timeout_ms) {
        const std::uint32_t ms = host_timeout_ms == 0 ? 1000u : host_timeout_ms;
        return milliseconds(ms - ms / 16);
    }
    // One lost frame must not use it up.
    constexpr std::uint32_t shortest_watchdog_ms() const {
        return (sequence_.limits().response.us + sequence_.quiet().quarantine.us) / 1000 + 50;
    }

    // Orders that leave the drive in a state that is not known while they are half done.
    static constexpr bool changes_beliefs(effect e) {
        return e != effect::none && e != effect::seen && e != effect::motion && e != effect::moved;
    }

    constexpr void check_mode_now_and_then(order& o) {
        const instant now = sequence_.line().now();
        if (since(mode_checked_, now) < milliseconds(500)) return;
        mode_checked_ = now;
        o.steps = routines::feedback_and_mode;
        o.arguments[0] = static_cast<std::uint16_t>(known_.mode);
    }

    // Errors of the transport or of a reply: the drive's state is not known any more.
    static constexpr bool voids_beliefs(const report& r) {
        if (r.error() == errc::faulted) return false;
        if (r.error() == errc::exception) return r.has_changed;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init || r.outcome() == outcome::unknown;
    }

    // An order has ended: what is believed now, and whether anything follows by itself.
    constexpr void settle() {
        const report r = sequence_.last();
        if (follow_up_ == follow_up::compare_positions) return judge_motion(r);
        if (follow_up_ == follow_up::stop_after_fault) return after_fault_stop(r);
        // A stop that does not read back was answered by somebody's late reply: once more.
        if (order_.stop != urgency::no_stop && r.error() == errc::unexpected_value && ++tries_ < 3)
            return start(order_, follow_up::none, is_own_);
        if (!is_own_) report_ = r;
        is_own_ = false;
        if (r) return apply();
        if (order_.then == effect::moved && r.step == routines::start_step &&
            r.outcome() == outcome::unknown) {
            motion_ = zlac8015d::motion::unknown;
            if (!sequence_.was_silent())
                start({.steps = routines::aftermath}, follow_up::compare_positions, false);
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
            sequence_.set_silence_limit(silence_limit(known_.host_timeout));
            mode_checked_ = sequence_.line().now();
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
        case effect::timeout_set:
            known_.host_timeout = order_.arguments[0];
            sequence_.set_silence_limit(silence_limit(known_.host_timeout));
            break;
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
            start({.steps = routines::stop_both, .stop = urgency::disable}, follow_up::stop_after_fault,
                  false);
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
        if (command_limit_ == duration{} || known_.state != drive_state::enabled) return;
        if (sequence_.is_idle() && sequence_.was_silent()) return forget();
        const instant now = sequence_.line().now();
        const bool is_stopping = !sequence_.is_idle() && order_.stop != urgency::no_stop;
        if (is_commanded_ && !is_stopping && since(last_command_, now) > command_limit_) {
            is_commanded_ = false;
            const bool is_cut = !is_idle();
            order o = halt{}.plan(known_);
            if (o.refusal != errc::ok) o = quick_stop{}.plan(known_);
            if (is_cut) ++number_;
            tries_ = 0;
            start(o, follow_up::none, !is_cut);
        } else if (sequence_.is_idle() && since(sequence_.last_heard(), now) > feeding_interval()) {
            start(read_feedback{}.plan(known_), follow_up::none, true);
        }
    }
    constexpr duration feeding_interval() const { return {silence_limit(known_.host_timeout).us / 3}; }

    sequence<Line> sequence_;
    beliefs known_{};
    order order_{};
    feedback seen_{};
    report report_{};
    duration command_limit_{};
    instant last_command_{};
    instant mode_checked_{};
    zlac8015d::motion motion_ = zlac8015d::motion::not_asked;
    follow_up follow_up_ = follow_up::none;
    std::uint8_t number_ = 0; // of the application's order
    std::uint8_t tries_ = 0;
    bool is_own_ = false;
    bool is_commanded_ = false;
    bool is_valid_;
};

} // namespace servobus::zlac8015d
