// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An operation in a superloop that calls `line.step`. Some loops are slow, some operations are given up
// before their end, some meet a second exchange, some are stops that wait for no quarantine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "clients.hpp"
#include "verdict.hpp"

namespace trial {

template <class Line> class stepping {
  public:
    bool gave_up() const { return gave_up_; }
    /// The time that the loop spent on other work.
    std::uint64_t added_us() const { return added_us_; }
    void forget() {
        gave_up_ = false;
        added_us_ = 0;
    }

    claim carry_out(clients<Line>& in, participant& at, const intent& meant, bool is_single) {
        scene& on = in.state();
        // Only single-word writes, whose response repeats the value: the response to a stop must differ
        // from that to an earlier write.
        const bool is_stop = meant.is_write() && is_single && on.one_in(6);
        in.court().set_quiet(at.gaps(), is_stop);
        on.cuts_quarantine = is_stop && in.court().is_troubled();
        if (on.cuts_quarantine) on.is_struck = true;
        const bool is_slow = !in.is_strict() && on.one_in(2);
        const std::uint64_t gives_up =
            on.one_in(8) ? on.now() + on.between(0, 2 * at.limits().response.us) : ~std::uint64_t{0};
        if (gives_up != ~std::uint64_t{0}) on.may_end_early = true;

        const std::size_t size = put(at, meant, is_single);
        servobus::modbus::exchange x{servobus::bytes{request_}.first(size), response_, in.line().timing(),
                                     at.limits(),
                                     is_stop ? servobus::priority::stop : servobus::priority::ordinary};
        const std::uint64_t stalled_us = on.stalled_us;
        auto guard = in.line().new_stall_detector();
        while (!x.done()) {
            const servobus::duration idle = in.line().step(x, at.gaps());
            if (x.done()) break;
            if (on.one_in(50)) intrude(in, at, stalled_us);
            if (on.now() >= gives_up || guard.has_failed(in.line().now())) {
                in.line().abandon(x);
                in.port().forget_request();
                on.is_struck = gave_up_ = true;
                break;
            }
            if (idle != servobus::duration{}) in.line().sleep(idle);
            if (is_slow && !in.line().is_sending()) {
                const std::uint32_t turn = on.random.below(world::longest_turn_us);
                added_us_ += turn;
                in.rest(turn);
            }
        }
        servobus::status why = x.status();
        // A program that steps an exchange must check this, as the library's own callers do: the response to
        // function 06 may be the echo.
        const bool may_be_echo = meant.is_write() && is_single && !in.line().is_echo_ruled_out(at.address());
        if (why.error() == servobus::errc::ok && may_be_echo) why.end(servobus::errc::own_echo);
        claim c{why};
        for (std::size_t i = 0; i < x.words().size(); ++i) c.words.push_back(x.words()[i]);
        return c;
    }

  private:
    std::size_t put(participant& at, const intent& meant, bool is_single) {
        request_[0] = at.address();
        const servobus::byte_buffer pdu = servobus::byte_buffer{request_}.subspan(1);
        std::size_t size = 0;
        if (!meant.is_write()) {
            size = servobus::modbus::put_read_request(pdu, servobus::modbus::function::read_holding_registers,
                                                      meant.address, static_cast<std::uint16_t>(meant.count));
        } else if (is_single) {
            size = servobus::modbus::put_write_request(pdu, meant.address, meant.words[0]);
        } else {
            size = servobus::modbus::put_write_request(pdu, meant.address,
                                                       std::span<const std::uint16_t>{meant.words});
        }
        return servobus::modbus::close_frame(request_, size);
    }

    // Steps another exchange while the line is taken, and gives it up before the line is free.
    // `stalled_us`: the total time of stalls before the first exchange began.
    static void intrude(clients<Line>& in, participant& at, std::uint64_t stalled_us) {
        std::array<std::uint8_t, 16> room{};
        const auto request = servobus::modbus::read_frame(at.address(), 0, 1);
        servobus::modbus::exchange other{request, room, in.line().timing(), at.limits()};
        const std::uint64_t before = in.state().transaction;
        (void)in.line().step(other, at.gaps());
        in.state().has_intruded = other.was_sent();
        in.state().may_end_early = in.state().may_end_early || other.was_sent();
        in.line().abandon(other);
        // After a stall the second exchange may take the line from the first, which is never sent again
        // (G33).
        if (in.state().stalled_us != stalled_us) return;
        if (other.was_sent() || in.state().transaction != before)
            throw broken{"G1: a second exchange was begun on a line that already carries one"};
    }

    std::array<std::uint8_t, servobus::modbus::max_frame> request_{};
    std::array<std::uint8_t, servobus::modbus::max_frame> response_{};
    std::uint64_t added_us_ = 0;
    bool gave_up_ = false;
};

} // namespace trial
