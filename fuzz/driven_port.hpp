// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port that is driven by the input. It takes a part of a frame or nothing; it gives nothing, noise, an
// echo, a valid response or half of one; it fails, or reports more bytes than it moved. Its clock runs,
// jumps or stops. After the end of the input, or after `calm_down`, it works, and every request gets a
// response.
#pragma once

#include <algorithm>
#include <cstdint>

#include <servobus/line/detail/stall_detector.hpp>
#include <servobus/line/port.hpp>

#include "reference.hpp"
#include "support.hpp"

namespace fuzz {

enum class clock_kind : std::uint8_t { honest, jumping, stopped };

class driven_port {
  public:
    driven_port(input& in, clock_kind clock, std::uint32_t tick) : in_{&in}, tick_{tick}, clock_{clock} {}

    servobus::transfer send(servobus::bytes out) {
        tick();
        const unsigned what = next();
        if (what >= 0xF0)
            return servobus::status{what % 2 == 0 ? servobus::errc::send_failed : servobus::errc::port_lost};
        std::size_t n = out.size();
        if (what >= 0xA0) n = std::min<std::size_t>(n, what % 8u);
        if (request.empty()) begin(n);
        request.insert(request.end(), out.begin(), out.begin() + static_cast<long>(n));
        busy_until_ = std::max(busy_until_, time) + character_us * n;
        has_rest = has_rest || n != 0;
        return moved(n, out.size(), what >= 0xE8);
    }

    bool sent() {
        tick();
        if (time < busy_until_ || next() >= 0xE0) return false;
        has_rest = false;
        if (request.empty()) rest_left_at = time;
        heard.clear(); // bytes that came until now belong to no response
        active_at = left_at = time;
        if (is_calm()) {
            drop_coming();
            response(0);
        }
        return true;
    }

    servobus::transfer receive(servobus::byte_buffer in) {
        tick();
        const unsigned what = is_calm() ? 0xD0u : in_->byte();
        if (what >= 0xF0) return failed(what % 2 == 0);
        if (what < 0x60) {
            gap_us_ = is_dated_ ? read_at_ - dated_at_ : 0;
            return std::uint16_t{0};
        }
        if (what < 0xB0) response(what);
        if (what >= 0xB0 && what < 0xC0) {
            const servobus::bytes noise = in_->take(1 + what % 16u * 3u);
            coming_.insert(coming_.end(), noise.begin(), noise.end());
        }
        const std::size_t most = what % 2 == 0 ? in.size() : std::size_t{1} + what % 8u;
        const std::size_t n = std::min({most, in.size(), coming_.size() - given_});
        if (n == 0) {
            gap_us_ = is_dated_ ? read_at_ - dated_at_ : 0;
        } else {
            give(in.first(n));
        }
        return moved(n, in.size(), what >= 0xE8);
    }

    servobus::instant now() {
        tick();
        read_at_ = time;
        if (!is_dated_) dated_at_ = time;
        is_dated_ = true;
        if (clock_ == clock_kind::honest || (clock_ == clock_kind::jumping && is_calm())) return shown();
        const unsigned what = in_->byte();
        if (clock_ == clock_kind::stopped) {
            if (what == 0) return last_;
        } else if (what >= 0xD8) {
            skew_ += time_of(in_->byte());
        } else if (what >= 0xB0) {
            skew_ -= time_of(in_->byte());
        }
        return shown();
    }

    void wait(servobus::duration d) {
        tick();
        if (is_calm() && given_ != coming_.size()) return;
        const unsigned what = next();
        time += what >= 0xC0 ? std::min<std::uint32_t>(d.us, what) : d.us; // a byte or a signal ends the wait
        if (what >= 0xF0 && clock_ != clock_kind::honest) time += time_of(in_->byte());
    }

    /// From now on the port works.
    void calm_down() {
        in_->rest();
        drop_coming();
        has_lied = false;
    }
    /// The next call sends a new request.
    void forget() {
        request.clear();
        heard.clear();
        before.clear();
        silence_before = begun_at = left_at = 0;
        while_leaving.clear();
        is_garbled_while_leaving = false;
        is_slow = false;
        calls_ = 0;
    }

    /// A byte that was given since the request had left.
    struct arrival {
        std::uint8_t byte;
        std::uint64_t at;
        /// The gap before it that the line saw: from the clock that it read first after the byte before, to the
        /// one before it found the receiver empty for the last time.
        std::uint64_t seen_gap;
    };
    /// A byte that was received before the request.
    struct sound {
        std::uint64_t at;
        bool is_glitch; ///< 0x00 or 0xFF, as when an RS-485 driver is switched
    };

    std::uint64_t time = 0xFFFF'0000u; ///< the true time; the clock that the line reads wraps soon
    std::uint64_t active_at = time;    ///< when the last byte was given or had left
    std::uint64_t silence_before = 0;  ///< the gap before the first byte of the request
    std::uint64_t begun_at = 0;        ///< when that byte was taken
    std::uint64_t left_at = 0;         ///< when `sent` reported that the request had left; 0 before
    std::uint32_t character_us = 87;   ///< 0: the bytes that it takes have left immediately
    bool is_slow = false;              ///< it was offered the request and took nothing at first
    bool has_rest = false;             ///< `sent` has not yet reported that all bytes taken have left
    std::uint64_t rest_left_at = 0;    ///< when `sent` last reported that, before the request
    bool has_lied = false;
    bool is_garbled_while_leaving = false;
    std::uint64_t last_while_leaving = 0; ///< when the last of `while_leaving` was given
    bool has_local_echo = false;          ///< some responses are the request itself, with zeros after it
    bool echoes_byte_count = false;       ///< as quantity, in the response to 10h
    reference::byte_list request;         ///< the bytes that were taken
    reference::list<arrival> heard;       ///< since the request had left
    reference::list<sound> before;
    reference::byte_list while_leaving; ///< received between the first byte of the request and `sent`

  private:
    bool is_leaving() const { return !request.empty() && left_at == 0; }
    bool is_calm() const { return in_->empty(); }
    unsigned next() { return in_->byte(); } // 0, no fault, after the end of the input
    // Counts calls instead of measuring time, so that a call that never ends is found on any machine.
    void tick() {
        time += tick_;
        require(++calls_ < 400'000, "G29 a call ends, whatever port and clock do");
    }
    void begin(std::size_t taken) {
        if (taken == 0) {
            is_slow = true;
            return;
        }
        begun_at = time;
        silence_before = time - active_at;
    }
    // The first bytes that are coming, as many as fit.
    void give(servobus::byte_buffer in) {
        std::uint64_t gap = gap_us_;
        for (std::uint8_t& byte : in) {
            byte = coming_[given_++];
            heard.push_back({byte, time, gap});
            gap = 0;
            if (request.empty()) before.push_back({time, byte == 0x00 || byte == 0xFF});
            if (is_leaving()) {
                while_leaving.push_back(byte);
                last_while_leaving = time;
            }
        }
        if (given_ == coming_.size()) drop_coming();
        gap_us_ = 0;
        is_dated_ = false;
        active_at = time;
    }
    void drop_coming() {
        coming_.clear();
        given_ = 0;
    }
    servobus::status failed(bool is_garbled) {
        if (!is_garbled) return {servobus::errc::port_lost};
        is_garbled_while_leaving = is_garbled_while_leaving || is_leaving();
        if (request.empty()) {
            before.push_back({time, false});
            active_at = time;
        }
        return {servobus::errc::receive_failed};
    }
    servobus::instant shown() { return last_ = {static_cast<std::uint32_t>((time + skew_) & 0xFFFF'FFFFu)}; }

    servobus::transfer moved(std::size_t n, std::size_t most, bool lies) {
        lies = lies && !is_calm();
        has_lied = has_lied || lies;
        return static_cast<std::uint16_t>(lies ? most + n : n);
    }

    // The response to the bytes that were taken, cut or damaged as the input chooses.
    void response(unsigned what) {
        if (request.size() < 8 || request[0] == 0) return;
        if (has_local_echo && what >= 0x70 && what < 0x80) {
            coming_.insert(coming_.end(), request.begin(), request.end());
            coming_.resize(coming_.size() + what % 16u);
            return;
        }
        reference::byte_list body{request.begin(), request.begin() + 6};
        if (request[1] == 16 && echoes_byte_count) body[5] = request[6];
        if (request[1] == 3 || request[1] == 4) {
            body.resize(2);
            body.push_back(static_cast<std::uint8_t>(2 * request[5]));
            body.resize(3 + 2u * request[5], 0xA5);
        }
        if (what >= 0xA0) body = {request[0], static_cast<std::uint8_t>(request[1] | 0x80u), 2};
        reference::byte_list f = reference::framed(body);
        if (what >= 0x80 && what < 0x90) f[in_->byte() % f.size()] ^= 0x10;
        if (what >= 0x90 && what < 0xA0) cut(f, in_->byte());
        coming_.insert(coming_.end(), f.begin(), f.end());
    }

    input* in_;
    reference::byte_list coming_;
    std::size_t given_ = 0; // of these
    std::uint64_t busy_until_ = 0;
    std::uint64_t skew_ = 0;
    std::uint64_t read_at_ = 0;  // when the clock was read
    std::uint64_t dated_at_ = 0; // for the first time since the last byte, if `is_dated_`
    std::uint64_t gap_us_ = 0;
    bool is_dated_ = false;
    std::uint32_t calls_ = 0; ///< since the last request was begun
    servobus::instant last_{};
    std::uint32_t tick_;
    clock_kind clock_;
};

static_assert(servobus::waiting_port<driven_port>);

} // namespace fuzz

// A line looks at a stopped clock 10 000 times before it gives up. Here it looks 64 times, since these looks took
// nine tenths of all fuzzing. The tests of the lines wait for all of them.
namespace servobus::detail {
template <> inline constexpr std::uint32_t most_looks<fuzz::driven_port> = 64;
template <> inline constexpr unsigned most_looks_log2<fuzz::driven_port> = 6;
} // namespace servobus::detail
