// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs a drive's control routines, which are tables of steps, over a line: `step` in each loop iteration
// never waits, `run` is a blocking call that loops over it. control/drive.hpp includes it. A program that
// uses no facade may run a routine by itself:
//
//     const node<zlac8015d::device> at{1};
//     sequence runner{wire, at.address, at.limits, at.gaps};
//     runner.begin(zlac8015d::routines::ramps, steps::arguments{{800, 800, 500, 500}}); // ms
//     while (!runner.is_idle()) runner.step();
//     if (!runner.last()) std::printf("step %d failed\n", runner.last().step);
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/stop_retry.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// Runs routines against one node. Between two steps nothing is kept but this object, so a routine can be
/// left and taken up again at any turn.
template <class Line> class sequence {
  public:
    static constexpr std::size_t max_arguments = steps::max_arguments;
    static constexpr std::size_t max_words = steps::max_words;
    static constexpr std::uint8_t tries_of_a_stop = detail::stop_retry::rounds;

    constexpr sequence(Line& on, std::uint8_t node_address, const response_limits& limits,
                       const bus_gaps& gaps, std::uint8_t read_retries = 2)
        : line_{&on}, limits_{limits}, gaps_{gaps}, unit_{node_address}, read_retries_{read_retries} {}

    // An exchange refers to this object's buffers.
    sequence(const sequence&) = delete;
    sequence& operator=(const sequence&) = delete;

    constexpr bool is_idle() const { return steps_.empty(); }
    constexpr Line& line() const { return *line_; }
    constexpr std::uint8_t address() const { return unit_; }
    constexpr const response_limits& limits() const { return limits_; }
    /// A device that says how long it may take: from the next frame on.
    constexpr void set_response_limit(duration limit) { limits_.response = limit; }
    constexpr const bus_gaps& gaps() const { return gaps_; }
    /// How the last routine ended; meaningful when idle.
    constexpr const routine_status& last() const { return report_; }
    /// What the fetch steps read.
    constexpr slice<const std::uint16_t> words() const { return words_; }
    /// When the last request began to leave that was answered: a drive's own watchdog counts from no earlier.
    /// Meaningful once one was.
    constexpr instant last_heard() const { return last_heard_; }
    /// Somebody else's request to this node, which began to leave at `at`, was answered.
    constexpr void note_heard(instant at) { last_heard_ = at; }

    /// After this long without an answered request only stops are sent; any other step, a retry too, ends its
    /// routine with `needs_init`. 0: no limit.
    constexpr void set_silence_limit(duration limit) { silence_limit_ = limit; }
    constexpr bool was_silent() const {
        return silence_limit_ != duration{} && since(last_heard_, line_->now()) > silence_limit_;
    }

    /// Starts a routine. If one is under way, the frame in flight is let end and the rest of it is dropped:
    /// so a stop is the next frame after the one in flight. The stops that a routine begins with go out once
    /// each before any is tried again; the first `urgent` of their frames go before all else and wait for no
    /// quarantine, those behind them wait as all do.
    constexpr void begin(routine table, const steps::arguments& arguments = {}) {
        begin(table, steps::given{arguments});
    }
    constexpr void begin(routine table, const steps::given& with,
                         std::uint8_t urgent = steps::urgent_frames) {
        if (table.empty()) return;
        next_steps_ = table;
        next_given_ = with;
        next_urgent_ = urgent;
        if (!is_idle() && is_waiting_to_send()) line_->abandon(exchange_);
        if (is_idle() || exchange_.done()) switch_over();
    }

    /// From the next routine on; what is known of the drive decides it.
    constexpr void set_recheck(const steps::recheck& r) {
        if (r.look == nullptr) checked_ = line_->epoch(unit_); // what is missed from here on counts
        recheck_ = r;
    }
    /// True from a request to the drive that was not answered, whoever on the line sent it, until what must
    /// hold was read again.
    constexpr bool is_doubted() const { return recheck_.look != nullptr && checked_ != line_->epoch(unit_); }

    /// True once after a routine was dropped for a stop while one of its writes was not answered: whether
    /// that was carried out is not known.
    constexpr bool take_lost() {
        const bool has_lost = has_lost_;
        has_lost_ = false;
        return has_lost;
    }
    /// How many of the routine's urgent frames have not left.
    constexpr std::uint8_t urgent_left() const { return urgent_left_; }
    /// True while an urgent stop is to go out and nothing of its frame has left.
    constexpr bool has_stop_to_send() const { return !is_idle() && is_stop() && is_waiting_to_send(); }

    /// Moves on as far as it goes without waiting. Returns the time within which nothing happens unless a
    /// byte comes.
    constexpr duration step() {
        if (is_idle()) return {};
        if (is_waiting_to_send() && !current().is_repeatable && was_silent()) {
            line_->abandon(exchange_);
            end({errc::needs_init});
            return {};
        }
        if (is_waiting_to_send() && needs_check() && check_ == nullptr) { // somebody else has met a silence
            line_->abandon(exchange_);
            send();
        }
        bus_gaps gaps = gaps_;
        gaps.is_stop = is_stop();
        const duration idle = line_->step(exchange_, gaps);
        if (!exchange_.done()) return idle;
        conclude();
        return {};
    }

    /// Runs the routine under way to its end: polls, or sleeps where the port can. Bounded by the steps'
    /// limits and the line's bound for each frame.
    constexpr const routine_status& run() {
        auto guard = line_->new_stall_detector();
        while (!is_idle()) {
            [[maybe_unused]] const duration idle = step();
            if (is_idle()) break;
            if (guard.has_failed(line_->now())) {
                give_up(errc::clock_stopped);
                break;
            }
            line_->sleep(idle);
        }
        return report_;
    }

    /// Ends the routine under way where it is.
    constexpr void give_up(errc why) {
        if (is_idle()) return;
        line_->abandon(exchange_);
        next_steps_ = {};
        note_write();
        end(why);
    }

  private:
    constexpr const servobus::step& current() const { return check_ != nullptr ? *check_ : steps_[at_]; }
    constexpr bool needs_check() const { return is_doubted() && !steps_[at_].is_repeatable; }
    constexpr bool is_stop() const { return is_leading_ && urgent_left_ != 0; }
    constexpr bool is_waiting_to_send() const { return exchange_.state() == modbus::exchange::phase::ready; }

    constexpr void switch_over() {
        steps_ = next_steps_;
        given_ = next_given_;
        urgent_left_ = next_urgent_;
        is_leading_ = true;
        next_steps_ = {};
        has_written_ = false;
        missed_ = {};
        at_ = 0;
        report_ = {};
        enter();
    }

    constexpr void enter() {
        tries_ = 1;
        entered_ = line_->now();
        if (steps_[at_].is_repeatable) {
            stops_.begin(steps_, at_);
        } else {
            is_leading_ = false;
        }
        send();
    }

    constexpr std::uint16_t word_for(std::size_t i) const {
        const servobus::step& s = current();
        if (s.slot == servobus::step::constant) return s.value;
        return check_ != nullptr ? recheck_.words[s.slot + i] : given_.arguments[s.slot + i];
    }

    constexpr void send() {
        check_ = needs_check() ? recheck_.look : nullptr;
        const servobus::step& s = current();
        frame_[0] = unit_;
        const byte_buffer pdu = byte_buffer{frame_}.subspan(1);
        const auto address = static_cast<std::uint16_t>(s.address + (s.is_element ? given_.shift : 0));
        std::size_t size = 0;
        if (s.what != servobus::step::kind::write) {
            size = modbus::put_read_request(pdu, modbus::function::read_holding_registers, address, s.count);
        } else if (s.count == 1) {
            size = modbus::put_write_request(pdu, address, word_for(0));
        } else {
            std::uint16_t words[max_arguments]{};
            for (std::size_t i = 0; i < s.count; ++i) words[i] = word_for(i);
            size = modbus::put_write_request(pdu, address, slice<const std::uint16_t>{words}.first(s.count));
        }
        exchange_ =
            modbus::exchange{bytes{frame_}.first(modbus::close_frame<modbus::exchange::crc>(frame_, size)),
                             response_, line_->timing(), limits_};
    }

    constexpr void conclude() {
        using kind = servobus::step::kind;
        const servobus::step& s = current();
        const status why = exchange_.status();
        const bool is_write = s.what == kind::write;
        const bool had_written = has_written_;
        note_write();
        if (why.has_response()) last_heard_ = line_->began_at();
        if (!next_steps_.empty()) {
            has_lost_ = has_lost_ || (is_write && !s.is_repeatable && !why.has_response()); // it was sent
            return switch_over();
        }
        if (s.is_repeatable) return conclude_stop(why, had_written);
        if (why.error() != errc::ok) {
            const bool may_repeat = !is_write && (why.error() != errc::exception || came_damaged(why));
            if (!may_repeat || tries_ > read_retries_ || why.error() == errc::port_lost)
                return end(why, had_written);
            ++tries_;
            return send();
        }
        if (s.what == kind::fetch) {
            for (std::size_t i = 0; i < s.count; ++i) words_[s.slot + i] = exchange_.words()[i];
        } else if (!is_write && !holds()) {
            if (missed_.error() != errc::ok) return end(missed_, true); // to be stopped again, not waited for
            if (s.what == kind::until && since(entered_, line_->now()) < limit_of(s)) {
                tries_ = 1;
                return send();
            }
            return end(s.otherwise);
        }
        if (check_ == nullptr) return go_on();
        checked_ = line_->epoch(unit_);
        send();
    }

    constexpr void conclude_stop(const status& why, bool had_written) {
        if (exchange_.was_sent() && urgent_left_ != 0) --urgent_left_;
        if (why.error() == errc::port_lost) return end(why, had_written);
        if (why.error() != errc::ok) stop_failure_ = why;
        if (stops_.conclude(why.error() == errc::ok)) {
            at_ = stops_.at();
            return send();
        }
        at_ = stops_.last();
        const bool is_last = at_ + 1u == steps_.size() || !steps_[at_ + 1u].is_repeatable;
        if (is_last && !stops_.is_any_answered()) return end(why, had_written);
        if (stops_.is_any_missed() && missed_.error() == errc::ok) missed_ = stop_failure_;
        go_on();
    }

    constexpr void go_on() {
        if (at_ + 1u == steps_.size() || is_barred(steps_[at_ + 1u])) return end(errc::ok);
        ++at_;
        enter();
    }

    // Behind a stop that never got through nothing is written but stops.
    constexpr bool is_barred(const servobus::step& s) const {
        return missed_.error() != errc::ok && s.what == servobus::step::kind::write && !s.is_repeatable;
    }

    // The drive's word that it did not understand a frame: as good as no response.
    constexpr bool came_damaged(const status& why) const {
        return why.exception() != 0 && why.exception() == limits_.corrupted_request;
    }

    constexpr duration limit_of(const servobus::step& s) const {
        return s.limit_ms == servobus::step::commanded_limit ? given_.limit : milliseconds(s.limit_ms);
    }

    constexpr bool holds() const {
        const words_view got = exchange_.words();
        for (std::size_t i = 0; i < got.size(); ++i) {
            if (!holds(got[i], i)) return false;
        }
        return true;
    }
    constexpr bool holds(std::uint16_t got, std::size_t i) const {
        if (!current().is_within) return ((got ^ word_for(i)) & current().mask) == 0;
        const auto value = static_cast<std::int16_t>(got);
        const auto most = static_cast<std::int32_t>(word_for(i));
        return value <= most && value >= -most;
    }

    constexpr void note_write() {
        has_written_ =
            has_written_ || (current().what == servobus::step::kind::write && exchange_.was_sent());
    }

    constexpr void end(status why, bool has_changed = false) {
        if (why.error() == errc::ok && missed_.error() != errc::ok) {
            why = missed_;
            has_changed = true; // the stops behind it
        }
        if (why.error() == errc::ok && !line_->is_echo_ruled_out()) why = errc::own_echo; // all single writes
        report_ = {why.with_sent(has_written_), static_cast<std::uint8_t>(at_), has_changed};
        steps_ = {};
    }

    Line* line_;
    response_limits limits_;
    bus_gaps gaps_;
    routine steps_{};
    routine next_steps_{};
    steps::given given_{};
    steps::given next_given_{};
    std::uint16_t words_[max_words]{};
    std::uint8_t frame_[24]{};
    std::uint8_t response_[32]{};
    modbus::exchange exchange_{};
    instant entered_{};
    instant last_heard_{};
    duration silence_limit_{};
    routine_status report_{};
    status stop_failure_{};
    status missed_{}; // a stop that had no response, while others had
    detail::stop_retry stops_{};
    std::uint8_t at_ = 0;
    std::uint8_t tries_ = 0;
    std::uint8_t unit_;
    std::uint8_t read_retries_;
    std::uint8_t urgent_left_ = 0;
    std::uint8_t next_urgent_ = 0;
    steps::recheck recheck_{};
    const servobus::step* check_ = nullptr; // goes before the step
    epoch checked_{};                       // in which what was checked last holds
    bool is_leading_ = false;               // nothing but stops so far
    bool has_written_ = false;
    bool has_lost_ = false;
};

} // namespace servobus
