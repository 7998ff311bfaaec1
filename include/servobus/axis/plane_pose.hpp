// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A pose: where a machine stands in the plane, and which way it faces, at a time. Odometry returns it, and programs
// read it in micrometres, millimetres and microradians.
//
//     using namespace servobus::literals;
//     constexpr plane_pose dock = plane_pose::at(1.5_m, -200_mm, 250_mrad);
//     static_assert(dock.x() == 1500_mm && dock.y_mm() == -200 * units::millimetre && dock.heading() == 250_mrad);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/lengths.hpp>
#include <servobus/core/time.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

/// A pose in the plane. x points forward at heading 0, y to the left; the heading grows to the left.
struct plane_pose {
    using millimetres = quantity<unit{measure::millimetre}, std::int32_t>;
    using microradians = quantity<unit{measure::microradian}, std::int32_t>;

    std::int64_t x_fine = 0;        ///< 2^-24 um, +-549 km
    std::int64_t y_fine = 0;        ///< likewise
    std::uint64_t heading_fine = 0; ///< 2^-64 turn, modulo a turn
    instant time{};                 ///< when it was true: when its counts were read
    bool is_continuous = true;      ///< false since a way of unknown length: set it anew

    /// Makes a pose that is true at `t`. `x` and `y` are limited to +-549 km; the heading may be any.
    static constexpr plane_pose at(micrometres x, micrometres y, microradians heading, instant t = {}) {
        // 2^64 / (2 pi 10^6)
        const std::uint64_t turn =
            static_cast<std::uint64_t>(std::int64_t{heading.count()}) * 2'935'890'503'282u;
        return {fine(x), fine(y), turn, t, true};
    }

    /// Rounded down to um.
    constexpr micrometres x() const { return micrometres{x_fine >> 24}; }
    constexpr micrometres y() const { return micrometres{y_fine >> 24}; }
    /// Rounded to the nearest mm.
    constexpr millimetres x_mm() const { return nearest_mm(x_fine); }
    constexpr millimetres y_mm() const { return nearest_mm(y_fine); }
    /// Rounded to the nearest urad, in (-pi, pi]: -3'141'592 .. 3'141'593.
    constexpr microradians heading() const {
        const auto high = static_cast<std::int32_t>(heading_fine >> 32);
        // 2 pi 10^6 in parts of 2^8
        const std::int64_t turned = std::int64_t{high} * 1'608'495'439 + (std::int64_t{1} << 39);
        const auto urad = static_cast<std::int32_t>(turned >> 40);
        return microradians{urad < -3'141'592 ? 3'141'593 : urad};
    }

  private:
    static constexpr std::int64_t fine(micrometres um) {
        constexpr std::int64_t most = (std::int64_t{1} << 39) - 1;
        const std::int64_t limited = um.count() > most ? most : um.count() < -most ? -most : um.count();
        return static_cast<std::int64_t>(static_cast<std::uint64_t>(limited) << 24);
    }
    static constexpr millimetres nearest_mm(std::int64_t fine) {
        // 2^8 um are 32/125 mm, 0.256. What is below them is less than that, and may reach the next half.
        const auto parts = static_cast<std::int32_t>(fine >> 32);
        auto mm = static_cast<std::int32_t>(std::int64_t{parts} * 1'099'511'628 >> 32);
        auto rest = static_cast<std::int32_t>(static_cast<std::uint32_t>(parts) * 32u -
                                              static_cast<std::uint32_t>(mm) * 125u);
        for (; rest < 0; rest += 125) --mm;
        const auto below = static_cast<std::int32_t>(static_cast<std::uint32_t>(fine) >> 26); // 1/250 mm
        return millimetres{2 * rest + below >= 125 ? mm + 1 : mm};
    }
};

} // namespace servobus
