// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Faults of the library that the runs have found and that are not mended yet. What is true here is avoided or
// excused; with `false` the runs must find it again, or not any more.
#pragma once

namespace trial::avoided {

/// line.hpp: a reply that comes in one piece with the end of its echo ends the exchange, but the line stays
/// taken, and knows neither that something was answered nor that it went wrong.
inline constexpr bool reply_in_one_piece_with_echo = true;

/// bus.hpp: a read that is about to leave goes before a stop that was ordered since the last turn (G25).
inline constexpr bool read_before_stop = true;

/// poll_plan.hpp: stops that are repeated to an absent drive leave the reads less room than a plan reckons
/// with, so that a live drive misses its keep-alive (G19).
inline constexpr bool stops_that_starve_reads = true;

} // namespace trial::avoided
