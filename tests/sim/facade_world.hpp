// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One run's line with facades of drives on it, and what happens to the drives. Each frame is looked at before
// it leaves: whose it is, and whether it is a stop, says which silence goes before it.
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
    facade_world(std::uint64_t seed, tally& count, std::size_t notes, const conditions& of)
        : world{seed, count, notes, of}, line_{port(), of.timing, watch{&court()}} {
        port().before_request = [this](servobus::bytes frame) { look_at(frame); };
        hostility = draw_hostility(state());
        events = state().one_in(2) ? 0 : state().between(50, 200);
    }
    /// Nothing strikes the line itself: the times that are promised hold.
    bool is_faultless() const { return hostility == 0 && events == 0; }
    void be_faultless() { hostility = events = 0; }

    plain_line& line() { return line_; }
    std::vector<std::unique_ptr<facade>>& facades() { return facades_; }
    facade* facade_at(std::uint8_t unit) {
        for (const auto& f : facades_) {
            if (f->place().unit() == unit) return f.get();
        }
        return nullptr;
    }

    /// A device without a facade.
    template <class Seat, class... Options>
    Seat& hang_on(const servobus::catalogue& map, std::uint8_t unit, Options... options) {
        return static_cast<Seat&>(
            take_in(std::make_unique<Seat>(state(), line_, others(), map, unit, baud(), options...)));
    }
    /// A facade for a device that hangs on the line with its limits.
    template <class Facade, class Seat> Facade& drive(Seat& at) {
        facades_.push_back(std::make_unique<Facade>(at, line_));
        return static_cast<Facade&>(*facades_.back());
    }

    /// Sees each frame as it begins to leave, with its facade, if it has one, and whether it is urgent.
    std::function<void(servobus::bytes, facade*, bool)> on_frame;

  private:
    void look_at(servobus::bytes frame) {
        facade* const whose = facade_at(frame[0]);
        const bool is_urgent = whose != nullptr && whose->sends_urgently(frame);
        for (const auto& s : seats()) {
            if (s->unit() != frame[0]) continue;
            state().model = {s->limits().response.us, s->gaps().quarantine.us, s->limits().leading_bytes};
            servobus::bus_gaps gaps = s->gaps();
            gaps.is_urgent = is_urgent;
            court().set_quiet(gaps);
        }
        if (on_frame) on_frame(frame, whose, is_urgent);
        prepare_devices(frame);
    }

    plain_line line_;
    std::vector<std::unique_ptr<facade>> facades_;
};

} // namespace trial
