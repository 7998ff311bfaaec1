// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "map_text.hpp"

#include <cstdio>

#include <servobus/registers/format.hpp>
#include <servobus/registers/row_value.hpp>

#include "named_values.hpp"

namespace tool {
namespace {

using servobus::entry;
using servobus::flag;

std::string hex(unsigned number) {
    char text[16];
    (void)std::snprintf(text, sizeof text, "0x%04X", number);
    return text;
}

// A cell, in quotes if it needs them.
std::string cell(std::string_view text) {
    if (text.find_first_of(",\"") == text.npos) return std::string{text};
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"') quoted += c;
        quoted += c;
    }
    return quoted + '"';
}

const char* when_cell(const entry& e) {
    if (has(e.flags, flag::when_stopped)) return "stopped";
    return has(e.flags, flag::when_running) ? "running" : "";
}

const char* effective_cell(const entry& e) {
    if (has(e.flags, flag::immediate)) return "immediate";
    if (has(e.flags, flag::at_stop)) return "at_stop";
    return has(e.flags, flag::after_power_cycle) ? "power_cycle" : "";
}

std::string modes_cell(const entry& e) {
    if (has(e.flags, flag::every_mode)) return "ALL";
    std::string letters;
    if (has(e.flags, flag::position_mode)) letters += 'P';
    if (has(e.flags, flag::speed_mode)) letters += 'S';
    if (has(e.flags, flag::torque_mode)) letters += 'T';
    return letters;
}

std::string flags_cell(const entry& e) {
    std::string words;
    for (const flag_word& f : flag_words) {
        if (!has(e.flags, f.of)) continue;
        if (!words.empty()) words += ';';
        words += f.word;
    }
    return words;
}

// `3=enable` names a code, `b3=ready` a bit that is set, `0x00C0:0x0040=locked` the value 0x0040 of the bits 0x00C0.
std::string name_part(const entry& e, const servobus::named_value& v, servobus::table in) {
    const unsigned mask = v.mask;
    const bool is_one_bit = mask != 0 && (mask & (mask - 1)) == 0;
    std::string value;
    if (v.is_whole()) { // the words of function 05, and what is no number or has two contents, by their bits
        const bool is_number = !is_bcd(e) && !is_sign_and_magnitude(e) && (!is_of_bits(in) || v.value <= 1);
        value = is_number ? std::to_string(code_number(e, v.value)) : hex(v.value);
    } else if (is_one_bit && v.value == mask) {
        unsigned bit = 0;
        while ((mask >> bit & 1u) == 0) ++bit;
        value = 'b' + std::to_string(bit);
    } else {
        value = hex(mask) + ':' + hex(v.value);
    }
    return value + '=' + v.name;
}

std::string names_cell(const entry& e, servobus::table in) {
    if (e.names == servobus::naming::halves) return "halves";
    if (e.names == servobus::naming::names && e.values.empty()) return "hex";
    std::string all;
    for (const servobus::named_value& v : e.values) all += (all.empty() ? "" : ";") + name_part(e, v, in);
    return all;
}

const char* order_cell(const entry& e, const servobus::profile& of) {
    if (!has_word_order(e)) return "";
    const bool is_own = e.own_word_order != servobus::word_order::unknown;
    return is_own || of.word_order_register != 0 ? word_order_text(e.own_word_order) : "";
}

// The columns after `table`, each with a comma before it.
std::string form_cells(const entry& e, const char* scaled_by) {
    if (e.form == nullptr) return ",,,,,";
    const servobus::value_form& f = *e.form;
    const unsigned last = f.first_bit + f.bits - 1u;
    std::string cells = ",";
    if (f.is_part()) cells += std::to_string(f.first_bit) + (f.bits == 1 ? "" : ".." + std::to_string(last));
    cells += ',' + (f.offset == 0 ? "" : std::to_string(f.offset)) + ',';
    for (std::size_t i = 0; i < f.none.size(); ++i) cells += (i == 0 ? "" : ";") + std::to_string(f.none[i]);
    cells += ',';
    if (f.scaled != servobus::scaling::none)
        cells += (f.scaled == servobus::scaling::exponent ? "10^" : "") +
                 (scaled_by != nullptr ? std::string{scaled_by} : hex(f.scale_address));
    return cells + ',' + (f.is_low_byte_first ? "low" : "");
}

std::string milliseconds(servobus::duration d) {
    char room[32];
    servobus::text_writer text{room};
    const bool is_whole = d.us % 1000 == 0;
    text.scaled(is_whole ? d.us / 1000 : d.us, is_whole ? 0 : 3);
    return {room, text.size()};
}

void put_key(std::string& lines, const std::string& key, const std::string& value) {
    lines += "# " + key + " = " + value + '\n';
}
void put_key(std::string& lines, const char* key, unsigned long value) {
    put_key(lines, key, std::to_string(value));
}

} // namespace

const char* table_text(servobus::table of) {
    constexpr const char* names[] = {"coil", "discrete", "holding", "input"};
    return names[static_cast<unsigned>(of)];
}

const char* type_text(const servobus::entry& e, servobus::table t) {
    return is_of_bits(t) ? "bool" : text(e.kind);
}

const char* word_order_text(servobus::word_order order) {
    switch (order) {
    case servobus::word_order::high_first: return "high";
    case servobus::word_order::low_first: return "low";
    case servobus::word_order::unknown: break;
    }
    return "selectable";
}

std::string scale_text(servobus::unit u) {
    char room[64];
    servobus::text_writer text{room};
    servobus::put_count(text, 1, u);
    return {room, text.size()};
}

std::string map_header(bool is_long) {
    std::string line;
    for (const std::string_view name : map_columns) {
        if (name == "description" && !is_long) continue;
        if (!line.empty()) line += ',';
        line += name;
    }
    return line;
}

const char* scaling_name(const entry& e, std::span<const entry> rows) {
    if (e.form == nullptr || e.form->scaled == servobus::scaling::none) return nullptr;
    const entry* const by = servobus::catalogue{nullptr, rows}.find(e.form->scale_address);
    return by != nullptr && by->address == e.form->scale_address ? static_cast<const char*>(by->name)
                                                                 : nullptr;
}

std::string map_row(const entry& e, const servobus::profile& of, const char* sentence, servobus::table in,
                    const char* scaled_by) {
    const bool is_saved = has(e.flags, flag::saved) || has(e.flags, flag::saved_on_write);
    std::string row = hex(e.address) + ',' + static_cast<const char*>(e.name) + ',' +
                      std::to_string(e.words()) + ',' + type_text(e, in) + ',' + text(e.rights) + ',' +
                      (is_saved ? "yes" : "no") + ',' + when_cell(e) + ',' + effective_cell(e) + ',' +
                      modes_cell(e) + ',' + (e.limits.is_stated ? std::to_string(e.limits.low) : "") + ',' +
                      (e.limits.is_stated ? std::to_string(e.limits.high) : "") + ',' +
                      (e.initial != servobus::no_default ? std::to_string(e.initial) : "") + ',' +
                      scale_text(e.unit_of_count) + ',' + cell(e.unit_symbol());
    if (sentence != nullptr) {
        const std::string quoted = cell(sentence);
        row += quoted.starts_with('"') ? ',' + quoted : ",\"" + quoted + '"';
    }
    return row + ',' + flags_cell(e) + ',' + cell(names_cell(e, in)) + ',' + order_cell(e, of) + ',' +
           table_text(in) + form_cells(e, scaled_by);
}

std::string profile_lines(const servobus::profile& of) {
    std::string lines;
    put_key(lines, "file_format", map_format);
    put_key(lines, "name", of.name);
    put_key(lines, "lowest_address", of.lowest_address);
    put_key(lines, "highest_address", of.highest_address);
    put_key(lines, "baud", of.baud);
    put_key(lines, "character_format", text(of.format));
    put_key(lines, "word_order", word_order_text(of.word_order));
    if (of.word_order_register != 0) put_key(lines, "word_order_register", hex(of.word_order_register));
    if (of.eeprom_switch != 0) put_key(lines, "eeprom_switch", hex(of.eeprom_switch));
    put_key(lines, "max_read", of.max_read);
    put_key(lines, "max_write", of.max_write);
    put_key(lines, "response_ms", milliseconds(of.limits.response));
    put_key(lines, "turnaround_ms", milliseconds(of.limits.turnaround));
    put_key(lines, "gap_ms", milliseconds(of.gap));
    put_key(lines, "quarantine_ms", milliseconds(of.quarantine));
    put_key(lines, "read_retries", of.read_retries);
    put_key(lines, "leading_bytes", of.limits.leading_bytes);
    put_key(lines, "corrupted_request", of.limits.corrupted_request);
    put_key(lines, "acknowledge", of.limits.acknowledge);
    put_key(lines, "echoes_byte_count", of.limits.echoes_byte_count ? "yes" : "no");
    put_key(lines, "writes_blocks_only",
            std::string{names_of_block_writes[static_cast<unsigned>(of.writes_blocks_only)]});
    for (const servobus::exception_meaning& e : of.exceptions)
        put_key(lines, "exception_" + std::to_string(e.number), e.words);
    return lines;
}

} // namespace tool
