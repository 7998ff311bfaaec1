// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response as a state machine without I/O. line/line.hpp includes it; programs include it
// to run exchanges over a transport of their own.
//
//     constexpr auto run = [](modbus::exchange& x, auto& uart) {
//         uart.send(x.request()), x.sent(uart.now()); // `send` returns after the last stop bit
//         for (instant at = uart.now(); !x.done(); at = uart.now()) // `at` is before the look for bytes
//             uart.has_byte() ? (void)x.feed_late(uart.read(), uart.now()) : (void)x.elapse(at);
//     };
//
// The caller sends the request, reports when its last bit has left, and passes on what arrives together with
// its time: a byte from an interrupt, a DMA buffer at an idle line, a read() from a descriptor.
//
//   request … crc |<- t3.5 ->|  (server works)  | response … crc |
//   ready leaving  sent()     awaiting            receiving    done
//
// The request alone determines which response is valid: address, function, byte count or repeated fields,
// CRC. The end of a frame follows from these counts, never from a CRC that happens to match. A response is
// gathered until it is whole or ends in a gap, and then judged once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/small_core.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/gathering.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::modbus {

/// One transaction. It keeps references to its buffers, timing and limits, which must outlive it. No member
/// waits. Members may be called only from the context that owns the exchange.
template <crc_engine Crc = default_crc, class Lengths = fixed_lengths>
class basic_exchange : gathering<std::uint16_t, Lengths> {
    using base = gathering<std::uint16_t, Lengths>;
    using base::count_;
    using base::length_;
    using base::lengths_;
    using base::request_;
    using base::response_;
    using base::same_;
    using base::size_;

  public:
    using crc = Crc;

    enum class phase : std::uint8_t {
        ready,      ///< constructed, nothing sent yet
        leaving,    ///< the transport has accepted the first byte: no byte is sent twice (G33)
        turnaround, ///< a broadcast has left: the devices execute it, and none responds
        awaiting,   ///< the request has left, no response yet
        receiving,  ///< the response has begun; if it is whole, and equals the beginning of its request, the
                    ///< next byte or a gap tells whether it is the request's echo
        other_node, ///< a frame of another address, or unexpected bytes, are ignored until they end
        done,       ///< ended: see `status()`
    };

    constexpr basic_exchange() = default;

    // Not copied: its request would be sent twice. One that is moved from has ended with `bad_argument`.
    constexpr basic_exchange(basic_exchange&& from) noexcept
        : basic_exchange{static_cast<const basic_exchange&>(from)} {
        from.end(errc::bad_argument);
    }
    constexpr basic_exchange& operator=(basic_exchange&& from) noexcept {
        *this = static_cast<const basic_exchange&>(from);
        from.end(errc::bad_argument);
        return *this;
    }

    /// An exchange that sends `request`, a whole frame, and stores the response in `response`, which may be
    /// the same memory as the request. The length of the response follows from the request for functions 03, 04, 06 and
    /// 10h; for any other it is `response.size()`, at most 256 (`expected_response` tells it). What the request fixes
    /// is checked for all (`modbus::like`). An exception needs 5 bytes; a response of 4 is stated by
    /// `expect_function_alone`.
    /// Errors (immediately, in state `done`): `bad_argument` if the request is not a frame, has a function
    /// code outside 01..7Fh, is a broadcast read, goes to a reserved address or needs a larger `response`.
#if __SIZEOF_SIZE_T__ >= 8 // inlined on hosts; small cores share one copy
    [[gnu::always_inline]]
#endif
    constexpr basic_exchange(bytes request, byte_buffer response, const rtu_timing& timing,
                             const response_limits& limits, servobus::priority of = {})
        : priority_{of}, timing_{&timing}, limits_{&limits} {
        request_ = request.data();
        response_ = response.data();
        if (is_sound(request)) {
            size_ = static_cast<std::uint16_t>(request.size());
            address_ = request[0];
            like_ = like(request[1]);
            length_ = expected_length(request, response.size());
            const bool has_room = length_ <= response.size() && response.size() >= exception_frame;
            // A broadcast has no response, so nothing can be read by one.
            if (length_ >= min_frame && (address_ == broadcast ? !has_count(like_) : has_room)) {
                if (!has_room) length_ = 0; // a gateway's refusal of the broadcast has no place
                same_ = size_;
                phase_ = phase::ready;
                status_ = {};
            }
        }
    }

    /// One whose response is as long as `rule` says, at most as `response`, where the request itself does not say it.
    /// An exchange of a line with `open_lengths`. Errors: `bad_argument` also for a broadcast and a rule that is none.
    template <class Rule>
    constexpr basic_exchange(bytes request, byte_buffer response, const Rule& rule, const rtu_timing& timing,
                             const response_limits& limits, servobus::priority of) requires(Lengths::are_open)
        : basic_exchange{request, response, timing, limits, of} {
        if (phase_ == phase::done || like_ != like_none) return;
        if (rule.is_valid() && !is_broadcast())
            base::begin_open(Lengths{rule, request.subspan(1, request.size() - 3)});
        else
            end(errc::bad_argument);
    }

    /// The same without a look at the request, for who has just made it: of function 01..06, 0F, 10h or 16h, to a
    /// valid address. `response` is as long as the whole response; for a write it may be the request's memory.
    [[gnu::always_inline]] static constexpr basic_exchange trusted(bytes request, byte_buffer response,
                                                                   const rtu_timing& timing,
                                                                   const response_limits& limits,
                                                                   servobus::priority of) {
        return {trusted_tag{}, request, response, timing, limits, of};
    }

    /// `trusted` in the place of this exchange, which must have ended: nothing is copied.
    constexpr void restart(bytes request, byte_buffer response, const rtu_timing& timing,
                           const response_limits& limits, servobus::priority of) {
        request_ = request.data();
        response_ = response.data();
        size_ = same_ = static_cast<std::uint16_t>(request.size());
        length_ = static_cast<std::uint16_t>(response.size());
        count_ = 0;
        phase_ = phase::ready;
        address_ = request[0];
        like_ = request[1];
        leading_ = 0;
        other_count_ = 0;
        priority_ = of;
        status_ = {};
        ticket_ = 0;
        timing_ = &timing;
        limits_ = &limits;
        sent_ = last_ = {};
        if constexpr (Lengths::are_open) lengths_ = {};
    }

    // The exchange keeps references: a temporary would be destroyed before the response arrives.
    basic_exchange(bytes, byte_buffer, const rtu_timing&&, const response_limits&,
                   servobus::priority = {}) = delete;
    basic_exchange(bytes, byte_buffer, const rtu_timing&, const response_limits&&,
                   servobus::priority = {}) = delete;

    constexpr phase state() const { return phase_; }
    /// Before it is sent: the response is judged as `modbus::like` says, where that is not the request's own function.
    constexpr void judge_like(std::uint8_t code) { like_ = code; }
    /// Before it is sent: the response is the function alone, 4 bytes with address and CRC. No effect where the
    /// function fixes more. `response` has room for an exception.
    constexpr void expect_function_alone() {
        if (like_ == like_none && phase_ == phase::ready && !is_broadcast()) length_ = min_frame;
    }
    constexpr bool done() const { return phase_ == phase::done; }
    /// True until the request's last bit has left: `ready` or `leaving`.
    constexpr bool is_to_leave() const { return phase_ <= phase::leaving; }
    /// How the exchange ended. Meaningful only when `done()`.
    constexpr servobus::status status() const { return status_; }
    constexpr bytes request() const { return {request_, size_}; }
    /// Longest time from the request's last bit to the response's first byte; for a broadcast the turnaround.
    constexpr duration longest_wait() const {
        return is_broadcast() ? limits_->turnaround : limits_->response;
    }
    /// Longest time from the request's last bit to the end of the exchange.
    constexpr duration longest() const { return is_broadcast() ? longest_wait() : longest_response(); }
    /// The same for a response, which a gateway may send to a broadcast too.
    constexpr duration longest_response() const {
        return limits_->response +
               (timing_->longest_gap(1) + timing_->wire_time(1)) * std::uint32_t{most_bytes()};
    }
    /// Longest time from the request's last bit until a stop that waits for it may be sent: for a response whose pauses
    /// are longer than a frame has them, less than `longest`.
    constexpr duration longest_before_stop() const {
        return is_broadcast() ? longest_wait() : limits_->response + timing_->longest_frame(most_bytes());
    }
    /// The number by which a line's arbitration identifies this exchange; 0 until the line has assigned one.
    constexpr std::uint16_t ticket() const { return ticket_; }
    constexpr void set_ticket(std::uint16_t number) { ticket_ = number; }
    constexpr servobus::priority priority() const { return priority_; }
    /// Length of the whole response in bytes; 5 after its function code has shown an exception.
    constexpr std::size_t response_size() const { return length_; }
    /// Bytes of the response that have not arrived.
    constexpr std::size_t missing() const { return static_cast<std::size_t>(length_ - count_); }
    constexpr std::uint8_t address() const { return address_; }
    constexpr bool is_broadcast() const { return address_ == broadcast; }
    /// True if any byte of the request may have been on the line.
    constexpr bool was_sent() const { return status_.was_sent(); }
    /// When the request's last bit left; instant 0 before `sent()`.
    constexpr instant sent_at() const { return sent_; }
    /// The bytes of the response received so far; empty for a broadcast.
    constexpr bytes response() const { return {response_, count_}; }
    /// The words of a successful read of registers; empty in all other cases.
    constexpr words_view words() const {
        return done() && status_.error() == errc::ok && is_read(like_)
                   ? words_view{bytes{response_, length_}.subspan(3, length_ - 5u)}
                   : words_view{};
    }
    /// True if the response differs from the request, so that it cannot be its echo. Meaningful only after a
    /// valid response.
    constexpr bool differs_from_request() const { return same_ < size_; }
    /// True if any byte arrived after the request had left, from whichever device, or a part of another node's frame
    /// while it left.
    constexpr bool has_received() const { return count_ != 0 || last_ != instant{}; }

    /// Call when the transport has accepted the first byte. From then on the request counts as sent.
    constexpr void begin_leaving() {
        if (phase_ != phase::ready) return;
        status_.mark_sent();
        phase_ = phase::leaving;
    }

    /// Bytes that arrived at `now`, after `begin_leaving` and before `sent`. They are the request's echo, or the
    /// beginning of another node's frame: in its rest no response begins. No effect before `begin_leaving`.
    [[gnu::cold]] constexpr void pass_while_leaving(bytes arrived, instant now) {
        if (phase_ != phase::leaving) return;
        for (const std::uint8_t byte : arrived) {
            if (other_count_ < size_ && byte == request_[other_count_])
                ++other_count_;
            else if (byte != 0x00 && byte != 0xFF) // a driver that is switched
                last_ = now;
        }
    }
    /// A garbled byte arrived then.
    constexpr void pass_garbled() { ++other_count_; }

    /// Call when the request's last stop bit has left, at `now`.
    constexpr void sent(instant now) {
        if (!is_to_leave()) return;
        status_.mark_sent();
        sent_ = now;
        phase_ = is_broadcast() ? phase::turnaround : phase::awaiting;
        if (last_ != instant{} && phase_ == phase::awaiting) [[unlikely]] {
            phase_ = phase::other_node;
            other_count_ = max_frame; // only a gap ends it
        }
    }

    /// The same for Modbus TCP, whose gateway may refuse a broadcast: a refusal is awaited for `limits.response` if
    /// `response` has room for it (8 bytes).
    constexpr void sent_to_gateway(instant now) {
        sent(now);
        if (phase_ == phase::turnaround && length_ != 0) phase_ = phase::awaiting;
    }
    /// The exchange has ended on Modbus TCP: exceptions 0Ah and 0Bh, and each exception to a broadcast, are the
    /// gateway's words.
    constexpr void note_gateway() { (void)modbus::note_gateway(status_, is_broadcast()); }

    /// Ends the exchange because the transport failed. `some_sent`: true if any byte may have been on the
    /// line.
    constexpr void abort(errc why, bool some_sent) {
        if (done()) return;
        if (some_sent) status_.mark_sent();
        end(why);
    }

    /// Processes bytes that arrived at `now`, all after `sent()`, the last of them just then. Returns how many
    /// belong to the transaction. That is less than all if the exchange ended before; the rest is not examined.
    constexpr std::size_t feed(bytes arrived, instant now) {
        end_by_gap(arrived.size(), now);
        return feed_late(arrived, now);
    }
    constexpr std::size_t feed(std::uint8_t byte, instant now) {
        end_by_gap(1, now);
        return take_bytes(&byte, 1, now);
    }
    /// The same for bytes that arrived at unknown times before `now`, as for a program that may have stalled
    /// since. The time since the bytes before them is no gap, except where `elapse` was called in it.
    constexpr std::size_t feed_late(bytes arrived, instant now) {
        if constexpr (is_host) {
            if (is_whole_response(arrived)) return take_whole(arrived);
        }
        return take_bytes(arrived.data(), arrived.size(), now);
    }
    constexpr std::size_t feed_late(std::uint8_t byte, instant now) { return take_bytes(&byte, 1, now); }

    /// Advances time to `now`, if no byte had arrived by then: read the clock before you look for a byte. The
    /// exchange ends here when a time limit has passed. Returns the time during which nothing changes unless a
    /// byte arrives.
    constexpr duration elapse(instant now) {
        if (is_to_leave() || done()) return {};
        duration idle{~std::uint32_t{0}};
        if (phase_ >= phase::receiving) {
            const duration passed = since(last_, now);
            const duration longest = ending_gap(1);
            if (passed > longest) {
                end_of_frame(now);
                if (done()) return {};
            } else {
                idle = longest + microseconds(1) - passed;
                if (phase_ == phase::receiving) return idle;
            }
        }
        const duration passed = since(sent_, now);
        const duration limit = phase_ == phase::turnaround ? limits_->turnaround : limits_->response;
        if (passed < limit) return shorter_of(idle, limit - passed);
        end(is_broadcast() ? errc::ok : errc::timeout);
        return {};
    }

  private:
    constexpr basic_exchange(const basic_exchange&) = default;
    constexpr basic_exchange& operator=(const basic_exchange&) = default;

    struct trusted_tag {};
    [[gnu::always_inline]] constexpr basic_exchange(trusted_tag, bytes request, byte_buffer response,
                                                    const rtu_timing& timing, const response_limits& limits,
                                                    servobus::priority of)
        : phase_{phase::ready}, address_{request[0]}, like_{request[1]}, status_{}, priority_{of},
          timing_{&timing}, limits_{&limits} {
        request_ = request.data();
        response_ = response.data();
        size_ = same_ = static_cast<std::uint16_t>(request.size());
        length_ = static_cast<std::uint16_t>(response.size());
    }

    static constexpr std::size_t exception_frame = 5;
    static constexpr bool is_host = !servobus::detail::is_small_core;

    static constexpr bool is_sound(bytes request) {
        if (request.size() < min_frame || request.size() > max_frame) return false;
        if (request[1] == 0 || request[1] >= exception_flag) return false;
        return request[0] <= 247 || request[0] == peer_address;
    }

    // True in the usual case: the response arrived in one piece and its header matches. `take_bytes` would
    // end the same way; a small core, which has more time than flash, uses `take_bytes` alone.
    constexpr bool is_whole_response(bytes arrived) const {
        if (phase_ != phase::awaiting || arrived.size() < length_) return false;
        if constexpr (Lengths::are_open) {
            if (lengths_.is_open()) return false;
        }
        const auto is_requested = [&](std::size_t at) {
            return load_word(arrived, at) == load_word(request(), at);
        };
        if (like_ == 0x06 && !std::is_constant_evaluated())
            return __builtin_memcmp(arrived.data(), request_, 8) == 0;
        if (like_ == 0x06) return is_requested(0) && is_requested(2) && is_requested(4) && is_requested(6);
        if (!is_requested(0)) return false;
        if (length_ < size_ && is_requested(length_ - 2u)) return false; // may be an echo
        if (length_ == size_) return false;                              // as long as its echo
        if (length_ > size_ && arrived[length_ - 1u] == 0) return false; // or one with zeros after it
        if (like_ == 0x10) return is_requested(2) && is_requested(4);
        return has_count(like_) && arrived[2] == length_ - 5u;
    }

    constexpr std::size_t take_whole(bytes arrived) {
        if (like_ == 0x06) { // equal to the request in every byte, so its CRC is right too
            count_ = 8;
            copy(arrived.data(), response_, 8);
            phase_ = phase::done; // the status is `ok` from the beginning
            return 8;
        }
        same_ = 0; // it differs from the request
        count_ = length_;
        const bytes whole{response_, length_};
        copy(arrived.data(), response_, whole.size());
        end(Crc::end(Crc::update(Crc::begin(), whole)) == 0 ? errc::ok : errc::bad_crc);
        return whole.size();
    }

    static constexpr void copy(const std::uint8_t* from, std::uint8_t* to, std::size_t size) {
        if (size < 8 || std::is_constant_evaluated()) {
            for (std::size_t i = 0; i < size; ++i) to[i] = from[i];
        } else if (size < 16) {
            copy_by<8>(from, to, size);
        } else {
            copy_by<16>(from, to, size);
        }
    }

    // Copies in blocks. The last block may overlap the one before; it is read first, since source and
    // destination may be the same buffer.
    template <std::size_t Block>
    static constexpr void copy_by(const std::uint8_t* from, std::uint8_t* to, std::size_t size) {
        __asm__("" : "+r"(to)); // else GCC, which cannot see that `size` fits, warns of an overflow
        std::uint8_t tail[Block]{};
        __builtin_memcpy(tail, from + size - Block, Block);
        for (std::size_t i = 0; i + Block < size; i += Block) __builtin_memmove(to + i, from + i, Block);
        __builtin_memcpy(to + size - Block, tail, Block);
    }

    // `arrived` bytes came together just now.
    constexpr void end_by_gap(std::size_t arrived, instant now) {
        if (phase_ != phase::receiving && phase_ != phase::other_node) return;
        if (arrived != 0 && since(last_, now) > ending_gap(arrived)) end_of_frame(now);
    }

    // A function of its own, so that the inlined code of the usual case stays short.
    constexpr std::size_t take_bytes(const std::uint8_t* data, std::size_t size, instant now) {
        if (size == 0 || phase_ <= phase::turnaround || done()) return 0;
        last_ = now;
        std::size_t taken = 0;
        for (; taken < size && !done(); ++taken) {
            if (!accept(data[taken])) break;
        }
        return taken;
    }

    constexpr void end(errc why) {
        status_.end(why);
        phase_ = phase::done;
    }

    // A gap that is too long to lie inside a frame: the frame before it has ended. After a whole response it
    // shows that this is no echo, unless the clock went back: then no gap was measured.
    constexpr void end_of_frame(instant now) {
        if (phase_ == phase::receiving) return conclude(went_back(last_, now));
        phase_ = phase::awaiting;
    }

    // The longest time since the previous byte after which `arrived` bytes still belong to the same frame. A
    // frame of another address whose CRC fits is over after t3.5, whatever its function.
    constexpr duration ending_gap(std::size_t arrived) const {
        const duration longest = timing_->longest_gap(arrived);
        if (phase_ != phase::other_node || Crc::end(other_crc_) != 0) return longest;
        const duration pause = duration{timing_->t3_5 - 1u} + timing_->wire_time(arrived);
        return pause < longest ? pause : longest;
    }

    static constexpr std::uint16_t expected_length(bytes request, std::size_t room) {
        const std::uint8_t code = request[1];
        if (is_read(code) || is_write(code)) return expected_register_response(request);
        return static_cast<std::uint16_t>(room < max_frame ? room : max_frame);
    }

    // False if the byte does not belong to the response, which ended before it.
    constexpr bool accept(std::uint8_t byte) {
        if (phase_ == phase::awaiting || phase_ == phase::receiving) {
            if (base::compare(byte)) {
                phase_ = phase::receiving;
                const bool is_next = base::is_whole();
                if (!is_next) {
                    base::store(byte);
                    if (!base::is_whole() || base::may_be_echo()) return true;
                }
                conclude(is_next);
                return !is_next;
            }
            if ((byte == 0x00 || byte == 0xFF) && leading_ < limits_->leading_bytes) {
                ++leading_;
                return true;
            }
            phase_ = phase::other_node;
            other_crc_ = Crc::begin();
            other_count_ = 0;
        }
        if (phase_ == phase::other_node) pass_by(byte);
        return true;
    }

    constexpr std::uint16_t most_bytes() const {
        if constexpr (Lengths::are_open) {
            if (lengths_.is_open()) return static_cast<std::uint16_t>(lengths_.room());
        }
        return length_;
    }

    // The response is whole, or what came of it has ended. `has_more`: a byte came after it.
    constexpr void conclude(bool has_more) {
        if constexpr (Lengths::are_open) base::template end_open<Crc>();
        const errc cut = timing_->mode == timing_mode::strict ? errc::bad_gap : errc::truncated_response;
        errc why = base::template judged<Crc, true>(like_, cut, *limits_, has_more, *this);
        if (why == errc::wrong_quantity && repeats_a_value(like_)) why = errc::wrong_value;
        end(why);
    }

    friend base;
    constexpr void rule_out_echo() {} // the line asks for `differs_from_request`
    constexpr void end_cleanly() {}
    constexpr void note_exception(std::uint8_t number) { status_.set_exception(number); }

    // Follows a response of another address to its end, since the awaited response may come immediately after
    // it. Any other frame ends with a gap (`ending_gap`).
    constexpr void pass_by(std::uint8_t byte) {
        other_crc_ = Crc::update(other_crc_, byte);
        if (++other_count_ < 3) {
            other_code_ = byte;
            return;
        }
        if (other_count_ == 3) other_length_ = static_cast<std::uint16_t>(response_length(other_code_, byte));
        if (other_count_ == other_length_ && Crc::end(other_crc_) == 0) phase_ = phase::awaiting;
    }

    // The bytes first, as in the base.
    phase phase_ = phase::done;
    std::uint8_t address_ = 0;
    std::uint8_t like_ = 0;
    std::uint8_t leading_ = 0;
    servobus::status status_{errc::bad_argument};
    servobus::priority priority_ = servobus::priority::ordinary;
    std::uint8_t other_code_ = 0;
    std::uint16_t other_count_ = 0;
    std::uint16_t other_length_ = 0;
    std::uint16_t ticket_ = 0;
    typename Crc::state other_crc_ = Crc::begin();
    const rtu_timing* timing_ = nullptr;
    const response_limits* limits_ = nullptr;
    instant sent_{};
    instant last_{};
};

using exchange = basic_exchange<>;

} // namespace servobus::modbus
