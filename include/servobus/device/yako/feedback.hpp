// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: what a drive reports in one frame, with its units: error, status, terminals,
// position and speed. yako/basic_drive.hpp includes it; programs get it from `read()` of a drive.
//
//     const result<yako::closed_loop::feedback> seen = axis.read();
//     if (!seen || seen->has_fault()) return 1;
//     if (seen->inputs.x0 && seen->position > 40'000 * pulse && !axis.run(halt{})) return 1;
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/core/slice.hpp>
#include <servobus/device/yako/prepared_command.hpp>

namespace servobus::yako {

/// The name of an error code of 0006h. The manual does not state what 1..5 mean [errata A36].
constexpr const char* text(std::uint16_t error) {
    constexpr const char* names[] = {"none", "error 1", "error 2", "error 3", "error 4", "error 5"};
    return error < 6 ? names[error] : "unlisted error";
}

/// What the drive says of itself in one frame.
template <class Device> struct basic_feedback {
    using input_levels =
        std::conditional_t<detail::is_closed_loop<Device>, closed_loop::inputs, open_loop::inputs>;
    using output_levels =
        std::conditional_t<detail::is_closed_loop<Device>, closed_loop::outputs, open_loop::outputs>;

    std::uint16_t error = 0; ///< 0: none; the manual has no list of the others; see `yako::text`
    motion_status state{};
    input_levels inputs{};
    output_levels outputs{};
    distance position{}; ///< closed loop: from the encoder, open loop: as commanded
    yako::speed speed{}; ///< as 001Ah was at the last `init` or `set_speed_resolution`

    constexpr bool has_fault() const { return state.has_alarm(); }
    constexpr bool is_moving() const { return state.is_moving(); }
    constexpr bool is_in_position() const { return state.is_in_position(); }

    /// Takes the seven words of 0006h..000Ch.
    static constexpr basic_feedback from_words(slice<const std::uint16_t> w, word_order order,
                                               speed_count resolution) {
        const bool is_tenth = resolution == speed_count::tenth_r_per_min;
        basic_feedback f;
        f.error = w[0];
        f.state = motion_status::from_word(w[routines::status_at]);
        f.inputs = input_levels::from_word(w[2]);
        f.outputs = output_levels::from_word(w[3]);
        f.position = position_in(w, order);
        f.speed = yako::speed{static_cast<i16>(w[6]) * (is_tenth ? 1 : 10)};
        return f;
    }
    static constexpr distance position_in(slice<const std::uint16_t> w, word_order order) {
        return distance{
            from_bits<i32>(join_words(w[routines::position_at], w[routines::position_at + 1u], order))};
    }
};

namespace closed_loop {
using feedback = basic_feedback<device>;
}
namespace open_loop {
using feedback = basic_feedback<device>;
}

} // namespace servobus::yako
