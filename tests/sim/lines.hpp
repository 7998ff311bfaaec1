// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lines that clients speak over in a run, each watched by the judge: with and without echo handling, and
// the small one, which has no observer and is watched from outside.
#pragma once

#include <cstdint>

#include <servobus/line/blocking_line.hpp>
#include <servobus/line/line.hpp>

#include "judge.hpp"
#include "shaky_port.hpp"

namespace trial {

template <class Echo> using line_on = servobus::line<shaky_port, watch, Echo>;

template <std::uint32_t Baud, servobus::modbus::timing_mode Mode>
class small_line_on
    : public servobus::blocking_line<shaky_port,
                                  servobus::modbus::timing_at(Baud, Mode, servobus::milliseconds(20)),
                                  servobus::milliseconds(200)> {
    using base = typename small_line_on::blocking_line;

  public:
    static constexpr std::uint32_t baud = Baud;

    small_line_on(shaky_port& port, const servobus::modbus::rtu_timing&, const watch& who)
        : base{port}, watch_{who} {}

    /// As the line's own, and keeps where its reply will be.
    template <class Patience, bool IsBroadcast = false> class exchange_for {
      public:
        static exchange_for trusted(servobus::bytes request, servobus::byte_buffer reply,
                                    const Patience& limits, bool is_single) {
            return {base_exchange::trusted(request, reply, limits, is_single), reply};
        }

      private:
        friend class small_line_on;
        using base_exchange = typename base::template exchange_for<Patience, IsBroadcast>;

        exchange_for(const base_exchange& x, servobus::byte_buffer reply) : own_{x}, reply_{reply} {}

        base_exchange own_;
        servobus::byte_buffer reply_;
    };

    template <class Patience, bool IsBroadcast>
    servobus::written run(const exchange_for<Patience, IsBroadcast>& x, const servobus::bus_gaps& wanted) {
        const servobus::written w = base::run(x.own_, wanted);
        servobus::bytes reply = x.reply_;
        if (IsBroadcast) reply = {};
        if (w.error() == servobus::errc::exception) reply = reply.first(5);
        watch_.on_reply(reply, w.why());
        return w;
    }

  private:
    watch watch_;
};

using small_host_line = small_line_on<38400, servobus::modbus::timing_mode::host>;
using small_strict_line = small_line_on<115200, servobus::modbus::timing_mode::strict>;

} // namespace trial
