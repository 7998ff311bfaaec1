// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line for blocking calls only, where flash and RAM are scarce: it keeps the promises that `line` keeps to
// a client. It has no turns, no echo handling and no observer, and its timing is a constant of the program.
//
//     leave: the silence, and the request until its last stop bit      await: the reply
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bytes.hpp>
#include <servobus/clock_guard.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/patience.hpp>
#include <servobus/port.hpp>
#include <servobus/result.hpp>
#include <servobus/time.hpp>

namespace servobus {

/// A line on `Port` with the silences of `Timing`, which must fit the wire's baud rate; after trouble it is
/// silent for `Quarantine`, which must be enough for every node. All nodes on the wire go through this one
/// object; it is used from one context only. What is no reply to the request is over at the next silence of
/// the line, and no sooner.
template <port Port, modbus::rtu_timing Timing, duration Quarantine = milliseconds(100),
          modbus::crc_engine Crc = modbus::default_crc>
class small_line {
  public:
    /// One request and its reply, as a client makes them: of functions 03, 04, 06 and 10h. `Patience` is
    /// `patience`, or a class that has its figures as constants.
    template <class Patience> class exchange_for {
      public:
        /// `reply` has room for the whole reply.
        constexpr exchange_for(bytes request, byte_buffer reply, const modbus::rtu_timing&,
                               const Patience& limits)
            : request_{request}, reply_{reply.first(length_in(reply, request))}, limits_{limits} {}

        /// Why it ended; `errc::ok` is success.
        constexpr failure why() const { return why_; }
        /// True if any byte of the request may have been on the line.
        constexpr bool was_sent() const { return was_sent_; }
        /// The words of a successful read.
        constexpr words_view words() const { return words_view{bytes{reply_}.subspan(3)}; }

      private:
        friend class small_line;
        // 0 for a request that is no frame, or without room.
        static constexpr std::size_t length_in(byte_buffer reply, bytes request) {
            if (request.size() < 8) return 0;
            const std::size_t length = modbus::is_read(request[1]) ? 5u + 2u * request[5] : 8u;
            return length <= reply.size() ? length : 0;
        }

        bytes request_;
        byte_buffer reply_;
        [[no_unique_address]] Patience limits_;
        failure why_{errc::bad_argument};
        bool was_sent_ = false;
    };

    /// The line is taken as troubled until it has been silent once.
    constexpr explicit small_line(Port& port) : port_{&port}, last_activity_{port.now()} {}

    // One wire has one owner of its time.
    small_line(const small_line&) = delete;
    small_line& operator=(const small_line&) = delete;

    static constexpr const modbus::rtu_timing& timing() { return the_timing; }
    constexpr Port& port() { return *port_; }
    constexpr instant now() const { return port_->now(); }
    /// True once something was answered that no echo can be; see `line::is_proven`.
    constexpr bool is_proven() const { return is_proven_; }

    /// Runs `x` to its end: polls, or sleeps where the port can. Bounded by `bound`, whatever the transport
    /// and the clock do. Errors of its own: `bad_argument` for a request that is no frame, or a node whose
    /// quarantine is longer than the line's.
    template <class Exchange, class Silences> constexpr void run(Exchange& x, const Silences& wanted) {
        if (x.reply_.empty() || wanted.quarantine > Quarantine) return;
        if (x.request_[0] == modbus::broadcast && modbus::is_read(x.request_[1])) return;
        look around{*port_, last_activity_};
        errc why = leave(x, wanted, around);
        if (why == errc::ok)
            why = x.request_[0] == modbus::broadcast ? turn_round(x, around) : await(x, around);
        x.why_.code = why;
        if (why == errc::exception) x.why_.exception = x.reply_[2];
        if (why != errc::ok && why != errc::exception) {
            is_troubled_ = true;
            last_activity_ = around.at; // the quarantine counts from here: a late reply begins within it
            if (why == errc::port_lost) is_proven_ = false;
        } else if (why != errc::ok || (x.request_[1] != 0x06 && x.request_[0] != modbus::broadcast)) {
            is_proven_ = true;
        }
    }

    /// The longest that `run` takes for a request and a reply of these lengths, if it is begun now.
    static constexpr duration bound(std::size_t request, std::size_t reply, const patience& limits,
                                    const silences& wanted) {
        return busy_limit(wanted.gap) + send_limit(request) + longer_of(limits.response, limits.turnaround) +
               Timing.longest_gap(1) * static_cast<std::uint32_t>(reply + 1);
    }

  private:
    static constexpr modbus::rtu_timing the_timing = Timing;
    static constexpr duration t3_5{Timing.t3_5};
    static constexpr duration after_trouble = longer_of(Timing.visible_silence(), Quarantine);
    // A late reply may begin at the end of the silence, and then it is needed in full.
    static constexpr duration busy_limit(duration gap) {
        return longer_of(after_trouble, gap) * 2 + Timing.wire_time(2 * modbus::max_frame);
    }
    static constexpr duration send_limit(std::size_t size) {
        return Timing.wire_time(2 * size) + Timing.inter_byte + t3_5;
    }

    /// Looks at the port, one after the other.
    struct look {
        static constexpr unsigned nothing = 0x100;
        static constexpr unsigned failed = 0x200;

        Port& port;
        detail::clock_guard guard;
        instant at{};

        constexpr look(Port& on, instant start)
            : port{on}, guard{start, waiting_port<Port> ? detail::looks_sleeping : detail::looks_polling} {}

        /// The byte that came, `nothing`, or `failed` and the error.
        constexpr unsigned again() {
            at = port.now();
            if (guard.has_failed(at)) return failed | static_cast<unsigned>(errc::clock_stopped);
            std::uint8_t byte = 0;
            const transfer came = port.receive(byte_buffer{&byte, 1});
            if (!came) return failed | static_cast<unsigned>(came.error());
            return *came == 0 ? nothing : byte;
        }
    };
    static constexpr bool is_glitch(unsigned heard) { return heard == 0x00 || heard == 0xFF; }

    // Waits for the silence and sends. What is heard meanwhile is no reply.
    template <class Exchange, class Silences>
    constexpr errc leave(Exchange& x, const Silences& wanted, look& around) {
        const std::uint8_t* next = x.request_.data();
        std::size_t left = x.request_.size();
        instant started = now();
        duration limit = busy_limit(wanted.gap);
        unsigned glitches = 0;
        for (;;) {
            const unsigned heard = around.again();
            // Garbled: somebody talks, lets go of the line, or it is our own echo.
            constexpr unsigned garbled = look::failed | static_cast<unsigned>(errc::receive_failed);
            if (heard >= look::failed && heard != garbled) return static_cast<errc>(heard & 0xFFu);
            if (!x.was_sent_) {
                if (heard != look::nothing) {
                    last_activity_ = around.at;
                    if (!is_glitch(heard) || ++glitches > 4) is_troubled_ = true;
                }
                if (went_back(last_activity_, around.at)) last_activity_ = around.at;
                const duration needed =
                    longer_of(is_troubled_ && !wanted.is_urgent ? after_trouble : t3_5, wanted.gap);
                const duration quiet = since(last_activity_, around.at);
                if (quiet < needed) {
                    if (since(started, around.at) > limit) return errc::line_busy;
                    rest(needed - quiet);
                    continue;
                }
            }
            if (left != 0) {
                const transfer took = port_->send({next, left});
                if (!took) return x.was_sent_ ? errc::send_cut : took.error();
                if (!x.was_sent_ && *took != 0) {
                    x.was_sent_ = true;
                    started = around.at;
                    limit = send_limit(left);
                    is_troubled_ = is_troubled_ && wanted.is_urgent; // what follows a stop waits for it
                }
                const std::size_t count = *took < left ? *took : left;
                next += count;
                left -= count;
            }
            if (left == 0 && heard == look::nothing && port_->sent()) { // what was heard before is no reply
                last_activity_ = now();
                return errc::ok;
            }
            if (since(started, around.at) > limit) return x.was_sent_ ? errc::send_cut : errc::send_failed;
        }
    }

    template <class Exchange> constexpr errc turn_round(const Exchange& x, look& around) {
        const instant sent = last_activity_;
        for (;;) {
            const unsigned heard = around.again();
            if (heard >= look::failed) return static_cast<errc>(heard & 0xFFu);
            if (heard != look::nothing) {
                last_activity_ = around.at;
                is_troubled_ = true;
            }
            const duration waited = since(sent, around.at);
            if (waited >= x.limits_.turnaround) return errc::ok;
            rest(x.limits_.turnaround - waited);
        }
    }

    // A reply is gathered and judged when it is whole, or when the line falls silent.
    template <class Exchange> constexpr errc await(Exchange& x, look& around) {
        const instant sent = last_activity_;
        const std::uint8_t* const request = x.request_.data();
        std::uint8_t* const reply = x.reply_.data();
        constexpr duration gap = Timing.longest_gap(1);
        const std::size_t size = x.request_.size();
        std::size_t length = x.reply_.size();
        std::size_t count = 0;
        unsigned leading = 0;
        bool is_foreign = false;
        for (;;) {
            const unsigned heard = around.again();
            if (heard >= look::failed) return static_cast<errc>(heard & 0xFFu);
            if (since(last_activity_, around.at) > gap) {
                if (count != 0) break;
                is_foreign = false;
            }
            if (heard != look::nothing) {
                last_activity_ = around.at;
                if (count == length) { // whole, and the request's beginning too
                    if (heard == request[length]) return errc::echo;
                    break;
                }
                if (count == 0 && heard != request[0])
                    is_foreign = is_foreign || !is_glitch(heard) || ++leading > x.limits_.leading_bytes;
                else if (!is_foreign)
                    reply[count++] = static_cast<std::uint8_t>(heard);
                if (count == 2 && (reply[1] & modbus::exception_flag) != 0) length = 5;
                if (count == length && !(length < size && same_bytes({reply, length}, {request, length})))
                    break;
            }
            const duration waited = since(sent, around.at);
            if (count == 0 && waited >= x.limits_.response) return errc::timeout;
            if (heard == look::nothing) rest(count == 0 ? x.limits_.response - waited : gap);
        }

        const bool is_exception = count > 1 && reply[1] == (request[1] | modbus::exception_flag);
        const bool is_read = modbus::is_read(request[1]);
        const std::size_t header = is_exception ? 0 : is_read ? 3 : 6;
        for (std::size_t i = 1; i < header && i < count; ++i) {
            const bool is_byte_count = is_read && i == 2;
            if (reply[i] == (is_byte_count ? 2 * request[5] : request[i])) continue;
            if (i == 1) return errc::wrong_function;
            if (is_byte_count) return errc::wrong_byte_count;
            if (i < 4) return errc::wrong_address;
            if (request[1] == 0x06) return errc::wrong_value;
            if (!x.limits_.echoes_byte_count || i != 5 || reply[i] != request[6]) return errc::wrong_quantity;
        }
        if (count != length)
            return Timing.mode == modbus::timing_mode::strict ? errc::bad_gap : errc::reply_cut;
        if (modbus::crc16<Crc>(bytes{reply, length}) != 0) return errc::bad_crc;
        if (is_exception) return errc::exception;
        // The request and zeros behind it: they keep a CRC that fits.
        return length > size && same_bytes({reply, size}, x.request_) ? errc::echo : errc::ok;
    }

    constexpr void rest([[maybe_unused]] duration most) {
        if constexpr (waiting_port<Port>)
            port_->wait(most < detail::longest_sleep ? most : detail::longest_sleep);
    }

    Port* port_;
    instant last_activity_;
    bool is_troubled_ = true;
    bool is_proven_ = false;
};

} // namespace servobus
