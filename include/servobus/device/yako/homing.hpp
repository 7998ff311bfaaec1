// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the homing methods, and the position that the drive has afterwards.
// yako/common.hpp includes it. Source: manual V2.6.0, section 4.3 and appendices 1 to 3; its methods 1..14
// and 17..30 end where those of CiA 402 with these numbers do. [errata An] are in device/errata.md.
//
//     constexpr yako::homing to_index = yako::homing::home_and_index_7;
//     static_assert(yako::closed_loop::is_valid(to_index) && !yako::open_loop::is_valid(to_index));
//     constexpr auto then = yako::offset_handling::stay_position_offset;
//     if (!axis.run(yako::closed_loop::home{to_index, 200 * pulse, then})) return 1; // it is at 200 then
#pragma once

#include <cstdint>

#include <servobus/registers/wire.hpp>

namespace servobus::yako {

/// 0031h homing method. A comment says where home is and which way the search begins while no switch is
/// active; an edge of the home switch is its negative or positive end. Methods with an index pulse need an
/// encoder that has one: closed loop.
enum class homing : std::int16_t {
    mechanical_stop_1 = -1, ///< closed loop; neither direction nor index pulse is documented [errata A18]
    mechanical_stop_2 = -2,
    mechanical_stop_3 = -3,
    mechanical_stop_4 = -4,

    negative_limit_and_index = 1,  ///< first index forward of the negative limit; backward
    positive_limit_and_index = 2,  ///< first index backward of the positive limit; forward
    positive_home_and_index_3 = 3, ///< first index backward of a home switch on the positive side; forward
    positive_home_and_index_4 = 4, ///< first index forward of its edge; forward, slowly all the way
    negative_home_and_index_5 = 5, ///< first index forward of a home switch on the negative side; backward
    negative_home_and_index_6 = 6, ///< first index backward of its edge; backward, slowly all the way
    home_and_index_7 = 7,          ///< first index backward of the negative edge; forward
    home_and_index_8 = 8,          ///< first index forward of the negative edge; forward
    home_and_index_9 = 9,          ///< first index backward of the positive edge; forward
    home_and_index_10 = 10,        ///< first index forward of the positive edge; forward [errata A19]
    home_and_index_11 = 11,        ///< first index forward of the positive edge; backward
    home_and_index_12 = 12,        ///< first index backward of the positive edge; backward
    home_and_index_13 = 13,        ///< first index forward of the negative edge; backward [errata A19]
    home_and_index_14 = 14,        ///< first index backward of the negative edge; backward [errata A19]

    negative_limit = 17,   ///< the negative limit's edge, met going forward; backward
    positive_limit = 18,   ///< the positive limit's edge, met going backward; forward
    positive_home_19 = 19, ///< the edge of a home switch on the positive side, met going backward; forward
    positive_home_20 = 20, ///< the same, met going forward; forward, slowly all the way
    negative_home_21 = 21, ///< the edge of a home switch on the negative side, met going forward; backward
    negative_home_22 = 22, ///< the same, met going backward; backward, slowly all the way
    home_23 = 23,          ///< the negative edge, met going backward; forward
    home_24 = 24,          ///< the negative edge, met going forward; forward
    home_25 = 25,          ///< the positive edge, met going backward; forward
    home_26 = 26,          ///< the positive edge, met going forward; forward [errata A19]
    home_27 = 27,          ///< the positive edge, met going forward; backward
    home_28 = 28,          ///< the positive edge, met going backward; backward
    home_29 = 29,          ///< the negative edge, met going forward; backward [errata A19]
    home_30 = 30,          ///< the negative edge, met going backward; backward [errata A19]

    index_negative = 33,   ///< first index backward in CiA 402; not described here [errata A18]
    index_positive = 34,   ///< first index forward in CiA 402; not described here [errata A18]
    current_position = 35, ///< without a motion
};

/// A method as its register takes it: `write<homing_method>(number_of(homing::home_24))`.
constexpr i16 number_of(homing m) { return static_cast<i16>(m); }

namespace closed_loop {
/// True for a method that the drive has: -1..-4, 1..14, 17..30, 33..35.
constexpr bool is_valid(homing m) {
    const i16 n = number_of(m);
    return (n >= -4 && n <= -1) || (n >= 1 && n <= 14) || (n >= 17 && n <= 30) || (n >= 33 && n <= 35);
}
} // namespace closed_loop

namespace open_loop {
/// True for a method that the drive has: 17..30 and 35.
constexpr bool is_valid(homing m) {
    const i16 n = number_of(m);
    return (n >= 17 && n <= 30) || n == 35;
}
} // namespace open_loop

/// 0030h: whether the motor moves on by the home offset (0035h) once home is found, and what position it has
/// then. CiA 402's home offset is `move_position_zero` or `stay_position_negative_offset`: the position is
/// zero the offset away from home. The factory's setting is not.
enum class offset_handling : std::uint16_t {
    move_position_offset = 0,
    move_position_zero = 1,
    move_position_negative_offset = 2,
    move_position_actual = 3, ///< the counter goes on
    move_position_actual_plus_offset = 4,
    move_position_actual_minus_offset = 5,
    stay_position_offset = 6,
    stay_position_zero = 7,
    stay_position_negative_offset = 8,
    stay_position_actual = 9,
    stay_position_actual_plus_offset = 10,
    stay_position_actual_minus_offset = 11,
};

} // namespace servobus::yako
