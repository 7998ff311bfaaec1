// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The device side of Modbus RTU: a server finds requests in received bytes and executes them on a register
// store. It does no I/O and has no clock. The simulated drives include it; programs include it to act as a
// Modbus device.
//
//     constexpr auto poll = [](auto& server, auto& uart) { // server: a modbus::server<Store>
//         server.feed(uart.received(), uart.now()), server.elapse(uart.now());
//         const bytes frame = server.response(uart.now());
//         if (!frame.empty()) uart.send(frame), server.sent(uart.now());
//     };
//
// The checks have the order of the standard: function, quantity and byte count, address range, execution. A
// server sends no response to a frame with a bad CRC (unless its rules give an exception for it), to a frame
// of another address or to a broadcast.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::modbus {

/// The registers of a server. `read` and `write` return 0, or one of the device's exception numbers. A write
/// that returns an exception must not have changed any register.
template <class S>
concept register_store = requires(S& s, std::uint16_t address, slice<std::uint16_t> to, words_view from) {
    { s.read(address, to) } -> std::same_as<std::uint8_t>;
    { s.write(address, from) } -> std::same_as<std::uint8_t>;
};

/// Which requests a server executes, and its exception numbers for the others.
struct server_rules {
    std::uint16_t max_read = modbus::max_read;   ///< registers in one read
    std::uint16_t max_write = modbus::max_write; ///< registers in one write
    bool reads_input_registers = false;          ///< function 04 reads the same registers as 03
    std::uint8_t illegal_function = 1;
    std::uint8_t illegal_address = 2;
    std::uint8_t illegal_value = 3;
    std::uint8_t bad_crc = 0;       ///< exception number for a frame with a bad CRC; 0: no response
    bool echoes_byte_count = false; ///< the response to 10h has the byte count in place of the quantity
};

/// The rules for a store: the result of its member `rules()` if it has one, otherwise the standard's.
template <register_store Store> constexpr server_rules rules_of(const Store& store) {
    if constexpr (requires { store.rules(); }) {
        return store.rules();
    } else {
        return {};
    }
}

/// Executes a request PDU on a store and builds the response PDU in `out` (at least 253 bytes). Returns the
/// length of the response. `pdu` must not share memory with `out`.
template <register_store Store>
constexpr std::size_t respond(Store& store, bytes pdu, byte_buffer out, const server_rules& rules) {
    const std::uint8_t code = pdu.empty() ? std::uint8_t{0} : pdu[0];
    const bool is_known = code == 0x03 || is_write(code) || (code == 0x04 && rules.reads_input_registers);
    if (!is_known) return put_exception(out, code, rules.illegal_function);
    const result<request> r = parse_request(pdu);
    if (!r) {
        return put_exception(out, code,
                             r.error() == errc::wrong_address ? rules.illegal_address : rules.illegal_value);
    }
    if (r->quantity > (is_read(code) ? rules.max_read : rules.max_write))
        return put_exception(out, code, rules.illegal_value);
    if (is_write(code)) {
        const std::uint8_t refusal = store.write(r->address, r->values());
        if (refusal != 0) return put_exception(out, code, refusal);
        for (std::size_t i = 0; i < 5; ++i) out[i] = pdu[i];
        if (rules.echoes_byte_count && code == 0x10)
            store_word(out, 3, static_cast<std::uint16_t>(2 * r->quantity));
        return 5;
    }
    std::uint16_t words[modbus::max_read]{};
    const slice<std::uint16_t> wanted = slice<std::uint16_t>{words}.first(r->quantity);
    const std::uint8_t refusal = store.read(r->address, wanted);
    if (refusal != 0) return put_exception(out, code, refusal);
    out[0] = code;
    out[1] = static_cast<std::uint8_t>(2 * wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) store_word(out, 2 + 2 * i, wanted[i]);
    return 2 + 2 * wanted.size();
}

/// The length of a request frame, from its first bytes. 0 while these are too few, and for functions whose
/// frames end only with a gap.
constexpr std::size_t request_length(bytes begun) {
    if (begun.size() < 2) return 0;
    if (is_read(begun[1]) || begun[1] == 0x06) return 8;
    if (begun[1] == 0x10 && begun.size() >= 7) return std::size_t{begun[6]} + 9;
    return 0;
}

/// A server at one address. The caller passes received bytes and their times to `feed`, calls `elapse` when
/// none arrived, and sends `response()` unless it is empty. Before the first byte the line counts as quiet.
///
/// Strict timing separates frames by gaps. Host timing cannot measure t3.5 and separates frames by length and
/// CRC. A frame of another address may then be a request of one length or a response of another. The server
/// follows both readings of the bytes. If only one of them contains a request to this server, the request is
/// executed after a visible gap (`rtu_timing::visible_gap`) has ended the other reading.
template <register_store Store> class server {
  public:
    constexpr server(std::uint8_t node_address, Store& store, rtu_timing timing)
        : server{node_address, store, timing, rules_of(store)} {}
    constexpr server(std::uint8_t node_address, Store& store, rtu_timing timing, server_rules rules)
        : store_{&store}, timing_{timing}, rules_{rules}, unit_{node_address} {}

    constexpr const rtu_timing& timing() const { return timing_; }
    constexpr std::uint8_t address() const { return unit_; }
    constexpr void set_address(std::uint8_t node_address) { unit_ = node_address; }

    /// Processes bytes that had arrived by `now`.
    constexpr void feed(bytes arrived, instant now) {
        if (arrived.empty()) return;
        const duration gap = since(last_, now);
        if (gap > timing_.longest_gap(arrived.size()) || !has_received_) end_of_frame(gap, arrived.size());
        has_received_ = true;
        last_ = now;
        for (const std::uint8_t byte : arrived) take(byte);
    }

    /// Advances time; call it when no byte arrived.
    constexpr void elapse(instant now) {
        if (since(last_, now) <= timing_.visible_gap() || state_ == state::answering) return;
        state_ = state::listening;
        gap_seen_ = true; // stored now: the clock may wrap before the next byte
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
        gap_seen_ = timing_.mode == timing_mode::host;
    }

    /// Number of dropped frames: bad CRC, too long, incomplete, or of another address with a function of
    /// unknown length.
    constexpr std::uint32_t dropped() const { return dropped_; }

  private:
    enum class state : std::uint8_t { listening, resync, answering };

    constexpr void end_of_frame(duration gap, std::size_t arrived) {
        const duration needed = timing_.mode == timing_mode::strict
                                    ? duration{timing_.t3_5} + timing_.wire_time(arrived)
                                    : timing_.visible_gap();
        gap_seen_ = !has_received_ || gap >= needed;
        if (state_ == state::answering) return;
        if (count_ != 0 && !settle().empty()) drop();
        state_ = state::listening;
    }

    constexpr void take(std::uint8_t byte) {
        if (state_ != state::listening) return;
        if (count_ == 0 && !gap_seen_) return start_resync();
        const bool is_ambiguous = reading_count_ > 1;
        if (count_ == max_frame && is_ambiguous) give_up_oldest();
        if (count_ >= max_frame) return start_resync();
        buffer_[count_++] = byte;
        part(is_ambiguous);
        if (reading_count_ != 1 || count_ == 0 || !is_mine(buffer_[0])) return;
        const bytes frame{buffer_, count_};
        if (count_ != request_length(frame)) return;
        if (crc16(frame) != 0) return refuse_crc(frame);
        execute(frame);
    }

    // One way to divide the received bytes into frames. `begin` is where the current frame begins. If the
    // last frame was a read request to another address, `unit` is that address and `byte_count` the count of
    // its response; otherwise `byte_count` is 0. It is `any` while nothing is known of the line: any read
    // response may follow.
    struct reading {
        static constexpr std::uint8_t any = 0xFF;

        std::uint16_t begin = 0;
        std::uint8_t node_address = 0;
        std::uint8_t byte_count = any;

        constexpr bool expects(bytes frame) const {
            if (byte_count == any) return frame[2] % 2 == 0 && frame[2] <= 2 * modbus::max_read;
            return frame[0] == node_address && frame[2] == byte_count;
        }
    };

    constexpr bool is_mine(std::uint8_t node_address) const {
        return node_address == unit_ || node_address == broadcast;
    }
    constexpr bytes under_way(const reading& r) const { return bytes{buffer_, count_}.subspan(r.begin); }

    // Applies the newest byte to every reading.
    constexpr void part(bool is_ambiguous) {
        reading before[most_readings];
        const std::size_t count = reading_count_;
        for (std::size_t i = 0; i < count; ++i) before[i] = readings_[i];
        reading_count_ = 0;
        for (std::size_t i = 0; i < count; ++i) follow(before[i], is_ambiguous);
        if (reading_count_ == 0 || reading_count_ > most_readings) return start_resync();
        move_to_front();
    }

    // Keeps a reading unless its current frame can no longer become valid.
    constexpr void follow(reading r, bool is_ambiguous) {
        const bytes frame = under_way(r);
        const std::size_t size = frame.size();
        const std::size_t as_request = request_length(frame);
        if (is_mine(frame[0])) {
            if (is_ambiguous && as_request != 0) {
                if (size == as_request && crc16(frame) != 0) return;
                // More bytes followed: if that was a request, its client did not wait for the response.
                if (size > as_request) r.begin = static_cast<std::uint16_t>(count_ - 1);
            }
            return add(r);
        }
        const std::size_t as_response = size >= 3 ? response_length(frame[1], frame[2]) : 0;
        const bool is_over = size >= as_request && size >= as_response && as_request + as_response != 0;
        if ((size == as_request || size == as_response) && crc16(frame) == 0) {
            if (!is_over && may_be_longer(r, frame)) add(r);
            gap_seen_ = timing_.mode == timing_mode::host;
            add(behind(frame));
        } else if (!is_over) {
            add(r);
        }
    }

    // True if a frame that may end here may also continue, as the longer one of request and response.
    constexpr bool may_be_longer(const reading& r, bytes frame) const {
        if (timing_.mode == timing_mode::strict) return false;
        if (frame.size() < 8) return true;
        if (is_read(frame[1])) return r.expects(frame);
        return frame[6] == 2u * load_word(frame, 4);
    }

    // The reading that continues after `frame`, which ended with the newest byte.
    constexpr reading behind(bytes frame) const {
        const auto begin = static_cast<std::uint16_t>(count_);
        if (is_read(frame[1]) && frame.size() == 8) {
            const std::uint16_t quantity = load_word(frame, 4);
            if (quantity <= modbus::max_read)
                return {begin, frame[0], static_cast<std::uint8_t>(2 * quantity)};
        }
        return {begin, 0, 0};
    }

    // Adds a reading. Readings whose current frame begins at the same byte are merged.
    constexpr void add(const reading& r) {
        for (std::size_t i = 0; i < reading_count_ && i < most_readings; ++i) {
            reading& known = readings_[i];
            if (known.begin != r.begin) continue;
            if (known.byte_count != r.byte_count) known = {r.begin};
            return;
        }
        if (reading_count_ < most_readings) readings_[reading_count_] = r;
        ++reading_count_;
    }

    // Moves the oldest current frame to the start of the buffer.
    constexpr void move_to_front() {
        std::size_t begin = count_;
        for (std::size_t i = 0; i < reading_count_; ++i) {
            if (readings_[i].begin < begin) begin = readings_[i].begin;
        }
        if (begin == 0) return;
        for (std::size_t i = begin; i < count_; ++i) buffer_[i - begin] = buffer_[i];
        for (std::size_t i = 0; i < reading_count_; ++i)
            readings_[i].begin = static_cast<std::uint16_t>(readings_[i].begin - begin);
        count_ -= begin;
    }

    // Drops the readings whose current frame fills the buffer: no valid frame is longer.
    constexpr void give_up_oldest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < reading_count_; ++i) {
            if (readings_[i].begin != 0) readings_[kept++] = readings_[i];
        }
        reading_count_ = static_cast<std::uint8_t>(kept);
        move_to_front();
    }

    // True if the current frame is complete provided that no byte follows. A frame of another address with a
    // known length is incomplete: otherwise it would not be current any more.
    constexpr bool is_whole(bytes frame) const {
        if (frame.size() < min_frame || crc16(frame) != 0) return false;
        const std::size_t length = request_length(frame);
        return length == 0 || (is_mine(frame[0]) && length == frame.size());
    }

    // Handles a gap, which ends every frame: readings with an incomplete frame are wrong. If one reading
    // remains, returns the frame that the gap has ended, or an empty one if its last frame had ended before.
    // If none or several remain, drops everything and returns an empty one.
    constexpr bytes settle() {
        std::size_t whole = 0;
        reading left{};
        for (std::size_t i = 0; i < reading_count_; ++i) {
            const bytes frame = under_way(readings_[i]);
            if (!frame.empty() && !is_whole(frame)) continue;
            left = readings_[i];
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

    // Ends frames whose function does not determine their length, and decides between readings.
    constexpr void end_by_gap() {
        const bytes frame = settle();
        if (frame.empty()) return;
        if (frame[0] == unit_ || (frame[0] == broadcast && request_length(frame) != 0)) return execute(frame);
        drop();
    }

    constexpr void begin_anew(reading r) {
        r.begin = 0;
        readings_[0] = r;
        reading_count_ = 1;
        count_ = 0;
    }

    constexpr void execute(bytes frame) {
        // A new request: the client no longer expects a response to one sent before the server's first byte.
        if (readings_[0].byte_count == reading::any) readings_[0].byte_count = 0;
        count_ = 0;
        gap_seen_ = timing_.mode == timing_mode::host;
        const bool is_broadcast = frame[0] == broadcast;
        if (is_broadcast && !is_write(frame[1])) return; // a broadcast read has no response and no effect
        response_[0] = unit_;
        const std::size_t size = respond(*store_, frame.subspan(1, frame.size() - 3),
                                         byte_buffer{response_}.subspan(1, max_pdu), rules_);
        if (!is_broadcast) answer(size);
    }

    constexpr void answer(std::size_t size) {
        response_size_ = close_frame(response_, size);
        state_ = state::answering;
    }

    constexpr void refuse_crc(bytes frame) {
        if (rules_.bad_crc == 0 || frame[0] == broadcast) return start_resync();
        drop();
        response_[0] = unit_;
        answer(put_exception(byte_buffer{response_}.subspan(1, max_pdu), frame[1], rules_.bad_crc));
    }

    constexpr void start_resync() {
        state_ = state::resync;
        drop();
    }

    // Counts a dropped frame and starts again with one reading, in which any response may follow.
    constexpr void drop() {
        ++dropped_;
        begin_anew({});
    }

    static constexpr std::size_t most_readings = 4;

    Store* store_;
    rtu_timing timing_;
    server_rules rules_;
    instant last_{};
    std::uint8_t buffer_[max_frame]{};
    std::uint8_t response_[max_frame]{};
    reading readings_[most_readings]{};
    std::size_t count_ = 0;
    std::size_t response_size_ = 0;
    std::uint32_t dropped_ = 0;
    std::uint8_t reading_count_ = 1;
    std::uint8_t unit_;
    state state_ = state::listening;
    bool has_received_ = false;
    bool gap_seen_ = true;
};

} // namespace servobus::modbus
