// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: sine and cosine of an angle of 32 bits, by a table of 65 entries and a correction of third order. The error
// is at most 3.7e-9 (4 parts of 2^30); tests/run/axis/sine.cpp measures it.
//
//     static_assert(detail::unit_vector_at(0).cosine == 1 << 30 && detail::unit_vector_at(0).sine == 0);
//     static_assert(detail::unit_vector_at(0x4000'0000).sine == 1 << 30); // a quarter of a turn
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::detail {

/// sin(n / 256 turn) in parts of 2^30, n = 0 .. 64.
inline constexpr std::int32_t quarter_sine[65] = {
    0,          26350943,   52686014,   78989349,   105245103,  131437462,  157550647,  183568930,
    209476638,  235258165,  260897982,  286380643,  311690799,  336813204,  361732726,  386434353,
    410903207,  435124548,  459083786,  482766489,  506158392,  529245404,  552013618,  574449320,
    596538995,  618269338,  639627258,  660599890,  681174602,  701339000,  721080937,  740388522,
    759250125,  777654384,  795590213,  813046808,  830013654,  846480531,  862437520,  877875009,
    892783698,  907154608,  920979082,  934248793,  946955747,  959092290,  970651112,  981625251,
    992008094,  1001793390, 1010975242, 1019548121, 1027506862, 1034846671, 1041563127, 1047652185,
    1053110176, 1057933813, 1062120190, 1065666786, 1068571464, 1070832474, 1072448455, 1073418433,
    1073741824,
};

/// A direction: cosine and sine in parts of 2^30.
struct unit_vector {
    std::int32_t cosine = 0;
    std::int32_t sine = 0;
};

/// a * b / 2^32, rounded to the nearest.
constexpr std::int32_t high_product(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>((std::int64_t{a} * b + 0x8000'0000) >> 32);
}

/// The direction of `angle`, in parts of 2^32 of a turn.
constexpr unit_vector unit_vector_at(std::uint32_t angle) {
    // The nearest entry of the whole turn's 256, and the angle from there, +-2^23.
    const std::uint32_t nearest = angle + 0x0080'0000u;
    const std::uint32_t index = nearest >> 24;
    const auto beyond = static_cast<std::int32_t>(nearest & 0x00FF'FFFFu) - 0x0080'0000;
    std::int32_t sine = quarter_sine[index & 63u];
    std::int32_t cosine = quarter_sine[64u - (index & 63u)];
    const std::int32_t first_sine = sine;
    switch (index >> 6) {
    case 1:
        sine = cosine;
        cosine = -first_sine;
        break;
    case 2:
        sine = -sine;
        cosine = -cosine;
        break;
    case 3:
        sine = -cosine;
        cosine = first_sine;
        break;
    default: break;
    }
    // The same angle in radians, in parts of 2^32: 2 pi is 6 + 145/512 - 75/2^22.
    const std::int32_t radians = beyond * 6 + (beyond * 145 >> 9) - ((beyond >> 8) * 75 >> 14);
    // sin b = b - b^3 / 6 and 1 - cos b = b^2 / 2, |b| <= 1/512 turn.
    const std::int32_t coarse = (radians + 0x8000) >> 16;
    const std::int32_t small_sine = radians - ((coarse * coarse * coarse >> 16) * 10'923 >> 16);
    const std::int32_t finer = (radians + 0x200) >> 10;
    const auto size = static_cast<std::uint32_t>(finer < 0 ? -finer : finer);
    const auto versine = static_cast<std::int32_t>((size * size + 0x1000u) >> 13);
    return {cosine - high_product(sine, small_sine) - high_product(cosine, versine),
            sine + high_product(cosine, small_sine) - high_product(sine, versine)};
}

} // namespace servobus::detail
