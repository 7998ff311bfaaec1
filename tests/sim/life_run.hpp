// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of lives: one drive whose program moves it, waits, homes it, saves and sets it, while it restarts at any
// instant, is away, loses frames, or has faults. In half of the runs a gateway responds in its place.
#pragma once

#include <cstdint>
#include <memory>

#include "life_scenes.hpp"
#include "server_neighbours.hpp"

namespace trial {

class life_run {
  public:
    life_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{make(seed, count, notes)}, life_{*in_} {}

    world& place() { return *in_; }
    void go() {
        constexpr int scenes = 20;
        ++in_->state().count->lives.lives;
        for (int i = 0; i < scenes; ++i) life_.any_scene();
        life_.end();
        server_neighbours{in_->state()}.go();
    }

  private:
    static conditions drawn(servobus::sim::dice& random) {
        conditions c = draw_conditions(random);
        while (c.wire.baud < 57600) c = draw_conditions(random);
        return c;
    }
    static std::unique_ptr<life_place> make(std::uint64_t seed, event_counts& count, std::size_t notes) {
        servobus::sim::dice random = dice_of_conditions(seed);
        const conditions c = drawn(random);
        const std::uint32_t which = random.below(4);
        if (which == 0) return std::make_unique<life_world<gateway_port>>(seed, count, notes, c, true);
        return std::make_unique<life_world<plain_port>>(seed, count, notes, c, which == 1);
    }

    std::unique_ptr<life_place> in_;
    life_scenes life_;
};

} // namespace trial
