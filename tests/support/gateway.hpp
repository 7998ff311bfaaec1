// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A gateway between a line and a simulated wire. Where the wire has no response it responds in the node's place, with
// exception 0Ah or 0Bh (Modbus Application Protocol V1.1b3, 7), or with nothing, as an RTU line does.
#pragma once

#include <cstdint>

#include <servobus/line/port.hpp>
#include <servobus/sim/line.hpp>

#include "scripted_port.hpp"

namespace tests {

/// `IsModbusTcp`: the port declares that it speaks Modbus TCP; else only a node can say that it has a gateway.
template <bool IsModbusTcp> class gateway {
  public:
    static constexpr bool has_gateway = IsModbusTcp;

    explicit gateway(servobus::sim::virtual_line& wire) : wire_{&wire} {}

    std::uint8_t number = 0x0B;  ///< of its exceptions; 0: it sends none
    bool is_cut = false;         ///< nothing reaches the wire
    bool loses_response = false; ///< of the next request, which reaches its node
    unsigned exceptions = 0;     ///< that it sent

    servobus::transfer send(servobus::bytes frame) {
        address_ = frame[0];
        code_ = frame[1];
        asked_ = wire_->now();
        given_ = response_.size();
        is_pending_ = is_cut || loses_response;
        loses_response = false;
        if (is_cut) return static_cast<std::uint16_t>(frame.size());
        return wire_->send(frame);
    }
    bool sent() { return wire_->sent(); }
    servobus::transfer receive(servobus::byte_buffer in) {
        if (is_pending_) {
            std::uint8_t dropped[256];
            if (const servobus::transfer t = wire_->receive(dropped); !t) return t;
            if (number == 0 || since(asked_, wire_->now()) < servobus::milliseconds(15))
                return std::uint16_t{0};
            response_ = exception_response(address_, code_, number);
            given_ = 0;
            is_pending_ = false;
            ++exceptions;
        }
        std::uint16_t n = 0;
        while (given_ < response_.size() && n < in.size()) in[n++] = response_[given_++];
        return n != 0 ? servobus::transfer{n} : wire_->receive(in);
    }
    servobus::instant now() { return wire_->now(); }
    void wait(servobus::duration d) { wire_->wait(d); }

  private:
    servobus::sim::virtual_line* wire_;
    byte_list response_{};
    std::size_t given_ = 0;
    servobus::instant asked_{};
    std::uint8_t address_ = 0;
    std::uint8_t code_ = 0;
    bool is_pending_ = false;
};

using modbus_tcp_gateway = gateway<true>;
using rtu_gateway = gateway<false>;

} // namespace tests
