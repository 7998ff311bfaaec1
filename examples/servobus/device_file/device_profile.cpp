// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_profile.hpp"

#include <algorithm>
#include <optional>

#include "../words/csv.hpp"
#include "../words/line_settings.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "map_text.hpp"

namespace tool {
namespace {

using servobus::profile;

constexpr std::size_t longest_name = servobus::label::longest;

// A key whose value is a whole number, or a time in ms with at most three decimals, which is kept in us.
struct number_key {
    std::string_view name;
    std::int64_t low;
    std::int64_t high;
    void (*set)(profile&, std::uint32_t);
    bool is_time = false;
};

constexpr number_key number_keys[] = {
    {"file_format", 1, map_format, [](profile&, std::uint32_t) {}},
    {"lowest_address", 1, 255,
     [](profile& p, std::uint32_t n) { p.lowest_address = static_cast<std::uint8_t>(n); }},
    {"highest_address", 1, 255,
     [](profile& p, std::uint32_t n) { p.highest_address = static_cast<std::uint8_t>(n); }},
    {"baud", lowest_baud, highest_baud, [](profile& p, std::uint32_t n) { p.baud = n; }},
    {"word_order_register", 1, 0xFFFF,
     [](profile& p, std::uint32_t n) { p.word_order_register = static_cast<std::uint16_t>(n); }},
    {"eeprom_switch", 1, 0xFFFF,
     [](profile& p, std::uint32_t n) { p.eeprom_switch = static_cast<std::uint16_t>(n); }},
    {"max_read", 1, 125, [](profile& p, std::uint32_t n) { p.max_read = static_cast<std::uint16_t>(n); }},
    {"max_write", 1, 123, [](profile& p, std::uint32_t n) { p.max_write = static_cast<std::uint16_t>(n); }},
    {"response_ms", 1, 60'000,
     [](profile& p, std::uint32_t n) { p.limits.response = servobus::milliseconds(n); }},
    {"turnaround_ms", 0, 60'000'000,
     [](profile& p, std::uint32_t n) { p.limits.turnaround = servobus::duration{n}; }, true},
    {"gap_ms", 0, 60'000'000, [](profile& p, std::uint32_t n) { p.gap = servobus::duration{n}; }, true},
    {"quarantine_ms", 0, 60'000'000,
     [](profile& p, std::uint32_t n) { p.quarantine = servobus::duration{n}; }, true},
    {"read_retries", 0, 100,
     [](profile& p, std::uint32_t n) { p.read_retries = static_cast<std::uint8_t>(n); }},
    {"leading_bytes", 0, 255,
     [](profile& p, std::uint32_t n) { p.limits.leading_bytes = static_cast<std::uint8_t>(n); }},
    {"corrupted_request", 0, 255,
     [](profile& p, std::uint32_t n) { p.limits.corrupted_request = static_cast<std::uint8_t>(n); }},
    {"acknowledge", 0, 255,
     [](profile& p, std::uint32_t n) { p.limits.acknowledge = static_cast<std::uint8_t>(n); }},
};

// Milliseconds as microseconds: 1.75 is 1750.
std::optional<std::int64_t> parse_time(std::string_view text) {
    const std::size_t point = std::min(text.find('.'), text.size());
    std::string digits{text.substr(0, point)};
    std::string_view decimals = text.substr(std::min(point + 1, text.size()));
    if (digits.empty() || digits.size() > 9 || decimals.size() > 3) return std::nullopt;
    if (point != text.size() && decimals.empty()) return std::nullopt;
    digits += decimals;
    digits.append(3 - decimals.size(), '0');
    if (digits.find_first_not_of("0123456789") != digits.npos) return std::nullopt;
    return parse_integer(digits);
}

std::string set_number(profile& facts, const number_key& key, std::string_view value) {
    const std::string name{key.name};
    const auto number = key.is_time ? parse_time(value) : parse_integer(value);
    if (key.name == "file_format" && number && *number > key.high)
        return "file_format " + csv::shown(value) + " is of a later version of this tool, which reads " +
               std::to_string(map_format);
    if (number && *number >= key.low && *number <= key.high) {
        key.set(facts, static_cast<std::uint32_t>(*number));
        return {};
    }
    const std::int64_t divisor = key.is_time ? 1000 : 1;
    return name + " takes " + (key.is_time ? "milliseconds" : "a whole number") + " from " +
           std::to_string(key.low / divisor) + " to " + std::to_string(key.high / divisor) + ", not " +
           csv::shown(value);
}

bool is_device_name(std::string_view name) {
    constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-";
    return !name.empty() && name.size() <= longest_name && name.find_first_not_of(allowed) == name.npos;
}

// The name of a file without its folder and its end, as the name of a device.
std::string device_name_of(std::string_view path) {
    const std::size_t folder = path.find_last_of("/\\:");
    if (folder != path.npos) path.remove_prefix(folder + 1);
    path = path.substr(0, path.find(".csv"));
    std::string name{path.substr(0, longest_name)};
    for (char& c : name) {
        if (!is_device_name(std::string_view{&c, 1})) c = '_';
    }
    return name.empty() ? "device" : name;
}

std::string unknown_key(std::string_view key) {
    std::vector<std::string_view> known{
        "name",        "word_order",        "byte_order", "character_format", "echoes_byte_count",
        "exception_1", "writes_blocks_only"};
    for (const number_key& k : number_keys) known.push_back(k.name);
    return "unknown key " + csv::shown(key) +
           did_you_mean(key, known, "; a line that begins with ## is a comment") + later_version;
}

} // namespace

std::string owned_profile::take(std::string_view line) {
    const std::size_t equals = line.find('=');
    const std::string key{csv::trimmed(line.substr(0, equals))};
    if (equals == line.npos)
        return "'#' and no key = value: " + csv::shown(line) + "; a line that begins with ## is a comment";
    const std::string_view value = csv::trimmed(line.substr(equals + 1));
    const auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
    if (!std::ranges::all_of(value, is_plain)) return "the value of " + csv::shown(key) + " is no ASCII text";
    std::string why = set(key, value);
    if (!why.empty()) return why;
    if (given_.emplace(key, value).second) return {};
    return csv::shown(key) + " is given twice";
}

std::string owned_profile::set(const std::string& key, std::string_view value) {
    for (const number_key& k : number_keys) {
        if (key == k.name) return set_number(facts_, k, value);
    }
    if (key == "name") {
        if (!is_device_name(value))
            return "name takes letters, digits, '_', '.' and '-', at most " + std::to_string(longest_name) +
                   ", not " + csv::shown(value);
        name_ = value;
        return {};
    }
    if (key == "word_order") {
        using enum servobus::word_order;
        for (const auto order : {high_first, low_first, unknown}) {
            if (value != word_order_text(order)) continue;
            facts_.word_order = order;
            return {};
        }
        return "word_order takes high, low or selectable, not " + csv::shown(value);
    }
    if (key == "character_format") {
        const std::optional<servobus::character_format> format = parse_format(value);
        if (!format)
            return std::string{"character_format takes "} + formats_taken + ", not " + csv::shown(value);
        facts_.format = *format;
        return {};
    }
    if (key == "byte_order") {
        is_low_byte_first_ = value == "low";
        return value == "low" || value == "high" ? ""
                                                 : "byte_order takes high or low, not " + csv::shown(value);
    }
    if (key == "echoes_byte_count") return set_yes_or_no(key, value, facts_.limits.echoes_byte_count);
    if (key == "writes_blocks_only") return set_block_writes(value);
    constexpr std::string_view exception = "exception_";
    if (key.starts_with(exception))
        return set_exception(std::string_view{key}.substr(exception.size()), value);
    return unknown_key(key);
}

std::string owned_profile::set_yes_or_no(const std::string& key, std::string_view value, bool& fact) {
    fact = value == "yes";
    return value == "yes" || value == "no" ? "" : key + " takes yes or no, not " + csv::shown(value);
}

std::string owned_profile::set_block_writes(std::string_view value) {
    for (unsigned i = 0; i < std::size(names_of_block_writes); ++i) {
        if (value != names_of_block_writes[i]) continue;
        facts_.writes_blocks_only = static_cast<servobus::block_writes>(i);
        return {};
    }
    return "writes_blocks_only takes yes, registers, coils or no, not " + csv::shown(value);
}

std::string owned_profile::set_exception(std::string_view number, std::string_view words) {
    const std::optional<std::int64_t> parsed = parse_integer(number);
    if (!parsed || *parsed < 1 || *parsed > 255 || std::to_string(*parsed) != number)
        return csv::shown("exception_" + std::string{number}) + " is none of exception_1 to exception_255";
    if (words.empty() || words.size() > 80)
        return "exception_" + std::string{number} + " takes its meaning in 1 to 80 characters";
    words_.emplace_back(words);
    exceptions_.push_back({static_cast<std::uint8_t>(*parsed), words_.back().c_str()});
    return {};
}

std::string owned_profile::finish(std::string_view name_of_file, std::string& key) {
    if (name_.empty()) name_ = device_name_of(name_of_file);
    facts_.name = name_.c_str();
    facts_.exceptions =
        exceptions_.empty()
            ? servobus::exception_table{servobus::standard_exceptions}
            : servobus::exception_table{exceptions_.data(), exceptions_.data() + exceptions_.size()};
    if (facts_.lowest_address > facts_.highest_address) {
        key = given_.contains("lowest_address") ? "lowest_address" : "highest_address";
        return "lowest_address " + std::to_string(facts_.lowest_address) + " is above highest_address " +
               std::to_string(facts_.highest_address);
    }
    const bool is_selectable = facts_.word_order == servobus::word_order::unknown;
    if (is_selectable && facts_.word_order_register == 0) {
        key = "word_order";
        return "word_order = selectable needs a line '# word_order_register = ADDRESS'";
    }
    if (!is_selectable && facts_.word_order_register != 0) {
        key = "word_order_register";
        return "word_order_register needs a line '# word_order = selectable'";
    }
    return {};
}

} // namespace tool
