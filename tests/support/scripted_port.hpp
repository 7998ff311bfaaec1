// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port in memory with its own clock. It records what was sent and when, lets a scripted device respond at
// given times after a request, and fails on demand: the n-th call, short writes, empty reads, a clock that
// wraps, jumps or stops. Nothing here uses the library's own CRC or frames, so a mistake there cannot hide
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include <servobus/line/port.hpp>

namespace tests {

using byte_list = std::vector<std::uint8_t>;

/// CRC-16/MODBUS, bit by bit as the standard's flow chart has it.
inline std::uint16_t crc_of(servobus::bytes data) {
    unsigned crc = 0xFFFF;
    for (const std::uint8_t byte : data) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? crc >> 1 ^ 0xA001u : crc >> 1;
    }
    return static_cast<std::uint16_t>(crc);
}

/// `body`, followed by its CRC.
inline byte_list framed(byte_list body) {
    const std::uint16_t crc = crc_of(body);
    body.push_back(static_cast<std::uint8_t>(crc & 0xFF));
    body.push_back(static_cast<std::uint8_t>(crc >> 8));
    return body;
}

inline byte_list operator+(byte_list a, const byte_list& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

inline std::uint8_t high_byte(unsigned word) { return static_cast<std::uint8_t>(word >> 8 & 0xFFu); }
inline std::uint8_t low_byte(unsigned word) { return static_cast<std::uint8_t>(word & 0xFFu); }

/// The response to a read, with these words.
inline byte_list read_response(std::uint8_t node_address, const std::vector<std::uint16_t>& words,
                               std::uint8_t code = 0x03) {
    byte_list body{node_address, code, static_cast<std::uint8_t>(2 * words.size())};
    for (const std::uint16_t w : words) {
        body.push_back(high_byte(w));
        body.push_back(low_byte(w));
    }
    return framed(std::move(body));
}

/// The response that acknowledges a request of function 06 or 10h.
inline byte_list acknowledgement(const byte_list& request) {
    return framed(byte_list(request.begin(), request.begin() + 6));
}

inline byte_list exception_response(std::uint8_t node_address, std::uint8_t code, std::uint8_t number) {
    return framed({node_address, static_cast<std::uint8_t>(code | 0x80u), number});
}

/// A small pseudo-random generator with a fixed seed: it gives the same numbers on every machine.
class dice {
  public:
    explicit dice(std::uint64_t seed) : state_{seed} {}
    std::uint32_t next() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<std::uint32_t>(state_ >> 33);
    }
    std::uint32_t below(std::uint32_t n) { return next() % n; }
    std::uint8_t byte() { return static_cast<std::uint8_t>(next() >> 8 & 0xFFu); }

  private:
    std::uint64_t state_;
};

/// The bytes of one frame on the wire, with the times of its first and last bit.
struct sent_frame {
    byte_list data;
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    bool complete = false;
};

/// The port. A test may set all its figures before the calls. Times are in microseconds of its own clock,
/// which advances by `call_us` at each call.
class scripted_port {
  public:
    /// Called when the last byte of a whole request is taken; sends the response by `say`.
    std::function<void(scripted_port&, const sent_frame&)> device;
    /// The value of the clock at a true time.
    std::function<std::uint32_t(std::uint64_t)> clock = [](std::uint64_t t) {
        return static_cast<std::uint32_t>(t & 0xFFFF'FFFFu);
    };

    std::uint64_t time = 1000;    ///< the true time
    std::uint32_t call_us = 1;    ///< the time that a call takes
    std::uint32_t receive_us = 0; ///< the additional time that a `receive` takes
    std::uint32_t character_us = 96;

    std::size_t takes_at_most = 1000; ///< bytes a `send` takes
    bool takes_only_when_idle = false;
    std::uint64_t takes_nothing_until = 0;
    std::size_t gives_at_most = 1000; ///< bytes a `receive` gives
    std::uint32_t empty_reads = 0;    ///< `receive` gives nothing this many times between two calls that may
                                      ///< give bytes
    std::uint64_t fails_at_call = 0;  ///< this call of `send` or `receive` fails; 0: none
    std::uint64_t noisy_until = 0;    ///< `receive` fails until then, as a UART does on a framing error
    std::uint64_t lost_from_call = 0; ///< from this call on the port is lost; 0: never
    std::uint32_t says_sent_late = 0; ///< `sent` is late by this much
    bool never_sent = false;          ///< `sent` never turns true
    bool lies_about_counts = false;   ///< claims to have moved more bytes than it was offered
    bool keeps_echo = false;          ///< does not empty its receiver: the line must remove the echo
    bool corrupts_echo = false;       ///< one bit of the second byte comes back wrong
    std::uint32_t echo_late_us = 0;   ///< the echo of a byte arrives this long after the byte has left
    bool echoes = false; ///< receives its own bytes, as a two-wire adapter does, and empties its receiver as
                         ///< it must
    std::uint64_t most_calls = 30'000'000; ///< then everything fails, so that no test can hang

    std::deque<sent_frame> frames; ///< whole and truncated requests, in the order in which they were sent
    bool ran_away = false;
    bool has_failed = false;      ///< the requested failure has occurred
    std::uint64_t calls = 0;      ///< of `send`, `sent` and `receive`
    std::uint64_t last_heard = 0; ///< when the last byte that `receive` gave had arrived

    /// Sends bytes whose first bit comes `after` us after the last bit of the request to which they respond.
    void say(std::uint64_t after, const byte_list& what) { say_at(answered_ + after, what); }
    /// Sends bytes whose first bit comes at true time `at`, without gaps.
    void say_at(std::uint64_t at, const byte_list& what) {
        for (const std::uint8_t b : what) {
            at += character_us;
            arrive(at, b);
        }
    }
    /// One byte that can be received from `at` on.
    void arrive(std::uint64_t at, std::uint8_t byte) {
        auto place = arriving_.end();
        while (place != arriving_.begin() && std::prev(place)->first > at) --place;
        arriving_.insert(place, {at, byte});
    }
    std::size_t not_yet_received() const { return arriving_.size(); }
    /// When the last byte that is on its way will have arrived.
    std::uint64_t last_arrival() const { return arriving_.empty() ? last_heard : arriving_.back().first; }

    /// The number of frames on the wire, including truncated ones, that begin like a request of this
    /// function.
    std::size_t count_of(std::uint8_t code) const {
        std::size_t n = 0;
        for (const sent_frame& f : frames) n += f.data.size() >= 2 && f.data[1] == code;
        return n;
    }
    std::size_t bytes_sent() const {
        std::size_t n = 0;
        for (const sent_frame& f : frames) n += f.data.size();
        return n;
    }

    servobus::transfer send(servobus::bytes out) {
        if (const auto e = enter(); e != servobus::errc::ok) return servobus::status{e};
        if (time < takes_nothing_until || (takes_only_when_idle && time < busy_until_))
            return std::uint16_t{0};
        const std::size_t n = out.size() < takes_at_most ? out.size() : takes_at_most;
        for (std::size_t i = 0; i < n; ++i) take(out[i]);
        return static_cast<std::uint16_t>(lies_about_counts ? n + 100 : n);
    }

    bool sent() {
        ++calls;
        tick(call_us);
        if (never_sent || ran_away || time < busy_until_ + says_sent_late) return false;
        if (!frames.empty() && !frames.back().complete && is_of_unknown_length()) complete();
        while (echoes && !keeps_echo && !has_emptied_ && !arriving_.empty() &&
               arriving_.front().first <= time)
            arriving_.pop_front();
        has_emptied_ = true;
        return true;
    }

    servobus::transfer receive(servobus::byte_buffer in) {
        if (const auto e = enter(); e != servobus::errc::ok) return servobus::status{e};
        tick(receive_us);
        if (time < noisy_until) return servobus::errc::receive_failed;
        if (empty_reads != 0 && empties_++ % (empty_reads + 1) != 0) return std::uint16_t{0};
        std::size_t n = 0;
        while (n < in.size() && n < gives_at_most && !arriving_.empty() && arriving_.front().first <= time) {
            in[n++] = arriving_.front().second;
            last_heard = arriving_.front().first;
            arriving_.pop_front();
        }
        return static_cast<std::uint16_t>(lies_about_counts && n == in.size() ? n + 100 : n);
    }

    servobus::instant now() {
        tick(call_us);
        return {clock(time)};
    }

  protected:
    std::uint64_t next_arrival() const {
        return arriving_.empty() ? ~std::uint64_t{0} : arriving_.front().first;
    }

  private:
    void tick(std::uint64_t us) {
        time += us;
        if (++ticks_ > most_calls) ran_away = true;
    }

    servobus::errc enter() {
        ++calls;
        tick(call_us);
        if (ran_away) return servobus::errc::port_lost;
        if (lost_from_call != 0 && calls >= lost_from_call) {
            has_failed = true;
            return servobus::errc::port_lost;
        }
        if (calls == fails_at_call) {
            has_failed = true;
            return servobus::errc::receive_failed;
        }
        return servobus::errc::ok;
    }

    void take(std::uint8_t byte) {
        if (frames.empty() || frames.back().complete || time > busy_until_ + 1500) {
            frames.push_back({{}, time, time, false});
            busy_until_ = time;
        }
        if (busy_until_ < time) busy_until_ = time;
        has_emptied_ = false;
        busy_until_ += character_us;
        sent_frame& f = frames.back();
        f.data.push_back(byte);
        f.end = busy_until_;
        if (echoes) {
            const bool is_wrong = corrupts_echo && f.data.size() == 2;
            arrive(busy_until_ + echo_late_us, is_wrong ? static_cast<std::uint8_t>(byte ^ 1u) : byte);
        }
        if (f.data.size() == request_length(f.data)) complete();
    }

    void complete() {
        sent_frame& f = frames.back();
        f.complete = true;
        answered_ = f.end;
        if (device) device(*this, f);
    }

    bool is_of_unknown_length() const {
        const byte_list& f = frames.back().data;
        return f.size() >= 4 && request_length(f) == 0 && f[1] != 0x10;
    }
    static std::size_t request_length(const byte_list& f) {
        if (f.size() < 2) return 0;
        if (f[1] == 0x03 || f[1] == 0x04 || f[1] == 0x06) return 8;
        return f[1] == 0x10 && f.size() >= 7 ? f[6] + std::size_t{9} : 0;
    }

    std::deque<std::pair<std::uint64_t, std::uint8_t>> arriving_;
    std::uint64_t busy_until_ = 0;
    std::uint64_t answered_ = 0;
    std::uint64_t ticks_ = 0;
    std::uint32_t empties_ = 0;
    bool has_emptied_ = false;
};

/// The same port with a `wait` that ends when a byte arrives.
class waiting_scripted_port : public scripted_port {
  public:
    std::uint64_t oversleeps_us = 0; ///< by how much a sleep without a byte is too long

    void wait(servobus::duration d) {
        const std::uint64_t due = time + (d.us == 0 ? 1 : d.us) + oversleeps_us;
        const std::uint64_t next = next_arrival();
        if (next <= time) return;
        time = next < due ? next : due;
    }
};

/// The registers of node 1. Registers that were given a value exist; for any other one the response is
/// exception 2.
struct register_file {
    std::map<std::uint16_t, std::uint16_t> words;
    std::uint32_t delay = 500;

    byte_list response_to(const byte_list& q) {
        const auto address = static_cast<std::uint16_t>(q[2] << 8 | q[3]);
        const unsigned count = q[1] == 0x06 ? 1u : static_cast<unsigned>(q[4] << 8 | q[5]);
        for (unsigned i = 0; i < count; ++i) {
            if (words.count(static_cast<std::uint16_t>(address + i)) == 0)
                return exception_response(q[0], q[1], 2);
        }
        if (q[1] == 0x03 || q[1] == 0x04) {
            std::vector<std::uint16_t> values;
            for (unsigned i = 0; i < count; ++i)
                values.push_back(words[static_cast<std::uint16_t>(address + i)]);
            return read_response(q[0], values, q[1]);
        }
        for (unsigned i = 0; i < count; ++i) {
            const std::size_t at = q[1] == 0x06 ? 4 : 7 + 2 * std::size_t{i};
            words[static_cast<std::uint16_t>(address + i)] =
                static_cast<std::uint16_t>(q[at] << 8 | q[at + 1]);
        }
        return acknowledgement(q);
    }
    void operator()(scripted_port& port, const sent_frame& f) {
        if (f.data[0] == 1) port.say(delay, response_to(f.data));
        if (f.data[0] == 0) (void)response_to(f.data);
    }
};

static_assert(servobus::port<scripted_port> && !servobus::waiting_port<scripted_port>);
static_assert(servobus::waiting_port<waiting_scripted_port>);

} // namespace tests
