// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The requests of a program beside its bus: to the node that the plan has for them, in time or backed off, and now and
// then one that the plan does not have, which must not be sent (G25, G28).
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include <servobus/modbus/exchange.hpp>

#include "fleet.hpp"

namespace trial {

class own_request {
  public:
    own_request(facade_world& in, fleet& of) : in_{in}, bus_{of}, to_{of.requested().front()} {}

    /// Called once in each iteration of the program's loop.
    servobus::duration step() {
        if (!exchange_ && !begin()) return servobus::milliseconds(2);
        const servobus::duration idle = in_.line().step(*exchange_, gaps_);
        if (exchange_->done()) end();
        look();
        return idle;
    }
    /// A request begins to leave.
    void begins(servobus::bytes frame) {
        if (frame[0] == stranger || (is_too_long_ && frame[0] == to_.address))
            throw broken{"G25: a request was sent that the plan of the bus does not have"};
        if (frame[0] != to_.address) return;
        is_back_ = false;
        if (!participant_of_node().device().is_off()) return tried_.clear();
        tried_.push_back(now());
        ++in_.state().count->gone_asked;
        // After three in a row each window has one, and two windows may touch.
        if (in_.is_faultless() && tried_.size() > 5 && now() - tried_[tried_.size() - 3] < 1'000'000)
            throw broken{"G28: a node of the program's own requests that is gone is asked too often"};
    }
    void went_off() { is_back_ = false; }
    void came_back() {
        is_back_ = true;
        back_at_ = now();
        tried_.clear();
    }
    std::uint8_t address() const { return to_.address; }

  private:
    static constexpr std::uint8_t stranger = 99;

    std::uint64_t now() const { return in_.state().now(); }
    participant& participant_of_node() const {
        for (const auto& s : in_.participants()) {
            if (s->address() == to_.address) return *s;
        }
        throw broken{"a plan has requests to a node that is not on the line"};
    }
    bool begin() {
        if (now() < next_) return false;
        scene& on = in_.state();
        next_ = now() + to_.period.us;
        gaps_ = to_.gaps;
        limits_ = to_.limits;
        std::uint8_t address = to_.address;
        std::uint16_t words = to_.words;
        is_too_long_ = false;
        is_refused_ = on.one_in(12);
        if (is_refused_ && on.one_in(2)) {
            address = stranger;
        } else if (is_refused_) {
            is_too_long_ = true;
            limits_.response = limits_.response + servobus::milliseconds(on.between(5, 500));
        }
        const auto request = servobus::modbus::read_frame(address, 0x0010, words);
        for (std::size_t i = 0; i < request.size; ++i) request_[i] = request.data[i];
        exchange_.emplace(servobus::bytes{request_}, response_, in_.line().timing(), limits_);
        return true;
    }
    void end() {
        const servobus::status s = exchange_->status();
        const bool was_refused = s.error() == servobus::errc::not_in_plan;
        if (was_refused != is_refused_ && s.was_sent() == is_refused_)
            throw broken{std::string{"G25: a request beside the bus ended with: "} +
                         servobus::text(s.error())};
        if (was_refused) ++in_.state().count->not_in_plan;
        if (s) ++in_.state().count->beside_the_bus;
        exchange_.reset();
        is_too_long_ = false;
    }
    void look() const {
        if (is_back_ && in_.is_faultless() && now() - back_at_ > bus_.found_within_us(1) + to_.period.us)
            throw broken{"G28: a node of the program's own requests is back and has not been asked"};
    }

    facade_world& in_;
    fleet& bus_;
    servobus::requested_node to_;
    std::optional<servobus::modbus::exchange> exchange_{};
    std::array<std::uint8_t, 8> request_{};
    std::array<std::uint8_t, 64> response_{};
    servobus::bus_gaps gaps_{};
    servobus::response_limits limits_{};
    std::deque<std::uint64_t> tried_{}; // while the node is off
    std::uint64_t next_ = 0;
    std::uint64_t back_at_ = 0;
    bool is_back_ = false;
    bool is_refused_ = false;
    bool is_too_long_ = false;
};

} // namespace trial
