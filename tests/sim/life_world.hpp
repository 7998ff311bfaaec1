// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line of a run of lives: one drive with its program, perhaps a gateway, and neighbours. Nothing is damaged on
// it but what the run plans.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "gateway.hpp"
#include "pilot_servo.hpp"
#include "pilot_stepper.hpp"
#include "pilot_wheels.hpp"
#include "world.hpp"

namespace trial {

/// What the program of a run needs of its world, whatever the port.
class life_place : public world {
  public:
    life_place(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of)
        : world{seed, count, notes, of}, gateway_{state(), of.wire.baud} {
        (void)wire().attach(gateway_);
        port().before_request = [this](servobus::bytes frame) {
            if (on_frame) on_frame(frame);
            gateway_.asked(frame);
            prepare_devices(frame);
        };
    }

    gateway& between() { return gateway_; }
    pilot& program() { return *pilot_; }
    /// Receives each frame before it leaves.
    std::function<void(servobus::bytes)> on_frame;

    virtual bool is_tcp() const = 0;
    virtual void sleep(servobus::duration longest) = 0;
    /// How long one exchange of this program with its drive may take.
    virtual servobus::duration longest_exchange() = 0;

  protected:
    void board(std::unique_ptr<pilot> p) { pilot_ = std::move(p); }

  private:
    gateway gateway_;
    std::unique_ptr<pilot> pilot_;
};

template <class Port> class life_world final : public life_place {
  public:
    using line_type = servobus::line<Port, watch, servobus::unechoed>;

    life_world(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of,
               bool has_gateway)
        : life_place{seed, count, notes, of}, port_{port()}, line_{port_, of.timing, watch{&court()}} {
        static constexpr std::uint32_t periods[] = {20, 20, 20, 50, 100, 250};
        scene& on = state();
        const servobus::duration every = servobus::milliseconds(periods[on.random.below(6)]);
        const auto node_address = static_cast<std::uint8_t>(on.between(1, 31));
        switch (on.random.below(3)) {
        case 0:
            add<wheels_pilot<line_type>, wheels_place<line_type>, servobus::sim::zlac8015d_options>(
                servobus::zlac8015d::catalogue, node_address, every, has_gateway);
            break;
        case 1:
            add<stepper_pilot<line_type>, stepper_place<line_type>, servobus::sim::yako_options>(
                servobus::yako::closed_loop::catalogue, node_address, every, has_gateway);
            break;
        default:
            add<servo_pilot<line_type>, servo_place<line_type>, servobus::sim::c630s_options>(
                servobus::c630s::catalogue, node_address, every, has_gateway);
        }
    }

    bool is_tcp() const override {
        return requires { Port::has_gateway; };
    }
    void sleep(servobus::duration longest) override { line_.sleep(longest); }
    servobus::duration longest_exchange() override {
        participant& at = program().place();
        return line_.bound(13, 27, at.limits(), at.gaps());
    }

  private:
    template <class Pilot, class Seat, class Options>
    void add(const servobus::catalogue& map, std::uint8_t node_address, servobus::duration every,
             bool has_gateway) {
        scene& on = state();
        auto& at = static_cast<Seat&>(
            take_in(std::make_unique<Seat>(on, line_, others(), map, node_address, baud(),
                                           Pilot::workable(on.manuals.template draw<Options>()))));
        const std::uint32_t own = at.own_delay().us + 4 * on.timing.t3_5;
        at.limits().response = servobus::duration{on.between(50'000, 110'000) + own};
        at.gaps().quarantine = servobus::duration{on.between(20'000, 80'000)};
        if (resolution_us() > 1) at.gaps().gap.us += on.timing.t3_5 + resolution_us(); // a coarse clock
        at.usual_delay_us = on.timing.t3_5 + on.random.below(500);
        at.set_delay(servobus::duration{at.usual_delay_us});
        at.set_listening(on.one_in(2));
        if (has_gateway) {
            between().stand_in(servobus::duration{on.between(12'000, 35'000) + own}, on.random.roll());
            if (!is_tcp()) put_behind_gateway(at.limits()); // a port of Modbus TCP needs no setting
        }
        // Gaps after a failed exchange are judged in other runs.
        court().set_quiet(at.gaps(), true);
        auto program = std::make_unique<Pilot>(at, line_, every);
        program->prepare();
        board(std::move(program));
    }

    Port port_;
    line_type line_;
};

} // namespace trial
