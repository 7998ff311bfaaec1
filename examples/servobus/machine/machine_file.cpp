// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "machine_file.hpp"

#include <algorithm>

#include "../devices/devices.hpp"
#include "../words/line_settings.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

constexpr std::string_view machine_magic = "servobus-machine";
constexpr std::int64_t machine_format = 1;
constexpr std::size_t longest_section_name = 32;

// The next word of a line, which loses it.
std::string_view take_word(std::string_view& line) {
    line = csv::trimmed(line);
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view word = line.substr(0, end);
    line = csv::trimmed(line.substr(end));
    return word;
}

bool is_plain_ascii(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

bool is_section_name(std::string_view name) {
    constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    return !name.empty() && name.size() <= longest_section_name &&
           name.find_first_not_of(allowed) == name.npos;
}

// What a line may not set, and why; empty for a parameter.
std::string no_parameter(const servobus::entry& e) {
    if (e.rights == servobus::access::wo) return "it is write-only, so nothing can be compared";
    if (has(e.flags, servobus::flag::motion)) return "it moves the machine";
    if (has(e.flags, servobus::flag::trigger)) return "it acts as it is written";
    return {};
}

// A decimal number times 1000 to the power of `thousands`, -1, 0 or 1: `2.5` is `2500.` or `.0025`.
std::string shifted(std::string_view number, int thousands) {
    const std::size_t sign = number.starts_with('-') || number.starts_with('+') ? 1 : 0;
    const std::size_t point = std::min(number.find('.'), number.size());
    std::string whole{number.substr(sign, point - sign)};
    std::string rest{number.substr(std::min(point + 1, number.size()))};
    for (int i = 0; i < 3 && thousands != 0; ++i) {
        if (thousands > 0) {
            whole += rest.empty() ? '0' : rest.front();
            rest.erase(0, rest.empty() ? 0 : 1);
        } else {
            rest.insert(rest.begin(), whole.empty() ? '0' : whole.back());
            if (!whole.empty()) whole.pop_back();
        }
    }
    const std::string shown = std::string{number.substr(0, sign)} + (whole.empty() ? "0" : whole);
    return rest.empty() ? shown : shown + '.' + rest;
}

// `3.0 A` without its unit: 3000 of a register in mA. Sets `why` if it is another kind of unit.
std::string without_unit(const servobus::entry& e, std::string_view value, std::string& why) {
    const std::size_t blank = value.find_first_of(" \t");
    const std::string_view number = value.substr(0, blank);
    if (blank == value.npos) return std::string{number};
    const std::string unit{csv::trimmed(value.substr(blank))};
    const bool is_raw = has(e.flags, servobus::flag::scaled_elsewhere);
    const std::string own = is_raw ? "" : e.unit_symbol();
    if (unit == own) return std::string{number};
    const bool is_decimal = number.find_first_not_of("+-.0123456789") == number.npos;
    if (is_decimal && !own.empty() && own == 'm' + unit) return shifted(number, 1);
    if (is_decimal && !own.empty() && unit == 'm' + own) return shifted(number, -1);
    why = std::string{e.name} + (own.empty() ? " has no unit" : " is in " + own) + ", not in " +
          csv::shown(unit);
    return {};
}

} // namespace

std::vector<parameter> machine_section::parameters(bool is_required) const {
    std::vector<parameter> all;
    for (const machine_line& l : lines) {
        if (l.is_required == is_required) all.push_back({l.row, l.words, {}});
    }
    return all;
}

const machine_section* machine_file::find(std::string_view name) const {
    const auto at = std::ranges::find(sections_, name, &machine_section::name);
    return at != sections_.end() ? &*at : nullptr;
}

std::string machine_file::parse(std::string_view path, std::string_view text) {
    const std::size_t folder = path.find_last_of("/\\");
    folder_ = folder == path.npos ? std::string_view{} : path.substr(0, folder + 1);
    lines_ = csv::lines{text};
    bool has_begun = false;
    const auto at_line = [&](const std::string& why) {
        return std::to_string(std::max<std::size_t>(lines_.number(), 1)) + ": " + why;
    };
    while (!lines_.is_at_end()) {
        std::string_view line = lines_.next();
        line = csv::without_remark(line);
        if (line.empty()) continue;
        const std::string why = !is_plain_ascii(line)   ? csv::shown(line) + " is no ASCII text"
                                : !has_begun            ? take_first_line(line)
                                : line.starts_with('[') ? take_section(line)
                                                        : take_setting(line);
        if (!why.empty()) return at_line(why);
        has_begun = true;
    }
    if (!has_begun)
        return at_line("the file is empty; it begins with " + std::string{machine_magic} + " format=1");
    if (sections_.empty()) return at_line("there is no drive, such as [lift] device=yako-closed-loop node=2");
    return {};
}

std::string machine_file::take_first_line(std::string_view line) const {
    if (take_word(line) != machine_magic)
        return "it is no machine file: the first line is " + std::string{machine_magic} + " format=1";
    constexpr std::string_view key = "format=";
    const std::string_view shown = line.starts_with(key) ? line.substr(key.size()) : std::string_view{};
    const std::optional<std::int64_t> number = parse_integer(shown);
    if (number == machine_format) return {};
    if (number && *number > machine_format)
        return "format " + csv::shown(shown) + " is of a later version of this tool, which reads 1";
    return "the first line says format=1, not " + csv::shown(line);
}

// [name] device=WORD node=N baud=N character_format=8N1
std::string machine_file::take_section(std::string_view line) {
    const std::size_t end = line.find(']');
    const std::string_view name = line.substr(1, end == line.npos ? line.npos : end - 1);
    if (end == line.npos || !is_section_name(name))
        return "a drive's line begins with its name in brackets: letters, digits, '_' and '-', at most " +
               std::to_string(longest_section_name);
    if (const machine_section* const same = find(name))
        return "[" + std::string{name} + "] is there twice, first in line " + std::to_string(same->line);
    machine_section added;
    added.name = name;
    added.line = lines_.number();
    std::vector<std::string_view> given;
    line.remove_prefix(end + 1);
    while (!csv::trimmed(line).empty()) {
        const std::string_view word = take_word(line);
        const std::size_t equals = word.find('=');
        const std::string_view key = word.substr(0, equals);
        if (std::ranges::find(given, key) != given.end()) return csv::shown(key) + " is given twice";
        // The device first, since the others are its.
        if (given.empty() && key != "device") return "device= comes first, behind the name in brackets";
        given.push_back(key);
        std::string why = take_key(added, key, equals == word.npos ? "" : word.substr(equals + 1));
        if (!why.empty()) return why;
    }
    if (added.kind == nullptr) return "device= is missing, such as device=zlac8015d";
    if (std::ranges::find(given, "node") == given.end())
        return "node= is missing, the drive's address on the line";
    for (const machine_section& other : sections_) {
        if (other.node == added.node)
            return "node " + std::to_string(added.node) + " is that of [" + other.name + "] in line " +
                   std::to_string(other.line);
        if (other.baud != added.baud || other.format != added.format)
            return "it has " + std::to_string(added.baud) + " baud, " + text(added.format) + ", and [" +
                   other.name + "] in line " + std::to_string(other.line) + " has " +
                   std::to_string(other.baud) + ", " + text(other.format) +
                   ": drives of one line share them; say baud= and character_format=";
    }
    sections_.push_back(std::move(added));
    return {};
}

std::string machine_file::take_key(machine_section& to, std::string_view key, std::string_view value) {
    if (key == "device") {
        const bool is_file = value.find('/') != value.npos || value.find(".csv") != value.npos;
        const bool is_relative = is_file && !value.starts_with('/') && value.find(':') == value.npos;
        std::string why;
        to.kind = find_device((is_relative ? folder_ : std::string{}) + std::string{value}, why);
        if (to.kind == nullptr) return why;
        to.baud = to.kind->facts().baud;
        to.format = to.kind->facts().format;
        return {};
    }
    const std::optional<std::int64_t> number = parse_integer(value);
    const servobus::profile& facts = to.kind->facts();
    if (key == "node") {
        if (!number || *number < facts.lowest_address || *number > facts.highest_address)
            return "node takes " + std::to_string(facts.lowest_address) + " to " +
                   std::to_string(facts.highest_address) + " for a " + facts.name + ", not " +
                   csv::shown(value);
        to.node = static_cast<std::uint8_t>(*number);
        return {};
    }
    if (key == "baud") {
        if (!number || *number < lowest_baud || *number > highest_baud)
            return "baud takes " + std::to_string(lowest_baud) + " to " + std::to_string(highest_baud) +
                   ", not " + csv::shown(value);
        to.baud = static_cast<std::uint32_t>(*number);
        to.says_rate = true;
        return {};
    }
    if (key == "character_format") {
        const std::optional<servobus::character_format> parsed = parse_format(value);
        if (!parsed)
            return std::string{"character_format takes "} + formats_taken + ", not " + csv::shown(value);
        to.format = *parsed;
        to.says_rate = true;
        return {};
    }
    constexpr std::string_view known[] = {"device", "node", "baud", "character_format"};
    return "unknown word " + csv::shown(key) +
           did_you_mean(key, known, "; a drive's line has device=, node=, baud= and character_format=");
}

// [require] REG=VALUE
std::string machine_file::take_setting(std::string_view line) {
    if (sections_.empty())
        return csv::shown(line) + " is before any drive, such as [lift] device=yako-closed-loop node=2";
    machine_section& in = sections_.back();
    machine_line added{nullptr, {}, lines_.number(), false};
    std::string_view rest = line;
    if (take_word(rest) == "require") {
        added.is_required = true;
        line = rest;
    }
    const std::size_t equals = line.find('=');
    if (equals == line.npos) return csv::shown(line) + " is no REG=VALUE";
    const std::string_view name = csv::trimmed(line.substr(0, equals));
    std::vector<std::string_view> known;
    for (const servobus::entry& e : in.kind->map->entries) {
        known.emplace_back(static_cast<const char*>(e.name));
        if (known.back() == name) added.row = &e;
    }
    if (added.row == nullptr)
        return in.kind->word() + " has no register " + csv::shown(name) +
               did_you_mean(name, known, "; servobus map " + in.kind->word() + " lists them");
    if (const std::string why = no_parameter(*added.row); !why.empty())
        return std::string{name} + " is no parameter: " + why;
    const bool is_read_only = added.row->rights == servobus::access::ro;
    if (is_read_only && !added.is_required)
        return std::string{name} + " is read-only; 'require' in front of it compares it";
    servobus::entry readable = *added.row;
    if (is_read_only) readable.rights = servobus::access::rw; // it is compared only
    const std::string_view value = csv::trimmed(line.substr(equals + 1));
    std::vector<u16> words;
    std::string why = read_value(readable, false, value, words); // a name may have a blank: 9600 Bd
    const bool has_unit =
        value.find_first_of(" \t") != value.npos && readable.names == servobus::naming::number;
    if (!why.empty() && has_unit) {
        why.clear();
        const std::string number = without_unit(readable, value, why);
        if (why.empty()) why = read_value(readable, false, number, words);
    }
    if (!why.empty()) return why;
    added.words = words;
    if (why = contradiction(in, added); !why.empty()) return why;
    in.lines.push_back(added);
    return {};
}

// What another line, or the drive's, says otherwise.
std::string machine_file::contradiction(const machine_section& in, const machine_line& added) const {
    const std::string name{added.row->name};
    for (const machine_line& other : in.lines) {
        if (other.row == added.row)
            return name + " is there twice, first in line " + std::to_string(other.line);
        const bool is_taken = in.kind->excludes != nullptr && number_of(*added.row, added.words) != 0 &&
                              added.words == other.words &&
                              in.kind->excludes(added.row->address, other.row->address);
        if (is_taken)
            return name + " and " + std::string{other.row->name} + " in line " + std::to_string(other.line) +
                   " cannot have the same function";
    }
    const std::int64_t number = is_text(*added.row) ? 0 : number_of(*added.row, added.words);
    if (added.row->address == in.kind->node_register && number != in.node)
        return name + "=" + std::to_string(number) +
               ", but the drive's line has node=" + std::to_string(in.node) +
               ", its address on the finished machine";
    if (in.kind->on_line == nullptr) return {};
    for (const servobus::rate_choice& r : in.kind->on_line->rates) {
        const bool is_this = in.kind->on_line->rate_register == added.row->address && r.code == number;
        if (is_this && r.baud != in.baud)
            return name + " is " + std::to_string(r.baud) + " baud, but the drive's line has " +
                   std::to_string(in.baud);
    }
    for (const servobus::format_choice& f : in.kind->on_line->formats) {
        const bool is_this = in.kind->on_line->format_register == added.row->address && f.code == number;
        if (is_this && f.format != in.format)
            return name + " is " + text(f.format) + ", but the drive's line has " + text(in.format);
    }
    return {};
}

} // namespace tool
