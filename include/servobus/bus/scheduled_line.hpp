// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line of a bus, which decides whether and when the requests of others are sent. Programs with a bus make it in
// place of a `line`, and it has the same calls. Until a bus begins it is a line as any other.
//
//     scheduled_line wire{serial, plan.timing()};
//     zlac8015d::drive wheels{wire, wheels_node, by_plan}; // the bus gives it what the plan says
//     auto all = make_bus<plan>(wire, wheels);
#pragma once

#include <cstdint>

#include <servobus/bus/detail/other_requests.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

namespace detail {
template <const auto& Plan, class Line>
constexpr duration step_beside(Line& on, typename Line::exchange& x, const bus_gaps& wanted);
template <class> inline constexpr bool is_scheduled = false;
} // namespace detail

/// As `line`, which it hides: nothing converts to it, so that no request that is stepped passes by the bus.
template <port Port, observer Observer = counters, class Echo = unechoed,
          class Lengths = modbus::fixed_lengths>
class scheduled_line : line<Port, Observer, Echo, Lengths> {
    using base = line<Port, Observer, Echo, Lengths>;

  public:
    using base::is_small, base::longest_frame;
    using typename base::crc, typename base::exchange, typename base::lengths, typename base::port_type;
    template <class Source, bool A = false, bool B = false, class P = priority>
    using exchange_for = typename base::template exchange_for<Source, A, B, P>;

    constexpr scheduled_line(Port& on, modbus::rtu_timing at, Observer watch = {}, Echo heard = {})
        : base{on, at, watch, heard} {}

    using base::bound;
    using base::epoch, base::begin_epoch, base::note_change, base::changed_node, base::run, base::sleep;
    using base::new_stall_detector, base::announce_stop, base::is_free, base::retime, base::is_sending,
        base::abandon;
    using base::timing, base::observer, base::port, base::echo, base::is_echo_ruled_out, base::now,
        base::began_at;

    /// As that of `line`. The bus lets a request of its plan wait for its turn, and ends another with `not_in_plan`
    /// before anything is sent. A stop goes first in any case.
    constexpr duration step(exchange& x, const bus_gaps& wanted) {
        return admit_ != nullptr ? admit_(*this, x, wanted) : base::step(x, wanted);
    }

  private:
    template <const auto&, class, class...> friend class bus;
    template <const auto&, class Line>
    friend constexpr duration detail::step_beside(Line&, typename Line::exchange&, const bus_gaps&);

    detail::other_requests others_{};
    duration (*admit_)(scheduled_line&, exchange&, const bus_gaps&) = nullptr; // the bus's
};

namespace detail {
template <class... As> inline constexpr bool is_scheduled<scheduled_line<As...>> = true;
} // namespace detail

} // namespace servobus
