// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "findings_file.hpp"

#include <algorithm>

#include "../words/csv.hpp"
#include "../words/nearest.hpp"

namespace tool {
namespace {

constexpr std::string_view findings_magic = "servobus-findings format=";
constexpr std::string_view findings_format = "1";

std::string take_finding(findings& found, std::string_view key, std::string_view value) {
    if (key == "firmware") {
        found.firmware = value;
        return {};
    }
    const std::span<const interpretation> of = found.all();
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < of.size(); ++i) {
        known.emplace_back(of[i].name);
        if (key != known.back()) continue;
        if (value == "?") return {};
        const auto at = std::ranges::find(of[i].ways, value);
        if (at == of[i].ways.end()) {
            std::string takes;
            for (const char* way : of[i].ways) takes += (takes.empty() ? "" : ", ") + std::string{way};
            return std::string{key} + " takes " + takes + " or ?, not " + csv::shown(value);
        }
        found.set(i, static_cast<unsigned>(at - of[i].ways.begin()));
        return {};
    }
    return "unknown name " + csv::shown(key) + did_you_mean(key, known, "");
}

} // namespace

std::string findings_head(const findings& found, std::string_view device) {
    std::string text =
        std::string{findings_magic} + std::string{findings_format} + " device=" + std::string{device} + '\n';
    if (!found.firmware.empty()) text += "firmware=" + found.firmware + '\n';
    return text;
}

std::string finding_lines(const findings& found) {
    std::string text;
    for (std::size_t i = 0; i < found.all().size(); ++i) {
        const interpretation& what = found.all()[i];
        text += std::string{what.name} + '=' + (found.way(i) ? what.ways[*found.way(i)] : "?") + " # " +
                what.place + '\n';
    }
    return text;
}

std::string parse_findings(findings& found, std::string_view device, std::string_view text) {
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
        std::string why = take_finding(found, key, csv::trimmed(line.substr(equals + 1)));
        if (!why.empty()) return at_line(why);
    }
    return {};
}

} // namespace tool
