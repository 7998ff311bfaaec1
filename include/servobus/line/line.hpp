// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One half-duplex line and its one owner: it decides which exchange may send when. It waits for the gaps,
// keeps a quarantine after a failed exchange, drops what cannot be a response, and moves an exchange on,
// by one `step` in each loop iteration or to its end. A program makes one line for each wire, on its port;
// clients, facades and buses refer to it.
//
//     posix::serial port;
//     if (port.open("/dev/ttyUSB0", posix::settings_of(zlac8015d::device::facts)) != errc::ok) return 1;
//     line wire{port, modbus::timing_at(zlac8015d::device::facts.baud)};
//     zlac8015d::drive wheels{wire, 1};
//     yako::closed_loop::drive lift{wire, 2}; // on the same wire
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/core/epoch.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/line/detail/arbiter.hpp>
#include <servobus/line/detail/stall_detector.hpp>
#include <servobus/line/echo.hpp>
#include <servobus/line/observer.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/exchange.hpp>

namespace servobus {

/// A line on `Port`. All nodes on the wire go through this one object; it is used from one context only.
template <port Port, observer Observer = counters, class Echo = unechoed> class line {
  public:
    using exchange = modbus::exchange;
    using crc = exchange::crc; ///< the engine of all frames, built and checked
    static constexpr bool is_small = false;
    static constexpr std::size_t longest_frame = modbus::max_frame; ///< bytes
    template <class, bool = false, bool = false> using exchange_for = exchange;

    /// `on` and the timing's baud rate must fit the wire. The line is taken as troubled until it has been
    /// silent once.
    constexpr line(Port& on, modbus::rtu_timing timing, Observer watch = {}, Echo echo = {})
        : port_{&on}, timing_{timing}, observer_{std::move(watch)}, echo_{echo} {}

    // One wire has one owner of its time.
    line(const line&) = delete;
    line& operator=(const line&) = delete;

    constexpr const modbus::rtu_timing& timing() const { return timing_; }
    constexpr Observer& observer() { return observer_; }
    constexpr const Observer& observer() const { return observer_; }
    constexpr Port& port() { return *port_; }
    constexpr Echo& echo() { return echo_; }
    /// True once something was answered that no echo can be: a read, a multiple write, an exception. Before
    /// that the response to function 06, which repeats its request, may be the line's own echo.
    constexpr bool is_echo_ruled_out() const { return is_echo_ruled_out_; }
    constexpr instant now() const { return port_->now(); }
    /// When the port took the first byte of the request that ended last: nobody heard that one any earlier,
    /// though the program may have looked late whether it has left.
    constexpr instant began_at() const { return started_; }
    /// Another value once what was learned of the node may no longer hold: a request to it got no valid
    /// response, whoever sent it, or the port was lost. Eight counters serve all nodes, so that a miss of
    /// node 9 counts for node 1 too. An exchange whose owner is gone counts for all nodes, as soon as the line
    /// is asked for by another (`is_free`).
    [[gnu::always_inline]] constexpr servobus::epoch epoch(std::uint8_t node_address) const {
        const std::uint8_t of_node = misses_[node_address % sizeof misses_];
        return {static_cast<std::uint16_t>(misses_of_all_ << 8 | of_node), losses_};
    }
    /// What was learned of the node, or with address 0 of all nodes, holds no longer.
    constexpr void begin_epoch(std::uint8_t node_address) {
        if (node_address == modbus::broadcast || ++misses_[node_address % sizeof misses_] == 0)
            ++misses_of_all_;
    }

    /// Moves `x` on as far as it goes without waiting. Returns the time within which nothing happens unless a
    /// byte comes; look at `x.done()` for the end. One exchange at a time: while another one is under way `x`
    /// waits for its turn, a stop (`is_stop`) for the frame in flight only. A caller that gives up earlier
    /// calls `abandon`; one that forgets to is taken for gone when its exchange has had all its time.
    /// An exchange that is not stepped for longer than its own time loses the line to whoever asks for it
    /// next. If any of it has left, it is never sent again and ends with `timeout` (its outcome is unknown),
    /// else `busy`.
    constexpr duration step(exchange& x, const bus_gaps& wanted) {
        if (x.done()) return {};
        if (!arbiter_.is_held_by(x.ticket()) && !is_granted(x, wanted)) return timing_.wire_time(1);
        return x.is_to_leave() ? send(x, wanted) : receive(x);
    }

    /// Runs `x` to its end: polls, or sleeps where the port can. Bounded by the line's busy limit, the
    /// frame's own time and the exchange's limits, whatever the transport and the clock do. While another
    /// exchange is under way it ends at once with `busy`: nobody else could move that one on.
    constexpr void run(exchange& x, const bus_gaps& wanted) {
        if (!is_free_for(x)) return;
        detail::stall_detector guard = new_stall_detector();
        const auto pause = [&](duration idle) {
            if (idle == duration{}) return; // it has moved on
            if (guard.has_failed(now())) return finish(x, errc::clock_stopped);
            sleep(idle);
        };
        if constexpr (is_host) { // on a host a branch less for each look
            while (x.is_to_leave()) pause(send(x, wanted));
        }
        while (!x.done()) pause(!is_host && x.is_to_leave() ? send(x, wanted) : receive(x));
    }

    /// Waits for a byte, at most `idle` and a few milliseconds, where the port can.
    constexpr void sleep([[maybe_unused]] duration idle) {
        if constexpr (waiting_port<Port>)
            port_->wait(idle < detail::longest_sleep ? idle : detail::longest_sleep);
    }
    /// Watches this line's clock in a loop that sleeps by `sleep`. It may take a long rest for one jump back.
    constexpr detail::stall_detector new_stall_detector() const {
        return {last_activity_, waiting_port<Port> ? detail::looks_sleeping : detail::looks_polling};
    }

    /// True if an exchange that is stepped now would be carried at once.
    constexpr bool is_free() {
        free_if_forgotten();
        return !arbiter_.is_held() && !arbiter_.has_stop();
    }

    /// Goes on with another timing, to which the port has been set. The line is as it was when it was made:
    /// troubled, and nobody has answered. `busy` while an exchange is under way, and nothing changes.
    constexpr errc retime(const modbus::rtu_timing& timing) {
        if (!is_free()) return errc::busy;
        timing_ = timing;
        last_activity_ = now();
        needs_quarantine_ = true;
        is_echo_ruled_out_ = false;
        return errc::ok;
    }

    /// True while a request is leaving.
    constexpr bool is_sending() const { return taken_ != 0; }

    /// Gives `x` up where it is. If any of it has left, the line is in quarantine afterwards, which begins
    /// when the response would be late.
    constexpr void abandon(exchange& x) {
        if (x.done()) return;
        if (!arbiter_.is_held_by(x.ticket())) {
            arbiter_.forget(x.ticket());
            end_without_line(x);
        } else if (x.state() == exchange::phase::ready) {
            end_without_line(x);
            release();
        } else {
            finish(x, errc::timeout);
        }
    }

    /// The longest that `run` takes for a request and a response of these lengths, if it is begun now: what
    /// the node before is owed counts.
    constexpr duration bound(std::size_t request, std::size_t response, const response_limits& limits,
                             const bus_gaps& wanted) const {
        return busy_limit(wanted) + send_limit(request) + longer_of(limits.response, limits.turnaround) +
               (timing_.longest_gap(1) + timing_.wire_time(1)) * static_cast<std::uint32_t>(response);
    }

  private:
    static constexpr bool is_host = sizeof(std::size_t) >= 8;

    constexpr bool is_granted(exchange& x, const bus_gaps& wanted) {
        if (x.state() != exchange::phase::ready) { // its time was over, and the line has gone on without it
            end_without_line(x);
            return false;
        }
        free_if_forgotten();
        if (x.ticket() == 0) x.set_ticket(arbiter_.new_ticket());
        if (!arbiter_.take(x.ticket(), wanted.is_stop, now())) return false;
        waits_ = false;
        hold_timeout_ = busy_limit(wanted) + send_limit(x.request().size()) + x.longest();
        return true;
    }

    constexpr bool is_free_for(exchange& x) {
        if (arbiter_.is_held()) {
            if (arbiter_.is_held_by(x.ticket())) return true;
            free_if_forgotten();
        }
        if (!arbiter_.is_held() && x.state() == exchange::phase::ready) return true;
        end_without_line(x);
        return false;
    }

    // The line is another one's, or nobody's. What has left of `x` is not sent again.
    [[gnu::cold]] static constexpr void end_without_line(exchange& x) {
        x.abort(x.was_sent() ? errc::timeout : errc::busy, false);
    }

    // The owner of the exchange under way is gone: the line was kept for it long enough.
    constexpr void free_if_forgotten() {
        if (!arbiter_.is_held()) return;
        const instant at = now();
        if (since(started_, at) <= hold_timeout_) return;
        needs_quarantine_ = true;
        last_activity_ = at;
        if (arbiter_.has_left()) {
            ++misses_of_all_; // its node is not known any more
            if (went_back(started_, at)) pending_quarantine_ = pending_quarantine_ + hold_timeout_;
        }
        release();
    }

    constexpr void release() {
        arbiter_.release();
        waits_ = false;
        cut_ = cut_ | taken_;
        taken_ = 0;
    }

    // The gap before a request; `is_quarantined`: the last exchange did not end in exactly one response.
    constexpr duration gap_before(const bus_gaps& wanted, bool is_quarantined) const {
        const duration between_frames = longer_of(duration{timing_.t3_5}, wanted.gap);
        return is_quarantined ? longer_of(longer_of(between_frames, timing_.visible_gap()),
                                          longer_of(wanted.quarantine, pending_quarantine_))
                              : between_frames;
    }

    // Another frame, a late response, may begin at the end of the quarantine, which then begins anew.
    constexpr duration busy_limit(const bus_gaps& wanted) const {
        return gap_before(wanted, true) * 2 + timing_.wire_time(2 * modbus::max_frame);
    }

    constexpr duration send_limit(std::size_t size) const {
        return timing_.wire_time(2 * size) + timing_.inter_byte + duration{timing_.t3_5};
    }

    // Zero from this and from `receive` means that `x` has moved on or ended.
    constexpr duration send(exchange& x, const bus_gaps& wanted) {
        const std::size_t size = x.request().size();
        const bool is_first_look = taken_ == 0;
        if (is_first_look) {
            instant at = now(); // before the receiver is emptied: a later byte is found at the next call
            if (drop_input(x, at)) return {};
            errc why = errc::line_busy;
            duration idle = missing_gap(wanted, at);
            if (idle == duration{}) {
                if (!offer(x)) return {};
                // Not ready: the gap is measured again before the next offer.
                why = errc::send_failed;
                if (taken_ == 0) idle = timing_.wire_time(1);
            }
            if (idle != duration{}) {
                waits_ = true;
                if (since(started_, at) <= busy_limit(wanted)) return idle;
                finish(x, why);
                return {};
            }
            begin(x, wanted, at);
        } else if (taken_ < size && !offer(x)) {
            return {};
        }
        if (taken_ < size || !port_->sent()) return sending(x);
        if (expects_echo()) return echoing(x);
        instant at = now();
        // It left between two calls of the port: what was received meanwhile may be older than the request.
        if (is_first_look && since(started_, at) >= timing_.wire_time(size) && drop_input(x, at)) return {};
        has_left(x, at);
        return {};
    }

    constexpr void has_left(exchange& x, instant at) {
        waits_ = false;
        taken_ = 0;
        last_activity_ = at;
        x.sent(at);
    }

    constexpr bool expects_echo() const {
        if constexpr (has_local_echo<Echo>) {
            return echo_.is_on;
        } else {
            return false;
        }
    }

    // All has left; the rest of its echo comes at once, or, through USB, somewhat later.
    constexpr duration echoing([[maybe_unused]] exchange& x) {
        if constexpr (has_local_echo<Echo>) {
            chunk given{};
            bytes after_echo;
            while (!echo_.is_whole(x.request())) {
                given = {};
                const transfer came = port_->receive(given.all);
                if (!came) {
                    finish(x, came.error());
                    return {};
                }
                const bytes arrived = given.first(*came);
                after_echo = arrived.subspan(echo_.take(x.request(), arrived));
                if (!arrived.empty()) continue;
                if (since(started_, now()) <= send_limit(x.request().size())) return timing_.wire_time(1);
                finish(x, errc::no_echo);
                return {};
            }
            if (echo_.differs()) {
                finish(x, errc::collision);
            } else {
                has_left(x, now());
                if (!after_echo.empty()) take(x, after_echo, last_activity_);
                if (!x.done()) return receive(x); // a slow loop: the response may lie there too
                conclude(x);
            }
        }
        return {};
    }

    // How long the line must still be silent.
    constexpr duration missing_gap(const bus_gaps& wanted, instant at) {
        if (!waits_) started_ = at;
        duration idle = since(last_activity_, at);
        if (needs_quarantine_ && (starts_anew_ || cut_ != 0)) {
            starts_anew_ = false; // nothing was received before this: the gap counts from here
            if (cut_ != 0 && port_->sent()) cut_ = 0;
            last_activity_ = now(); // after that look: it may have left just before
            if (cut_ != 0) return timing_.wire_time(1);
            idle = {};
        } else if (went_back(last_activity_, at)) {
            last_activity_ = at;
            idle = {};
        }
        const duration needed = gap_before(wanted, needs_quarantine_ && !wanted.is_stop);
        return idle < needed ? needed - idle : duration{};
    }

    // Offers the port what it has not taken yet. False if it failed.
    constexpr bool offer(exchange& x) {
        const bytes left = x.request().subspan(taken_);
        const transfer took = port_->send(left);
        if (!took) {
            finish(x, taken_ == 0 || took.error() == errc::port_lost ? took.error() : errc::partial_send);
            return false;
        }
        taken_ = static_cast<std::uint16_t>(taken_ + (*took < left.size() ? *took : left.size()));
        return true;
    }

    // The first byte of `x` has left. A stop waits for no quarantine, but what follows it does.
    constexpr void begin(exchange& x, const bus_gaps& wanted, instant at) {
        x.begin_leaving();
        glitches_ = 0;
        arbiter_.note_sending();
        if constexpr (has_local_echo<Echo>) echo_.begin();
        if (!wanted.is_stop) {
            pending_quarantine_ = wanted.quarantine;
            needs_quarantine_ = false;
        } else if (!needs_quarantine_ || pending_quarantine_ < wanted.quarantine) {
            pending_quarantine_ = wanted.quarantine;
        }
        started_ = at;
        observer_.on_request(x.request());
    }

    constexpr duration sending(exchange& x) {
        instant at = now();
        if (drop_input(x, at, true)) return {};
        // Late, but it may have left while the program was stopped.
        if (since(started_, at) <= send_limit(x.request().size()) || port_->sent())
            return timing_.wire_time(1);
        finish(x, errc::partial_send);
        return {};
    }

    // What a port gives in one call. Zeroed: the last response may lie in this very memory, and a port that
    // claims bytes which it did not write would give it again, CRC and all.
    struct chunk {
        std::uint8_t all[is_host ? 32 : 4]; // a small core clears 4 bytes by one store

        // Not more than there is, whatever a port claims.
        constexpr bytes first(std::uint16_t count) const {
            return {all, count < sizeof all ? count : sizeof all};
        }
    };

    // Takes what has arrived, at most a frame of it: a port may never be empty.
    constexpr duration receive(exchange& x) {
        std::size_t taken = 0;
        do {
            chunk given{};
            const transfer came = port_->receive(given.all);
            if (!came) {
                finish(x, came.error());
                return {};
            }
            const instant at = now();
            if (*came == 0) {
                const duration idle = x.elapse(at);
                if (x.done()) conclude(x);
                return taken == 0 ? idle : duration{};
            }
            const bytes arrived = given.first(*came);
            taken += arrived.size();
            take(x, arrived, at);
        } while (!x.done() && taken < modbus::max_frame);
        if (x.done()) conclude(x);
        return {};
    }

    constexpr void take(exchange& x, bytes arrived, instant at) {
        last_activity_ = at;
        // A full chunk: more may lie there.
        const std::size_t used = x.feed(arrived, at, arrived.size() < sizeof(chunk) ? arrived.size() : 32);
        if (used < arrived.size()) note_unexpected(arrived.subspan(used));
    }

    // Empties the receiver: what came before the request had left belongs to no response. While it leaves,
    // that is its echo or a collision. `at`, when this began, becomes when the last byte was taken. True if
    // the port failed, which ends `x`.
    constexpr bool drop_input(exchange& x, instant& at, bool is_leaving = false) {
        chunk given{};
        for (std::size_t dropped = 0; dropped < 4096;) {
            const transfer came = port_->receive(given.all);
            if (came && *came == 0) [[likely]]
                return false;
            if (!came && came.error() != errc::receive_failed) {
                finish(x, came.error());
                return true;
            }
            at = last_activity_ = now();
            if (!came) { // a garbled character: somebody talks, or lets go of the line
                needs_quarantine_ = needs_quarantine_ || !is_leaving;
                return false;
            }
            const bytes arrived = given.first(*came);
            dropped += arrived.size();
            if (!is_leaving) {
                note_unexpected(arrived);
            } else if constexpr (has_local_echo<Echo>) {
                if (echo_.is_on) (void)echo_.take(x.request(), arrived);
            }
        }
        return false;
    }

    // A few 0x00 or 0xFF bytes are the driver switching; anything else may be a second or late response,
    // after which the line must be silent for the quarantine.
    constexpr void note_unexpected(bytes unexpected) {
        for (const std::uint8_t b : unexpected) {
            if ((b != 0x00 && b != 0xFF) || ++glitches_ > 4) needs_quarantine_ = true;
        }
        observer_.on_unexpected(unexpected);
    }

    // `x` ends before its time: what the port has of it leaves all the same, and its response may come as
    // late as ever.
    [[gnu::cold]] constexpr void finish(exchange& x, errc why) {
        x.abort(why, false);
        conclude(x, true);
    }

    [[gnu::cold]] constexpr void note_failure(const exchange& x, bool is_early) {
        needs_quarantine_ = true;
        last_activity_ = now(); // the quarantine counts from here: a late response begins within it
        if (x.was_sent()) {
            // Or the clock has jumped back: no timeout.
            if (is_early || went_back(x.sent_at(), last_activity_))
                pending_quarantine_ =
                    pending_quarantine_ + x.longest_wait() + timing_.wire_time(x.request().size());
            if (!x.is_broadcast()) begin_epoch(x.address());
        }
        if (x.status().error() == errc::port_lost && !starts_anew_) {
            starts_anew_ = true;
            is_echo_ruled_out_ = false;
            ++losses_;
            ++misses_of_all_;
        }
        release();
    }

    constexpr void conclude(const exchange& x, bool is_early = false) {
        const errc why = x.status().error();
        if (why != errc::ok && why != errc::exception) {
            note_failure(x, is_early);
        } else {
            if (x.differs_from_request()) is_echo_ruled_out_ = true;
            arbiter_.release();
        }
        observer_.on_response(x.response(), x.status());
    }

    // The bytes first, where a short instruction of a small core reaches them.
    bool waits_ = false; // since `started_`
    bool needs_quarantine_ = true;
    bool is_echo_ruled_out_ = false;
    bool starts_anew_ = true; // a new line, or a port that was lost: nothing was received yet
    std::uint8_t glitches_ = 0;
    std::uint8_t losses_ = 0;
    std::uint8_t misses_of_all_ = 0;
    std::uint8_t misses_[8]{};
    std::uint16_t taken_ = 0; // bytes of the request, while it leaves
    std::uint16_t cut_ = 0;   // not 0: the port may still be sending a request that was given up
    detail::arbiter arbiter_;
    Port* port_;
    modbus::rtu_timing timing_;
    instant last_activity_{};
    instant started_{};
    duration pending_quarantine_{}; // the quarantine of the node that was spoken to last
    duration hold_timeout_{};
    [[no_unique_address]] Observer observer_;
    [[no_unique_address]] Echo echo_;
};

} // namespace servobus
