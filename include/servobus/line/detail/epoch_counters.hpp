// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line counts for `epoch`: requests without a valid response, losses of its port, and writes of settings that a
// facade caches.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/epoch.hpp>

namespace servobus::detail {

// Nodes share `Counters` counters of 8 bits. One that wraps advances the next wider one, so that no epoch
// comes back before 2^16 misses.
template <std::size_t Counters> class epoch_counters {
  public:
    [[gnu::always_inline]] constexpr epoch of(std::uint8_t node_address) const {
        const std::uint8_t of_node = of_node_[node_address % Counters];
        return {static_cast<std::uint16_t>(of_all_ << 8 | of_node), losses_};
    }
    constexpr void count_miss(std::uint8_t node_address) {
        if (++of_node_[node_address % Counters] == 0) count_miss_of_all();
    }
    constexpr void count_miss_of_all() {
        if (++of_all_ == 0) ++losses_;
    }
    constexpr void count_loss() {
        ++losses_;
        count_miss_of_all();
    }
    // It counts as `epoch::change` losses, by which a facade tells the two. No miss: what clients have learned of a node holds.
    constexpr void count_change() { losses_ = static_cast<std::uint8_t>(losses_ + epoch::change); }

  private:
    std::uint8_t losses_ = 0;
    std::uint8_t of_all_ = 0;
    std::uint8_t of_node_[Counters]{};
};

} // namespace servobus::detail
