// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lines that clients use in a run, each watched by the judge: `scheduled_line` with and without echo handling, and
// `blocking_line`, which has no observer and is watched by a wrapper.
#pragma once

#include <cstdint>

#include <servobus/bus/scheduled_line.hpp>
#include <servobus/line/blocking_line.hpp>

#include "judge.hpp"
#include "shaky_port.hpp"

namespace trial {

template <class Echo> using line_on = servobus::scheduled_line<shaky_port, watch, Echo>;

template <std::uint32_t Baud, servobus::modbus::timing_mode Mode>
class blocking_line_on
    : public servobus::blocking_line<shaky_port,
                                     servobus::modbus::timing_at(Baud, Mode, servobus::milliseconds(20)),
                                     servobus::milliseconds(200)> {
    using base = typename blocking_line_on::blocking_line;

  public:
    static constexpr std::uint32_t baud = Baud;

    blocking_line_on(shaky_port& port, const servobus::modbus::rtu_timing&, const watch& who)
        : base{port}, watch_{who} {}

    /// The line's own exchange, together with the buffer for its response.
    template <class Limits, bool IsBroadcast = false, bool IsAnyFunction = false,
              class Priority = servobus::priority>
    class exchange_for {
      public:
        static exchange_for trusted(servobus::bytes request, servobus::byte_buffer response,
                                    const Limits& limits, bool is_single, Priority of) {
            return {base_exchange::trusted(request, response, limits, is_single, of), response};
        }

      private:
        friend class blocking_line_on;
        using base_exchange =
            typename base::template exchange_for<Limits, IsBroadcast, IsAnyFunction, Priority>;

        exchange_for(const base_exchange& x, servobus::byte_buffer response) : own_{x}, response_{response} {}

        base_exchange own_;
        servobus::byte_buffer response_;
    };

    template <class Limits, bool IsBroadcast, bool IsAnyFunction, class Priority>
    servobus::status run(const exchange_for<Limits, IsBroadcast, IsAnyFunction, Priority>& x,
                         const servobus::bus_gaps& wanted) {
        const servobus::status w = base::run(x.own_, wanted);
        servobus::bytes response = x.response_;
        if (IsBroadcast) response = {};
        if (!w && w.has_response()) response = response.first(5);
        watch_.on_response(response, w);
        return w;
    }

  private:
    watch watch_;
};

using blocking_host_line = blocking_line_on<38400, servobus::modbus::timing_mode::host>;
using blocking_strict_line = blocking_line_on<115200, servobus::modbus::timing_mode::strict>;

} // namespace trial
