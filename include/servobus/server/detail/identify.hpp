// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: responses of a server's functions 2Bh/0Eh and 11h.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/modbus/identification.hpp>
#include <servobus/server/options.hpp>

namespace servobus::detail {

inline constexpr std::size_t identification_head = 7; ///< bytes before the objects

/// The bytes of a response with the longest object.
template <class Objects> constexpr std::size_t least_room() {
    std::size_t longest = 0;
    for (std::size_t i = 0; i < Objects::count; ++i) {
        if (Objects::begin()[i].size > longest) longest = Objects::begin()[i].size;
    }
    return identification_head + 2 + longest;
}

constexpr std::uint8_t* put_text(std::uint8_t* to, const char* text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) *to++ = static_cast<std::uint8_t>(text[i]);
    return to;
}

constexpr std::size_t size_of_identification(const std::uint8_t* p) {
    const std::uint8_t* at = p + identification_head;
    for (unsigned left = p[6]; left != 0; --left) at += 2u + at[1];
    return static_cast<std::size_t>(at - p);
}

/// Function 2Bh/0Eh: as many objects as the buffer holds. Returns 0, or an exception.
template <class Objects>
[[gnu::noinline]] constexpr unsigned identify(std::uint8_t* p, std::size_t room, std::size_t size) {
    if (size < 2) return 3;
    if (p[1] != modbus::mei_identification) return 1;
    const unsigned kind = p[2], from = p[3];
    if (size != 4 || kind - 1 > 3) return 3;
    const bool is_single = kind == 4;
    const unsigned last = kind == 1 ? 0x02 : kind == 2 ? 0x7F : 0xFF;
    const identity* object = Objects::begin();
    const identity* const end = object + Objects::count;
    while (object != end && object->id < from) ++object;
    if (object == end || object->id != from || object->id > last) { // an unknown one
        if (is_single) return 2;
        object = Objects::begin(); // the standard: begins again
    }
    constexpr std::uint8_t highest = Objects::begin()[Objects::count - 1].id;
    p[3] = highest >= 0x80 ? 0x83 : highest > 2 ? 0x82 : 0x81;
    p[4] = p[5] = p[6] = 0;
    std::uint8_t* at = p + identification_head;
    for (; object != end && object->id <= last; ++object) {
        if (static_cast<std::size_t>(at - p) + 2 + object->size > room) { // the rest in another response
            p[4] = 0xFF;
            p[5] = object->id;
            break;
        }
        *at++ = object->id;
        *at++ = object->size;
        at = put_text(at, object->text, object->size);
        ++p[6];
        if (is_single) break;
    }
    return 0;
}

/// Function 11h. Returns 0.
template <class Id> constexpr unsigned report(std::uint8_t* p) {
    constexpr std::uint8_t is_running = 0xFF;
    p[1] = static_cast<std::uint8_t>(Id::size + 1 + Id::additional_size);
    std::uint8_t* const indicator = put_text(p + 2, Id::text(), Id::size);
    *indicator = is_running;
    if constexpr (Id::additional_size != 0) put_text(indicator + 1, Id::additional(), Id::additional_size);
    return 0;
}

} // namespace servobus::detail
