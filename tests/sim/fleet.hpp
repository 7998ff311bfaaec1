// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus with its plan and its drives, whatever the plan: what it reads, what it promises, what it has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "bus_plans.hpp"
#include "facade_world.hpp"

namespace trial {

/// The absence rules of all simulated buses.
inline constexpr servobus::back_off absence_rules{};

class fleet {
  public:
    fleet() = default;
    fleet(const fleet&) = delete;
    fleet& operator=(const fleet&) = delete;
    virtual ~fleet() = default;

    virtual servobus::duration step() = 0;
    virtual std::span<const servobus::poll> polls() const = 0;
    virtual bool is_absent(std::uint8_t unit) const = 0;
    virtual std::uint32_t count(std::size_t i) const = 0;
    /// What read `i` gave last; empty if that is too old, or of an order that is not known.
    virtual std::vector<std::uint16_t> latest(std::size_t i) const = 0;
    virtual std::uint32_t longest_us(const servobus::poll& p) const = 0;
    virtual std::uint32_t absent_load_per_mille() const = 0;
    virtual std::uint32_t found_within_us(std::uint32_t absent) const = 0;
    virtual std::uint32_t stop_latency_us(std::uint32_t drives) const = 0;
    virtual std::uint32_t longest_stop_us() const = 0;
    virtual std::uint32_t longest_stop_pause_us() const = 0;
};

template <const auto& Plan> class fleet_of : public fleet {
  public:
    explicit fleet_of(facade_world& in) : bus_{in.line(), absence_rules} {}

    std::span<const servobus::poll> polls() const override { return Plan.polls; }
    bool is_absent(std::uint8_t unit) const override { return bus_.is_absent(unit); }
    std::uint32_t count(std::size_t i) const override { return bus_.count(i); }
    std::vector<std::uint16_t> latest(std::size_t i) const override { return latest_of<0>(i); }
    std::uint32_t longest_us(const servobus::poll& p) const override { return Plan.longest(p).us; }
    std::uint32_t absent_load_per_mille() const override { return Plan.absent_load_per_mille(absence_rules); }
    std::uint32_t found_within_us(std::uint32_t absent) const override {
        return Plan.rediscovery_bound(absent, absence_rules).us;
    }
    std::uint32_t stop_latency_us(std::uint32_t drives) const override {
        return Plan.worst_case_stop_latency(drives).us;
    }
    std::uint32_t longest_stop_us() const override { return Plan.longest_stop().us; }
    std::uint32_t longest_stop_pause_us() const override { return Plan.longest_stop_pause(absence_rules).us; }

  protected:
    template <class Device> static constexpr servobus::node<Device> node_of(std::uint8_t unit) {
        servobus::node<Device> n{unit};
        for (const servobus::poll& p : Plan.polls) {
            if (p.unit != unit) continue;
            n.limits = p.limits;
            n.gaps = p.gaps;
        }
        return n;
    }
    /// With the limits that the plan has for it.
    template <class Seat, class Device, class... Options>
    static Seat& hang_on(facade_world& in, const servobus::catalogue& map, std::uint8_t unit,
                         Options... options) {
        Seat& s = in.hang_on<Seat>(map, unit, options...);
        const auto node = node_of<Device>(unit);
        s.limits() = node.limits;
        s.gaps() = node.gaps;
        scene& on = in.state();
        // Right after the silence, or at almost the last moment.
        const std::uint32_t most = s.limits().response.us * 8 / 10;
        s.usual_delay_us = on.one_in(3) ? on.between(on.timing.t3_5, most) : on.timing.t3_5;
        s.usual_delay_us = std::max(s.usual_delay_us, s.own_delay().us);
        s.set_delay({s.usual_delay_us});
        return s;
    }
    static void hang_gauge_on(facade_world& in, std::uint8_t unit) {
        using gauge_seat = seat_of<plain_line, gauge::device, gauge::registers>;
        (void)hang_on<gauge_seat, gauge::device>(in, gauge::catalogue, unit);
    }
    /// The reads, whose order of words was told, as if by a program that learns it again at once.
    auto& reads() {
        for (const servobus::poll& p : Plan.polls) bus_.set_order(p.unit, servobus::word_order::high_first);
        return bus_;
    }

  private:
    template <std::size_t I> std::vector<std::uint16_t> latest_of(std::size_t i) const {
        if constexpr (I < Plan.size) {
            if (I != i) return latest_of<I + 1>(i);
            auto v = bus_.template latest<I>(servobus::milliseconds(1000));
            if (!v) return {};
            const auto words = v->words();
            return {words.begin(), words.end()};
        } else {
            return {};
        }
    }

    servobus::bus<Plan, plain_line> bus_;
};

class fast_fleet final : public fleet_of<plans::fast::plan> {
  public:
    explicit fast_fleet(facade_world& in)
        : fleet_of{in}, wheels_{in.drive<wheels>(hang_on<wheels_seat, servobus::zlac8015d::device>(
                            in, servobus::zlac8015d::catalogue, plans::fast::wheels_node.unit,
                            in.state().manuals.draw<servobus::sim::zlac8015d_options>()))},
          lift_{in.drive<stepper>(hang_on<stepper_seat, servobus::yako::closed_loop::device>(
              in, servobus::yako::closed_loop::catalogue, plans::fast::lift_node.unit,
              in.state().manuals.draw<servobus::sim::yako_options>()))} {
        hang_gauge_on(in, plans::fast::gauge_node.unit);
    }
    servobus::duration step() override { return reads().step(wheels_.drive, lift_.drive); }

  private:
    wheels& wheels_;
    stepper& lift_;
};

class slow_fleet final : public fleet_of<plans::slow::plan> {
  public:
    explicit slow_fleet(facade_world& in)
        : fleet_of{in}, servo_{in.drive<servo>(hang_on<servo_seat, servobus::c630s::device>(
                            in, servobus::c630s::catalogue, plans::slow::servo_node.unit,
                            in.state().manuals.draw<servobus::sim::c630s_options>()))} {
        for (const std::uint8_t unit :
             {plans::slow::first_node.unit, plans::slow::second_node.unit, plans::slow::third_node.unit})
            hang_gauge_on(in, unit);
    }
    servobus::duration step() override { return reads().step(servo_.drive); }

  private:
    servo& servo_;
};

} // namespace trial
