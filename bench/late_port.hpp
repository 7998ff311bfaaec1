// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Ports on a simulated line for a program that is woken late, as under an operating system: one that sleeps until its
// wait ends, and one that wakes early by as much and polls, as `posix::serial` with `wakes_early`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/posix/detail/early_wake_up.hpp>
#include <servobus/sim/line.hpp>

namespace bench {

/// How late wake-ups are: anything between the two is as likely, and one of `outlier_in` is an outlier.
struct lateness {
    servobus::duration least;
    servobus::duration most;
    std::uint32_t outlier_in = 0; ///< 0: there are none
    servobus::duration outlier{};
};

class dice {
  public:
    /// 0 .. n - 1, by Marsaglia's xorshift.
    std::uint32_t roll(std::uint32_t n) {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 17;
        state_ ^= state_ << 5;
        return state_ % n;
    }

  private:
    std::uint32_t state_ = 2'463'534'242u;
};

/// A port whose `wait` ends late, whether a byte or the time limit ends it.
class late_port {
  public:
    late_port(servobus::sim::virtual_line& wire, const lateness& late, servobus::duration /*character*/ = {})
        : wire_{&wire}, late_{late} {}

    servobus::transfer send(servobus::bytes out) { return wire_->send(out); }
    bool sent() { return wire_->sent(); }
    servobus::transfer receive(servobus::byte_buffer in) { return wire_->receive(in); }
    servobus::instant now() { return wire_->now(); }
    void wait(servobus::duration longest) {
        const std::uint64_t before = wire_->time_us();
        wire_->wait(longest);
        if (wire_->time_us() != before) wire_->pass(late()); // only if it slept
    }
    std::uint64_t polled_us() const { return 0; }

  private:
    servobus::duration late() {
        if (late_.outlier_in != 0 && dice_.roll(late_.outlier_in) == 0) return late_.outlier;
        return late_.least + servobus::duration{dice_.roll(late_.most.us - late_.least.us + 1)};
    }

    servobus::sim::virtual_line* wire_;
    lateness late_;
    dice dice_{};
};
static_assert(servobus::waiting_port<late_port>);

/// The same, but it wakes early. It counts the time that it polls.
class early_port {
  public:
    early_port(servobus::sim::virtual_line& wire, const lateness& late, servobus::duration character)
        : wire_{&wire}, sleeping_{wire, late}, character_{character} {}

    servobus::transfer send(servobus::bytes out) {
        is_sending_ = true;
        return wire_->send(out);
    }
    bool sent() {
        const bool has_left = wire_->sent();
        is_sending_ = is_sending_ && !has_left;
        return has_left;
    }
    servobus::transfer receive(servobus::byte_buffer in) {
        std::uint16_t size = 0;
        for (; size < in.size() && first_ < count_; ++size) in[size] = held_[first_++];
        if (size == 0) {
            const servobus::transfer came = wire_->receive(in);
            if (!came) return came;
            size = *came;
        }
        if (size != 0) missing_ = 0;
        return size;
    }
    servobus::instant now() { return wire_->now(); }
    void wait(servobus::duration longest) {
        const servobus::duration due = character_ * std::exchange(missing_, std::uint16_t{0});
        if (is_sending_) return sleeping_.wait(longest);
        const std::uint64_t before = wire_->time_us();
        slept_us_ = 0;
        (void)early_.wait(kernel{this}, longest, due);
        polled_us_ += wire_->time_us() - before - slept_us_;
    }
    void expect(std::uint16_t missing) { missing_ = missing; }
    std::uint64_t polled_us() const { return polled_us_; }

  private:
    struct kernel {
        early_port* of;
        servobus::instant now() const { return of->wire_->now(); }
        int wait(servobus::duration d) const { return of->has_byte(d) ? 1 : 0; }
    };

    // Waits for a byte, as the system's poll does.
    bool has_byte(servobus::duration longest) {
        if (has_fetched() || longest == servobus::duration{}) return first_ < count_;
        const std::uint64_t before = wire_->time_us();
        sleeping_.wait(longest);
        slept_us_ += wire_->time_us() - before;
        return has_fetched();
    }
    bool has_fetched() {
        if (first_ == count_) {
            first_ = 0;
            count_ = wire_->receive(held_).value_or(0);
        }
        return first_ < count_;
    }

    servobus::sim::virtual_line* wire_;
    late_port sleeping_;
    servobus::duration character_;
    servobus::posix::detail::early_wake_up early_{};
    std::uint8_t held_[64]{};
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    std::uint64_t slept_us_ = 0;
    std::uint64_t polled_us_ = 0;
    std::uint16_t missing_ = 0; // bytes of the response, for the next wait
    bool is_sending_ = false;
};
static_assert(servobus::expecting_port<early_port>);

} // namespace bench
