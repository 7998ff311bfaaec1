// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus --help, servobus COMMAND --help.
#include "help.hpp"

#include <algorithm>

#include <servobus/core/version.hpp>

#include "topics.hpp"

namespace tool {
namespace {

constexpr std::size_t page_width = 80;
constexpr std::size_t topic_column = 8;
constexpr std::size_t option_column = 18;

// Appends `text`, wrapped, from `column` on; the last line of `out` already reaches up to `at`. An empty line
// in it stays one.
void wrap(std::string& out, std::string_view text, std::size_t column, std::size_t at) {
    const std::string margin(column, ' ');
    if (at >= column && column != 0) {
        out += '\n';
        at = 0;
    }
    out.append(column - at, ' ');
    at = column;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
        const std::string_view word = text.substr(0, end);
        if (at > column && at + 1 + word.size() > page_width) {
            out += '\n' + margin;
            at = column;
        } else if (at > column) {
            out += ' ';
            ++at;
        }
        out += word;
        at += word.size();
        text.remove_prefix(end);
        if (text.starts_with("\n\n")) {
            out += "\n\n" + margin;
            at = column;
        }
        text.remove_prefix(std::min(text.find_first_not_of(" \n"), text.size()));
    }
    out += '\n';
}

void put_topic(std::string& out, const topic& t) {
    out += t.name;
    wrap(out, t.about, topic_column, t.name.size());
}

void put_options(std::string& out, std::span<const option> options) {
    for (const option& o : options) {
        const std::string heading = "  " + heading_of(o);
        out += heading;
        wrap(out, o.help, option_column, heading.size());
    }
}

std::string usage_of(const command& c) {
    std::string line = "servobus " + std::string{c.name};
    if (!c.words.empty()) line += " " + std::string{c.words};
    return line;
}

bool has_options(const command& c) { return !c.options.empty() || !c.shared.empty(); }

void put_exit_status(std::string& out) { wrap(out, "Exit status: " + std::string{exit_status}, 0, 0); }

} // namespace

std::string version_text() {
    const servobus::version_number v = servobus::version;
    return std::to_string(v.major_number) + "." + std::to_string(v.minor_number) + "." +
           std::to_string(v.patch_number);
}

std::string sentence(std::string_view text) {
    std::string whole = std::string{text} + ".";
    if (whole[0] >= 'a' && whole[0] <= 'z') whole[0] = static_cast<char>(whole[0] - 'a' + 'A');
    return whole;
}

std::string heading_of(const option& o) {
    return "--" + std::string{o.name} + (o.takes_value() ? " " + std::string{o.value} : "");
}

std::string users_of(const option_group& group, const command_table& all) {
    std::vector<std::string_view> names;
    for (const command& c : all.all) {
        if (std::ranges::find(c.shared, &group) != c.shared.end()) names.push_back(c.name);
    }
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i != 0) text += i + 1 == names.size() ? " and " : ", ";
        text += names[i];
    }
    return text;
}

std::string help(const command_table& all) {
    std::string out = "servobus: " + std::string{purpose} + "\n\n";
    std::size_t summary_column = 0;
    for (const command& c : all.all) summary_column = std::max(summary_column, usage_of(c).size() + 4);
    for (const command& c : all.all) {
        const std::string line = "  " + usage_of(c);
        out += line;
        wrap(out, c.summary, summary_column, line.size());
    }
    const std::string of_one = "  servobus COMMAND --help";
    out += of_one;
    wrap(out, "one command", summary_column, of_one.size());
    out += "  servobus --version\n\n";
    for (const topic& t : topics()) put_topic(out, t);
    for (const command& c : all.all) {
        out += '\n';
        wrap(out, std::string{c.name} + ": " + std::string{c.about}, 0, 0);
        put_options(out, c.options);
    }
    for (const option_group* group : all.shared) {
        out += '\n';
        wrap(out,
             std::string{group->title} + ", for " + users_of(*group, all) + ". " + std::string{group->note},
             0, 0);
        put_options(out, group->options);
    }
    out += '\n';
    put_exit_status(out);
    return out;
}

std::string help_of(const command& c) {
    std::string out = usage_of(c) + (has_options(c) ? " [OPTION...]" : "") + "\n\n";
    wrap(out, sentence(c.summary) + " " + std::string{c.about}, 0, 0);
    if (!c.options.empty()) out += '\n';
    put_options(out, c.options);
    for (const option_group* group : c.shared) {
        out += '\n';
        wrap(out, std::string{group->title} + ". " + std::string{group->note}, 0, 0);
        put_options(out, group->options);
    }
    bool is_first = true;
    for (const topic& t : topics()) {
        if (c.words.find(t.name) == c.words.npos) continue;
        if (is_first) out += '\n';
        is_first = false;
        put_topic(out, t);
    }
    out += '\n';
    put_exit_status(out);
    return out;
}

} // namespace tool
