// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Calls on a line over a driven port, and the checks of each call on either kind of line: its time, the gap
// before it, whether it was really sent, and that a success has its response. The last call runs on a line
// that works again. The checks use the bytes that the port itself took and gave.
#pragma once

#include <algorithm>
#include <cstdint>

#include <servobus/core/response_limits.hpp>
#include <servobus/core/result.hpp>

#include "driven_port.hpp"

namespace fuzz {

/// A port that is driven by the input, with the clock that the input chooses.
struct wire {
    explicit wire(input& from)
        : in{&from}, clock{clock_of(from.byte())}, tick{1u + from.byte() % 8u}, port{from, clock, tick} {}

    /// Whether the times and the bytes that the port reported are right.
    bool is_honest() const { return clock == clock_kind::honest && !port.has_lied; }
    /// With a stopped clock each call takes 10 000 readings of the clock.
    int most_calls() const { return clock == clock_kind::stopped ? 1 : 8; }

    input* in;
    clock_kind clock;
    std::uint32_t tick;
    driven_port port;

  private:
    static clock_kind clock_of(std::uint8_t choice) {
        if (choice >= 0xFC) return clock_kind::stopped;
        return choice < 0xA0 ? clock_kind::honest : clock_kind::jumping;
    }
};

/// A call that is chosen by the input.
struct call {
    explicit call(input& in)
        : how{in.byte()}, priority{is_stop(how) ? servobus::priority::stop : servobus::priority::ordinary},
          wanted{short_time(in), short_time(in)}, limits{limits_of(in, how)}, what{in.byte()},
          request{request_of(what)} {}

    unsigned how; ///< bit 0: a stop; from bit 5 on: the leading bytes; the rest is for the target
    servobus::priority priority;
    servobus::bus_gaps wanted;
    servobus::response_limits limits;
    unsigned what; ///< the request; from bit 5 on for the target
    reference::byte_list request;

  private:
    static bool is_stop(unsigned how) { return (how & 1u) != 0; }
    static servobus::duration short_time(input& in) {
        return servobus::duration{time_of(static_cast<std::uint8_t>(in.byte() & 0x8Fu))};
    }
    static servobus::response_limits limits_of(input& in, unsigned how) {
        servobus::response_limits limits;
        limits.response = short_time(in);
        limits.leading_bytes = static_cast<std::uint8_t>(how >> 5);
        return limits;
    }
    static reference::byte_list request_of(unsigned what) {
        const std::uint8_t node_address = what % 8 == 0 ? std::uint8_t{0} : std::uint8_t{5};
        const auto n = static_cast<std::uint8_t>(1 + what / 8 % 4);
        reference::byte_list body{node_address, 6, 0x20, 0x88, 0x00, n};
        if (what % 8 >= 4) body[1] = 3;
        if (what % 8 == 3) {
            body[1] = 16;
            body.push_back(static_cast<std::uint8_t>(2 * n));
            body.resize(7 + 2u * n, 0x11);
        }
        return reference::framed(body);
    }
};

inline bool is_read(const reference::byte_list& request) { return request[1] == 3 || request[1] == 4; }
inline std::size_t response_size(const reference::byte_list& request) {
    return is_read(request) ? 5 + 2u * request[5] : 8u;
}
/// Whether every repeated field and every count of a response matches the request.
inline bool is_answer(const reference::byte_list& f, const reference::byte_list& request,
                      const servobus::response_limits& limits) {
    if (f.size() != response_size(request) || f[0] != request[0] || f[1] != request[1]) return false;
    if (is_read(request)) return f[2] == 2 * request[5];
    if (std::equal(f.begin(), f.begin() + 6, request.begin())) return true;
    return limits.echoes_byte_count && request[1] == 16 &&
           reference::word(f, 2) == reference::word(request, 2) && reference::word(f, 4) == request[6];
}

/// Judges one call after the other on one line. A line that `forgives_glitches` needs only one sufficient
/// gap after a failed exchange: the gap also counts if a stop follows, and bytes 00 or FF after it do not
/// invalidate it. On the other kind of line they restart the quarantine.
class call_judge {
  public:
    call_judge(wire& on, std::uint32_t t3_5, bool forgives_glitches)
        : on_{&on}, t3_5_{t3_5}, forgives_glitches_{forgives_glitches}, troubled_at_{on.port.time} {}

    /// Called before each call.
    void begin() {
        on_->port.forget();
        was_cut_ = on_->port.has_rest;
        time_ = on_->port.time;
        left_ = on_->in->size();
    }

    bool has_begun() const { return !on_->port.request.empty(); }

    void judge_time(servobus::duration bound) const {
        if (on_->clock != clock_kind::honest) return;
        require(on_->port.time - time_ <= bound.us + slack(), "G29 a call returns within its bound");
    }

    /// `after_trouble`: the gap that the line must keep after a failed exchange.
    void judge_silence(const call& c, servobus::duration after_trouble) {
        const bool is_stop = c.priority == servobus::priority::stop;
        const driven_port& port = on_->port;
        bool owes = is_troubled_;
        std::uint64_t since = troubled_at_;
        const auto is_served = [&](std::uint64_t at) { return at + look() >= since + after_trouble.us; };
        for (const driven_port::sound& s : port.before) {
            if (!s.is_glitch)
                owes = true;
            else if (forgives_glitches_ && is_served(s.at))
                owes = false;
            since = s.at;
        }
        if (has_begun() && on_->is_honest()) {
            const std::uint32_t between = std::max(t3_5_, c.wanted.gap.us);
            require(port.silence_before >= t3_5_, "G8 a request comes after a gap of t3.5");
            require(port.silence_before >= c.wanted.gap.us, "G8 a request comes after the node's own gap");
            if (owes && !is_stop) {
                require(is_served(port.begun_at), "G1 after a failed exchange the line keeps the quarantine");
                require(forgives_glitches_ || port.silence_before >= after_trouble.us,
                        "G1 the quarantine is directly before the request");
            }
            if (is_stop && port.before.empty() && !port.is_slow) {
                // The port first sends the rest of a partly sent request.
                const std::uint64_t from = was_cut_ ? std::max(time_, port.rest_left_at) : time_;
                require(port.begun_at - from <= between + slack(), "G25 a stop waits for no quarantine");
            }
        }
        if (has_begun()) {
            const bool was_served = forgives_glitches_ && is_served(port.begun_at);
            is_troubled_ = owes && is_stop && !was_served;
            troubled_at_ = port.active_at;
        } else {
            is_troubled_ = owes;
            troubled_at_ = since;
        }
    }

    /// The call was not completed. If none of its bytes was taken, no quarantine is needed.
    void note_unfinished() {
        if (!has_begun()) return;
        is_troubled_ = true;
        troubled_at_ = on_->port.time;
    }

    /// Checks how the call ended; `response` is what it returns.
    void judge_end(const servobus::status& how, const reference::byte_list& request, servobus::bytes response,
                   const servobus::response_limits& limits) {
        const driven_port& port = on_->port;
        const servobus::errc why = how.error();
        if (on_->clock == clock_kind::honest)
            require(why != servobus::errc::clock_stopped, "a clock that runs is not reported as stopped");
        if (why != servobus::errc::ok && why != servobus::errc::exception) {
            if (how.was_sent()) note_unfinished();
            if (!port.has_lied)
                require(how.was_sent() == has_begun(),
                        "G16 a request is reported sent exactly if it has begun to leave");
            return;
        }
        if (port.has_lied) return;
        require(how.was_sent(), "G16 the request of a successful call was sent");
        require(servobus::same_bytes(port.request, request),
                "the request of a successful call has left completely");
        require(port.left_at != 0, "a call succeeds after its request has left");
        if (request[0] == 0) return;
        const reference::byte_list f{response.begin(), response.end()};
        require(reference::is_frame(f) && f[0] == request[0],
                "G2 a response is a frame of the requested node");
        if (why == servobus::errc::exception)
            require(f.size() == 5 && f[1] == (request[1] | 0x80u) && f[2] == how.exception(),
                    "G12 an exception has the number that came");
        else
            require(is_answer(f, request, limits), "G2 a response matches its request");
        const auto is_same = [](const driven_port::arrival& a, std::uint8_t byte) { return a.byte == byte; };
        const auto found = std::search(port.heard.begin(), port.heard.end(), f.begin(), f.end(), is_same);
        require(found != port.heard.end(), "G1 a response came after its request had left");
    }

  private:
    // Each byte of the input at most prolongs a call or causes one more.
    std::uint64_t slack() const { return on_->tick * (200 + 8 * (left_ - on_->in->size())); }
    // A line last reads the clock a few calls of the port before its own call ends.
    std::uint64_t look() const { return on_->tick * 8; }

    wire* on_;
    std::uint32_t t3_5_;
    bool forgives_glitches_;
    bool is_troubled_ = true; // until a first quarantine was kept
    bool was_cut_ = false;    // the port may still be sending the request of the call before
    std::uint64_t troubled_at_;
    std::uint64_t time_ = 0; // at the beginning of the call
    std::size_t left_ = 0;   // input left at the beginning of the call
};

/// No other exchange uses the line any more and the port works, so the next call must succeed.
template <class Line> void judge_recovery(wire& on, Line& line, call_judge& judge) {
    on.port.calm_down();
    on.port.time += 60'000'000;
    const servobus::response_limits limits;
    const servobus::bus_gaps wanted;
    const reference::byte_list request = reference::framed({5, 3, 0x20, 0xAB, 0, 2});
    reference::byte_list response(9);
    typename Line::template exchange_for<servobus::response_limits> x{request, response, line.timing(),
                                                                      limits};
    judge.begin();
    const servobus::duration bound = line.bound(request.size(), response.size(), limits, wanted);
    servobus::status how;
    if constexpr (Line::is_small) {
        how = line.run(x, wanted);
    } else {
        line.run(x, wanted);
        require(x.done(), "a blocking call ends");
        how = x.status();
    }
    judge.judge_time(bound);
    if (on.clock == clock_kind::stopped) return;
    require(how.error() == servobus::errc::ok, "G9 on a line that works again a call succeeds");
    judge.judge_end(how, request, response, limits);
}

} // namespace fuzz
