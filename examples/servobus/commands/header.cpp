// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus header: a device as a C++ header, with its profile, its rows, and a catalogue for tools.
#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "../text/map_text.hpp"
#include "../tool.hpp"

namespace tool {
namespace header_file {
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
                                      "radian_per_second"};
static_assert(std::size(unit_names) == static_cast<unsigned>(servobus::measure::radian_per_second) + 1);

// From the lowest bit of servobus::flag on.
constexpr const char* flag_names[] = {
    "saved",      "saved_on_write", "when_stopped",      "when_running",  "trigger", "scaled_elsewhere",
    "immediate",  "at_stop",        "after_power_cycle", "communication", "motion",  "position_mode",
    "speed_mode", "torque_mode",    "every_mode",        "zero_by_name"};

// Words that are no names: keywords, macros, and the names that each header has.
constexpr std::string_view taken_words[] = {"alignas",
                                            "alignof",
                                            "and",
                                            "and_eq",
                                            "asm",
                                            "assert",
                                            "auto",
                                            "bitand",
                                            "bitor",
                                            "bool",
                                            "break",
                                            "case",
                                            "catalogue",
                                            "catch",
                                            "char",
                                            "char16_t",
                                            "char32_t",
                                            "char8_t",
                                            "class",
                                            "co_await",
                                            "co_return",
                                            "co_yield",
                                            "compl",
                                            "concept",
                                            "const",
                                            "const_cast",
                                            "consteval",
                                            "constexpr",
                                            "constinit",
                                            "continue",
                                            "decltype",
                                            "default",
                                            "delete",
                                            "device",
                                            "do",
                                            "double",
                                            "dynamic_cast",
                                            "else",
                                            "enum",
                                            "EOF",
                                            "errno",
                                            "explicit",
                                            "export",
                                            "extern",
                                            "false",
                                            "float",
                                            "for",
                                            "friend",
                                            "goto",
                                            "if",
                                            "inline",
                                            "input",
                                            "int",
                                            "linux",
                                            "long",
                                            "mutable",
                                            "names",
                                            "namespace",
                                            "new",
                                            "noexcept",
                                            "not",
                                            "not_eq",
                                            "NULL",
                                            "nullptr",
                                            "operator",
                                            "or",
                                            "or_eq",
                                            "private",
                                            "protected",
                                            "public",
                                            "register",
                                            "reinterpret_cast",
                                            "requires",
                                            "return",
                                            "ro",
                                            "rw",
                                            "servobus",
                                            "short",
                                            "signed",
                                            "sizeof",
                                            "static",
                                            "static_assert",
                                            "static_cast",
                                            "std",
                                            "stderr",
                                            "stdin",
                                            "stdout",
                                            "struct",
                                            "switch",
                                            "template",
                                            "this",
                                            "thread_local",
                                            "throw",
                                            "true",
                                            "try",
                                            "typedef",
                                            "typeid",
                                            "typename",
                                            "union",
                                            "unix",
                                            "unsigned",
                                            "using",
                                            "virtual",
                                            "void",
                                            "volatile",
                                            "wchar_t",
                                            "while",
                                            "wo",
                                            "xor",
                                            "xor_eq",
                                            "coil_catalogue",
                                            "discrete_input_catalogue",
                                            "input_register_catalogue"};

std::string identifier(std::string_view name) {
    std::string word{name};
    for (char& c : word) {
        const bool is_good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        if (!is_good) c = '_';
    }
    if (word[0] >= '0' && word[0] <= '9') word.insert(0, "device_");
    if (std::ranges::find(taken_words, std::string_view{word}) != std::end(taken_words)) word += '_';
    return word;
}

std::string literal(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

std::string count_text(std::int64_t count) { return std::to_string(count); }

std::string duration_text(servobus::duration d) {
    if (d.us % 1000 == 0) return "servobus::milliseconds(" + std::to_string(d.us / 1000) + ")";
    return "servobus::duration{" + std::to_string(d.us) + "}";
}

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

// The type of a row's value. A word of two bytes has both axes.
std::string value_type(const entry& e) {
    if (e.names == servobus::naming::halves && !e.limits.is_stated)
        return std::string{"servobus::left_right<std::"} + (e.is_signed() ? "int8_t>" : "uint8_t>");
    return std::string{"servobus::"} + text(e.kind);
}

std::string range_text(const entry& e) {
    if (e.limits.is_stated) return "{" + count_text(e.limits.low) + ", " + count_text(e.limits.high) + "}";
    if (e.names == servobus::naming::halves) return "servobus::unstated";
    return "servobus::full<" + value_type(e) + ">";
}

std::string default_text(const entry& e) {
    return e.initial == servobus::no_default ? "servobus::no_default" : count_text(e.initial);
}

class header_text {
  public:
    header_text(const device& of) : of_{&of}, space_{identifier(of.facts().name)} {}

    std::string whole() {
        put_begin();
        put_device();
        for (const table t : all_tables) put_rows(t);
        out_ += "\n// For tools.\nnamespace names {\n";
        for (const table t : all_tables) put_entries(t);
        out_ += "} // namespace names\n";
        for (const table t : all_tables) put_catalogue(t);
        out_ += "\n// clang-format on\n\n} // namespace " + space_ + '\n';
        return std::move(out_);
    }

  private:
    void put_begin() {
        out_ = "// " + std::string{of_->facts().name} + ": its registers, made by `servobus header`.\n" +
               "#pragma once\n\n#include <cstdint>\n\n#include <servobus/registers/catalogue.hpp>\n" +
               "#include <servobus/registers/tables.hpp>\n\nnamespace " + space_ + " {\n";
    }

    void put_device() {
        const servobus::profile& facts = of_->facts();
        const servobus::profile usual{.name = ""};
        const std::string inside = "\n                                             ";
        std::string all = ".name = " + literal(facts.name);
        const auto put = [&](bool is_usual, const std::string& text) {
            if (!is_usual) all += "," + inside + text;
        };
        const auto number = [&](const char* name, unsigned long value, unsigned long usual_value) {
            put(value == usual_value, std::string{name} + " = " + std::to_string(value));
        };
        number(".max_read", facts.max_read, usual.max_read);
        number(".max_write", facts.max_write, usual.max_write);
        number(".lowest_address", facts.lowest_address, usual.lowest_address);
        number(".highest_address", facts.highest_address, usual.highest_address);
        put(facts.word_order == usual.word_order,
            std::string{".word_order = servobus::word_order::"} +
                (facts.word_order == servobus::word_order::unknown ? "unknown" : "low_first"));
        put(facts.word_order_register == 0, ".word_order_register = " + hex_word(facts.word_order_register));
        put(facts.eeprom_switch == 0, ".eeprom_switch = " + hex_word(facts.eeprom_switch));
        number(".baud", facts.baud, usual.baud);
        constexpr const char* formats[] = {"n81", "n82", "e81", "o81"};
        put(facts.format == usual.format, std::string{".format = servobus::character_format::"} +
                                              formats[static_cast<unsigned>(facts.format)]);
        const std::string limits = limits_text(facts.limits);
        put(limits.empty(), ".limits = {" + limits + "}");
        put(facts.quarantine.us == usual.quarantine.us, ".quarantine = " + duration_text(facts.quarantine));
        put(facts.gap.us == usual.gap.us, ".gap = " + duration_text(facts.gap));
        number(".read_retries", facts.read_retries, usual.read_retries);
        const bool has_exceptions = facts.exceptions.begin() != facts.exceptions.end();
        put(!has_exceptions, ".exceptions = exceptions");
        out_ += "\nstruct device {\n";
        if (has_exceptions) {
            out_ += "    static constexpr servobus::exception_meaning exceptions[] = {\n";
            for (const servobus::exception_meaning& e : facts.exceptions)
                out_ += "        {" + std::to_string(e.number) + ", " + literal(e.words) + "},\n";
            out_ += "    };\n";
        }
        out_ += "    static constexpr servobus::profile facts{" + all + "};\n};\n\n";
        for (const char* const rights : {"ro", "rw", "wo"}) {
            out_ += std::string{"template <class T> using "} + rights +
                    " = servobus::reg<T, servobus::access::" + rights + ", device>;\n";
        }
        out_ += "template <class T> using input = servobus::input_reg<T, device>;\n\n// clang-format off\n";
    }

    static std::string limits_text(const servobus::response_limits& limits) {
        const servobus::response_limits usual{};
        std::string all;
        const auto put = [&](bool is_usual, const std::string& text) {
            if (!is_usual) all += (all.empty() ? "" : ", ") + text;
        };
        put(limits.response.us == usual.response.us, ".response = " + duration_text(limits.response));
        put(limits.turnaround.us == usual.turnaround.us, ".turnaround = " + duration_text(limits.turnaround));
        put(limits.leading_bytes == usual.leading_bytes,
            ".leading_bytes = " + std::to_string(limits.leading_bytes));
        put(limits.corrupted_request == usual.corrupted_request,
            ".corrupted_request = " + std::to_string(limits.corrupted_request));
        put(limits.acknowledge == usual.acknowledge, ".acknowledge = " + std::to_string(limits.acknowledge));
        put(limits.echoes_byte_count == usual.echoes_byte_count, ".echoes_byte_count = true");
        return all;
    }

    // Rows of two names may have one identifier: `int` and `int_`.
    std::string row_name(const entry& e) {
        std::string& word = row_names_[std::string{static_cast<const char*>(e.name)}];
        if (!word.empty()) return word;
        word = identifier(static_cast<const char*>(e.name));
        while (!used_.insert(word).second) word += '_';
        return word;
    }

    void put_rows(table t) {
        for (const entry& e : of_->rows_of(t)) {
            // A backslash at the end of a comment would take the next line into it.
            std::string sentence = of_->sentence(e.address, t);
            std::ranges::replace(sentence, '\\', '/');
            out_ += "\n/// " + hex_word(e.address).substr(2) + "h " + sentence;
            while (out_.ends_with(' ')) out_.pop_back();
            out_ += "\ninline constexpr " + row_text(e, t) + ";\n";
        }
    }

    std::string row_text(const entry& e, table t) {
        const std::string flags = flags_text(e.flags);
        const std::string name = row_name(e);
        if (is_of_bits(t)) {
            const std::string type = t == table::coils ? std::string{"servobus::coil<servobus::access::"} +
                                                             text(e.rights) + ", device>"
                                                       : "servobus::discrete_input<device>";
            return type + ' ' + name + '{' + hex_word(e.address) + ", " +
                   (e.initial == 1 ? "true" : "false") + (flags.empty() ? "" : ", " + flags) + '}';
        }
        const bool is_input = t == table::input_registers;
        const std::string row = hex_word(e.address) + ", " + range_text(e) + ", " +
                                unit_text(e.unit_of_count) + ", " + default_text(e) +
                                (flags.empty() ? "" : ", " + flags);
        return (is_input ? "input" : text(e.rights)) + ('<' + value_type(e)) + "> " + name + '{' +
               (is_input ? '{' + row + '}' : row) + '}';
    }

    // The array of the names of a row. Rows with the same names share one.
    std::string names_of_row(const entry& e) {
        if (e.values.empty()) return {};
        std::string values;
        for (const servobus::named_value& v : e.values) {
            values += "    {" + hex_word(v.mask) + ", " + hex_word(v.value) + ", " + literal(v.name) + "},\n";
        }
        std::string& array = arrays_[values];
        if (array.empty()) {
            array = row_name(e) + "_names";
            out_ += "inline constexpr servobus::named_value " + array + "[] = {\n" + values + "};\n";
        }
        return array;
    }

    void put_entries(table t) {
        const auto rows = of_->rows_of(t);
        if (rows.empty()) return;
        std::string lines;
        std::string descriptions;
        bool has_sentences = false;
        for (const entry& e : rows) {
            const std::string array = names_of_row(e);
            constexpr const char* namings[] = {"number", "names", "halves"};
            const bool is_number = e.names == servobus::naming::number && array.empty();
            const std::string naming =
                std::string{"servobus::naming::"} + namings[static_cast<unsigned>(e.names)];
            const std::string names = is_number ? "" : ", " + naming + (array.empty() ? "" : ", " + array);
            const std::string name = literal(static_cast<const char*>(e.name));
            if (is_of_bits(t)) {
                const std::string flags = flags_text(e.flags);
                lines += "    {" + hex_word(e.address) + ", " + name +
                         ", servobus::value_kind::unsigned_word, servobus::access::" + text(e.rights) +
                         ", {" + count_text(e.limits.low) + ", " + count_text(e.limits.high) + ", " +
                         (e.limits.is_stated ? "true" : "false") + "}, " + default_text(e) +
                         ", servobus::no_unit, " + (flags.empty() ? "servobus::flag::none" : flags) + names +
                         "},\n";
            } else {
                lines += "    servobus::list(" + name + ", ::" + space_ + "::" + row_name(e) + names + "),\n";
            }
            const std::string_view sentence = of_->sentence(e.address, t);
            has_sentences = has_sentences || !sentence.empty();
            descriptions += "    {" + hex_word(e.address) + ", " + literal(sentence) + "},\n";
        }
        out_ += "inline constexpr servobus::entry " + catalogue_name(t) + "_entries[] = {\n" + lines + "};\n";
        if (!has_sentences) return;
        has_sentences_[static_cast<std::size_t>(t)] = true;
        out_ += "inline constexpr servobus::description " + catalogue_name(t) + "_descriptions[] = {\n" +
                descriptions + "};\n";
    }

    void put_catalogue(table t) {
        if (of_->rows_of(t).empty() && t != table::holding_registers) return;
        const std::string name = catalogue_name(t);
        const std::string entries = "names::" + name + "_entries";
        const std::string descriptions = "names::" + name + "_descriptions";
        const bool is_described = has_sentences_[static_cast<std::size_t>(t)];
        const bool is_empty = of_->rows_of(t).empty();
        out_ += '\n';
        if (!is_empty) out_ += "static_assert(servobus::is_in_order(" + entries + "));\n";
        if (is_described)
            out_ += "static_assert(servobus::is_described(" + entries + ", " + descriptions + "));\n";
        out_ += "inline constexpr servobus::catalogue " + name + "{&device::facts, " +
                (is_empty ? "{}" : entries) + (is_described ? ", " + descriptions : "") + "};\n";
    }

    static std::string catalogue_name(table t) {
        constexpr const char* names[] = {"coil_catalogue", "discrete_input_catalogue", "catalogue",
                                         "input_register_catalogue"};
        return names[static_cast<unsigned>(t)];
    }

    const device* of_;
    std::string space_;
    std::string out_{};
    std::map<std::string, std::string> row_names_{};
    std::set<std::string> used_{};
    std::map<std::string, std::string> arrays_{};
    bool has_sentences_[4]{};
};

// A client of the library has one word order for all pairs of a device.
const entry* find_own_word_order(const device& of) {
    for (const table t : all_tables) {
        for (const entry& e : of.rows_of(t)) {
            if (e.own_word_order != servobus::word_order::unknown &&
                e.own_word_order != of.facts().word_order)
                return &e;
        }
    }
    return nullptr;
}

} // namespace
} // namespace header_file

int header(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "header takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    if (const servobus::entry* e = header_file::find_own_word_order(*of)) {
        return complain(usage,
                        of->word() + ": " + static_cast<const char*>(e->name) +
                            " has a word order of its own; in a header all pairs of a device have one");
    }
    (void)std::fputs(header_file::header_text{*of}.whole().c_str(), stdout);
    return done;
}

} // namespace tool
