// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line for blocking calls only, for cores with little flash and RAM. It keeps the promises that `line` keeps
// to a client, but has no arbitration between exchanges, no echo handling and no observer, and its timing is
// a constant of the program. Firmware for a small core includes it in place of line/line.hpp.
//
//     blocking_line<my_uart, modbus::timing_at(115200)> wire{uart};
//     client wheels{wire, fixed_node<zlac8015d::device, 1>{}}; // takes no RAM for the node's limits
//     if (!wheels.write<zlac8015d::left_acceleration_time>(800 * millisecond)) return 1;
//
// A transaction: `leave` waits for the gap and sends the request, `await` gathers the response until it is
// whole or a gap follows, `judged` checks it. Its state is in fields and not in variables: a Cortex-M0+ has
// registers for half of them, and reaches a field by one short instruction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/epoch.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>
#include <servobus/line/detail/epoch_counters.hpp>
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
    Port* port_ = nullptr;
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

/// A line on `Port` with the gaps of `Timing`, which must fit the wire's baud rate. After an exchange without
/// a valid response the next request waits for `Quarantine`, which must be long enough for every node. All
/// nodes on the wire share this one object, which is used from one context only. After bytes that are no
/// response to the request, those up to the next gap are ignored; where their CRC fits, a gap of t3.5 is
/// enough. A port without members is copied.
template <port Port, modbus::rtu_timing Timing, duration Quarantine = milliseconds(100),
          modbus::crc_engine Crc = modbus::default_crc, class Lengths = modbus::fixed_lengths>
class blocking_line : modbus::gathering<std::uint8_t, Lengths> {
    using gathering = modbus::gathering<std::uint8_t, Lengths>;
    using gathering::count_;
    using gathering::length_;
    using gathering::lengths_;
    using gathering::request_;
    using gathering::response_;
    using gathering::same_;
    using gathering::size_;

  public:
    using lengths = Lengths;
    using port_type = Port;
    static constexpr bool is_small = true;            ///< a client passes it constants where it can
    using crc = Crc;                                  ///< the engine of all frames, built and checked
    static constexpr std::size_t longest_frame = 255; ///< bytes; function 10h needs no more

    /// A request and room for its response. `Limits` is `response_limits`, or a class that has its figures as
    /// constants; `Priority` likewise. A broadcast, and a function other than 01..06, 0F and 10h, are types of
    /// their own, so that only a program that sends one pays for it.
    template <class Limits, bool IsBroadcast = false, bool IsAnyFunction = false, class Priority = priority>
    class exchange_for {
      public:
        /// `response` has room for the whole response; for a write it may be the memory of the request. The
        /// response to another function is as long as `response`.
        constexpr exchange_for(bytes request, byte_buffer response, const modbus::rtu_timing&,
                               const Limits& limits, Priority of = {})
            : exchange_for{request, response.first(length_in(response, request)), limits,
                           request.size() >= 8 && modbus::repeats_a_value(request[1]), of} {}

        /// One whose response is as long as `rule` says, at most as `response`, where the request itself does not say
        /// it. For a line with `modbus::open_lengths`.
        template <class Rule>
        constexpr exchange_for(bytes request, byte_buffer response, const Rule& rule,
                               const modbus::rtu_timing&, const Limits& limits,
                               Priority of) requires(Lengths::are_open)
            : exchange_for{request, response.first(rule.is_valid() ? length_in(response, request) : 0),
                           limits, false, of} {
            if (response_.empty() || modbus::like(request[1]) != modbus::like_none) return;
            lengths_ = Lengths{rule, request.subspan(1, request.size() - 3)};
        }

        /// The same unchecked, for a caller that has made both to fit. `is_single`: function 05, 06 or 16h.
        static constexpr exchange_for trusted(bytes request, byte_buffer response, const Limits& limits,
                                              bool is_single, Priority of) {
            return {request, response, limits, is_single, of};
        }

        /// The response is the function alone, 4 bytes with address and CRC. No effect where the function fixes more.
        constexpr void expect_function_alone() {
            if (!response_.empty() && modbus::expected_response(request_) == modbus::any_length)
                response_ = response_.first(modbus::min_frame);
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
        constexpr exchange_for(bytes request, byte_buffer response, const Limits& limits, bool is_single,
                               Priority of)
            : request_{request}, response_{response}, limits_{limits}, priority_{of}, is_single_{is_single} {}

        // 0 for a request that is no frame of this kind, or without room.
        static constexpr std::size_t length_in(byte_buffer response, bytes request) {
            if (request.size() < modbus::min_frame || request.size() > longest_frame) return 0;
            const std::uint8_t code = request[1];
            if (code == 0 || code >= modbus::exception_flag) return 0;
            if (!IsAnyFunction && code > 0x06 && code != 0x0F && code != 0x10) return 0;
            std::size_t length = modbus::expected_response(request);
            if (length == modbus::any_length) {
                if (IsBroadcast) return 0;
                length = response.size();
            }
            if (IsBroadcast && modbus::has_count(modbus::like(request[1]))) return 0; // it would read
            if (IsBroadcast ? request[0] != modbus::broadcast
                            : !modbus::is_node_address(request[0]) && request[0] != modbus::peer_address)
                return 0;
            return length >= 5 && length <= response.size() && length <= longest_frame ? length : 0;
        }

        bytes request_;
        byte_buffer response_;
        [[no_unique_address]] Limits limits_;
        [[no_unique_address]] Priority priority_;
        bool is_single_; // apart, so that a program that sends none has nothing of it
        [[no_unique_address]] Lengths lengths_{};
    };

    /// The first request waits for a quarantine. The line reads the clock before the receiver: if the program
    /// stalls between the two, the gap before the next request is shorter by as much.
    constexpr explicit blocking_line(Port& port) : port_{port} {}

    // Two lines on one wire would not keep each other's gaps.
    blocking_line(const blocking_line&) = delete;
    blocking_line& operator=(const blocking_line&) = delete;

    static constexpr const modbus::rtu_timing& timing() { return the_timing; }
    constexpr Port& port() { return port_.get(); }
    constexpr instant now() const { return port_.get().now(); }
    /// Another value once what was learned of a node may be stale: after a loss of the port, and after a
    /// request without a valid response by a client that learns something of its node. One counter serves all
    /// nodes.
    constexpr servobus::epoch epoch(std::uint8_t node_address) const { return epochs_.of(node_address); }
    /// What was learned of the nodes is stale from now on.
    constexpr void begin_epoch(std::uint8_t node_address) { epochs_.count_miss(node_address); }
    /// The length of the last response, in bytes: of one that is as long as a rule says.
    constexpr std::size_t response_size() const { return length_; }
    /// True from a response on that no echo can be, until a request is not answered by exactly one valid response;
    /// see `line::is_echo_ruled_out`. One flag serves all nodes.
    constexpr bool is_echo_ruled_out(std::uint8_t /*node_address*/ = 0) const { return is_echo_ruled_out_; }

    /// Runs `x` to its end: polls, or sleeps if the port can. Returns how it ended, within `bound`, whatever
    /// the port and the clock do. Errors of its own: `bad_argument` for a request that is no frame, or a node
    /// whose quarantine is longer than the line's.
    template <class Limits, bool IsBroadcast, bool IsAnyFunction, class Priority, class Gaps>
    [[gnu::always_inline]] constexpr status
    run(const exchange_for<Limits, IsBroadcast, IsAnyFunction, Priority>& x, const Gaps& wanted) {
        if (x.response_.empty() || wanted.quarantine > Quarantine) return errc::bad_argument;
        auto sizes = static_cast<std::uint32_t>(x.request_.size() | x.response_.size() << 8);
        if constexpr (Lengths::are_open) lengths_ = x.lengths_;
        status w;
        if constexpr (std::is_empty_v<Limits> && std::is_empty_v<Gaps> && std::is_empty_v<Priority>) {
            w = carried<IsBroadcast, IsAnyFunction, Limits, Gaps>(x.request_.data(), x.response_.data(),
                                                                  sizes);
        } else {
            if (x.priority_ == priority::stop) sizes |= stop_bit;
            w = carried<IsBroadcast, IsAnyFunction>(x.request_.data(), x.response_.data(), sizes, x.limits_,
                                                    wanted);
        }
        if (x.is_single_ && w.error() == errc::wrong_quantity) w.end(errc::wrong_value);
        return w;
    }

    /// The longest that `run` takes for a response of this length, in bytes.
    static constexpr duration bound(std::size_t /*request*/, std::size_t response,
                                    const response_limits& limits, const bus_gaps& wanted) {
        return busy_limit(wanted.gap) * 2 + longer_of(limits.response, limits.turnaround) +
               gap_inside * static_cast<std::uint32_t>(response + 1);
    }

  private:
    static constexpr modbus::rtu_timing the_timing = Timing;
    static constexpr duration t3_5{Timing.t3_5};
    static constexpr duration gap_inside = Timing.longest_gap(1);
    static constexpr duration pause = t3_5 + Timing.wire_time(1) - microseconds(1); // and the byte after it
    static constexpr duration after_error = longer_of(Timing.visible_gap(), Quarantine);
    static constexpr duration gap_before(duration gap) { return longer_of(t3_5, gap); }
    // A late response may begin at the end of the quarantine, which then begins anew; then the request leaves.
    static constexpr duration busy_limit(duration gap) {
        return (after_error + gap_before(gap)) * 2 + Timing.wire_time(2 * modbus::max_frame) +
               Timing.inter_byte;
    }
    static constexpr unsigned looks_log2 = detail::most_looks_log2<Port>;

    // A response that ended too early.
    static constexpr errc cut =
        Timing.mode == modbus::timing_mode::strict ? errc::bad_gap : errc::truncated_response;

    // With strict timing a shorter gap ends every frame.
    static constexpr bool has_pauses = gap_inside > pause;

    // True if bytes that have arrived are taken without a look at the clock between them. With strict timing the
    // line looks at the clock for each byte.
    static constexpr bool takes_at_once = Timing.mode != modbus::timing_mode::strict;

    static constexpr duration unknown{0x8000'0000}; // `is_past`, also some time later
    static constexpr duration no_limit{0x4000'0000};
    static constexpr int nothing = -1;
    static constexpr int over = -2;
    static constexpr std::uint8_t more =
        0xFF;                           // bytes than a response that could be the request's beginning has
    static constexpr int noise = 0x100; // a garbled byte
    static constexpr bool is_glitch(int received) { return received == 0x00 || received == 0xFF; }
    static constexpr bool is_past(duration left) { return static_cast<std::int32_t>(left.us) < 0; }

    static constexpr std::uint32_t stop_bit = std::uint32_t{1} << 16;

    // The sizes of request and response, and `stop_bit`, share a register. Figures that are constants take none.
    template <bool IsBroadcast, bool IsAnyFunction, class Limits, class Gaps>
    [[gnu::noinline]] constexpr status carried(const std::uint8_t* request, std::uint8_t* response,
                                               std::uint32_t sizes) {
        return carry<IsBroadcast, IsAnyFunction, false>(request, response, sizes, Limits{}, Gaps{});
    }
    template <bool IsBroadcast, bool IsAnyFunction, class Limits, class Gaps>
    [[gnu::noinline]] constexpr status carried(const std::uint8_t* request, std::uint8_t* response,
                                               std::uint32_t sizes, const Limits& limits,
                                               const Gaps& wanted) {
        return carry<IsBroadcast, IsAnyFunction, true>(request, response, sizes, limits, wanted);
    }
    template <bool IsBroadcast, bool IsAnyFunction, bool MayBeStop, class Limits, class Gaps>
    [[gnu::always_inline]] constexpr status carry(const std::uint8_t* request, std::uint8_t* response,
                                                  std::uint32_t sizes, const Limits& limits,
                                                  const Gaps& wanted) {
        request_ = request;
        response_ = response;
        size_ = static_cast<std::uint8_t>(sizes & 0xFFu);
        gathering::begin_gathering();
        length_ = static_cast<std::uint8_t>(sizes >> 8 & 0xFFu);
        if constexpr (Lengths::are_open) gathering::begin_open(lengths_);
        bool owes = false;
        const bool has_left = leave(wanted, MayBeStop && (sizes & stop_bit) != 0, owes);
        if constexpr (IsBroadcast && !has_gateway<Port>) {
            idle_ = {};
            if (has_left) wait_turnaround(limits.turnaround);
        } else {
            if (has_left) {
                await(limits);
                if (takes_at_once && last_ != instant{}) last_ = now(); // a gap counts from the last byte
            }
            idle_ = {}; // a quarantine counts from here: a late response begins within it
            if constexpr (Lengths::are_open) gathering::template end_open<Crc>();
            if (count_ != 0)
                ended_.end(gathering::template judged<Crc, IsAnyFunction>(
                    IsAnyFunction ? modbus::like(request_[1]) : request_[1], cut, limits, count_ > length_,
                    *this));
            if constexpr (has_gateway<Port>) {
                if (modbus::note_gateway(ended_, IsBroadcast)) idle_ = {};
            }
            if (IsBroadcast && ended_.error() == errc::timeout) { // no gateway has refused it
                ended_.end(errc::ok);
                idle_ = after_error;
            }
            if (idle_ != after_error) is_echo_ruled_out_ = false; // not by exactly one valid response
        }
        if (owes) idle_ = {};
        return ended_;
    }

    /// The byte that came, `nothing`, or `over`: the time has run out, or the port or its clock failed.
    [[gnu::noinline]] constexpr int look() {
        if (is_past(left_)) return over; // since the look before: a slow loop finds what came in time
        const instant now = port_.get().now();
        const duration passed = since(last_, now);
        last_ = now;
        if (static_cast<std::int32_t>(passed.us) > 0) {
            looks_ = 0;
            idle_ = idle_ + passed;
            left_ = left_ - passed;
        } else if (++looks_ >> looks_log2 != 0) { // it does not advance, or goes back again and again
            return failed(errc::clock_stopped);
        }
        return take();
    }
    /// The same without a look at the clock.
    [[gnu::always_inline]] constexpr int take() {
        std::uint8_t byte = 0;
        const transfer came = port_.get().receive(byte_buffer{&byte, 1});
        if (came) return *came == 0 ? nothing : byte;
        // Garbled before the request has left: another sender, a driver that is switched off, or an echo.
        if (came.error() == errc::receive_failed && ended_.error() != errc::timeout) return noise;
        return failed(came.error());
    }
    constexpr int failed(errc why) {
        ended_.end(why);
        count_ = 0; // what came of a response is not judged
        if (why == errc::port_lost) {
            is_echo_ruled_out_ = false;
            epochs_.count_loss();
            last_ = {}; // nothing is received until it is back
        }
        return over;
    }

    // Waits for the gap and sends. What is received meanwhile is no response. True once the request has left.
    template <class Gaps> constexpr bool leave(const Gaps& wanted, bool is_stop, bool& owes) {
        std::size_t left = size_;
        std::size_t echoed = 0; // bytes that came back while it left
        left_ = {};
        ended_ = errc::line_busy;
        if (last_ == instant{}) last_ = now();
        int received = look(); // the time between two calls is part of the gap, and not waiting
        left_ = busy_limit(wanted.gap);
        for (;; received = look()) {
            if (received == over) return false;
            if (!ended_.was_sent()) {
                if (received >= 0) {
                    if (!is_glitch(received) || idle_ < after_error)
                        idle_ = {};
                    else // a driver that is switched needs no quarantine
                        idle_ = after_error;
                    owes = false;
                }
                // A stop waits only for its node's own gap, and what follows it for the quarantine.
                if (is_stop && idle_ < after_error) owes = true;
                const duration needed = owes ? gap_before(wanted.gap) : after_error + gap_before(wanted.gap);
                if (idle_ < needed) {
                    rest(needed - idle_);
                    continue;
                }
                if (ended_.error() == errc::line_busy) { // the time limit of its own sending
                    ended_.end(errc::send_failed);
                    left_ = busy_limit(wanted.gap);
                }
            } else if (received == noise || (echoed < size_ && received == request_[echoed])) {
                ++echoed;
            } else if (received > 0 && !is_glitch(received)) {
                same_ = 0; // a frame of another node: in its rest no response begins
                idle_ = unknown;
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
                port_.get().sent()) { // what was received before is no response
                last_ = now();
                ended_.end(errc::timeout);
                return true;
            }
            rest(Timing.wire_time(1));
        }
    }

    // Gathers the response until it is whole, or a gap follows.
    template <class Limits> constexpr void await(const Limits& limits) {
        unsigned leading = limits.leading_bytes;
        // The CRC of another node's frame, which is over where it fits and t3.5 passes.
        unsigned other = 0xFFFF;
        left_ = limits.response;
        for (;;) {
            const int received = look();
            if (received == over) break;
            if (received == nothing) {
                if (is_past(idle_)) idle_ = {}; // from here on there is a gap
                const duration longest = other == 0 ? pause : gap_inside;
                if (idle_ > longest) {
                    if (count_ != 0) break;
                    same_ = size_; // another node's frame is over
                    other = 0xFFFF;
                }
                if constexpr (waiting_port<Port>) {
                    const bool is_inside = count_ != 0 || same_ == 0;
                    const bool is_next = is_inside && !is_past(left_); // a gap, before the time is over
                    if constexpr (expecting_port<Port>) {
                        if (count_ != 0) port_.get().expect(static_cast<std::uint16_t>(length_ - count_));
                    }
                    rest(is_next ? shorter_of(left_, longest + microseconds(1) - idle_) : left_);
                }
                continue;
            }
            // The program may have stalled since it read the clock: only an empty look after this one begins a gap.
            idle_ = unknown;
            const auto byte = static_cast<unsigned>(received);
            if (same_ == 0 || !gathering::compare(byte)) {
                if (same_ != 0 && is_glitch(received) && leading != 0) {
                    --leading;
                    continue;
                }
                same_ = 0;
                if constexpr (has_pauses) other = crc_bit_by_bit(other, byte);
                continue;
            }
            if (gathering::
                    is_whole()) { // and equal to the request's beginning: if more bytes follow, its echo
                count_ = more;
                break;
            }
            gathering::store(byte);
            left_ = no_limit; // but a gap
            if constexpr (takes_at_once) {
                if (!take_burst()) break;
            }
            if (gathering::is_whole() && !gathering::may_be_echo()) break;
        }
    }
    // Takes the bytes that have arrived, and none after the response: a garbled one may follow, as a driver is
    // switched. False if the port failed.
    [[gnu::always_inline]] constexpr bool take_burst() {
        int next = 0;
        while (!gathering::is_whole() && (next = take()) >= 0) {
            (void)gathering::compare(static_cast<unsigned>(next));
            gathering::store(static_cast<unsigned>(next));
        }
        return next != over;
    }

    // The smallest code for one byte; bytes of other nodes are few.
    static constexpr unsigned crc_bit_by_bit(unsigned crc, unsigned byte) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? (crc >> 1) ^ 0xA001u : crc >> 1;
        return crc;
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

    status ended_{}; // of the transaction, if it ended now
    bool is_echo_ruled_out_ = false;
    detail::epoch_counters<1, detail::losses_alone> epochs_;
    instant last_{};          // look at the clock; zero: time counts from the next one
    duration idle_{};         // since the last byte, after trouble; a good end counts as `after_error`
    duration left_{};         // of the current time limit
    std::uint32_t looks_ = 0; // since the clock advanced
    [[no_unique_address]] detail::port_pointer<Port> port_;
};

} // namespace servobus
