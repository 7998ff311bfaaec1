// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many random moves and feedbacks of one axis, and their sums in 64 bits, which are exact.
#pragma once

#include <cstdint>
#include <random>

#include <servobus/axis/carried_move.hpp>
#include <servobus/axis/unwrapped.hpp>

namespace axis_moves {

inline constexpr servobus::scale um_of_count = servobus::scale::of(652'300, 16'384);
inline constexpr servobus::scale counts_of_um = servobus::scale::of(16'384, 652'300);

inline int sign_of(servobus::count_direction d) { return d == servobus::count_direction::forward ? 1 : -1; }

/// The counts by which the sum of random relative moves differs from the nearest count. One in eight does not end done.
inline std::int64_t drift(servobus::count_direction direction, int moves) {
    using namespace servobus;
    std::mt19937 random{44};
    carried_move carried{counts_of_um, direction};
    std::int64_t um = 0;
    std::int64_t counts = 0;
    for (int i = 0; i < moves; ++i) {
        const auto distance = static_cast<std::int32_t>(random() % 20'001) - 10'000;
        const result<planned_move> m = carried.plan(micrometres{distance});
        if (random() % 8 == 0) continue;
        carried.commit(*m);
        um += distance;
        counts += sign_of(direction) * m->counts;
    }
    // Towards the nearest: half a count more, rounded down.
    const std::int64_t d = 2 * std::int64_t{counts_of_um.denominator()};
    const std::int64_t twice = 2 * um * counts_of_um.numerator() + counts_of_um.denominator();
    const std::int64_t nearest = twice >= 0 ? twice / d : -((d - 1 - twice) / d);
    return counts - nearest;
}

struct unwrapping {
    bool are_equal = true;
    std::int64_t wraps = 0;
};

/// Unwraps feedbacks of 9000 counts on average, and compares counts and micrometres after each.
inline unwrapping unwrap(servobus::count_direction direction, int feedbacks) {
    using namespace servobus;
    std::mt19937 random{43};
    unwrapped position{direction};
    unwrapped_length length{um_of_count, direction};
    std::uint32_t raw = 0xFFFF'0000;
    position.start(raw);
    length.start(raw);
    std::int64_t counts = 0;
    unwrapping u;
    for (int i = 0; i < feedbacks; ++i) {
        const auto step = static_cast<std::int32_t>(random() % 100'001) - 41'000;
        raw += static_cast<std::uint32_t>(sign_of(direction) * step);
        counts += step;
        u.are_equal &= position.update(raw) == step && static_cast<bool>(length.update(raw));
        u.are_equal &= position.counts() == counts && length.counts() == counts;
        // At most half a um off.
        const std::int64_t off =
            length.length().count() * um_of_count.denominator() - counts * um_of_count.numerator();
        u.are_equal &= 2 * off <= um_of_count.denominator() && -2 * off <= um_of_count.denominator();
    }
    u.wraps = counts >> 32;
    return u;
}

} // namespace axis_moves
