// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Checks the client's end of the wire: the gap before each request (G1, G8), the bytes of each response
// (G2), and how many requests an operation sends. The echo of a request is checked in echo_judge.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include <servobus/line/line.hpp>

#include "echo_judge.hpp"
#include "scene.hpp"
#include "timed_sender.hpp"

namespace trial {

/// CRC-16/MODBUS bit by bit, independent of the library's.
inline std::uint16_t plain_crc(servobus::bytes of) {
    unsigned crc = 0xFFFF;
    for (const std::uint8_t b : of) {
        crc ^= b;
        for (int i = 0; i < 8; ++i) crc = (crc & 1u) != 0 ? crc >> 1 ^ 0xA001u : crc >> 1;
    }
    return static_cast<std::uint16_t>(crc);
}

class judge {
  public:
    explicit judge(scene& on) : on_{&on}, echo_{on} {}

    /// `slack_us`: the resolution of the client's clock.
    void set_slack(std::uint32_t slack_us) { slack_us_ = slack_us; }
    /// The line is configured for a local echo.
    void expect_echoes() { echo_.expect(); }
    /// This line ignores any number of bytes 00 or FF between two transactions: they cannot be part of a late
    /// response.
    void bear_glitches() {
        bears_glitches_ = true;
        surplus_.most = ~0u;
    }
    /// Receives each request that has got a valid response.
    std::function<void(servobus::bytes)> on_response;

    /// The operation in progress needs these gaps.
    void set_quiet(const servobus::bus_gaps& wanted, bool is_stop = false) {
        wanted_ = wanted;
        is_stop_ = is_stop;
    }

    /// A request that begins now has to wait: the quarantine is not over.
    bool must_wait() const { return is_troubled() && !has_waited(on_->now()); }

    void begin_operation() {
        writes_ = reads_ = exchanges_ = 0;
        had_echo_like_read_ = false;
        were_suspects_ = suspects_;
        was_echo_ruled_out_ = is_echo_ruled_out_;
        has_differed_ = false;
        returned_before_ = on_->wire->returned();
    }
    unsigned writes() const { return writes_; }       ///< requests that left in the operation
    unsigned reads() const { return reads_; }         ///< requests of other functions
    unsigned exchanges() const { return exchanges_; } ///< exchanges that ended
    /// A read of the operation had a response that its echo can be.
    bool had_echo_like_read() const { return had_echo_like_read_; }

    // From the port

    void begins(std::uint64_t at, servobus::bytes frame) {
        ++on_->transaction;
        ++on_->count->transactions;
        (servobus::modbus::is_write(frame[1]) ? writes_ : reads_) += 1;
        check_silence(at);
        request_.assign(frame.begin(), frame.end());
        on_->must_fail = on_->has_long_pause = false;
        on_->borne = "G9";
        // A second response may still be arriving or begin soon: it may begin until this request has left.
        on_->is_spoiled = on_->sounding_until > at;
        if (on_->is_spoiled) on_->is_struck = true;
        on_->asked_node = frame[0];
        on_->count->switches.note(on_->kinds[frame[0]], on_->positions[frame[0]]);
        collisions_ = on_->wire->collisions();
        // A late response begins within the quarantine: a stop that began after it has waited like any other. By a
        // clock that is wrong each of them may have waited.
        if (!is_stop_ || has_waited(at) || on_->does_clock_lie) is_troubled_ = false;
        has_begun_ = on_->is_awaited = true;
        echo_.begins(at, frame);
        surplus_.forget();
        heard_.clear();
    }
    void left() { heard_.clear(); }
    void heard(servobus::bytes what) {
        looked_us_ = on_->now();
        if (has_begun_) {
            what = echo_.take(what);
            heard_.insert(heard_.end(), what.begin(), what.end());
        } else {
            for (const std::uint8_t b : what) surplus_.add(b);
        }
    }
    /// A byte reaches the client's end of the wire.
    void arrives(std::uint64_t at, std::uint8_t byte) {
        const bool is_part_of_response = !bears_glitches_ || (byte != 0x00 && byte != 0xFF);
        arrivals_[next_arrival_++ % arrivals_.size()] = at;
        if (is_part_of_response) meant_[next_meant_++ % meant_.size()] = at;
    }
    /// A response came that cannot be an echo, since its request does not begin so. Before that a response to
    /// function 06 proves nothing (G3), nor does a read's whose value and CRC are the request's bytes.
    bool is_echo_ruled_out(std::uint8_t node_address) const {
        return is_echo_ruled_out_ && !suspects_[node_address % suspects_.size()];
    }
    /// The line has one flag for all nodes.
    void suspect_all_as_one() { suspects_are_one_ = true; }
    /// True if a response that repeats its request could be an echo as the operation began: no response so far could
    /// not, or a request to this node got no valid response, and since then none that differs from its request.
    bool could_be_echo(std::uint8_t node_address) const {
        return !was_echo_ruled_out_ || were_suspects_[node_address % suspects_.size()];
    }
    /// A response of the operation differed from its request: the adapter did not return that one.
    bool has_differed() const { return has_differed_; }
    /// The adapter has returned a request of the operation.
    bool was_returned() const { return on_->wire->returned() != returned_before_; }
    /// The last transaction did not end in exactly one valid response, or unexpected bytes came after it.
    bool is_troubled() const { return is_troubled_ || surplus_.is_trouble(); }
    /// The port was lost, and with it the bytes that it had received.
    void forget_arrivals() { arrivals_ = meant_ = {}; }
    /// The client's clock was wrong, and the line has been at rest since.
    void pardon() { is_troubled_ = false; }

    // From the line

    void concluded(servobus::bytes response, servobus::status why) {
        ++exchanges_;
        on_->is_awaited = false;
        if (why.error() == servobus::errc::port_lost) is_echo_ruled_out_ = false;
        if (!has_begun_) return;
        has_begun_ = false;
        echo_.concluded(why.error(), slack_us_);
        if (!why.has_response()) {
            is_troubled_ = true;
            ended_ = on_->clock_read_us; // a stall after that counts as quarantine
            heard_.clear();
            suspect(request_[0], true);
            return;
        }
        const bool is_echo_like = response.size() <= request_.size() &&
                                  std::equal(response.begin(), response.end(), request_.begin());
        if (!is_echo_like)
            rule_out_echo();
        else if (!response.empty() && !servobus::modbus::is_write(response[1]))
            had_echo_like_read_ = true;
        auto found = std::search(heard_.begin(), heard_.end(), response.begin(), response.end());
        // If noise came before it, the first of two responses may be lost in the noise.
        if (std::any_of(heard_.begin(), found, [](std::uint8_t b) { return b != 0x00 && b != 0xFF; }))
            found = std::find_end(heard_.begin(), heard_.end(), response.begin(), response.end());
        if (found == heard_.end() && !response.empty())
            throw broken{
                "G2: an accepted response contains bytes that did not arrive after the request had left"};
        if (!response.empty() && plain_crc(response) != 0)
            throw broken{"G2: a response with a wrong CRC was accepted"};
        for (auto i = response.empty() ? heard_.begin()
                                       : found + static_cast<std::ptrdiff_t>(response.size());
             i != heard_.end(); ++i)
            surplus_.add(*i);
        heard_.clear();
        if (!response.empty() && on_->must_fail)
            by_chance_or(
                "G2: a response was accepted that is not a complete, valid response to the request (or, in "
                "strict timing, G7: has a gap inside)");
        if (why.error() == servobus::errc::ok && on_response) on_response(request_);
    }

    /// Bytes changed on the way match a CRC once in 65536 times. Then the promise cannot be judged.
    void by_chance_or(const std::string& promise) {
        if (!on_->is_spoiled && collisions_ == on_->wire->collisions()) throw broken{promise};
        ++on_->count->crc_chances;
        on_->log->remark(on_->now(), "damaged bytes match their CRC by chance");
        on_->is_struck = true;
    }

  private:
    // Bytes received outside a transaction. A few bytes 00 or FF come from the switching of an RS-485 driver.
    struct outside {
        unsigned most = 4;
        unsigned count = 0;
        bool is_rubbish = false;
        void forget() {
            count = 0;
            is_rubbish = false;
        }
        void add(std::uint8_t b) {
            ++count;
            is_rubbish = is_rubbish || (b != 0x00 && b != 0xFF);
        }
        bool is_trouble() const { return is_rubbish || count > most; }
    };
    void check_silence(std::uint64_t at) {
        if (on_->does_clock_lie) return;
        const std::uint64_t last = last_of(arrivals_);
        const std::uint64_t needed = std::max(std::uint32_t{on_->timing.t3_5}, wanted_.gap.us);
        if (at + slack_us_ < last + needed)
            throw broken{"G8: only " + std::to_string(at - last) + " us of gap before a request, needed " +
                         std::to_string(needed)};
        if (!is_troubled() || is_stop_ || has_waited(at)) return;
        throw broken{"G1: only " + std::to_string(at - trouble_ended()) +
                     " us of gap before a request after a failed exchange, needed " +
                     std::to_string(quarantine())};
    }
    // The gap before a request at `at` includes the quarantine.
    bool has_waited(std::uint64_t at) const { return at + slack_us_ >= trouble_ended() + quarantine(); }
    std::uint64_t quarantine() const {
        const std::uint64_t between = std::max(std::uint32_t{on_->timing.t3_5}, wanted_.gap.us);
        return std::max(
            {between, std::uint64_t{wanted_.quarantine.us}, std::uint64_t{on_->timing.visible_gap().us}});
    }
    std::uint64_t trouble_ended() const {
        const std::uint64_t last = last_of(meant_);
        return is_troubled_ ? std::max(last, ended_) : last;
    }

    // The program cannot know of bytes that arrive after its last call of `receive`.
    std::uint64_t last_of(const std::array<std::uint64_t, 16>& arrivals) const {
        std::uint64_t last = on_->left_us;
        for (const std::uint64_t a : arrivals) {
            if (a <= looked_us_) last = std::max(last, a);
        }
        return last;
    }

    // Nodes of which eight are apart share a flag of a line, so that one may speak for another.
    void suspect(std::uint8_t node_address, bool is_suspect) {
        if (node_address == servobus::modbus::broadcast) return;
        if (suspects_are_one_)
            suspects_.fill(is_suspect);
        else
            suspects_[node_address % suspects_.size()] = is_suspect;
    }

    void rule_out_echo() {
        has_differed_ = true;
        is_echo_ruled_out_ = true;
        suspect(request_[0], false);
    }

    scene* on_;
    echo_judge echo_;
    servobus::bus_gaps wanted_{};
    bool is_stop_ = false;
    byte_list request_; ///< the last one
    byte_list heard_;
    outside surplus_;
    std::array<std::uint64_t, 16> arrivals_{};
    std::array<std::uint64_t, 16> meant_{}; ///< arrivals of bytes that may be part of a late response
    std::size_t next_arrival_ = 0;
    std::size_t next_meant_ = 0;
    std::uint64_t ended_ = 0;
    std::uint64_t looked_us_ = 0; ///< when the program last called `receive`
    std::uint32_t slack_us_ = 0;
    std::uint32_t collisions_ = 0;
    unsigned writes_ = 0;
    unsigned reads_ = 0;
    unsigned exchanges_ = 0;
    bool is_troubled_ = true;
    bool bears_glitches_ = false;
    bool has_begun_ = false;
    bool is_echo_ruled_out_ = false;
    bool was_echo_ruled_out_ = false;
    bool has_differed_ = false;
    bool suspects_are_one_ = false;
    std::array<bool, 8> suspects_{};
    std::array<bool, 8> were_suspects_{};
    std::uint32_t returned_before_ = 0;
    bool had_echo_like_read_ = false;
};

/// The observer of a line, which notifies the judge.
struct watch {
    judge* who = nullptr;

    void on_request(servobus::bytes) {}
    void on_unexpected(servobus::bytes) {}
    void on_response(servobus::bytes response, servobus::status why) { who->concluded(response, why); }
};

} // namespace trial
