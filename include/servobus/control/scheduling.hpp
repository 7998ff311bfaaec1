// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a bus asks of the facades that it schedules. It is no part of what a program uses of a drive: a bus
// includes it.
//
//     if (scheduling::has_stop(wheels)) wheels.step();   // before all other traffic
//     const auto waiting = scheduling::ticket(wheels);   // the lowest of all drives is next
#pragma once

#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>

namespace servobus {

/// A drive with a facade, as a plan has it.
struct supervised_node {
    std::uint8_t address = 0;
    response_limits limits{};
    bus_gaps gaps{};
    supervision by = unsupervised;
};

/// The members of a facade that only a bus uses.
struct scheduling {
    /// A stop that goes before all other traffic waits to be sent.
    template <class Facade> static constexpr bool has_stop(const Facade& of) { return of.has_stop_to_send(); }
    /// The place in the queue of the frame that waits for the line: a lower one has waited longer. 0: none waits.
    template <class Facade> static constexpr std::uint16_t ticket(const Facade& of) {
        return of.is_waiting_to_send() ? of.exchange_.ticket() : std::uint16_t{0};
    }
    /// Its frame is on the wire, or the response is awaited.
    template <class Facade> static constexpr bool is_on_the_wire(const Facade& of) {
        return of.flight_ != flight::none && !of.is_waiting_to_send();
    }
    /// Its settings are known, and no stop must be the next frame that it receives.
    template <class Facade> static constexpr bool may_be_read(Facade& of) {
        of.check_link(of.line_->now());
        return of.is_known();
    }
    template <class Facade> static constexpr bool is_known(const Facade& of) { return of.is_known(); }
    /// The facade follows the plan. One at another address, or on another line, is polled no more and refuses all
    /// commands but stops from now on.
    template <class Facade, class Line>
    static constexpr void adopt(Facade& of, const Line& on, const supervised_node& as, duration stop_every,
                                duration retry_every, duration longest_response) {
        if (of.line_ == &on)
            of.priority_ = priority::planned; // also of a refused one: its stops are read back
        if (of.address_ != as.address || of.line_ != &on) {
            of.is_refused_ = true;
            of.polling_.set_period({});
            return;
        }
        of.limits_ = as.limits;
        of.gaps_ = as.gaps;
        of.polling_.set_period(as.by.feedback);
        of.polling_.absence().set_period(retry_every);
        of.set_command_timeout(as.by.command_timeout);
        of.repeat_stops(stop_every);
        if constexpr (requires { of.model_.grant_at_most(longest_response); })
            of.model_.grant_at_most(longest_response);
    }
    /// As `begin`, for a call that waits: a refusal shows in `last()` too.
    template <class Facade, class Wanted>
    static constexpr errc begin_to_wait(Facade& of, const Wanted& wanted) {
        return of.note_refusal(of.begin(wanted));
    }
    /// A blocking call waits for this drive: its command timeout begins again.
    template <class Facade> static constexpr void note_wait(Facade& of) {
        of.supervisors_.note_command(of.line_->now());
    }
    template <class Facade> static constexpr void give_up(Facade& of, errc why) { of.give_up(why); }
};

} // namespace servobus
