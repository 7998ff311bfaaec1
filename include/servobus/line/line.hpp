// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A half-duplex line and the exchanges on it. The line decides which exchange may send and when: it keeps the
// gaps between frames, waits a quarantine after a failed exchange, and drops bytes that belong to no
// response. An exchange is moved on by one `step` in each loop iteration, or run to its end. A program makes
// one line for each wire, on its port; clients, facades and buses refer to it.
//
//     posix::serial port;
//     if (port.open("/dev/ttyUSB0", posix::settings_of(zlac8015d::device::facts)) != errc::ok) return 1;
//     line wire{port, modbus::timing_at(zlac8015d::device::facts.baud)};
//     zlac8015d::drive wheels{wire, 1, {.command_timeout = milliseconds(500)}};
//     yako::closed_loop::drive lift{wire, 2}; // on the same wire
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/core/epoch.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/small_core.hpp>
#include <servobus/line/detail/arbiter.hpp>
#include <servobus/line/detail/chunk.hpp>
#include <servobus/line/detail/epoch_counters.hpp>
#include <servobus/line/detail/line_gap.hpp>
#include <servobus/line/detail/stall_detector.hpp>
#include <servobus/line/echo.hpp>
#include <servobus/line/observer.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/exchange.hpp>

namespace servobus {

/// A line on `Port`. All nodes on the wire share this one object, which is used from one context only.
/// `Lengths` is `modbus::open_lengths` for responses whose length no request tells (modbus/response_lengths.hpp).
template <port Port, observer Observer = counters, class Echo = unechoed,
          class Lengths = modbus::fixed_lengths>
class line {
  public:
    using lengths = Lengths;
    using port_type = Port;
    using exchange = modbus::basic_exchange<modbus::default_crc, Lengths>;
    using crc = typename exchange::crc; ///< the engine of all frames, built and checked
    static constexpr bool is_small = false;
    static constexpr std::size_t longest_frame = modbus::max_frame; ///< bytes
    template <class, bool = false, bool = false, class = priority> using exchange_for = exchange;

    /// `on` and the timing's baud rate must fit the wire. The first request waits for a quarantine.
    constexpr line(Port& on, modbus::rtu_timing timing, Observer watch = {}, Echo echo = {})
        : port_{&on}, timing_{timing}, observer_{std::move(watch)}, echo_{echo} {}

    // Two lines on one wire would not keep each other's gaps.
    line(const line&) = delete;
    line& operator=(const line&) = delete;

    constexpr const modbus::rtu_timing& timing() const { return timing_; }
    constexpr Observer& observer() { return observer_; }
    constexpr const Observer& observer() const { return observer_; }
    constexpr Port& port() { return *port_; }
    constexpr Echo& echo() { return echo_; }
    /// True if a response of this node that equals its request, such as that to function 06, is no echo. False until
    /// the first response that cannot be an echo: to a read, to a multiple write, or an exception, of any node. False
    /// again after a request to the node without a valid response, until the node sends one that cannot be an echo:
    /// there are adapters that return what they send while no node drives the wire. The counters of `epoch` serve for
    /// it, so that node 9 counts as node 1.
    constexpr bool is_echo_ruled_out(std::uint8_t node_address) const {
        return !(epochs_.is_suspect(node_address) | is_echo_possible_);
    }
    /// The same of all nodes.
    constexpr bool is_echo_ruled_out() const { return !(is_echo_possible_ || epochs_.is_any_suspect()); }
    constexpr instant now() const { return port_->now(); }
    /// When the port took the first byte of the last request: no node received it earlier than this, however
    /// late the program checked that it had left.
    constexpr instant began_at() const { return started_; }
    /// Another value once what was learned of the node may be stale: after a request to it without a valid
    /// response, by any client, and after a loss of the port. Eight counters serve all nodes, so that a missing
    /// response of node 9 counts for node 1 too. An exchange that was not stepped to its end counts for all
    /// nodes, from the next request or call of `is_free` on.
    [[gnu::always_inline]] constexpr servobus::epoch epoch(std::uint8_t node_address) const {
        return epochs_.of(node_address);
    }
    /// What was learned of the node, or with address 0 of all nodes, is stale from now on.
    constexpr void begin_epoch(std::uint8_t node_address) {
        if (node_address == modbus::broadcast)
            epochs_.count_miss_of_all();
        else
            epochs_.begin(node_address);
    }

    /// A setting of the node that a facade caches was written by another client. Address 0: of all nodes. The facade's
    /// settings are stale from now on.
    constexpr void note_change(std::uint8_t node_address) {
        epochs_.count_change();
        if (node_address == modbus::broadcast) epochs_.count_change(); // as two, which count for all nodes
        changed_node_ = node_address;
    }
    /// The node of the last change.
    constexpr std::uint8_t changed_node() const { return changed_node_; }

    /// Moves `x` on as far as possible without waiting; `x.done()` tells whether it has ended. Returns a time
    /// during which no further step is needed unless a byte arrives.
    /// An exchange is stepped on one line only. One exchange at a time has the line. Another one waits until it
    /// has ended; a stop (`x.priority()`) pre-empts it unless its request has begun to leave. To give an
    /// exchange up, call `abandon`. One that is not stepped for longer than it can take loses the line to the
    /// next exchange that is stepped: it ends with `timeout`, and is not sent again, if any of it has left; else
    /// with `busy`.
    constexpr duration step(exchange& x, const bus_gaps& wanted) {
        if (x.done()) return {};
        if (!arbiter_.is_held_by(x.ticket()) && !is_granted(x, wanted)) return timing_.wire_time(1);
        return x.is_to_leave() ? send(x, wanted) : receive(x, now());
    }

    /// Runs `x` to its end: polls, or sleeps if the port can. Returns within `bound`, whatever the port and the
    /// clock do. Ends immediately with `busy` while another exchange has the line, which would not be stepped.
    constexpr void run(exchange& x, const bus_gaps& wanted) {
        end_unless_free(x);
        detail::stall_detector guard = new_stall_detector();
        const auto pause = [&](duration idle) {
            if (idle == duration{}) return; // a further step is possible
            if (guard.has_failed(now())) return finish(x, errc::clock_stopped);
            sleep(idle);
        };
        if constexpr (is_host) { // one branch less in each iteration, and one look at the clock
            while (x.is_to_leave()) pause(send(x, wanted));
            for (instant at = x.sent_at(); !x.done(); at = now()) pause(receive(x, at));
        } else {
            while (!x.done()) pause(x.is_to_leave() ? send(x, wanted) : receive(x, now()));
        }
    }

    /// Waits for a byte, at most `idle` and at most a few milliseconds, if the port can.
    constexpr void sleep([[maybe_unused]] duration idle) {
        if constexpr (waiting_port<Port>)
            port_->wait(idle < detail::longest_sleep ? idle : detail::longest_sleep);
    }
    /// Detects that this line's clock has stopped, in a loop that sleeps by `sleep`.
    constexpr detail::stall_detector new_stall_detector() const {
        return {gap_.last_activity(), detail::most_looks<Port>};
    }

    /// A stop is about to be stepped: until then, or for half a second, no other exchange that is stepped is sent.
    constexpr void announce_stop() { arbiter_.announce_stop(has_left(), now()); }

    /// True if an exchange that is stepped now would get the line.
    constexpr bool is_free() {
        free_if_forgotten();
        return !arbiter_.is_held() && !arbiter_.has_stop();
    }

    /// Continues with another timing, to which the port was set before. The next request waits for a
    /// quarantine, and an echo is possible again. Errors: `busy` while an exchange has the line; nothing changes.
    constexpr status retime(const modbus::rtu_timing& timing) {
        if (!is_free()) return errc::busy;
        timing_ = timing;
        gap_.require_quarantine_from(now());
        is_echo_possible_ = true;
        return errc::ok;
    }

    /// True while a request is leaving.
    constexpr bool is_sending() const { return static_cast<std::int16_t>(taken_) > 0; }

    /// True while a stop waits for the frame in flight.
    constexpr bool is_stop_waiting() const { return arbiter_.has_stop(); }

    /// Gives `x` up: it ends with `busy`, or with `timeout` if any of it has left. In that case the next request
    /// waits for a quarantine that begins when the response would be late.
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

    /// The longest that `run` takes for a request and a response of these lengths, in bytes, if it is called
    /// now: it may have to wait for the quarantine of another node.
    constexpr duration bound(std::size_t request, std::size_t response, const response_limits& limits,
                             const bus_gaps& wanted) const {
        return gap_.busy_limit(timing_, wanted) + send_limit(request) +
               longer_of(limits.response, limits.turnaround) +
               (timing_.longest_gap(1) + timing_.wire_time(1)) * static_cast<std::uint32_t>(response);
    }

  private:
    static constexpr bool is_host = !detail::is_small_core;

    static constexpr bool is_stop(const exchange& x) { return x.priority() == priority::stop; }
    static constexpr std::uint16_t whole = 0xFFFF; // as a signed number -1: `is_sending` is one comparison
    // A byte of the request has left, so that it cannot be called back.
    constexpr bool has_left() const { return taken_ != 0; }

    constexpr bool is_granted(exchange& x, const bus_gaps& wanted) {
        if (x.state() != exchange::phase::ready) { // it has lost the line
            end_without_line(x);
            return false;
        }
        free_if_forgotten();
        if (x.ticket() == 0) x.set_ticket(arbiter_.new_ticket());
        if (!arbiter_.take(x.ticket(), is_stop(x), has_left(), now())) return false;
        waits_ = false;
        hold_timeout_ = gap_.busy_limit(timing_, wanted) + send_limit(x.request().size()) + x.longest();
        if constexpr (has_gateway<Port>) hold_timeout_ = hold_timeout_ + x.longest_response();
        return true;
    }

    // Ends `x` if it cannot have the line now.
    constexpr void end_unless_free(exchange& x) {
        if (arbiter_.is_held()) {
            if (arbiter_.is_held_by(x.ticket())) return;
            free_if_forgotten();
        }
        if (arbiter_.is_held() || x.state() != exchange::phase::ready) end_without_line(x);
    }

    // `x` does not have the line. If any of it has left, its outcome is unknown.
    [[gnu::cold]] static constexpr void end_without_line(exchange& x) {
        x.abort(x.was_sent() ? errc::timeout : errc::busy, false);
    }

    // Frees the line of an exchange that was not stepped for longer than it can take.
    constexpr void free_if_forgotten() {
        if (!arbiter_.is_held()) return;
        const instant at = now();
        if (since(started_, at) <= hold_timeout_) return;
        gap_.require_quarantine_from(at);
        if (has_left()) {
            epochs_.count_miss_of_all(); // its address is not known any more
            if (went_back(started_, at)) gap_.require_quarantine_from(at, hold_timeout_);
        }
        release();
    }

#if __SIZEOF_SIZE_T__ < 8 // one copy
    [[gnu::noinline]]
#endif
    constexpr void
    release() {
        arbiter_.release();
        if (is_sending()) gap_.note_cut();
        waits_ = false;
        taken_ = 0;
    }

    constexpr duration send_limit(std::size_t size) const {
        return timing_.wire_time(2 * size) + timing_.inter_byte + duration{timing_.t3_5};
    }

    // Zero from this and from `receive`: a further step is possible, or `x` has ended.
    constexpr duration send(exchange& x, const bus_gaps& wanted) {
        const std::size_t size = x.request().size();
        const bool is_first_look = taken_ == 0;
        if (is_first_look) {
            instant at = now(); // before the receiver is emptied: a byte that comes later is found next time
            if (drop_input(x, at)) return {};
            errc why = errc::line_busy;
            duration idle = gap_.left(*port_, timing_, wanted, x.priority(), at);
            if (idle == duration{}) {
                if (!offer(x, 0)) return {};
                // The port is not ready: the gap is measured again before the next offer.
                why = errc::send_failed;
                if (taken_ == 0) idle = timing_.wire_time(1);
            }
            if (idle != duration{}) {
                if (!waits_) started_ = at;
                waits_ = true;
                if (since(started_, at) <= gap_.busy_limit(timing_, wanted)) return idle;
                finish(x, why);
                return {};
            }
            begin(x, wanted, at);
        } else if (taken_ < size && !offer(x, taken_)) {
            return {};
        }
        if (taken_ < size || !port_->sent()) return sending(x);
        if (expects_echo()) return echoing(x);
        instant at = now();
        // The program was stopped between two calls of the port: what came meanwhile may be no response.
        if (is_first_look && since(started_, at) >= timing_.wire_time(size)) {
            x.begin_leaving();
            if (drop_input(x, at)) return {};
        }
        note_left(x, at);
        return {};
    }

    constexpr void note_left(exchange& x, instant at) {
        waits_ = false;
        taken_ = whole;
        gap_.note_activity(at);
        if constexpr (has_gateway<Port>)
            x.sent_to_gateway(at);
        else
            x.sent(at);
    }

    constexpr bool expects_echo() const {
        if constexpr (has_local_echo<Echo>) {
            return echo_.is_on;
        } else {
            return false;
        }
    }

    // The request has left. The rest of its echo is there, or comes somewhat later through USB.
    constexpr duration echoing([[maybe_unused]] exchange& x) {
        if constexpr (has_local_echo<Echo>) {
            detail::chunk given{};
            bytes after_echo;
            x.begin_leaving();
            while (!echo_.is_whole(x.request())) {
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
                note_left(x, now());
                if (!after_echo.empty()) take(x, after_echo, gap_.last_activity());
                if (!x.done()) return receive(x, now()); // in a slow loop the response may be there too
                conclude(x);
            }
        }
        return {};
    }

    // Offers the port what it has not taken yet. False if it failed.
    constexpr bool offer(exchange& x, std::uint16_t taken) {
        const bytes left = x.request().subspan(taken);
        const transfer took = port_->send(left);
        if (!took) {
            finish(x, taken == 0 || took.error() == errc::port_lost ? took.error() : errc::partial_send);
            return false;
        }
        taken_ = static_cast<std::uint16_t>(taken + (*took < left.size() ? *took : left.size()));
        return true;
    }

    // The port has taken the first byte of `x`.
    constexpr void begin(exchange& x, const bus_gaps& wanted, instant at) {
        if constexpr (has_local_echo<Echo>) echo_.begin();
        gap_.begin_request(wanted, x.priority());
        started_ = at;
        observer_.on_request(x.request());
    }

    constexpr duration sending(exchange& x) {
        x.begin_leaving();
        instant at = now();
        if (drop_input(x, at, true)) return {};
        const std::size_t size = x.request().size();
        // It is late, but the whole of it may have left while the program was stopped.
        if (since(started_, at) <= send_limit(size) || (taken_ == size && port_->sent()))
            return timing_.wire_time(1);
        finish(x, errc::partial_send);
        return {};
    }

    // Takes what has arrived, at most the length of a frame: a port might never be empty. A program may stall
    // between any two calls of its port. So `at` is read before the receiver is found empty, and after the
    // bytes came: the time between the two was a gap.
    constexpr duration receive(exchange& x, instant at) {
        for (std::size_t taken = 0;;) {
            detail::chunk given{};
            const transfer came = port_->receive(given.all);
            if (!came) {
                finish(x, came.error());
                return {};
            }
            if (*came != 0) {
                const bytes arrived = given.first(*came);
                at = now();
                take(x, arrived, at);
                if (x.done()) break;
                taken += arrived.size();
                if (taken < modbus::max_frame) continue;
            }
            const duration idle = x.elapse(at);
            if (!x.done()) {
                if constexpr (expecting_port<Port>) {
                    if (!x.response().empty()) port_->expect(static_cast<std::uint16_t>(x.missing()));
                }
                return idle;
            }
            break;
        }
        conclude(x);
        return {};
    }

    constexpr void take(exchange& x, bytes arrived, instant at) {
        gap_.note_activity(at);
        const std::size_t used = x.feed_late(arrived, at);
        if (used == arrived.size()) return;
        gap_.note_unexpected(arrived.subspan(used));
        observer_.on_unexpected(arrived.subspan(used));
    }

    // Empties the receiver: what came before the request had left belongs to no response. While it leaves,
    // that is its echo or a collision. Sets `at` to the time after the last byte, if there was one. True if
    // the port failed, which ends `x`.
    constexpr bool drop_input(exchange& x, instant& at, bool is_leaving = false) {
        detail::chunk given{};
        for (std::size_t dropped = 0; dropped < 4096;) {
            const transfer came = port_->receive(given.all);
            if (came && *came == 0) [[likely]]
                return false;
            if (!came && came.error() != errc::receive_failed) {
                finish(x, came.error());
                return true;
            }
            at = now();
            gap_.note_activity(at);
            if (!came) { // a garbled character: another sender, or a driver that is switched off
                if (is_leaving)
                    x.pass_garbled();
                else
                    gap_.require_quarantine();
                return false;
            }
            const bytes arrived = given.first(*came);
            dropped += arrived.size();
            if (!is_leaving) {
                gap_.note_unexpected(arrived);
                observer_.on_unexpected(arrived);
            } else if constexpr (has_local_echo<Echo>) {
                if (echo_.is_on) (void)echo_.take(x.request(), arrived);
            }
            if (!expects_echo()) x.pass_while_leaving(arrived, at);
        }
        return false;
    }

    // Ends `x` early. Bytes that the port has taken may still leave, and the response may still come.
    [[gnu::cold]] constexpr void finish(exchange& x, errc why) {
        x.abort(why, false);
        conclude(x, true);
    }

    [[gnu::cold]] constexpr void note_failure(const exchange& x, bool is_early) {
        const instant at = now(); // a late response begins within the quarantine
        duration more{};
        if (x.was_sent()) {
            // A timeout that a jump of the clock has caused is early too.
            if (is_early || went_back(x.sent_at(), at))
                more = x.longest_wait() + timing_.wire_time(x.request().size());
            if (!x.is_broadcast()) epochs_.count_miss(x.address());
        }
        gap_.require_quarantine_from(at, more);
        if (x.status().error() == errc::port_lost && gap_.note_loss()) {
            is_echo_possible_ = true;
            epochs_.count_loss();
        }
        release();
    }

    constexpr void conclude(exchange& x, bool is_early = false) {
        if constexpr (has_gateway<Port>) x.note_gateway();
        if (!x.status().has_response()) {
            note_failure(x, is_early);
        } else {
            if (x.differs_from_request()) {
                is_echo_possible_ = false;
                epochs_.clear_suspicion(x.address());
            }
            if constexpr (is_host) {
                arbiter_.release();
                taken_ = 0;
            } else {
                release(); // it is there already
            }
        }
        observer_.on_response(x.response(), x.status());
    }

    // The bytes first: a short instruction of a small core reaches no further than 31 bytes for them.
    bool waits_ = false;           // for the gap, since `started_`
    bool is_echo_possible_ = true; // of all nodes: no response so far was different from its request
    detail::epoch_counters<8> epochs_;
    std::uint16_t taken_ = 0; // bytes of the request of the exchange that has the line, or `whole`
    detail::line_gap gap_;
    [[no_unique_address]] detail::arbiter arbiter_;
    std::uint8_t changed_node_ = 0; // in a byte that the arbiter leaves free
    Port* port_;
    modbus::rtu_timing timing_;
    instant started_{}; // waiting, or sending
    duration hold_timeout_{};
    [[no_unique_address]] Observer observer_;
    [[no_unique_address]] Echo echo_;
};

} // namespace servobus
