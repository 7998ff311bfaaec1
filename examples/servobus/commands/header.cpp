// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus header: a device as a C++ header, with its profile, its rows, and a catalogue for tools.
#include <algorithm>
#include <cstdio>
#include <map>

#include "../cpp/cpp_codes.hpp"
#include "../cpp/cpp_names.hpp"
#include "../cpp/cpp_profile.hpp"
#include "../cpp/cpp_rows.hpp"
#include "../device_file/map_text.hpp"
#include "../devices/devices.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace header_file {
namespace {

using servobus::entry;
using servobus::table;

// The names that each header has.
constexpr std::string_view own_names[] = {"catalogue",
                                          "device",
                                          "input",
                                          "names",
                                          "number_of",
                                          "ro",
                                          "rw",
                                          "servobus",
                                          "std",
                                          "wo",
                                          "coil_catalogue",
                                          "discrete_input_catalogue",
                                          "input_register_catalogue"};

// `0x0040`, `0x80000000`
std::string hex(std::uint32_t bits) {
    char text[16];
    (void)std::snprintf(text, sizeof text, "0x%04X", static_cast<unsigned>(bits));
    return text;
}

bool has_own_symbol(const entry& e) { return e.form != nullptr && e.form->symbol != nullptr; }

// The library needs a header for rows that are more than integers of one or two registers.
bool has_type_of_values(const entry& e) { return cpp::has_form(e) || (cpp::has_codes(e) && e.words() == 2); }

class header_text {
  public:
    explicit header_text(const device& of)
        : of_{&of}, space_{cpp::scope{"device_", own_names}.name(of.facts().name)} {
        // A row keeps its name where an enumeration could have it too.
        for (const table t : all_tables) {
            for (const entry& e : of.rows_of(t)) (void)row_name(e);
        }
    }

    std::string whole() {
        put_begin();
        put_device();
        for (const table t : all_tables) put_enumerations(t);
        for (const bool are_scaled : {false, true}) { // by rows that must stand before them
            for (const table t : all_tables) put_rows(t, are_scaled);
        }
        out_ += "\n// For tools.\nnamespace names {\n";
        for (const table t : all_tables) put_entries(t);
        out_ += "} // namespace names\n";
        for (const table t : all_tables) put_catalogue(t);
        out_ += "\n// clang-format on\n\n} // namespace " + space_ + '\n';
        return std::move(out_);
    }

  private:
    template <class Is> bool any_row(Is is) const {
        return std::ranges::any_of(all_tables,
                                   [&](table t) { return std::ranges::any_of(of_->rows_of(t), is); });
    }
    bool has_unit_of_meters() const {
        return any_row([](const entry& e) { return cpp::is_of_meters(e.unit_of_count); });
    }

    void put_begin() {
        out_ = "// " + std::string{of_->facts().name} + ": its registers, made by `servobus header`.\n" +
               "#pragma once\n\n#include <cstdint>\n\n#include <servobus/registers/catalogue.hpp>\n" +
               (any_row(has_own_symbol) ? "#include <servobus/registers/device_unit.hpp>\n" : "") +
               (has_unit_of_meters() ? "#include <servobus/registers/meter_units.hpp>\n" : "") +
               "#include <servobus/registers/tables.hpp>\n" +
               (any_row(has_type_of_values) ? "#include <servobus/registers/value_forms.hpp>\n" : "") +
               "\nnamespace " + space_ + " {\n";
    }

    void put_device() {
        out_ += '\n' + cpp::device_class(of_->facts()) + '\n';
        for (const char* const rights : {"ro", "rw", "wo"}) {
            out_ += std::string{"template <class T> using "} + rights +
                    " = servobus::reg<T, servobus::access::" + rights + ", device>;\n";
        }
        out_ += "template <class T> using input = servobus::input_reg<T, device>;\n\n// clang-format off\n";
    }

    std::string row_name(const entry& e) {
        std::string& word = row_names_[std::string{static_cast<const char*>(e.name)}];
        if (word.empty()) word = names_.name(static_cast<const char*>(e.name));
        return word;
    }

    // Rows with the same codes share an enumeration, under a name for each of them. All are in front of the rows, which
    // enumerators of the same name would shadow.
    void put_enumerations(table t) {
        if (is_of_bits(t)) return;
        for (const entry& e : of_->rows_of(t)) {
            if (!cpp::has_codes(e)) continue;
            const std::string name = names_.name(row_name(e) + "_code");
            const std::string codes = cpp::enumeration(e);
            out_ += "\n/// The codes of " + row_name(e) + ".\n";
            codes_[row_name(e)] = name;
            std::string& shared = enumerations_[codes];
            if (!shared.empty()) {
                out_ += "using " + name + " = " + shared + ";\n";
                continue;
            }
            shared = name;
            out_ += "enum class " + name + codes;
            if (!e.is_signed()) continue;
            const std::string number = std::string{"servobus::"} + text(e.kind);
            out_ += "constexpr " + number + " number_of(" + name + " code) { return static_cast<" + number +
                    ">(code); }\n";
        }
    }

    void put_rows(table t, bool are_scaled) {
        for (const entry& e : of_->rows_of(t)) {
            const entry* const by = of_->scaling_row(e);
            if ((by != nullptr) != are_scaled) continue;
            // A backslash at the end of a comment would take the next line into it.
            std::string sentence = of_->sentence(e, t);
            std::ranges::replace(sentence, '\\', '/');
            out_ += "\n/// " + hex_word(e.address).substr(2) + "h " + sentence;
            while (out_.ends_with(' ')) out_.pop_back();
            out_ += "\ninline constexpr " +
                    cpp::row(e, t, row_name(e), codes_[row_name(e)],
                             by != nullptr ? row_name(*by) : std::string{}) +
                    ";\n";
        }
    }

    // The array of the names of a row. Rows with the same names share one.
    std::string names_of_row(const entry& e) {
        if (e.values.empty()) return {};
        std::string values;
        for (const servobus::named_value& v : e.values) {
            values += "    {" + hex(v.mask) + ", " + hex(v.value) + ", " + cpp::literal(v.name) + "},\n";
        }
        std::string& array = arrays_[values];
        if (array.empty()) {
            array = row_name(e) + "_names";
            out_ += "inline constexpr servobus::named_value " + array + "[] = {\n" + values + "};\n";
        }
        return array;
    }

    // The symbol of a unit of the device's own is in an object beside the entry.
    std::string with_symbol(const entry& e, const std::string& listed) {
        if (!has_own_symbol(e)) return listed;
        const std::string form = row_name(e) + "_form";
        out_ += "inline constexpr servobus::value_form " + form + " = servobus::form_with_symbol(" + listed +
                ", " + cpp::literal(e.form->symbol) + ");\n";
        return "servobus::with_form(" + listed + ", " + form + ")";
    }

    void put_entries(table t) {
        const auto rows = of_->rows_of(t);
        if (rows.empty()) return;
        std::string lines;
        std::string descriptions;
        bool has_sentences = false;
        for (const entry& e : rows) {
            const std::string row = "::" + space_ + "::" + row_name(e);
            lines += "    " + with_symbol(e, cpp::row_entry(e, t, row, names_of_row(e))) + ",\n";
            const std::string_view sentence = of_->sentence(e, t);
            has_sentences = has_sentences || !sentence.empty();
            descriptions += "    {" + hex_word(e.address) + ", " + cpp::literal(sentence) + "},\n";
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
    cpp::scope names_{"row_", own_names};
    std::map<std::string, std::string> enumerations_{}; // their names, by what they have
    std::map<std::string, std::string> codes_{};        // their names, by those of the rows
    std::map<std::string, std::string> arrays_{};
    bool has_sentences_[4]{};
};

} // namespace
} // namespace header_file

// Returns the first row that is scaled by a row of a kind that the library does not scale by; null if there is none.
// The library scales by integers without a scale of their own.
static const servobus::entry* find_unusual_scale(const device& of) {
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            const servobus::entry* const by = of.scaling_row(e);
            if (by == nullptr) continue;
            const servobus::unit u = by->unit_of_count;
            const bool is_ratio = u == servobus::unit{} || u == servobus::unit{servobus::measure::times};
            const bool is_integer = by->kind <= servobus::value_kind::signed_pair;
            const bool is_enumeration = cpp::has_codes(*by) && !by->is_signed();
            if (!is_integer || is_enumeration || !is_ratio) return &e;
        }
    }
    return nullptr;
}

int header(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "header takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    if (const servobus::entry* const e = find_unusual_scale(*of)) {
        return complain(
            usage,
            of->word() + ": " + static_cast<const char*>(of->scaling_row(*e)->name) + " scales " +
                static_cast<const char*>(e->name) +
                "; in a header such a row is u16, i16, u32 or i32, without names and a scale of its own");
    }
    (void)std::fputs(header_file::header_text{*of}.whole().c_str(), stdout);
    return done;
}

} // namespace tool
