// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One run's line: its rate and timing, who hangs on it, what its clock shows first, how hostile it is. All of
// it drawn from the seed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "gauge.hpp"
#include "seat.hpp"
#include "words.hpp"

namespace trial {

using gauge_seat = seat_of<gauge::device, gauge::registers>;

class world {
  public:
    world(std::uint64_t seed, tally& count, std::size_t notes)
        : first_{seed * 2654435761u + 7}, settings_{draw_settings()}, wire_{settings_},
          log_{draw_gap(), notes}, port_{scene_, judge_, draw_resolution()},
          line_{port_, scene_.timing, watch{&judge_}}, babbler_{scene_, settings_.baud} {
        scene_.count = &count;
        scene_.random = servobus::sim::dice{seed};
        scene_.log = &log_;
        scene_.blur_us = resolution_us_ + longest_turn_us;
        wire_.set_hook(&world::note_byte, this);
        judge_.set_slack(resolution_us_);
        port_.before_request = [this](servobus::bytes frame) { prepare_devices(frame); };
        (void)wire_.attach(babbler_);
        fill_seats();
        static constexpr std::uint32_t chances[] = {0, 30, 100, 200, 400};
        hostility = chances[scene_.random.below(5)];
        events = scene_.random.below(3) == 0 ? 0 : scene_.random.below(120);
        if (scene_.one_in(6)) port_.takes_at_most = scene_.between(4, 16);
    }
    world(const world&) = delete;
    world& operator=(const world&) = delete;

    /// A superloop's other work between two looks at its line.
    static constexpr std::uint32_t longest_turn_us = 800;

    std::uint32_t hostility = 0; ///< faults in a thousand frames
    std::uint32_t events = 0;    ///< other events in a thousand operations

    scene& state() { return scene_; }
    judge& court() { return judge_; }
    record& log() { return log_; }
    shaky_port& port() { return port_; }
    line_type& line() { return line_; }
    servobus::sim::virtual_line& wire() { return wire_; }
    babbler& others() { return babbler_; }
    std::vector<std::unique_ptr<seat>>& seats() { return seats_; }
    seat& any_seat() { return *seats_[scene_.random.below(static_cast<std::uint32_t>(seats_.size()))]; }
    std::uint32_t resolution_us() const { return resolution_us_; }
    bool is_strict() const { return scene_.timing.mode == servobus::modbus::timing_mode::strict; }
    bool has_only_gauges() const { return has_only_gauges_; }

    /// Nobody at the client's end does anything for a time.
    void rest(std::uint64_t us) {
        const std::uint64_t end = wire_.time_us() + us;
        while (wire_.time_us() < end) {
            port_.look();
            const std::uint64_t left = end - wire_.time_us();
            std::uint64_t next = port_.next_plan();
            next = next > wire_.time_us() ? next - wire_.time_us() : left;
            const std::uint64_t step = std::min({left, next, std::uint64_t{1'000'000'000}});
            wire_.pass(servobus::duration{static_cast<std::uint32_t>(step)});
        }
        port_.look();
    }

    bool is_free(std::uint8_t unit) const {
        for (const auto& s : seats_) {
            if (s->device_unit() == unit || s->unit() == unit) return false;
        }
        return true;
    }
    std::uint8_t free_unit() {
        for (;;) {
            const auto unit = static_cast<std::uint8_t>(scene_.between(1, 120));
            if (is_free(unit)) return unit;
        }
    }

    void print() {
        vocabulary maps;
        for (const auto& s : seats_) maps[s->unit()] = &s->map();
        trial::print(log_, maps, gauge::catalogue);
    }

  private:
    servobus::sim::line_settings draw_settings() {
        static constexpr std::uint32_t rates[] = {1200,  9600,   19200,  38400,  57600,  57600,
                                                  57600, 115200, 115200, 115200, 115200, 115200};
        servobus::sim::line_settings s;
        s.baud = rates[first_.below(12)];
        s.echoes = first_.below(4) == 0;
        s.start = {first_.below(3) == 0 ? ~first_.below(3'000'000) : first_.roll()};
        const bool is_strict = first_.below(2) == 0;
        scene_.timing = servobus::modbus::timing_at(
            s.baud, is_strict ? servobus::modbus::timing_mode::strict : servobus::modbus::timing_mode::host,
            servobus::microseconds(16'000 + first_.below(10'000)));
        // A clock of a millisecond will do above 19200 Bd in host timing.
        if (!is_strict && s.baud > 19200 && first_.below(4) == 0) resolution_us_ = 1000;
        return s;
    }
    std::uint64_t draw_gap() const { return 2u * scene_.timing.character + 100; }
    std::uint32_t draw_resolution() {
        scene_.wire = &wire_;
        scene_.log = &log_;
        return resolution_us_;
    }

    void fill_seats() {
        for (std::uint32_t n = scene_.between(1, 4); n != 0; --n) {
            add_seat();
            (void)wire_.attach(seats_.back()->device());
            settle(*seats_.back());
        }
    }
    template <class Device, class Store, class... Options>
    void add(const servobus::catalogue& map, Options... options) {
        seats_.push_back(std::make_unique<seat_of<Device, Store>>(scene_, line_, babbler_, map, free_unit(),
                                                                  settings_.baud, options...));
    }
    void add_seat() {
        using namespace servobus;
        const std::uint32_t kind = scene_.random.below(10);
        has_only_gauges_ = has_only_gauges_ && kind > 3;
        const sim::yako_options yako{.answers_bad_crc = scene_.one_in(2)};
        const sim::c630s_options c630s{.echoes_byte_count = scene_.one_in(2)};
        switch (kind) {
        case 0: return add<zlac8015d::device, sim::zlac8015d>(zlac8015d::catalogue);
        case 1:
            return add<yako::closed_loop::device, sim::yako_closed_loop>(yako::closed_loop::catalogue, yako);
        case 2: return add<yako::open_loop::device, sim::yako_open_loop>(yako::open_loop::catalogue, yako);
        case 3: return add<c630s::device, sim::c630s>(c630s::catalogue, c630s);
        default: return add_gauge();
        }
    }
    void add_gauge() {
        add<gauge::device, gauge::registers>(gauge::catalogue);
        auto& node = static_cast<gauge_seat&>(*seats_.back()).client.node();
        node.order = scene_.one_in(2) ? servobus::word_order::low_first : servobus::word_order::high_first;
        node.read_retries = static_cast<std::uint8_t>(scene_.between(0, 3));
    }
    // Limits that fit the device, as whoever sets a node up would choose them.
    void settle(seat& s) {
        const std::uint32_t t3_5 = scene_.timing.t3_5;
        s.limits().response = {scene_.between(30'000, 120'000) + 4 * t3_5};
        s.limits().turnaround = {scene_.between(2'000, 20'000)};
        s.limits().leading_bytes = scene_.one_in(4) ? std::uint8_t{0} : std::uint8_t{4};
        s.quiet().quarantine = {scene_.between(30'000, 150'000) + 2 * t3_5};
        s.quiet().gap = {scene_.one_in(3) ? scene_.between(0, 10'000) : 0u};
        // A coarse clock shows up to a tick more than has passed, and the drive insists on t3.5.
        if (resolution_us_ > 1) s.quiet().gap.us += t3_5 + resolution_us_;
        const std::uint32_t most =
            std::min(s.limits().response.us * 6 / 10, s.quiet().quarantine.us * 8 / 10);
        s.usual_delay_us = scene_.one_in(4) ? scene_.between(t3_5, most) : t3_5 + scene_.random.below(500);
        s.set_delay({s.usual_delay_us});
    }

    void prepare_devices(servobus::bytes frame) {
        for (const auto& s : seats_)
            s->device().prepare(frame.size(), frame[0] == s->device_unit() || frame[0] == 0);
    }
    static void note_byte(void* self, const servobus::sim::wire_byte& b) {
        world& w = *static_cast<world*>(self);
        w.log_.byte(b.at_us, b.value, b.is_from_client);
        if (!b.is_from_client && !w.port_.is_gone()) w.judge_.arrives(b.at_us);
    }

    scene scene_;
    servobus::sim::dice first_;
    std::uint32_t resolution_us_ = 1;
    servobus::sim::line_settings settings_;
    servobus::sim::virtual_line wire_;
    record log_;
    judge judge_{scene_};
    shaky_port port_;
    line_type line_;
    babbler babbler_;
    std::vector<std::unique_ptr<seat>> seats_;
    bool has_only_gauges_ = true;
};

} // namespace trial
