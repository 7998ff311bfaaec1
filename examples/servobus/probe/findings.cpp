// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "findings.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "../text/csv.hpp"
#include "../text/nearest.hpp"
#include "../tool.hpp"

namespace tool {
namespace {

constexpr std::string_view findings_magic = "servobus-findings format=";
constexpr std::string_view findings_format = "1";

[[noreturn]] void misspelt(std::string_view name) {
    (void)std::fprintf(stderr, "servobus: no interpretation %.*s\n", static_cast<int>(name.size()),
                       name.data());
    std::abort();
}

} // namespace

std::size_t findings::index_of(std::string_view name) const {
    const auto at =
        std::ranges::find(of_, name, [](const interpretation& i) { return std::string_view{i.name}; });
    if (at == of_.end()) misspelt(name);
    return static_cast<std::size_t>(at - of_.begin());
}

void findings::set(std::string_view name, std::string_view way) {
    const std::size_t i = index_of(name);
    const auto at = std::ranges::find(of_[i].ways, way);
    if (at == of_[i].ways.end()) misspelt(way);
    ways_[i] = static_cast<unsigned>(at - of_[i].ways.begin());
}

std::vector<unsigned> findings::numbers() const {
    std::vector<unsigned> all;
    for (const std::optional<unsigned>& way : ways_) all.push_back(way.value_or(0));
    return all;
}

std::string findings::file_text(std::string_view device) const {
    std::string text =
        std::string{findings_magic} + std::string{findings_format} + " device=" + std::string{device} + '\n';
    for (const auto& [key, value] : facts) text += key + '=' + value + '\n';
    for (std::size_t i = 0; i < of_.size(); ++i) {
        text += std::string{of_[i].name} + '=' + (ways_[i] ? of_[i].ways[*ways_[i]] : "?") + " # " +
                of_[i].place + '\n';
    }
    return text;
}

std::string findings::parse(std::string_view device, std::string_view text) {
    csv::lines lines{text};
    const auto at_line = [&](const std::string& why) {
        return std::to_string(std::max<std::size_t>(lines.number(), 1)) + ": " + why;
    };
    if (lines.is_at_end() || !lines.next().starts_with(findings_magic))
        return at_line("it is no file of findings");
    lines = csv::lines{text};
    std::string_view first = csv::trimmed(lines.next()).substr(findings_magic.size());
    const std::string_view format = first.substr(0, first.find(' '));
    if (format != findings_format)
        return at_line("it has format " + csv::shown(format) + ", not " + std::string{findings_format});
    const std::string expected = " device=" + std::string{device};
    if (first.substr(format.size()) != expected)
        return at_line("it is not of a " + std::string{device} + ": " + csv::shown(first));
    std::vector<std::string> given;
    while (!lines.is_at_end()) {
        std::string_view line = lines.next();
        line = csv::trimmed(line.substr(0, line.find('#')));
        if (line.empty()) continue;
        const std::size_t equals = line.find('=');
        if (equals == line.npos) return at_line(csv::shown(line) + " is no name=value");
        const std::string key{csv::trimmed(line.substr(0, equals))};
        if (std::ranges::find(given, key) != given.end()) return at_line(key + " is there twice");
        given.push_back(key);
        std::string why = take(key, csv::trimmed(line.substr(equals + 1)));
        if (!why.empty()) return at_line(why);
    }
    return {};
}

std::string findings::take(std::string_view key, std::string_view value) {
    if (key == "firmware") {
        facts.emplace_back(key, value);
        return {};
    }
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < of_.size(); ++i) {
        known.emplace_back(of_[i].name);
        if (key != known.back()) continue;
        if (value == "?") return {};
        const auto at = std::ranges::find(of_[i].ways, value);
        if (at == of_[i].ways.end()) {
            std::string takes;
            for (const char* way : of_[i].ways) takes += (takes.empty() ? "" : ", ") + std::string{way};
            return std::string{key} + " takes " + takes + " or ?, not " + csv::shown(value);
        }
        ways_[i] = static_cast<unsigned>(at - of_[i].ways.begin());
        return {};
    }
    return "unknown name " + csv::shown(key) + did_you_mean(key, known, "");
}

} // namespace tool
