// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Finds the requests to a server among received bytes: the part that every server on a line shares. It does no I/O and
// has no clock. modbus/server.hpp and server/host_row_server.hpp derive from it; so does a server of your own.
//
//     struct mute : modbus::request_receiver<mute> { // it executes nothing, and says so
//         using request_receiver::request_receiver;
//         constexpr std::size_t execute(bytes f, byte_buffer pdu) { return modbus::put_exception(pdu, f[1], 1); }
//         constexpr bool is_executed(std::uint8_t) const { return false; }
//     };
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::modbus {

/// Receives the frames of a line for a server at one address, `Server`, which derives from it. The caller passes
/// received bytes and their times to `feed`, calls `elapse` when none arrived, and sends `response()` unless it is
/// empty. Before the first byte the line counts as quiet.
///
/// Strict timing separates frames by gaps. Host timing, where adapters add gaps and hide others, separates
/// frames by length and CRC. A frame of another address may then be a request of one length or a response of
/// another: these are two parse candidates, and the server follows both. If only one of them contains a request to
/// this server, the request is executed after a visible gap (`rtu_timing::visible_gap`) has ended the other.
///
/// In host timing a frame of another address with a function of unknown length ends with a visible gap, or
/// earlier where its CRC fits and no byte was received for t3.5. Only the next request is found so: no
/// request to this server ends there.
///
/// Up to `leading_bytes` bytes 00 or FF after a gap are skipped, as a driver that is switched on sends them. A
/// frame that begins with such a byte, such as a broadcast, is another parse candidate. It is executed where
/// it ends; a request after skipped bytes may have to wait for a visible gap.
///
/// `Server` has two members:
/// - `std::size_t execute(bytes frame, byte_buffer pdu)` executes a request to its address or to all. `frame` has a
///   right CRC. It builds the response in `pdu`, 253 bytes, and returns its length; 0 for none. To a broadcast no
///   response is sent.
/// - `bool is_executed(std::uint8_t code)` is true for the functions of which a bad CRC at their length is an error. A
///   frame of any other may have any length.
///
/// `bad_crc` is the exception number for a frame with a bad CRC; 0: no response.
template <class Server> class request_receiver {
  public:
    constexpr request_receiver(std::uint8_t node_address, rtu_timing timing, std::uint8_t leading_bytes = 4,
                               std::uint8_t bad_crc = 0)
        : timing_{timing}, address_{node_address}, leading_bytes_{leading_bytes}, bad_crc_{bad_crc},
          beginning_{at_beginning()} {}

    constexpr const rtu_timing& timing() const { return timing_; }
    constexpr std::uint8_t address() const { return address_; }
    constexpr void set_address(std::uint8_t node_address) { address_ = node_address; }

    /// Processes bytes that arrived at `now`, the last of them just then: by an interrupt, or in a program that
    /// never stalls. Where they arrived earlier, the time that has passed would count as a gap before them.
    constexpr void feed(bytes arrived, instant now) {
        if (arrived.empty()) return;
        const duration gap = since(last_, now);
        if (is_host() && gap >= t3_5_before(arrived.size())) note_pause();
        if (gap > timing_.longest_gap(arrived.size())) end_of_frame(gap, arrived.size());
        feed_late(arrived, now);
    }

    /// The same for bytes that arrived at unknown times before `now`, as in a program that polls a port and may
    /// stall between two calls of it. A gap before them counts as far as `elapse` was called in it.
    constexpr void feed_late(bytes arrived, instant now) {
        if (arrived.empty()) return;
        if (!has_received_) end_of_frame({}, 0);
        has_received_ = true;
        last_ = now;
        for (const std::uint8_t byte : arrived) take(byte);
    }

    /// Advances time to `now`, if no byte had arrived by then: read the clock before you look for a byte.
    constexpr void elapse(instant now) {
        if (state_ == state::answering) return;
        const duration gap = since(last_, now);
        if (is_host() && gap >= t3_5_before(0)) note_pause();
        if (gap <= timing_.visible_gap()) return;
        state_ = state::listening;
        beginning_ = at_beginning(); // stored now: the clock may wrap before the next byte
        if (count_ != 0) end_by_gap();
    }

    /// The response frame to send now. Empty if there is none, or if the last byte arrived less than t3.5
    /// ago.
    constexpr bytes response(instant now) const {
        if (state_ != state::answering || since(last_, now) < duration{timing_.t3_5}) return {};
        return bytes{response_, response_size_};
    }

    /// True from the end of a request that has a response until `sent()`.
    constexpr bool is_answering() const { return state_ == state::answering; }

    /// Call when the last stop bit of the response has left, at `now`.
    constexpr void sent(instant now) {
        state_ = state::listening;
        count_ = 0;
        last_ = now;
        beginning_ = 0;
    }

    /// Number of dropped frames: bad CRC, too long, incomplete, or, in strict timing, of another address with
    /// a function of unknown length.
    constexpr std::uint32_t dropped() const { return dropped_; }

  private:
    enum class state : std::uint8_t { listening, resync, answering };

    constexpr bool is_host() const { return timing_.mode == timing_mode::host; }
    // The time since the byte before, if `arrived` bytes have come together after a gap of t3.5.
    constexpr duration t3_5_before(std::size_t arrived) const {
        return duration{timing_.t3_5} + timing_.wire_time(arrived);
    }
    constexpr std::uint16_t at_beginning() const { return static_cast<std::uint16_t>(leading_bytes_ + 1); }

    constexpr void end_of_frame(duration gap, std::size_t arrived) {
        const duration needed = is_host() ? timing_.visible_gap() : t3_5_before(arrived);
        beginning_ = !has_received_ || gap >= needed ? at_beginning() : std::uint16_t{0};
        if (state_ == state::answering) return;
        if (count_ != 0 && !settle().empty()) drop();
        state_ = state::listening;
    }

    constexpr void take(std::uint8_t byte) {
        if (state_ != state::listening) return;
        const bool is_ambiguous = candidate_count_ > 1;
        if (count_ == max_frame && is_ambiguous) give_up_oldest();
        if (count_ >= max_frame) return start_resync();
        buffer_[count_++] = byte;
        part(is_ambiguous);
        beginning_ = may_skip(byte) ? static_cast<std::uint16_t>(beginning_ - 1) : std::uint16_t{0};
        // Skipping a byte never hides a frame that begins with it.
        candidate r = candidates_[0];
        std::size_t direct = 0;
        for (std::size_t i = 0; i < candidate_count_; ++i) {
            if (!candidates_[i].has_skipped) r = candidates_[i], ++direct;
        }
        if (direct != 1 && candidate_count_ != 1) return;
        const bytes frame = under_way(r);
        if (frame.empty() || !is_mine(frame[0]) || frame.size() != request_length(frame)) return;
        if (crc16(frame) == 0) return execute(r, frame);
        if (self().is_executed(frame[1])) refuse_crc(frame);
    }

    // One way to divide the received bytes into frames. `begin` is where the current frame begins. If the
    // last frame was a read request to another address, `node_address` is that address and `byte_count` the count of
    // its response; otherwise `byte_count` is 0. It is `any` while nothing is known of the line: any read
    // response may follow. `has_skipped`: a byte 00 or FF before the frame was skipped, and there is a
    // candidate in which the frame begins with it.
    struct candidate {
        static constexpr std::uint8_t any = 0xFF;

        std::uint16_t begin = 0;
        std::uint8_t node_address = 0;
        std::uint8_t byte_count = any;
        bool has_skipped = false;

        constexpr bool expects(bytes frame) const {
            if (byte_count == any)
                return frame[2] <= 2 * modbus::max_read && (frame[2] % 2 == 0 || is_bit_read(frame[1]));
            return frame[0] == node_address && frame[2] == byte_count;
        }
    };

    static constexpr bool is_bit_read(std::uint8_t code) { return code == 0x01 || code == 0x02; }
    static constexpr bool has_length(std::uint8_t code) { return response_length(code, 0) != 0; }

    constexpr bool is_mine(std::uint8_t node_address) const {
        return node_address == address_ || node_address == broadcast;
    }
    constexpr bytes under_way(const candidate& r) const { return bytes{buffer_, count_}.subspan(r.begin); }
    constexpr bool is_glitch(std::uint8_t byte) const {
        return (byte == 0x00 || byte == 0xFF) && byte != address_;
    }
    constexpr bool may_skip(std::uint8_t byte) const { return beginning_ > 1 && is_glitch(byte); }

    // Applies the newest byte to every candidate.
    constexpr void part(bool is_ambiguous) {
        candidate before[most_candidates];
        const std::size_t count = candidate_count_;
        for (std::size_t i = 0; i < count; ++i) before[i] = candidates_[i];
        if (count == 1) before[0].has_skipped = false;
        candidate_count_ = 0;
        for (std::size_t i = 0; i < count; ++i) follow(before[i], is_ambiguous);
        if (candidate_count_ == 0 || candidate_count_ > most_candidates) return start_resync();
        move_to_front();
    }

    // Keeps a candidate unless its current frame can no longer become valid.
    constexpr void follow(candidate r, bool is_ambiguous) {
        const std::size_t as_request = request_length(under_way(r));
        // More bytes followed: if that was a request, its client did not wait for the response.
        if (is_ambiguous && as_request != 0 && is_mine(under_way(r)[0]) && under_way(r).size() > as_request)
            r.begin = static_cast<std::uint16_t>(count_ - 1);
        const bytes frame = under_way(r);
        const std::size_t size = frame.size();
        if (size == 1) return begin_frame(r, frame[0]);
        if (is_ambiguous && size == 2 && is_glitch(frame[0]) && !is_function(frame[1])) return;
        if (is_mine(frame[0])) {
            if (!is_ambiguous || size != as_request || crc16(frame) == 0) add(r);
            return;
        }
        const std::size_t as_response = size >= 3 ? response_length(frame[1], frame[2]) : 0;
        // The byte count of a request of function 17h may follow after the end of a response.
        const bool is_known = as_request != 0 || (as_response != 0 && frame[1] != 0x17);
        const bool is_over = is_known && size >= as_request && size >= as_response;
        if ((size == as_request || size == as_response) && crc16(frame) == 0) {
            const bool is_request = size == as_request;
            if (is_host() && !is_over && (is_request ? r.expects(frame) : may_be_request(frame))) add(r);
            add(behind(r, frame, is_request));
        } else if (!is_over) {
            add(r);
        }
    }

    static constexpr bool is_function(std::uint8_t code) { return code != 0 && code < exception_flag; }

    // A frame may begin with this byte; or after it, if it may be skipped.
    constexpr void begin_frame(candidate r, std::uint8_t byte) {
        if (!is_host() && beginning_ == 0) return;
        add(r);
        if (!may_skip(byte)) return;
        r.begin = static_cast<std::uint16_t>(count_);
        r.has_skipped = true;
        add(r);
    }

    // True if a frame that may end here as a response may also continue as a request, which is longer.
    static constexpr bool may_be_request(bytes frame) {
        const std::size_t size = frame.size();
        if (frame[1] == 0x17) {
            if (size >= 6 && (load_word(frame, 4) == 0 || load_word(frame, 4) > modbus::max_read))
                return false;
            return size < 11 || frame[10] == 2u * load_word(frame, 8);
        }
        if (size < 8) return true;
        const std::size_t quantity = load_word(frame, 4);
        return frame[6] == (frame[1] == 0x0F ? (quantity + 7) / 8 : 2 * quantity);
    }

    // The candidate that continues after `frame`, which ended with the newest byte.
    constexpr candidate behind(const candidate& r, bytes frame, bool is_request) const {
        const auto begin = static_cast<std::uint16_t>(count_);
        if (is_request && detail::is_in(detail::counted_responses, frame[1])) {
            const std::size_t quantity = load_word(frame, 4);
            const std::size_t count = is_bit_read(frame[1]) ? (quantity + 7) / 8 : 2 * quantity;
            if (count <= std::size_t{2} * modbus::max_read)
                return {begin, frame[0], static_cast<std::uint8_t>(count), r.has_skipped};
        }
        return {begin, 0, 0, r.has_skipped};
    }

    // No byte was received for t3.5, in host timing. Ends the frames that end so. If a frame has ended,
    // candidates that are inside a frame of unknown length are wrong.
    constexpr void note_pause() {
        if (state_ != state::listening || beginning_ == at_beginning()) return; // or it was noted before
        beginning_ = at_beginning();
        const auto end = static_cast<std::uint16_t>(count_);
        bool has_ended = false;
        for (std::size_t i = 0; i < candidate_count_; ++i) {
            candidate& r = candidates_[i];
            if (ends_with_pause(under_way(r))) r = {end, 0, 0, r.has_skipped};
            has_ended = has_ended || r.begin == end;
        }
        if (!has_ended) return;
        const std::size_t count = candidate_count_;
        candidate_count_ = 0;
        for (std::size_t i = 0; i < count; ++i) { // `add` stores no further than at i
            const candidate r = candidates_[i];
            const bytes frame = under_way(r);
            if (frame.size() < 2 || has_length(frame[1]) || is_whole(frame)) add(r);
        }
        move_to_front();
    }

    // True for a whole frame of unknown length that is not addressed to this server alone.
    constexpr bool ends_with_pause(bytes frame) const {
        return frame.size() >= min_frame && frame[0] != address_ && !has_length(frame[1]) &&
               crc16(frame) == 0;
    }

    // Adds a candidate. Candidates whose current frame begins at the same byte are merged.
    constexpr void add(const candidate& r) {
        for (std::size_t i = 0; i < candidate_count_ && i < most_candidates; ++i) {
            candidate& known = candidates_[i];
            if (known.begin != r.begin) continue;
            const bool has_skipped = known.has_skipped && r.has_skipped;
            if (known.byte_count != r.byte_count || known.node_address != r.node_address) known = {r.begin};
            known.has_skipped = has_skipped;
            return;
        }
        if (candidate_count_ < most_candidates) candidates_[candidate_count_] = r;
        ++candidate_count_;
    }

    // Moves the oldest current frame to the start of the buffer.
    constexpr void move_to_front() {
        std::size_t begin = count_;
        for (std::size_t i = 0; i < candidate_count_; ++i) {
            if (candidates_[i].begin < begin) begin = candidates_[i].begin;
        }
        if (begin == 0) return;
        for (std::size_t i = begin; i < count_; ++i) buffer_[i - begin] = buffer_[i];
        for (std::size_t i = 0; i < candidate_count_; ++i)
            candidates_[i].begin = static_cast<std::uint16_t>(candidates_[i].begin - begin);
        count_ -= begin;
    }

    // Drops the candidates whose current frame fills the buffer: no valid frame is longer. Where it is a whole request,
    // the next one begins.
    constexpr void give_up_oldest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < candidate_count_; ++i) {
            candidate& r = candidates_[i];
            if (r.begin == 0 && is_mine(buffer_[0]) && request_length(under_way(r)) == max_frame &&
                crc16(under_way(r)) == 0)
                r.begin = max_frame;
            if (r.begin != 0) candidates_[kept++] = r;
        }
        candidate_count_ = static_cast<std::uint8_t>(kept);
        move_to_front();
    }

    // True if the current frame is complete provided that no byte follows. A frame of another address with a
    // known length is incomplete: otherwise it would not be current any more.
    constexpr bool is_whole(bytes frame) const {
        if (frame.size() < min_frame || crc16(frame) != 0) return false;
        if (!is_mine(frame[0])) return !has_length(frame[1]);
        const std::size_t length = request_length(frame);
        return length == 0 || length == frame.size() || !self().is_executed(frame[1]);
    }

    // Handles a gap, which ends every frame: candidates with an incomplete frame are wrong. If one candidate
    // remains, returns the frame that the gap has ended, or an empty one if its last frame had ended before.
    // If none or several remain, drops everything and returns an empty one.
    constexpr bytes settle() {
        std::size_t whole = 0;
        candidate left{};
        for (std::size_t i = 0; i < candidate_count_; ++i) {
            const bytes frame = under_way(candidates_[i]);
            if (!frame.empty() && !is_whole(frame)) continue;
            left = candidates_[i];
            ++whole;
        }
        if (whole != 1) {
            drop();
            return {};
        }
        const bytes frame = under_way(left);
        begin_anew(left);
        return frame;
    }

    // Ends frames whose function does not determine their length, and decides between candidates.
    constexpr void end_by_gap() {
        const bytes frame = settle();
        if (frame.empty()) return;
        if (frame[0] == address_ || (frame[0] == broadcast && request_length(frame) != 0))
            return execute(candidates_[0], frame);
        drop();
    }

    constexpr void begin_anew(candidate r) {
        r.begin = 0;
        candidates_[0] = r;
        candidate_count_ = 1;
        count_ = 0;
    }

    // `frame` is under way in `r`. All other candidates are dropped.
    constexpr void execute(candidate r, bytes frame) {
        // A new request: the client no longer expects a response to one sent before the server's first byte.
        if (r.byte_count == candidate::any) r.byte_count = 0;
        begin_anew(r);
        const bool is_broadcast = frame[0] == broadcast;
        response_[0] = address_;
        const std::size_t size = self().execute(frame, byte_buffer{response_}.subspan(1, max_pdu));
        if (!is_broadcast && size != 0) answer(size);
    }

    constexpr void answer(std::size_t size) {
        response_size_ = close_frame(response_, size);
        state_ = state::answering;
    }

    constexpr void refuse_crc(bytes frame) {
        if (bad_crc_ == 0 || frame[0] == broadcast) return start_resync();
        drop();
        response_[0] = address_;
        answer(put_exception(byte_buffer{response_}.subspan(1, max_pdu), frame[1], bad_crc_));
    }

    constexpr void start_resync() {
        state_ = state::resync;
        drop();
    }

    // Counts a dropped frame and starts again with one candidate, in which any response may follow.
    constexpr void drop() {
        ++dropped_;
        begin_anew({});
    }

    constexpr Server& self() { return static_cast<Server&>(*this); }
    constexpr const Server& self() const { return static_cast<const Server&>(*this); }

    static constexpr std::size_t most_candidates = 4;

    rtu_timing timing_;
    instant last_{};
    std::uint8_t buffer_[max_frame]{};
    std::uint8_t response_[max_frame]{};
    candidate candidates_[most_candidates]{};
    std::size_t count_ = 0;
    std::size_t response_size_ = 0;
    std::uint32_t dropped_ = 0;
    std::uint8_t candidate_count_ = 1;
    std::uint8_t address_;
    std::uint8_t leading_bytes_;
    std::uint8_t bad_crc_;
    state state_ = state::listening;
    bool has_received_ = false;
    // At the beginning of a burst one more than the bytes that may still be skipped, otherwise 0.
    std::uint16_t beginning_;
};

} // namespace servobus::modbus
