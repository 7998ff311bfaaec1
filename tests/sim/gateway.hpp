// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A gateway between the client and its drives. Where a drive does not respond it sends exception 0Ah or 0Bh in the
// place of the drive (Modbus Application Protocol V1.1b3, section 7). It is a device on the wire that listens to both
// sides. A port says whether the client reaches it by Modbus TCP or by RTU frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include <servobus/sim/station.hpp>

#include "shaky_port.hpp"
#include "timed_sender.hpp"

namespace trial {

/// The port of a program whose line has no gateway, or one that RTU frames reach.
class plain_port {
  public:
    explicit plain_port(shaky_port& inner) : inner_{&inner} {}

    servobus::transfer send(servobus::bytes out) { return inner_->send(out); }
    bool sent() { return inner_->sent(); }
    servobus::transfer receive(servobus::byte_buffer in) { return inner_->receive(in); }
    servobus::instant now() { return inner_->now(); }
    void wait(servobus::duration longest) { inner_->wait(longest); }

  private:
    shaky_port* inner_;
};
/// The port of Modbus TCP, as `servobus::mbap_port` declares itself.
class gateway_port : public plain_port {
  public:
    static constexpr bool has_gateway = true;
    using plain_port::plain_port;
};

/// Tells a node that RTU frames reach it through a gateway.
template <class Limits> void put_behind_gateway(Limits& limits) {
    if constexpr (requires { limits.has_gateway; }) limits.has_gateway = true;
}

/// True if the error is that of a gateway's exception.
template <class Error> constexpr bool is_of_gateway(Error e) {
    if constexpr (requires { Error::gateway_exception; }) {
        return e == Error::gateway_exception;
    } else {
        return false;
    }
}

class gateway final : public servobus::sim::line_device {
  public:
    gateway(scene& on, std::uint32_t baud) : on_{&on}, sender_{on}, baud_{baud} {}

    /// From now on it responds in the place of a drive, `after` the last bit of a request without a response.
    void stand_in(servobus::duration after, std::uint64_t seed) {
        after_ = after;
        random_ = servobus::sim::dice{seed};
    }
    bool is_there() const { return after_.us != 0; }
    /// A request begins to leave.
    void asked(servobus::bytes frame) {
        node_ = frame[0];
        function_ = frame[1];
        left_ = frame.size();
        is_waiting_ = is_there() && node_ != 0;
    }
    /// Exceptions that it has sent.
    std::uint64_t sent() const { return sent_; }
    /// The number of the request to which it has responded last.
    std::uint64_t asked_by() const { return asked_by_; }
    /// Called when it sends an exception.
    std::function<void()> on_exception;

    void receive(std::uint8_t, bool, servobus::instant) override {
        if (left_ == 0) {
            is_waiting_ = false; // the drive responds
        } else if (--left_ == 0) {
            due_us_ = on_->now() + after_.us;
        }
    }
    servobus::duration run(servobus::instant) override {
        if (!is_waiting_ || left_ != 0) return sender_.until_due();
        if (on_->now() < due_us_) return servobus::duration{static_cast<std::uint32_t>(due_us_ - on_->now())};
        is_waiting_ = false;
        ++sent_;
        asked_by_ = on_->transaction;
        if (on_exception) on_exception();
        const std::uint8_t number = random_.below(2) == 0 ? 0x0A : 0x0B;
        const byte_list response = closed({node_, static_cast<std::uint8_t>(function_ | 0x80u), number});
        on_->log->remark(on_->now(), "the gateway responds in the place of the drive");
        (void)sender_.send_at(on_->now(), response);
        return servobus::microseconds(1);
    }
    servobus::bytes send(servobus::instant) override { return sender_.due(); }
    std::uint32_t baud() const override { return baud_; }

  private:
    scene* on_;
    timed_sender sender_;
    servobus::sim::dice random_{1};
    servobus::duration after_{};
    std::uint64_t due_us_ = 0;
    std::uint64_t sent_ = 0;
    std::uint64_t asked_by_ = 0;
    std::size_t left_ = 0; ///< bytes of the request that have not arrived yet
    std::uint32_t baud_;
    std::uint8_t node_ = 0;
    std::uint8_t function_ = 0;
    bool is_waiting_ = false;
};

} // namespace trial
