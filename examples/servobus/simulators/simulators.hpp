// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated drives of `servobus sim`, and how one is asked for. Each returns the exit status.
#pragma once

#include <cstdint>
#include <vector>

#include <servobus/sim/faults.hpp>

namespace tool {

struct device;

/// How a simulator is asked for.
struct simulation {
    std::uint8_t node = 1;
    std::uint32_t baud = 0;
    std::uint64_t seed = 1;
    servobus::sim::fault_plan faults{};
    /// What the other end sends comes back to it, as from an adapter that receives what it sends.
    bool echoes = false;
    bool has_strict_rate = false; ///< no response at another rate than its own
    const char* link = nullptr;
    /// A number for each interpretation of the device; none: the simulator's own.
    std::vector<unsigned> ways{};
};

int simulate_zlac8015d(const simulation& wanted);
int simulate_yako_closed_loop(const simulation& wanted);
int simulate_yako_open_loop(const simulation& wanted);
int simulate_c630s(const simulation& wanted);
/// A device of a file, which holds what is written to it.
int simulate_file(const device& of, const simulation& wanted);

} // namespace tool
