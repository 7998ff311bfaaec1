// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The place of an axis: follows the drive's position, over its wraps too, and carries what relative moves leave when
// they are rounded to counts. The model of a drive with an axis has one.
//
//     static constexpr auto slide = axis::of(lead(5_mm, counts_per_turn{1000}));
//     static_assert([] { axis_place p{slide}; p.follow(0x7FFF'FFFF, 1); p.follow(0x8000'0000, 1);
//                        return p.length() == 10'737'418'240 * units::micrometre; }());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/axis.hpp>

namespace servobus {

/// Where an axis is, and the rest of its moves. Positions are counted from elsewhere in another epoch.
class axis_place {
  public:
    constexpr axis_place() = default;
    /// `of` must outlive it: a constant of the namespace does.
    constexpr explicit axis_place(const axis& of) : axis_{&of} {}
    axis_place(const axis&&) = delete;

    constexpr const axis& geometry() const { return *axis_; }

    /// Takes a position of the drive. The first one of an epoch is a place from zero, the next ones are the nearest way
    /// from the one before.
    constexpr void follow(std::uint32_t raw, std::uint16_t epoch) {
        const bool is_new = !is_known_ || epoch != epoch_;
        if (is_new) begin();
        auto left = static_cast<std::int32_t>(is_new ? raw : raw - last_);
        last_ = raw;
        epoch_ = epoch;
        is_known_ = true;
        const std::int32_t most = axis_->most_counts();
        for (; left > most; left -= most) add(most);
        for (; left < -most; left += most) add(-most);
        add(left);
    }
    constexpr bool is_known() const { return is_known_; }
    /// At most 0.5 um off the drive's counts, whatever the number of steps.
    constexpr micrometres length() const { return micrometres{um_}; }

    /// The counts of a relative move after those that were kept, and what it leaves in `rest`. Errors: out_of_range.
    constexpr result<std::int32_t> plan(micrometres way, std::int32_t& rest) const {
        rest = rest_of_moves_;
        return axis_->counts_of(way, rest);
    }
    /// Keeps what a move leaves that has begun.
    constexpr void keep(std::int32_t rest) { rest_of_moves_ = rest; }

  private:
    constexpr void add(std::int32_t counts) { um_ += axis_->um_of(counts, rest_of_place_); }
    constexpr void begin() {
        um_ = 0;
        rest_of_place_ = 0;
        rest_of_moves_ = 0;
    }

    const axis* axis_ = nullptr;
    std::int64_t um_ = 0;
    std::uint32_t last_ = 0;
    std::int32_t rest_of_place_ = 0;
    std::int32_t rest_of_moves_ = 0;
    std::uint16_t epoch_ = 0;
    bool is_known_ = false;
};

} // namespace servobus
