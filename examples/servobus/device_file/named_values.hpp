// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The codes and bits of a register with their names, as lists for people have them.
#pragma once

#include <cstdio>
#include <string>

#include <servobus/registers/row_value.hpp>

namespace tool {

/// Calls `use` with the row as if it had no offset and no raw values that mean none: codes are without these.
template <class Use> auto with_plain_number(servobus::entry e, Use use) {
    servobus::value_form plain = e.form != nullptr ? *e.form : servobus::value_form{};
    plain.offset = 0;
    plain.none = {};
    e.form = &plain;
    return use(e);
}
/// The number that a code is for the row's type.
inline std::int64_t code_number(const servobus::entry& e, std::uint32_t bits) {
    return with_plain_number(e, [&](const servobus::entry& plain) { return value_of(plain, bits).count(); });
}

// The manuals write command codes and alarms in hexadecimal, everything else as decimal numbers.
inline bool has_hexadecimal_codes(const servobus::entry& e) {
    if (is_two_complement(e)) return false;
    unsigned highest = 0;
    for (const servobus::named_value& v : e.values) highest = v.value > highest ? v.value : highest;
    return highest > (has(e.flags, servobus::flag::trigger) ? 0xFu : 0xFFu);
}

/// Returns the code or the bits of `v` in a word of `e`: `2`, `0x08`, `bit 3`, `bits 0x0300 = 0x0100`.
inline std::string code_text(const servobus::entry& e, const servobus::named_value& v) {
    const unsigned mask = v.mask;
    const unsigned value = v.value;
    const bool is_one_bit = mask != 0 && (mask & (mask - 1)) == 0;
    char text[32];
    if (v.is_whole() && has_hexadecimal_codes(e)) {
        (void)std::snprintf(text, sizeof text, "0x%02X", value);
    } else if (v.is_whole()) {
        (void)std::snprintf(text, sizeof text, "%lld", static_cast<long long>(code_number(e, value)));
    } else if (is_one_bit && value == mask) {
        unsigned bit = 0;
        while ((mask >> bit & 1u) == 0) ++bit;
        (void)std::snprintf(text, sizeof text, "bit %u", bit);
    } else {
        (void)std::snprintf(text, sizeof text, "bits 0x%04X = 0x%04X", mask, value);
    }
    return text;
}

} // namespace tool
