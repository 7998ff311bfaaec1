// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "arguments.hpp"

#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"

namespace tool {

namespace {

void complain_unknown(const std::string& shown, const command& of) {
    complain(usage,
             "unknown option '" + shown + "'" +
                 did_you_mean(std::string_view{shown}.substr(shown.starts_with("--") ? 2 : 1),
                              of.option_names(), "; see servobus " + std::string{of.name} + " --help", "--"));
}

} // namespace

std::optional<arguments> arguments::parse(std::span<char* const> words, const command& of) {
    arguments parsed{of};
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string_view word = words[i];
        if (!word.starts_with("--")) {
            if (word.starts_with('-') && word.size() > 1) {
                complain_unknown(std::string{word}, of);
                return std::nullopt;
            }
            parsed.words_.emplace_back(word);
            continue;
        }
        const std::size_t equals = word.find('=');
        const std::string_view name = word.substr(2, equals == word.npos ? word.npos : equals - 2);
        const option* const found = of.find(name);
        const std::string shown = "--" + std::string{name};
        if (found == nullptr) {
            complain_unknown(shown, of);
            return std::nullopt;
        }
        std::string value;
        if (equals != word.npos) {
            if (!found->takes_value()) {
                complain(usage, shown + " takes no value");
                return std::nullopt;
            }
            value = word.substr(equals + 1);
        } else if (found->takes_value()) {
            if (i + 1 == words.size()) {
                complain(usage, shown + " needs a value");
                return std::nullopt;
            }
            value = words[++i];
        }
        if (!parsed.options_.emplace(name, value).second) {
            complain(usage, shown + " is given twice");
            return std::nullopt;
        }
    }
    return parsed;
}

const std::string* arguments::find(std::string_view name) const {
    const auto at = options_.find(name);
    return at == options_.end() ? nullptr : &at->second;
}

const char* arguments::text(std::string_view name) const {
    const std::string* value = find(name);
    return value == nullptr ? nullptr : value->c_str();
}

std::optional<std::int64_t> arguments::number(std::string_view name, std::int64_t low, std::int64_t high,
                                              std::int64_t otherwise) const {
    const std::string* value = find(name);
    if (value == nullptr) return otherwise;
    const std::optional<std::int64_t> parsed = parse_integer(*value);
    if (parsed && *parsed >= low && *parsed <= high) return parsed;
    complain(usage, "--" + std::string{name} + " takes a whole number from " + std::to_string(low) + " to " +
                        std::to_string(high) + ", not '" + *value + "'");
    return std::nullopt;
}

std::optional<bool> arguments::on_or_off(std::string_view name) const {
    const std::string* value = find(name);
    if (value == nullptr || *value == "off") return false;
    if (*value == "on") return true;
    complain(usage, "--" + std::string{name} + " takes on or off, not '" + *value + "'");
    return std::nullopt;
}

} // namespace tool
