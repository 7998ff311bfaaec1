// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "map_register.hpp"

#include <cstdio>

#include <servobus/registers/value_text.hpp>

#include "../device_file/map_text.hpp"
#include "../device_file/named_values.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

using servobus::access;
using servobus::entry;
using servobus::flag;

void print_line(const char* what, const std::string& said) {
    if (!said.empty()) std::printf("%-10s %s\n", what, said.c_str());
}

void append(std::string& list, const char* between, const std::string& item) {
    list += list.empty() ? item : between + item;
}

std::string address_text(const device& of, const entry& e) {
    std::string text = hex_word(e.address);
    if (e.words() > 1)
        text += (e.words() == 2 ? " and " : " to ") + hex_word(static_cast<u16>(e.address + e.words() - 1));
    if (of.number != nullptr) {
        char parameter[8];
        (void)std::snprintf(parameter, sizeof parameter, "P%02X-%02u", (e.address >> 8u) & 0xFFu,
                            e.address & 0xFFu);
        text += std::string{" ("} + parameter + ")";
    }
    return text;
}

const char* access_text(access rights) {
    switch (rights) {
    case access::ro: return "read-only";
    case access::wo: return "write-only";
    case access::rw: break;
    }
    return "read and write";
}

std::string registers_text(const entry& e) {
    if (e.words() == 1) return is_text(e) ? ", one register" : "";
    return e.words() == 2 ? ", two registers" : ", " + std::to_string(e.words()) + " registers";
}

std::string count_text(std::int64_t count, servobus::unit u) {
    char room[64];
    servobus::text_writer text{room};
    servobus::put_count(text, count, u);
    return {room, text.size()};
}

// Counts from `low` to `high`, and what they are worth if that is another number: `0..300 (0..30 A)`.
std::string counts_text(const entry& e, std::int64_t low, std::int64_t high) {
    const auto text = [&](servobus::unit u) {
        return count_text(low, u) + (low == high ? "" : ".." + count_text(high, u));
    };
    const servobus::unit u = e.unit_of_count;
    const std::string symbol = e.unit_symbol();
    const std::string raw = text({});
    const std::string scaled = text(u) + (symbol.empty() ? "" : " " + symbol);
    return scale_text(u) == "1" ? scaled : raw + " (" + scaled + ")";
}

std::string range_text(const entry& e) {
    if (e.limits.is_stated) return counts_text(e, e.limits.low, e.limits.high);
    return e.rights == access::ro ? "" : "not stated";
}

std::string default_text(const entry& e) {
    if (e.initial == servobus::no_default) return e.rights == access::ro ? "" : "not stated";
    if (e.is_quantity() && !e.is_code(e.initial)) return counts_text(e, e.initial, e.initial);
    char room[512];
    servobus::text_writer text{room};
    servobus::put_row_value(text, e, bits_of_number(e, e.initial).bits);
    const std::string named{room, text.size()};
    const std::size_t end = named.rfind(" ("); // of a word without a name there is only the word
    return std::to_string(e.initial) + (end == named.npos ? "" : " (" + named.substr(0, end) + ")");
}

std::string unit_text(const entry& e) {
    const std::string scale = scale_text(e.unit_of_count);
    return (scale == "1" ? "" : scale + " ") + e.unit_symbol();
}

std::string written_text(const entry& e) {
    if (e.rights == access::ro) return {};
    if (has(e.flags, flag::when_stopped)) return "only while the motor is stopped";
    return has(e.flags, flag::when_running) ? "at any time" : "the manual does not say when";
}

std::string effective_text(const entry& e) {
    if (has(e.flags, flag::immediate)) return "at once";
    if (has(e.flags, flag::at_stop)) return "when the motor stops next";
    return has(e.flags, flag::after_power_cycle) ? "after the next power cycle" : "";
}

std::string saved_text(const entry& e) {
    if (has(e.flags, flag::saved_on_write)) return "by each write, which wears the EEPROM";
    return has(e.flags, flag::saved) ? "by a command of its own" : "";
}

std::string modes_text(const entry& e) {
    if (has(e.flags, flag::every_mode)) return "all";
    std::string modes;
    if (has(e.flags, flag::position_mode)) append(modes, ", ", "position");
    if (has(e.flags, flag::speed_mode)) append(modes, ", ", "speed");
    if (has(e.flags, flag::torque_mode)) append(modes, ", ", "torque");
    return modes;
}

std::string note_text(const device& of, const entry& e) {
    std::string notes;
    if (has(e.flags, flag::trigger)) append(notes, "; ", "acts when it is written");
    if (has(e.flags, flag::motion))
        append(notes, "; ",
               of.file != nullptr ? "a write moves the machine" : "a write moves an enabled motor");
    if (has(e.flags, flag::communication)) append(notes, "; ", "a setting of the line");
    if (has(e.flags, flag::scaled_elsewhere)) append(notes, "; ", "another register sets the scale");
    if (has(e.flags, flag::zero_by_name)) append(notes, "; ", "what 0 does is not documented");
    return notes;
}

// Prints the columns after `table`.
void print_form(const device& of, const entry& e) {
    if (e.form == nullptr) return;
    const servobus::value_form& f = *e.form;
    const unsigned last = f.first_bit + f.bits - 1u;
    if (f.is_part())
        print_line("bits", std::to_string(f.first_bit) + (f.bits == 1 ? "" : ".." + std::to_string(last)));
    if (f.is_low_byte_first) print_line("byte order", "the low byte first");
    if (f.offset != 0) print_line("offset", std::to_string(f.offset) + ", in counts");
    std::string none;
    for (const std::int64_t raw : f.none) append(none, ", ", std::to_string(raw));
    print_line("no value", none);
    if (const entry* const by = of.scaling_row(e))
        print_line("factor", (f.scaled == servobus::scaling::exponent ? "10^" : "") + std::string{by->name});
}

void print_values(const entry& e) {
    if (e.names == servobus::naming::halves) {
        print_line("values", "high byte: left");
        print_line("", "low byte: right");
    }
    const char* what = "values";
    for (const servobus::named_value& v : e.values) {
        print_line(what, code_text(e, v) + ": " + v.name);
        what = "";
    }
}

} // namespace

void print_register(const device& of, const chosen& what) {
    const entry& e = *what.row;
    std::printf("%s\n", static_cast<const char*>(e.name));
    const std::string_view sentence = of.sentence(e, what.form.table);
    if (!sentence.empty()) std::printf("%s\n", sentence.data());
    std::printf("\n");
    const bool is_holding = what.form.table == servobus::table::holding_registers;
    print_line("address", address_text(of, e));
    if (!is_holding) print_line("table", table_text(what.form.table));
    print_line("type", std::string{type_text(e, what.form.table)} + registers_text(e));
    print_form(of, e);
    print_line("access", access_text(e.rights));
    print_line("range", range_text(e));
    print_line("default", default_text(e));
    print_line("unit", unit_text(e));
    print_line("written", written_text(e));
    print_line("effective", effective_text(e));
    print_line("saved", saved_text(e));
    print_line("modes", modes_text(e));
    print_line("note", note_text(of, e));
    print_values(e);
}

} // namespace tool
