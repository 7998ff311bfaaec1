// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "cpp_rows.hpp"

#include <cstdint>
#include <iterator>

#include <servobus/registers/row_value.hpp>

#include "../device_file/map_text.hpp"
#include "../words/numbers.hpp"
#include "cpp_names.hpp"

namespace tool::cpp {
namespace {

using servobus::entry;
using servobus::table;

// In the order of servobus::measure, whose enumerators and named units these are.
constexpr const char* unit_names[] = {"none",
                                      "r_per_min",
                                      "second",
                                      "millisecond",
                                      "nanosecond",
                                      "ampere",
                                      "milliampere",
                                      "milliampere_per_second",
                                      "volt",
                                      "millivolt",
                                      "ohm",
                                      "watt",
                                      "kilohertz",
                                      "hertz",
                                      "percent",
                                      "times",
                                      "degree_celsius",
                                      "degree",
                                      "revolution",
                                      "pulse",
                                      "pulse_per_revolution",
                                      "reference_unit",
                                      "count",
                                      "microsecond",
                                      "micrometre",
                                      "millimetre",
                                      "metre",
                                      "micrometre_per_second",
                                      "millimetre_per_second",
                                      "metre_per_second",
                                      "microradian",
                                      "milliradian",
                                      "radian",
                                      "microradian_per_second",
                                      "milliradian_per_second",
                                      "radian_per_second",
                                      "minute",
                                      "hour",
                                      "kilowatt",
                                      "volt_ampere",
                                      "var",
                                      "watt_hour",
                                      "kilowatt_hour",
                                      "var_hour",
                                      "kilogram",
                                      "newton",
                                      "newton_metre",
                                      "pascals",
                                      "bar",
                                      "litre",
                                      "cubic_metre",
                                      "litre_per_minute",
                                      "cubic_metre_per_hour",
                                      "device_unit"};
static_assert(std::size(unit_names) == static_cast<unsigned>(servobus::measure::device_unit) + 1);

// From the lowest bit of servobus::flag on.
constexpr const char* flag_names[] = {
    "saved",      "saved_on_write", "when_stopped",      "when_running",  "trigger", "scaled_elsewhere",
    "immediate",  "at_stop",        "after_power_cycle", "communication", "motion",  "position_mode",
    "speed_mode", "torque_mode",    "every_mode",        "zero_by_name"};

std::string count_text(std::int64_t count) { return std::to_string(count); }

std::string unit_text(servobus::unit u) {
    const std::string name = unit_names[static_cast<unsigned>(u.of)];
    if (u == servobus::unit{}) return "servobus::no_unit";
    if (u.of != servobus::measure::none && u.numerator == 1) {
        const std::string plain = "servobus::units::" + name;
        return u.denominator == 1 ? plain : plain + " / " + std::to_string(u.denominator);
    }
    return "servobus::unit{servobus::measure::" + name + ", " + std::to_string(u.numerator) + ", " +
           std::to_string(u.denominator) + "}";
}

std::string flags_text(servobus::flag flags) {
    std::string all;
    for (unsigned bit = 0; bit < std::size(flag_names); ++bit) {
        if ((static_cast<unsigned>(flags) >> bit & 1u) == 0) continue;
        all += (all.empty() ? "servobus::" : " | servobus::") + std::string{flag_names[bit]};
    }
    return all;
}

std::string base_type(const entry& e) {
    const std::string words = '<' + std::to_string(e.words()) + '>';
    if (is_text(e)) return "servobus::text_of" + words;
    if (is_bcd(e)) return "servobus::bcd" + words;
    if (is_sign_and_magnitude(e)) return "servobus::sign_magnitude" + words;
    return std::string{"servobus::"} + text(e.kind);
}

std::string bits_text(const servobus::value_form& f) {
    if (f.bits == 8 && f.first_bit == 8) return "high_byte";
    if (f.bits == 8 && f.first_bit == 0) return "low_byte";
    return "bits<" + std::to_string(f.first_bit) + ", " + std::to_string(f.first_bit + f.bits - 1) + '>';
}

// The lowest number of 64 bits has no literal of its own.
std::string code_text(std::int64_t code) {
    return code == INT64_MIN ? std::to_string(code + 1) + " - 1" : std::to_string(code);
}

// The options of `with`, each with a comma before it.
std::string options_text(const entry& e, const std::string& scaled_by) {
    std::string all;
    const auto add = [&](const std::string& option) { all += ", servobus::" + option; };
    if (e.form != nullptr) {
        const servobus::value_form& f = *e.form;
        if (f.is_part()) add(bits_text(f));
        if (f.offset != 0) add("offset<" + std::to_string(f.offset) + '>');
        std::string codes;
        for (const std::int64_t code : f.none) codes += (codes.empty() ? "" : ", ") + code_text(code);
        if (!codes.empty()) add("or_none<" + codes + '>');
        if (f.scaled == servobus::scaling::exponent) add("ten_to<" + scaled_by + '>');
        if (f.scaled == servobus::scaling::factor) add("times_row<" + scaled_by + '>');
    }
    if (e.own_word_order == servobus::word_order::high_first) add("high_word_first");
    if (e.own_word_order == servobus::word_order::low_first) add("low_word_first");
    if (e.form != nullptr && e.form->is_low_byte_first) add("low_byte_first");
    return all;
}

// The type of a row's value. A word of two bytes has both axes.
std::string value_type(const entry& e, const std::string& scaled_by) {
    if (e.names == servobus::naming::halves && !e.limits.is_stated)
        return std::string{"servobus::left_right<std::"} + (e.is_signed() ? "int8_t>" : "uint8_t>");
    const std::string options = options_text(e, scaled_by);
    return options.empty() ? base_type(e) : "servobus::with<" + base_type(e) + options + ">";
}

std::string range_text(const entry& e, const std::string& type) {
    if (e.limits.is_stated) return "{" + count_text(e.limits.low) + ", " + count_text(e.limits.high) + "}";
    if (e.names == servobus::naming::halves) return "servobus::unstated";
    return "servobus::full<" + type + ">";
}

std::string default_text(const entry& e) {
    return e.initial == servobus::no_default ? "servobus::no_default" : count_text(e.initial);
}

} // namespace

bool has_form(const entry& e) { return !is_plain(e) || e.own_word_order != servobus::word_order::unknown; }

std::string row(const entry& e, table in, const std::string& name, const std::string& codes,
                const std::string& scaled_by) {
    const std::string flags = flags_text(e.flags);
    if (is_of_bits(in)) {
        const std::string type = in == table::coils ? std::string{"servobus::coil<servobus::access::"} +
                                                          text(e.rights) + ", device>"
                                                    : "servobus::discrete_input<device>";
        return type + ' ' + name + '{' + hex_word(e.address) + ", " + (e.initial == 1 ? "true" : "false") +
               (flags.empty() ? "" : ", " + flags) + '}';
    }
    // In the library the value of a signed register is a number, also if it is a code.
    const bool is_of_codes = !codes.empty() && !e.is_signed();
    const bool is_input = in == table::input_registers;
    const std::string type = value_type(e, scaled_by);
    const std::string data = hex_word(e.address) + ", " + range_text(e, type) + ", " +
                             unit_text(e.unit_of_count) + ", " + default_text(e) +
                             (flags.empty() ? "" : ", " + flags);
    return (is_input ? "input" : text(e.rights)) + ('<' + (is_of_codes ? codes : type)) + "> " + name + '{' +
           (is_input ? '{' + data + '}' : data) + '}';
}

std::string row_entry(const entry& e, table in, const std::string& row, const std::string& names) {
    constexpr const char* namings[] = {"number", "names", "halves"};
    const bool is_number = e.names == servobus::naming::number && names.empty();
    const std::string naming = std::string{", servobus::naming::"} + namings[static_cast<unsigned>(e.names)] +
                               (names.empty() ? "" : ", " + names);
    const std::string named = is_number ? "" : naming;
    const std::string name = literal(static_cast<const char*>(e.name));
    if (!is_of_bits(in)) return "servobus::list(" + name + ", " + row + named + ')';
    const std::string flags = flags_text(e.flags);
    return '{' + hex_word(e.address) + ", " + name +
           ", servobus::value_kind::unsigned_word, servobus::access::" + text(e.rights) + ", {" +
           count_text(e.limits.low) + ", " + count_text(e.limits.high) + ", " +
           (e.limits.is_stated ? "true" : "false") + "}, " + default_text(e) + ", servobus::no_unit, " +
           (flags.empty() ? "servobus::flag::none" : flags) + named + '}';
}

} // namespace tool::cpp
