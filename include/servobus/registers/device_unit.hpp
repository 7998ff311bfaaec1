// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Entries of catalogues whose unit is the device's own, with its symbol. Headers that the tool makes include it.
//
//     constexpr entry row{7, "co2", value_kind::unsigned_word, access::ro, full<u16>, no_default,
//                         unit{measure::device_unit}, flag::none};
//     constexpr value_form co2_form = form_with_symbol(row, "ppm");
//     constexpr entry co2 = with_form(row, co2_form);
//     static_assert(co2.unit_symbol()[0] == 'p');
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/registers/catalogue.hpp>

namespace servobus {

/// The form of an entry whose unit is the device's own, `measure::device_unit`, with its symbol.
constexpr value_form form_with_symbol(const entry& e, const char* symbol) {
    value_form form = e.form != nullptr ? *e.form : value_form{};
    form.symbol = symbol;
    return form;
}
/// The entry with this form, which has static lifetime.
constexpr entry with_form(entry e, const value_form& form) {
    e.form = &form;
    return e;
}

} // namespace servobus
