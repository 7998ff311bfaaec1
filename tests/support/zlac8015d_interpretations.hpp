// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The switches of the simulated ZLAC8015D as choices.
#pragma once

#include <cstddef>
#include <vector>

#include <servobus/sim/zlac8015d.hpp>
#include <tests/support/under_interpretations.hpp>

namespace zlac8015d_interpretations {

using options = servobus::sim::zlac8015d_options;

inline const std::vector<unsigned> sizes{2, 2, 2, 2, 2, 2, 3, 2, 2, 2};
/// Those that only the field has shown to be open.
inline const std::vector<unsigned> sizes_of_field{2, 2, 2, 2, 2, 2, 2};

/// The number of positions of each switch of `options_of`.
inline std::vector<unsigned> switches() {
    std::vector<unsigned> all = sizes;
    all.insert(all.end(), sizes_of_field.begin(), sizes_of_field.end());
    return all;
}

/// Moves show no speed only where the running bit says whether a wheel turns. Otherwise a wheel that turns after a stop
/// shows in no register [B31].
inline options options_of(const interpretations::choice& c) {
    return {.resumes_after_watchdog = c[0] == 0,
            .save = static_cast<options::kept>(c[1]),
            .host_timeout = static_cast<options::zero>(c[2]),
            .while_turning = static_cast<options::shaft>(c[3]),
            .in_torque_mode = static_cast<options::shaft>(c[4]),
            .after_quick_stop = static_cast<options::stopped>(c[5]),
            .bit = static_cast<options::running>(c[6]),
            .code = static_cast<options::fault_code>(c[7]),
            .by_fault = static_cast<options::switched_off>(c[8]),
            .code_1 = static_cast<options::brake>(c[9]),
            .idle_shaft = static_cast<options::idle>(c[10]),
            .shows_speed_of_moves = c[11] == 0 || c[6] != 0,
            .position_start = static_cast<options::start>(c[12]),
            .enables_without_mode = c[13] != 0,
            .speed_ramp = static_cast<options::ramp>(c[14]),
            .checks_option_codes = c[15] == 0,
            .rescales_immediately = c[16] != 0};
}

/// Plays `scenes(options)` under each choice of the drive's switches; it returns how many scenes it played.
template <class Scenes> void under(const Scenes& scenes) {
    interpretations::under(
        "zlac8015d", sizes, [&](const interpretations::choice& c) { return scenes(options_of(c)); },
        sizes_of_field);
}

} // namespace zlac8015d_interpretations
