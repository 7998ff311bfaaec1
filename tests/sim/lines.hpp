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

    /// As the line's own, and keeps where its response will be.
    template <class Patience, bool IsBroadcast = false> class exchange_for {
      public:
        static exchange_for trusted(servobus::bytes request, servobus::byte_buffer response,
                                    const Patience& limits, bool is_single) {
            return {base_exchange::trusted(request, response, limits, is_single), response};
        }

      private:
        friend class small_line_on;
        using base_exchange = typename base::template exchange_for<Patience, IsBroadcast>;

        exchange_for(const base_exchange& x, servobus::byte_buffer response) : own_{x}, response_{response} {}

        base_exchange own_;
        servobus::byte_buffer response_;
    };

    template <class Patience, bool IsBroadcast>
    servobus::written run(const exchange_for<Patience, IsBroadcast>& x, const servobus::bus_gaps& wanted) {
        const servobus::written w = base::run(x.own_, wanted);
        servobus::bytes response = x.response_;
        if (IsBroadcast) response = {};
        if (w.error() == servobus::errc::exception) response = response.first(5);
        watch_.on_response(response, w.why());
        return w;
    }

  private:
    watch watch_;
};

using small_host_line = small_line_on<38400, servobus::modbus::timing_mode::host>;
using small_strict_line = small_line_on<115200, servobus::modbus::timing_mode::strict>;

} // namespace trial
