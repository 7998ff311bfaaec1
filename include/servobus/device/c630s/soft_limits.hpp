// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The limits of the travel of an axis, which a C630S does not have: the library keeps them. c630s/axis_drive.hpp
// includes it.
//
//     constexpr c630s::soft_limits ends{{-2'000, 180'000}};
//     static_assert(ends.passed_by(200'000) == c630s::travel_end::highest);
#pragma once

#include <cstdint>

#include <servobus/registers/reg.hpp>

namespace servobus::c630s {

/// The end of its travel that an axis would pass.
enum class travel_end : std::uint8_t { none, lowest, highest };

constexpr const char* text(travel_end e) {
    switch (e) {
    case travel_end::none: return "none";
    case travel_end::lowest: return "the lowest place";
    case travel_end::highest: return "the highest place";
    }
    return "unknown";
}

/// Places in reference units from the drive's home. Made of nothing there are none.
class soft_limits {
  public:
    /// Within those of a segment. A target that wraps lies outside then.
    static constexpr range widest{.low = -1'073'741'824, .high = 1'073'741'824};

    /// A place that has no count.
    static constexpr std::int32_t beyond = 0x7FFF'FFFF;

    constexpr soft_limits() = default;
    constexpr explicit soft_limits(range of) : of_{of}, are_set_{true} {}

    constexpr bool are_set() const { return are_set_; }
    /// The end that a target lies beyond.
    constexpr travel_end passed_by(std::int64_t target) const {
        if (!are_set_ || of_.contains(target)) return travel_end::none;
        return target < of_.low ? travel_end::lowest : travel_end::highest;
    }

  private:
    range of_{};
    bool are_set_ = false;
};

} // namespace servobus::c630s
