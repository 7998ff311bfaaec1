// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line for blocking calls only, where flash and RAM are scarce: it keeps the promises that `line` keeps
// to a client. It has no arbitration between exchanges, no echo handling and no observer, and its timing
// is a constant of the program. Firmware for a small core includes it in place of line/line.hpp.
//
//     blocking_line<my_uart, modbus::timing_at(115200)> wire{uart};
//     client wheels{wire, fixed_node<zlac8015d::device, 1>{}}; // takes no RAM for the node's limits
//     if (!wheels.write<zlac8015d::left_acceleration_time>(800 * millisecond)) return 1;
//
//   leave: the gap, then the request until its last stop bit
//   await: the response, gathered until it is whole or the line is quiet
//   judged: what it is
//
// The state of a transaction is in fields of the line and not in variables: a Cortex-M0+ has registers for
// half of them, and reaches a field by one short instruction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/epoch.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>
#include <servobus/line/detail/stall_detector.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/gathering.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus {

namespace detail {
template <class Port> class port_pointer {
  public:
    constexpr explicit port_pointer(Port& p) : port_{&p} {}
    constexpr Port& get() const { return *port_; }

  private:
    Port* port_;
};
// A port that is nothing but functions needs no pointer to it.
template <class Port>
requires(std::is_empty_v<Port>&& std::is_trivially_copyable_v<Port>&&
             std::is_copy_constructible_v<Port>) class port_pointer<Port> {
  public:
    constexpr explicit port_pointer(Port& p) : port_{p} {}
    constexpr Port& get() const { return port_; }

  private:
    [[no_unique_address]] mutable Port port_;
};
} // namespace detail

/// A line on `Port` with the silences of `Timing`, which must fit the wire's baud rate; after trouble it is
/// silent for `Quarantine`, which must be enough for every node. All nodes on the wire go through this one
/// object; it is used from one context only. What is no response to the request is over at the next silence
/// of the line, and no sooner. A port without members is copied.
template <port Port, modbus::rtu_timing Timing, duration Quarantine = milliseconds(100),
          modbus::crc_engine Crc = modbus::default_crc>
class blocking_line : modbus::gathering<std::uint8_t> {
    using gathering = modbus::gathering<std::uint8_t>;

  public:
    static constexpr bool is_small = true;            ///< what a client asks of it, it asks by constants
    using crc = Crc;                                  ///< the engine of all frames, built and checked
    static constexpr std::size_t longest_frame = 255; ///< bytes; function 10h needs no more

    /// A request and room for its response. `Limits` is `response_limits`, or a class that has its figures as
    /// constants. A broadcast, and a function other than 03, 04, 06 and 10h, are types of their own, so that
    /// only a program that sends one pays for it.
    template <class Limits, bool IsBroadcast = false, bool IsAnyFunction = false> class exchange_for {
      public:
        /// `response` has room for the whole response; for a write it may be the memory of the request. The
        /// response to another function is as long as `response`.
        constexpr exchange_for(bytes request, byte_buffer response, const modbus::rtu_timing&,
                               const Limits& limits)
            : exchange_for{request, response.first(length_in(response, request)), limits,
                           request.size() == 8 && request[1] == 0x06} {}

        /// The same without a look at them, for who has just made both to fit. `is_single`: function 06.
        static constexpr exchange_for trusted(bytes request, byte_buffer response, const Limits& limits,
                                              bool is_single) {
            return {request, response, limits, is_single};
        }

        /// Length of the whole response in bytes; 0 if the request is no frame, or has too little room.
        constexpr std::size_t response_size() const { return response_.size(); }
        /// The words of a successful read.
        constexpr words_view words() const {
            return words_view{response_.size() < 5 ? bytes{}
                                                   : bytes{response_}.subspan(3, response_.size() - 5)};
        }

      private:
        friend class blocking_line;
        constexpr exchange_for(bytes request, byte_buffer response, const Limits& limits, bool is_single)
            : request_{request}, response_{response}, limits_{limits}, is_single_{is_single} {}

        // 0 for a request that is no frame of this kind, or without room.
        static constexpr std::size_t length_in(byte_buffer response, bytes request) {
            if (request.size() < modbus::min_frame || request.size() > longest_frame) return 0;
            const bool is_read = modbus::is_read(request[1]);
            if (!is_read && !modbus::is_write(request[1])) {
                const bool is_function = request[1] != 0 && request[1] < modbus::exception_flag;
                return IsAnyFunction && is_function && modbus::is_node_address(request[0]) &&
                               response.size() >= 5 && response.size() <= longest_frame
                           ? response.size()
                           : 0;
            }
            if (request.size() < 8) return 0;
            const bool has_sane_count = request[4] == 0 && request[5] != 0;
            if (is_read && (IsBroadcast || request.size() > 8 || !has_sane_count)) return 0;
            if ((request[0] == modbus::broadcast) != IsBroadcast) return 0;
            const std::size_t length = is_read ? 5u + 2u * request[5] : 8u;
            return length <= response.size() && length <= longest_frame ? length : 0;
        }

        bytes request_;
        byte_buffer response_;
        [[no_unique_address]] Limits limits_;
        bool is_single_; // apart, so that a program that sends none has nothing of it
    };

    /// The line is taken as troubled until it has been silent once. It reads the clock before the receiver:
    /// if the program stalls between the two while no response is awaited, the gap before the next request
    /// is shorter by as much.
    constexpr explicit blocking_line(Port& port) : port_{port} {}

    // One wire has one owner of its time.
    blocking_line(const blocking_line&) = delete;
    blocking_line& operator=(const blocking_line&) = delete;

    static constexpr const modbus::rtu_timing& timing() { return the_timing; }
    constexpr Port& port() { return port_.get(); }
    constexpr instant now() const { return port_.get().now(); }
    /// Another value once what was learned of a node may no longer hold: the port was lost, or a client that
    /// learns something of its node got no valid response. One counter serves all nodes.
    constexpr servobus::epoch epoch(std::uint8_t /*node_address*/) const { return {misses_, losses_}; }
    /// What was learned of the nodes holds no longer.
    constexpr void begin_epoch(std::uint8_t /*node_address*/) { ++misses_; }
    /// True once something was answered that no echo can be; see `line::is_echo_ruled_out`.
    constexpr bool is_echo_ruled_out() const { return is_echo_ruled_out_; }

    /// Runs `x` to its end: polls, or sleeps where the port can. Bounded by `bound`, whatever the transport
    /// and the clock do. Returns how it ended, for a read too. Errors of its own: `bad_argument` for a
    /// request that is no frame, or a node whose quarantine is longer than the line's.
    template <class Limits, bool IsBroadcast, bool IsAnyFunction, class Gaps>
    [[gnu::always_inline]] constexpr status run(const exchange_for<Limits, IsBroadcast, IsAnyFunction>& x,
                                                const Gaps& wanted) {
        if (x.response_.empty() || wanted.quarantine > Quarantine) return errc::bad_argument;
        const auto sizes = static_cast<std::uint32_t>(x.request_.size() | x.response_.size() << 8);
        status w;
        if constexpr (std::is_empty_v<Limits> && std::is_empty_v<Gaps>) {
            w = carried<IsBroadcast, IsAnyFunction, Limits, Gaps>(x.request_.data(), x.response_.data(),
                                                                  sizes);
        } else {
            w = carried<IsBroadcast, IsAnyFunction>(x.request_.data(), x.response_.data(), sizes, x.limits_,
                                                    wanted);
        }
        if (x.is_single_ && w.error() == errc::wrong_quantity) w.end(errc::wrong_value);
        return w;
    }

    /// The longest that `run` takes for a response of this length, if it is begun now.
    static constexpr duration bound(std::size_t /*request*/, std::size_t response,
                                    const response_limits& limits, const bus_gaps& wanted) {
        return busy_limit(wanted.gap) * 2 + longer_of(limits.response, limits.turnaround) +
               gap_inside * static_cast<std::uint32_t>(response + 1);
    }

  private:
    static constexpr modbus::rtu_timing the_timing = Timing;
    static constexpr duration t3_5{Timing.t3_5};
    static constexpr duration gap_inside = Timing.longest_gap(1);
    static constexpr duration after_error = longer_of(Timing.visible_gap(), Quarantine);
    static constexpr duration gap_before(duration gap) { return longer_of(t3_5, gap); }
    // A late response may begin at the end of the silence, and then it is needed in full; and the request.
    static constexpr duration busy_limit(duration gap) {
        return (after_error + gap_before(gap)) * 2 + Timing.wire_time(2 * modbus::max_frame) +
               Timing.inter_byte;
    }
    // Looks at a clock that does not go on: about as many as a `line` takes, and no constant to load.
    static constexpr unsigned looks_log2 = waiting_port<Port> ? 13 : 22;

    // A response that ended too early.
    static constexpr errc cut =
        Timing.mode == modbus::timing_mode::strict ? errc::bad_gap : errc::truncated_response;

    static constexpr std::uint32_t without_clock = ~std::uint32_t{}; // so is the next look
    static constexpr int nothing = -1;
    static constexpr int over = -2;
    static constexpr std::uint8_t more =
        0xFF; // bytes than a response that could be the request's beginning has
    static constexpr int noise = 0x55;
    static constexpr bool is_glitch(int received) { return received == 0x00 || received == 0xFF; }
    static constexpr bool is_past(duration left) { return static_cast<std::int32_t>(left.us) < 0; }

    // Figures that are constants take no registers.
    template <bool IsBroadcast, bool IsAnyFunction, class Limits, class Gaps>
    [[gnu::noinline]] constexpr status carried(const std::uint8_t* request, std::uint8_t* response,
                                               std::uint32_t sizes) {
        return carry<IsBroadcast, IsAnyFunction>(request, response, sizes, Limits{}, Gaps{});
    }
    template <bool IsBroadcast, bool IsAnyFunction, class Limits, class Gaps>
    [[gnu::noinline]] constexpr status carried(const std::uint8_t* request, std::uint8_t* response,
                                               std::uint32_t sizes, const Limits& limits,
                                               const Gaps& wanted) {
        return carry<IsBroadcast, IsAnyFunction>(request, response, sizes, limits, wanted);
    }
    template <bool IsBroadcast, bool IsAnyFunction, class Limits, class Gaps>
    [[gnu::always_inline]] constexpr status carry(const std::uint8_t* request, std::uint8_t* response,
                                                  std::uint32_t sizes, const Limits& limits,
                                                  const Gaps& wanted) {
        request_ = request;
        response_ = response;
        size_ = static_cast<std::uint8_t>(sizes & 0xFFu);
        begin_gathering();
        length_ = static_cast<std::uint8_t>(sizes >> 8);
        bool owes = false;
        const bool has_left = leave(wanted, owes);
        if constexpr (IsBroadcast) {
            idle_ = {};
            if (has_left) wait_turnaround(limits.turnaround);
        } else {
            if (has_left) await(limits);
            idle_ = {}; // a quarantine counts from its end, and a late response begins within it
            if (count_ != 0) {
                last_ = now(); // not every byte was taken with a look at the clock
                ended_.end(
                    gathering::template judged<Crc, IsAnyFunction>(cut, limits, count_ > length_, *this));
            }
        }
        if (owes) idle_ = {};
        return ended_;
    }

    /// The byte that came, `nothing`, or `over`: the time has run out, or the port or its clock failed.
    [[gnu::noinline]] constexpr int look() {
        if (is_past(left_)) return over; // at the look before: a slow loop finds what came in time
        Port& port = port_.get();
        if (++looks_ != 0) {
            const instant now = port.now();
            const duration passed = since(last_, now);
            last_ = now;
            if (static_cast<std::int32_t>(passed.us) > 0) {
                looks_ = 0;
                idle_ = idle_ + passed;
                left_ = left_ - passed;
            } else if (looks_ >> looks_log2 != 0) { // it stands still, or goes back and back
                return failed(errc::clock_stopped);
            }
        }
        std::uint8_t byte = 0;
        const transfer came = port.receive(byte_buffer{&byte, 1});
        if (came) return *came == 0 ? nothing : byte;
        // Garbled before the request has left: somebody talks, lets go of the line, or it is our own echo.
        if (came.error() == errc::receive_failed && ended_.error() != errc::timeout) return noise;
        return failed(came.error());
    }
    constexpr int failed(errc why) {
        ended_.end(why);
        count_ = 0; // what came of a response is no matter
        if (why == errc::port_lost) {
            is_echo_ruled_out_ = false;
            ++losses_;
            ++misses_;  // of more bits: 256 tries are not none
            last_ = {}; // nobody listens until it is back
        }
        return over;
    }

    // Waits for the silence and sends. What is heard meanwhile is no response. True once the request has
    // left.
    template <class Gaps> constexpr bool leave(const Gaps& wanted, bool& owes) {
        std::size_t left = size_;
        left_ = {};
        ended_ = errc::line_busy;
        if (last_ == instant{}) last_ = now();
        int received = look(); // the time between two calls is silence, and not waiting
        left_ = busy_limit(wanted.gap);
        for (;; received = look()) {
            if (received == over) return false;
            if (!ended_.was_sent()) {
                if (received >= 0) {
                    if (!is_glitch(received) || idle_ < after_error)
                        idle_ = {};
                    else // a driver that is switched on or off: no trouble
                        idle_ = after_error;
                    owes = false;
                }
                // What follows a stop waits for it, and the stop itself only for its node's own gap.
                if (wanted.is_stop && idle_ < after_error) owes = true;
                const duration needed = owes ? gap_before(wanted.gap) : after_error + gap_before(wanted.gap);
                if (idle_ < needed) {
                    rest(needed - idle_);
                    continue;
                }
                if (ended_.error() == errc::line_busy) { // now its own time to leave
                    ended_.end(errc::send_failed);
                    left_ = busy_limit(wanted.gap);
                }
            }
            if (left != 0) {
                const transfer took = port_.get().send({request_ + size_ - left, left});
                if (!took) {
                    const bool is_cut = ended_.was_sent() && took.error() != errc::port_lost;
                    (void)failed(is_cut ? errc::partial_send : took.error());
                    return false;
                }
                const std::size_t count = *took;
                if (count != 0) ended_ = status::sent(errc::partial_send);
                left = count < left ? left - count : 0;
            }
            if (left == 0 && received == nothing &&
                port_.get().sent()) { // what was heard before is no response
                last_ = now();
                ended_.end(errc::timeout);
                return true;
            }
        }
    }

    // A response is gathered and judged when it is whole, or when the line falls silent.
    template <class Limits> constexpr void await(const Limits& limits) {
        unsigned leading = limits.leading_bytes;
        left_ = limits.response;
        for (;;) {
            const int received = look();
            if (received == over) break;
            if (idle_ > gap_inside) {
                if (count_ != 0) break;
                same_ = size_; // another node's frame is over
            }
            if (received == nothing) {
                rest(left_);
                continue;
            }
            idle_ = {};
            if (same_ == 0) continue;
            const auto byte = static_cast<unsigned>(received);
            if (!compare(byte)) {
                if (is_glitch(received) && leading != 0)
                    --leading;
                else
                    same_ = 0;
                continue;
            }
            if (is_whole()) { // it was the request's beginning too: its echo, if that goes on
                count_ = more;
                break;
            }
            store(byte);
            left_ = gap_inside;
            if (is_whole() && !may_be_echo()) break;
            looks_ = without_clock; // a byte that lies there already came together with this one
        }
    }

    friend gathering;
    constexpr void rule_out_echo() { is_echo_ruled_out_ = true; }
    constexpr void end_cleanly() { idle_ = after_error; }
    constexpr void note_exception(std::uint8_t number) { ended_.set_exception(number); }

    constexpr void wait_turnaround(duration turnaround) {
        left_ = turnaround;
        idle_ = after_error;
        for (int received = look(); received != over; received = look()) {
            if (received == nothing)
                rest(left_);
            else
                idle_ = {};
        }
        if (ended_.error() == errc::timeout)
            ended_.end(errc::ok);
        else
            idle_ = {};
    }

    constexpr void rest([[maybe_unused]] duration most) {
        if constexpr (waiting_port<Port>) {
            if (!is_past(most)) port_.get().wait(most < detail::longest_sleep ? most : detail::longest_sleep);
        }
    }

    status ended_{}; ///< what the transaction comes to if it ends now
    bool is_echo_ruled_out_ = false;
    std::uint8_t losses_ = 0; ///< of the port
    std::uint16_t misses_ = 0;
    instant last_{};          ///< look
    duration idle_{};         ///< the line has been, after trouble; a good end counts as `after_error`
    duration left_{};         ///< for what is under way
    std::uint32_t looks_ = 0; ///< since the clock went on
    [[no_unique_address]] detail::port_pointer<Port> port_;
};

} // namespace servobus
