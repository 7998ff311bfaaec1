// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Faults of the library that the runs have found and that are not mended yet. What is true here is avoided or
// excused; with `false` the runs must find it again, or not any more.
#pragma once

namespace trial::avoided {

/// poll_plan.hpp: stops that are repeated to an absent drive leave the reads less room than a plan reckons
/// with, so that a live drive misses its keep-alive (G19).
inline constexpr bool stops_that_starve_reads = true;

} // namespace trial::avoided
