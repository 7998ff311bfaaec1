// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response as a state machine without I/O. line/line.hpp includes it; programs include it
// to run exchanges over a transport of their own.
//
//     constexpr auto run = [](modbus::exchange& x, auto& uart) {
//         uart.send(x.request()); // returns after the last stop bit
//         for (x.sent(uart.now()); !x.done(); x.elapse(uart.now()))
//             if (uart.has_byte()) x.feed(uart.read(), uart.now());
//     };
//
// The caller sends the request, reports when its last bit has left, and passes on what arrives together with
// its time: a byte from an interrupt, a DMA buffer at an idle line, a read() from a descriptor.
//
//   request … crc |<- t3.5 ->|  (server works)  | response … crc |
//   ready leaving  sent()     awaiting            receiving    done
//
// The request alone determines which response is valid: address, function, byte count or repeated fields,
// CRC. The end of a frame follows from these counts, never from a CRC that happens to match.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::modbus {

/// One transaction. It keeps references to its buffers, timing and limits, which must outlive it. No member
/// waits. Members may be called only from the context that owns the exchange.
template <crc_engine Crc = default_crc> class basic_exchange {
  public:
    using crc = Crc;

    enum class phase : std::uint8_t {
        ready,      ///< constructed, nothing sent yet
        leaving,    ///< the transport has accepted the first byte: no byte is sent twice (G33)
        awaiting,   ///< the request has left, no response yet
        receiving,  ///< the response has begun
        maybe_echo, ///< a whole response that equals the request's beginning: the next byte or a gap decides
        other_unit, ///< a frame of another address is being received
        resync,     ///< unexpected bytes are ignored until a gap
        done,       ///< ended: see `why()`
    };

    constexpr basic_exchange() = default;

    /// An exchange that sends `request`, a whole frame, and stores the response in `response`, which may be
    /// the same memory as the request. The length of the response follows from the request for functions 03,
    /// 04, 06 and 10h; for any other function it is `response.size()`, at most 256. An exception needs 5
    /// bytes.
    /// Errors (immediately, in state `done`): `bad_argument` if the request is not a frame, has a function
    /// code outside 01..7Fh, is a broadcast read, goes to a reserved address or needs a larger `response`.
#if __SIZEOF_SIZE_T__ >= 8 // inlined on hosts; small cores share one copy
    [[gnu::always_inline]]
#endif
    constexpr basic_exchange(bytes request, byte_buffer response, const rtu_timing& timing,
                             const response_limits& limits)
        : request_{request}, response_{response}, timing_{&timing}, limits_{&limits} {
        if (is_sound(request_)) {
            unit_ = request_[0];
            code_ = request_[1];
            length_ = expected_length();
            const bool has_room = length_ <= response_.size() && response_.size() >= exception_frame;
            if (length_ >= min_frame && (unit_ == broadcast || has_room)) {
                phase_ = phase::ready;
                why_ = {};
            }
        }
    }

    // The exchange keeps references: a temporary would be destroyed before the response arrives.
    basic_exchange(bytes, byte_buffer, const rtu_timing&&, const response_limits&) = delete;
    basic_exchange(bytes, byte_buffer, const rtu_timing&, const response_limits&&) = delete;

    constexpr phase state() const { return phase_; }
    constexpr bool done() const { return phase_ == phase::done; }
    /// True until the request's last bit has left: `ready` or `leaving`.
    constexpr bool is_to_leave() const { return phase_ <= phase::leaving; }
    /// Why the exchange ended; `errc::ok` is success. Meaningful only when `done()`.
    constexpr failure why() const { return why_; }
    /// `why()` and `was_sent()` as the result of a write. Meaningful only when `done()`.
    constexpr written ended() const { return {why_, was_sent_}; }
    constexpr bytes request() const { return request_; }
    /// Longest time from the request's last bit to the response's first byte; for a broadcast the turnaround.
    constexpr duration longest_wait() const {
        return is_broadcast() ? limits_->turnaround : limits_->response;
    }
    /// Longest time from the request's last bit to the end of the exchange.
    constexpr duration longest() const {
        if (is_broadcast()) return longest_wait();
        return longest_wait() + longer_gap() * static_cast<std::uint32_t>(length_);
    }
    /// The number by which a line's arbitration identifies this exchange; 0 until the line has assigned one.
    constexpr std::uint16_t ticket() const { return ticket_; }
    constexpr void set_ticket(std::uint16_t number) { ticket_ = number; }
    /// Length of the whole response in bytes; 5 after its function code has shown an exception.
    constexpr std::size_t response_size() const { return length_; }
    constexpr std::uint8_t unit() const { return unit_; }
    constexpr bool is_broadcast() const { return unit_ == broadcast; }
    /// True if any byte of the request may have been on the line.
    constexpr bool was_sent() const { return was_sent_ || phase_ == phase::leaving; }
    /// When the request's last bit left; instant 0 before `sent()`.
    constexpr instant sent_at() const { return sent_; }
    /// The bytes of the response received so far; empty for a broadcast.
    constexpr bytes response() const { return bytes{response_.data(), count_}; }
    /// The words of a successful read; empty in all other cases.
    constexpr words_view words() const {
        return done() && why_.code == errc::ok && is_read(code_)
                   ? words_view{bytes{response_.data(), length_}.subspan(3, length_ - 5u)}
                   : words_view{};
    }
    /// True if a valid response to this function cannot be the request's own echo: a read or 10h. A response
    /// to 06 repeats its request; so may the response to a function not known here.
    constexpr bool differs_from_request() const { return is_read(code_) || code_ == 0x10; }
    /// True if any byte arrived after the request had left, from whichever device.
    constexpr bool has_heard() const { return has_heard_ || count_ != 0; }
    /// Number of valid frames of other addresses received since `sent()`, at most 255.
    constexpr std::uint8_t other_unit_frames() const { return other_frames_; }

    /// Call when the transport has accepted the first byte. From then on the request counts as sent.
    constexpr void begin_leaving() {
        if (phase_ == phase::ready) phase_ = phase::leaving;
    }

    /// Call when the request's last stop bit has left, at `now`.
    constexpr void sent(instant now) {
        if (!is_to_leave()) return;
        was_sent_ = true;
        sent_ = now;
        phase_ = phase::awaiting;
    }

    /// Ends the exchange because the transport failed. `some_sent`: true if any byte may have been on the
    /// line.
    constexpr void abort(errc why, bool some_sent) {
        if (done()) return;
        was_sent_ = was_sent() || some_sent;
        end({why});
    }

    /// Processes bytes that had arrived by `now`, all after `sent()`. Returns how many belong to the
    /// transaction. That is less than all if the exchange ended before; the rest is not examined.
    constexpr std::size_t feed(bytes arrived, instant now) {
        if constexpr (sizeof(std::size_t) >= 8) {
            if (is_whole_response(arrived)) return take_whole(arrived);
        }
        return take_bytes(arrived.data(), arrived.size(), now);
    }

    constexpr std::size_t feed(std::uint8_t byte, instant now) { return take_bytes(&byte, 1, now); }

    /// Advances time; call it when no byte arrived. The exchange ends here when a time limit has passed.
    /// Returns the time during which nothing changes unless a byte arrives.
    constexpr duration elapse(instant now) {
        if (is_to_leave() || done()) return {};
        if (is_broadcast()) return until_due(sent_, now, limits_->turnaround, {errc::ok});
        if (phase_ == phase::maybe_echo) return until_due(last_, now, longer_gap(), after_doubt(now));
        if (phase_ == phase::receiving) {
            return until_due(
                last_, now, longer_gap(),
                {timing_->mode == timing_mode::strict ? errc::bad_gap : errc::truncated_response});
        }
        if (phase_ != phase::awaiting && since(last_, now) > longer_gap()) restart();
        return until_due(sent_, now, limits_->response, {errc::timeout});
    }

  private:
    static constexpr std::size_t exception_frame = 5;

    static constexpr bool is_sound(bytes request) {
        if (request.size() < min_frame || request.size() > max_frame) return false;
        if (request[1] == 0 || (request[1] & exception_flag) != 0) return false;
        return is_unit(request[0]) || (request[0] == broadcast && !is_read(request[1]));
    }

    // True in the usual case: the response arrived in one piece and its header matches. `take_bytes` would
    // end the same way; a small core, which has more time than flash, uses `take_bytes` alone.
    constexpr bool is_whole_response(bytes arrived) const {
        if (phase_ != phase::awaiting || arrived.size() < length_ || is_broadcast()) return false;
        const auto is_requested = [&](std::size_t at) {
            return load_word(arrived, at) == load_word(request_, at);
        };
        if (code_ == 0x06 && !std::is_constant_evaluated())
            return __builtin_memcmp(arrived.data(), request_.data(), 8) == 0;
        if (code_ == 0x06) return is_requested(0) && is_requested(2) && is_requested(4) && is_requested(6);
        if (!is_requested(0)) return false;
        if (length_ < request_.size() && is_requested(length_ - 2u)) return false; // may be an echo
        if (code_ == 0x10) return is_requested(2) && is_requested(4);
        return !is_read(code_) || arrived[2] == length_ - 5u;
    }

    constexpr std::size_t take_whole(bytes arrived) {
        count_ = length_;
        if (code_ == 0x06) { // equal to the request in every byte, so its CRC is right too
            copy(arrived.data(), response_.data(), 8);
            end({});
            return 8;
        }
        const bytes whole{response_.data(), length_};
        copy(arrived.data(), response_.data(), whole.size());
        end({Crc::end(Crc::update(Crc::begin(), whole)) == 0 ? errc::ok : errc::bad_crc});
        if (arrived[length_ - 1u] == 0) [[unlikely]]
            doubt_zeros();
        return whole.size();
    }

    // The request followed by zero bytes has a valid CRC: such a frame is an echo, not a response.
    [[gnu::cold, gnu::noinline]] constexpr void doubt_zeros() {
        if (why_.code == errc::ok && length_ > request_.size() && response_.data() != request_.data() &&
            same_bytes(response_.first(request_.size()), request_))
            why_ = {errc::own_echo};
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

    // A function of its own, so that the inlined code of the usual case stays short.
    constexpr std::size_t take_bytes(const std::uint8_t* data, std::size_t size, instant now) {
        const bytes arrived{data, size};
        if (arrived.empty() || is_to_leave() || done() || is_broadcast()) return 0;
        has_heard_ = true;
        if (since(last_, now) > timing_->longest_gap(arrived.size())) gap(now);
        last_ = now;
        std::size_t taken = 0;
        while (taken < arrived.size() && !done()) {
            if (phase_ == phase::maybe_echo) {
                end({arrived[taken] == request_[length_] ? errc::own_echo : errc::ok});
                break;
            }
            if (phase_ == phase::receiving && count_ >= header_checked()) {
                while (taken < arrived.size() && count_ < length_) response_[count_++] = arrived[taken++];
            } else {
                accept(arrived[taken++]);
            }
            if (phase_ == phase::receiving && count_ == length_) check_frame();
        }
        return taken;
    }

    constexpr void end(failure why) {
        why_ = why;
        phase_ = phase::done;
    }

    constexpr void restart() {
        phase_ = phase::awaiting;
        count_ = 0;
    }

    // Handles a gap that is too long to lie inside a frame: the frame before it has ended.
    constexpr void gap(instant now) {
        if (phase_ == phase::receiving) {
            end({timing_->mode == timing_mode::strict ? errc::bad_gap : errc::truncated_response});
        } else if (phase_ == phase::maybe_echo) {
            end(after_doubt(now));
        } else if (phase_ != phase::awaiting) {
            restart();
        }
    }

    // A gap after a whole frame shows that it is not the beginning of an echo. If the clock went back, no gap
    // was measured.
    constexpr failure after_doubt(instant now) const {
        return {went_back(last_, now) ? errc::own_echo : errc::ok};
    }

    // The longest gap before the next byte, plus the character time of that byte.
    constexpr duration longer_gap() const { return timing_->longest_gap(1) + timing_->wire_time(1); }

    constexpr duration until_due(instant start, instant now, duration limit, failure why) {
        const duration passed = since(start, now);
        if (passed < limit) return limit - passed;
        end(why);
        return {};
    }

    constexpr std::uint16_t expected_length() const {
        if (is_read(code_)) {
            const bool whole =
                request_.size() == 8 && request_[4] == 0 && request_[5] >= 1 && request_[5] <= max_read;
            return whole ? static_cast<std::uint16_t>(5 + 2 * request_[5]) : std::uint16_t{0};
        }
        // A response to 06 repeats its request including the CRC, so a request of 06 has 8 bytes.
        if (is_write(code_)) return request_.size() == 8 || (request_.size() > 8 && code_ != 0x06) ? 8 : 0;
        return static_cast<std::uint16_t>(response_.size() < max_frame ? response_.size() : max_frame);
    }

    // Number of response bytes that are compared one by one as they arrive; the CRC checks the others. A
    // response that is shorter than its request may be the beginning of the request's echo, with a valid CRC:
    // this is possible for 248 requests for one register (`06 03 02 12 00 01 24 00`).
    constexpr std::size_t header_checked() const {
        return length_ < request_.size() ? length_ : is_write(code_) ? 6u : 3u;
    }

    constexpr void accept(std::uint8_t byte) {
        switch (phase_) {
        case phase::awaiting: return begin(byte);
        case phase::receiving: return check(byte);
        case phase::other_unit: return pass_by(byte);
        default: return;
        }
    }

    constexpr void begin(std::uint8_t byte) {
        if (byte == unit_) {
            phase_ = phase::receiving;
            differs_ = false;
            response_[0] = byte;
            count_ = 1;
        } else if ((byte == 0x00 || byte == 0xFF) && leading_ < limits_->leading_bytes) {
            ++leading_;
        } else {
            phase_ = phase::other_unit;
            other_crc_ = Crc::update(Crc::begin(), byte);
            other_length_ = 3; // until the third byte has arrived
            other_count_ = 1;
        }
    }

    constexpr void check(std::uint8_t byte) {
        const errc wrong = mismatch(byte);
        // Compared before the byte is stored: request and response may share memory.
        differs_ = differs_ || byte != request_[count_];
        response_[count_++] = byte;
        if (wrong != errc::ok) end({wrong});
    }

    // Compares the next byte of the header with what the request implies.
    constexpr errc mismatch(std::uint8_t byte) {
        if (count_ == 1) {
            if (byte == (code_ | exception_flag)) {
                length_ = exception_frame;
                return errc::ok;
            }
            return byte == code_ ? errc::ok : errc::wrong_function;
        }
        if (response_[1] != code_) return errc::ok; // an exception may have any number
        if (is_read(code_)) return count_ > 2 || byte == length_ - 5u ? errc::ok : errc::wrong_byte_count;
        if (!is_write(code_) || count_ >= 6) return errc::ok;
        std::uint8_t expected = request_[count_];
        if (code_ == 0x10 && limits_->echoes_byte_count && count_ == 5 && byte == request_[6])
            expected = byte;
        if (byte == expected) return errc::ok;
        if (count_ < 4) return errc::wrong_address;
        return code_ == 0x06 ? errc::wrong_value : errc::wrong_quantity;
    }

    constexpr void check_frame() {
        if (crc16<Crc>(bytes{response_.data(), length_}) != 0) return end({errc::bad_crc});
        if (response_[1] != code_) return end({errc::exception, response_[2]});
        if (length_ < request_.size() && !differs_) {
            phase_ = phase::maybe_echo;
        } else {
            end({errc::ok});
            if (response_[length_ - 1u] == 0) doubt_zeros();
        }
    }

    // Follows a response of another address to its end, since the awaited response may come immediately after
    // it. After a frame of unknown length or with a bad CRC all bytes are ignored until a gap.
    constexpr void pass_by(std::uint8_t byte) {
        other_crc_ = Crc::update(other_crc_, byte);
        if (other_count_ == 1) other_code_ = byte;
        ++other_count_;
        if (other_count_ == 3) other_length_ = static_cast<std::uint16_t>(response_length(other_code_, byte));
        if (other_count_ < other_length_) return;
        if (other_length_ == 0 || Crc::end(other_crc_) != 0) {
            phase_ = phase::resync;
        } else {
            if (other_frames_ < 0xFF) ++other_frames_;
            restart();
        }
    }

    bytes request_{};
    byte_buffer response_{};
    const rtu_timing* timing_ = nullptr;
    const response_limits* limits_ = nullptr;
    instant sent_{};
    instant last_{};
    typename Crc::state other_crc_{};
    std::uint16_t count_ = 0;
    std::uint16_t length_ = 0;
    std::uint16_t other_length_ = 0;
    std::uint16_t ticket_ = 0;
    std::uint16_t other_count_ = 0;
    std::uint8_t other_code_ = 0;
    std::uint8_t other_frames_ = 0;
    std::uint8_t unit_ = 0;
    std::uint8_t code_ = 0;
    std::uint8_t leading_ = 0;
    bool was_sent_ = false;
    bool has_heard_ = false;
    bool differs_ = false; // the response received so far differs from the request
    phase phase_ = phase::done;
    failure why_{errc::bad_argument};
};

using exchange = basic_exchange<>;

} // namespace servobus::modbus
