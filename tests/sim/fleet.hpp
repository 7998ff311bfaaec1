// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus with its plan and its drives, for any plan: what it sends, which times it promises, and its latest
// values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "bus_plans.hpp"
#include "facade_world.hpp"

namespace trial {

class fleet {
  public:
    fleet() = default;
    fleet(const fleet&) = delete;
    fleet& operator=(const fleet&) = delete;
    virtual ~fleet() = default;

    virtual servobus::duration step() = 0;
    virtual std::span<const servobus::poll> polls() const = 0;
    virtual std::span<const servobus::controlled_node> controlled() const = 0;
    virtual std::span<const servobus::requested_node> requested() const = 0;
    virtual bool is_absent(std::uint8_t node_address) const = 0;
    virtual std::uint32_t count(std::size_t i) const = 0;
    /// The latest value of read `i`. Empty if it is stale or its word order is unknown.
    virtual std::vector<std::uint16_t> latest(std::size_t i) const = 0;
    virtual std::uint32_t longest_us(const servobus::poll& p) const = 0;
    virtual std::uint32_t longest_gap_us(const servobus::controlled_node& d) const = 0;
    virtual std::uint32_t absent_load_per_mille() const = 0;
    virtual std::uint32_t found_within_us(std::uint32_t absent) const = 0;
    virtual std::uint32_t stop_latency_us(std::uint32_t drives) const = 0;
    virtual std::uint32_t longest_stop_us() const = 0;
    virtual std::uint32_t longest_stop_pause_us() const = 0;
};

template <const auto& Plan, class... Drives> class fleet_of : public fleet {
  public:
    servobus::duration step() override { return reads().step(); }
    std::span<const servobus::poll> polls() const override { return {Plan.polls, Plan.size}; }
    std::span<const servobus::controlled_node> controlled() const override {
        return {Plan.controlled, Plan.drives};
    }
    std::span<const servobus::requested_node> requested() const override {
        return {Plan.requests, Plan.requested};
    }
    bool is_absent(std::uint8_t node_address) const override { return bus_->is_absent(node_address); }
    std::uint32_t count(std::size_t i) const override { return bus_->count(i); }
    std::vector<std::uint16_t> latest(std::size_t i) const override { return latest_of(i, Plan); }
    std::uint32_t longest_us(const servobus::poll& p) const override { return Plan.longest(p).us; }
    std::uint32_t longest_gap_us(const servobus::controlled_node& d) const override {
        return Plan.longest_gap(d).us;
    }
    std::uint32_t absent_load_per_mille() const override { return Plan.absent_load_per_mille(); }
    std::uint32_t found_within_us(std::uint32_t absent) const override {
        return Plan.rediscovery_bound(absent).us;
    }
    std::uint32_t stop_latency_us(std::uint32_t drives) const override {
        return Plan.worst_case_stop_latency(drives).us;
    }
    std::uint32_t longest_stop_us() const override { return Plan.longest_stop().us; }
    std::uint32_t longest_stop_pause_us() const override { return Plan.longest_stop_pause().us; }

  protected:
    template <class Device> static constexpr servobus::node<Device> node_of(std::uint8_t node_address) {
        servobus::node<Device> n{node_address};
        for (std::size_t i = 0; i < Plan.size; ++i) {
            if (Plan.polls[i].node_address != node_address) continue;
            n.limits = Plan.polls[i].limits;
            n.gaps = Plan.polls[i].gaps;
        }
        for (std::size_t i = 0; i < Plan.requested; ++i) {
            if (Plan.requests[i].address != node_address) continue;
            n.limits = Plan.requests[i].limits;
            n.gaps = Plan.requests[i].gaps;
        }
        for (std::size_t i = 0; i < Plan.drives; ++i) {
            if (Plan.controlled[i].address != node_address) continue;
            n.limits = Plan.controlled[i].limits;
            n.gaps = Plan.controlled[i].gaps;
        }
        return n;
    }
    /// Adds a device with the limits that the plan has for it.
    template <class Seat, class Device, class... Options>
    static Seat& hang_on(facade_world& in, const servobus::catalogue& map, std::uint8_t node_address,
                         Options... options) {
        Seat& s = in.hang_on<Seat>(map, node_address, options...);
        const auto node = node_of<Device>(node_address);
        s.limits() = node.limits;
        s.gaps() = node.gaps;
        scene& on = in.state();
        // It responds after t3.5, or as late as 80 % of the time limit.
        const std::uint32_t most = s.limits().response.us * 8 / 10;
        s.usual_delay_us = on.one_in(3) ? on.between(on.timing.t3_5, most) : on.timing.t3_5;
        s.usual_delay_us = std::max(s.usual_delay_us, s.own_delay().us);
        s.set_delay(servobus::duration{s.usual_delay_us});
        return s;
    }
    static void hang_test_device_on(facade_world& in, std::uint8_t node_address) {
        using test_participant = participant_of<plain_line, test_device::device, test_device::registers>;
        (void)hang_on<test_participant, test_device::device>(in, test_device::catalogue, node_address);
    }
    /// The bus takes the drives over, which have their own command timeouts.
    void put_together(facade_world& in, Drives&... drives) {
        bus_.emplace(in.line(), drives...);
        (give_timeout(in.state(), drives), ...);
    }
    /// The bus, with the word order of its nodes set, as if a program learned it again immediately.
    auto& reads() {
        for (std::size_t i = 0; i < Plan.size; ++i)
            bus_->set_word_order(Plan.polls[i].node_address, servobus::word_order::high_first);
        return *bus_;
    }

  private:
    // Half of the programs supervise their commands.
    template <class Drive> static void give_timeout(scene& on, Drive& drive) {
        if (on.one_in(2)) drive.set_command_timeout(servobus::milliseconds(400));
    }
    using plan_type = std::remove_cvref_t<decltype(Plan)>;
    // Asks for the rows of each entry of the plan.
    template <class... Entries>
    std::vector<std::uint16_t> latest_of(std::size_t i, const servobus::poll_plan<Entries...>&) const {
        std::vector<std::uint16_t> words;
        [&]<std::size_t... Places>(std::index_sequence<Places...>) {
            (take<Places>(i, static_cast<const Entries*>(nullptr), words), ...);
        }
        (std::index_sequence_for<Entries...>{});
        return words;
    }
    template <std::size_t>
    void take(std::size_t, const void*, std::vector<std::uint16_t>&) const {} // no read
    template <std::size_t Place, const auto&... Rs>
    void take(std::size_t i, const servobus::cyclic_read<Rs...>*, std::vector<std::uint16_t>& words) const {
        constexpr std::size_t read = [] {
            std::size_t n = 0;
            while (plan_type::offsets.place[n] != Place) ++n;
            return n;
        }();
        if (i != read) return;
        using device = typename servobus::detail::same_device<Rs...>::device;
        constexpr servobus::node<device> node{Plan.polls[read].node_address};
        auto v = bus_->template latest<Rs...>(node, servobus::milliseconds(1000));
        if (!v) return;
        if constexpr (sizeof...(Rs) != 1) {
            words.assign(v->words().begin(), v->words().end());
        } else {
            const std::uint32_t bits = bits_of(*v);
            if ((servobus::row_type<Rs>::words + ...) == 2)
                words.push_back(static_cast<std::uint16_t>(bits >> 16));
            words.push_back(static_cast<std::uint16_t>(bits));
        }
    }
    template <class Value> static std::uint32_t bits_of(const Value& v) {
        if constexpr (requires { v.count(); })
            return servobus::to_bits(v.count());
        else
            return servobus::to_bits(v);
    }

    std::optional<servobus::bus<Plan, plain_line, Drives...>> bus_;
};

using wheels_drive = decltype(wheels::drive);
using lift_drive = decltype(stepper::drive);
using servo_drive = decltype(servo::drive);

class fast_fleet final : public fleet_of<plans::fast::plan, wheels_drive, lift_drive> {
  public:
    explicit fast_fleet(facade_world& in)
        : wheels_{in.drive<wheels>(hang_on<wheels_participant, servobus::zlac8015d::device>(
              in, servobus::zlac8015d::catalogue, plans::fast::wheels_node.address,
              in.state().manuals.draw<servobus::sim::zlac8015d_options>()))},
          lift_{in.drive<stepper>(hang_on<stepper_participant, servobus::yako::closed_loop::device>(
              in, servobus::yako::closed_loop::catalogue, plans::fast::lift_node.address,
              in.state().manuals.draw<servobus::sim::yako_options>()))} {
        hang_test_device_on(in, plans::fast::test_node.address);
        hang_test_device_on(in, plans::fast::asked_node.address);
        put_together(in, wheels_.drive, lift_.drive);
    }

  private:
    wheels& wheels_;
    stepper& lift_;
};

class slow_fleet final : public fleet_of<plans::slow::plan, servo_drive> {
  public:
    explicit slow_fleet(facade_world& in)
        : servo_{in.drive<servo>(hang_on<servo_participant, servobus::c630s::device>(
              in, servobus::c630s::catalogue, plans::slow::servo_node.address,
              in.state().manuals.draw<servobus::sim::c630s_options>()))} {
        for (const std::uint8_t node_address :
             {plans::slow::first_node.address, plans::slow::second_node.address,
              plans::slow::third_node.address, plans::slow::asked_node.address})
            hang_test_device_on(in, node_address);
        put_together(in, servo_.drive);
    }

  private:
    servo& servo_;
};

} // namespace trial
