// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line of one run with facades of drives on it, and what happens to the drives. Each frame is checked
// before it leaves: its node, and whether it is a stop, determine the gap that it needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "facade.hpp"
#include "servo.hpp"
#include "stepper.hpp"
#include "wheels.hpp"

namespace trial {

class facade_world final : public world {
  public:
    facade_world(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of)
        : world{seed, count, notes, of}, line_{port(), of.timing, watch{&court()}} {
        port().before_request = [this](servobus::bytes frame) { look_at(frame); };
        court().on_response = [this](servobus::bytes request) {
            facade* const whose = facade_at(request[0]);
            if (whose == nullptr) return;
            whose->answered(request);
            if (on_response) on_response(request, *whose);
        };
        hostility = draw_hostility(state());
        events = state().one_in(2) ? 0 : state().between(50, 200);
    }
    /// The line has no faults, so the promised times must be kept.
    bool is_faultless() const { return hostility == 0 && events == 0; }
    void be_faultless() { hostility = events = 0; }

    plain_line& line() { return line_; }
    std::vector<std::unique_ptr<facade>>& facades() { return facades_; }
    facade* facade_at(std::uint8_t node_address) {
        for (const auto& f : facades_) {
            if (f->place().address() == node_address) return f.get();
        }
        return nullptr;
    }

    /// A device without a facade.
    template <class Seat, class... Options>
    Seat& hang_on(const servobus::catalogue& map, std::uint8_t node_address, Options... options) {
        return static_cast<Seat&>(
            take_in(std::make_unique<Seat>(state(), line_, others(), map, node_address, baud(), options...)));
    }
    /// A facade for a device on the line, with the limits of that device.
    template <class Facade, class Seat> Facade& drive(Seat& at) {
        facades_.push_back(std::make_unique<Facade>(at, line_));
        return static_cast<Facade&>(*facades_.back());
    }

    /// Receives each frame as it begins to leave, with its facade, if there is one, and whether it is a
    /// stop that may go before all others.
    std::function<void(servobus::bytes, facade*, bool)> on_frame;
    /// Receives each request to a drive with a facade once it has got a valid response.
    std::function<void(servobus::bytes, facade&)> on_response;

  private:
    void look_at(servobus::bytes frame) {
        facade* const whose = facade_at(frame[0]);
        bool is_stop = false;
        for (const auto& s : participants()) {
            if (s->address() != frame[0]) continue;
            state().model = {s->limits().response.us, s->gaps().quarantine.us, s->limits().leading_bytes};
            court().set_quiet(s->gaps());
            is_stop = whose != nullptr && whose->sends_urgently(frame, !court().must_wait(), state().now());
            court().set_quiet(s->gaps(), is_stop);
        }
        if (on_frame) on_frame(frame, whose, is_stop);
        prepare_devices(frame);
    }

    plain_line line_;
    std::vector<std::unique_ptr<facade>> facades_;
};

} // namespace trial
