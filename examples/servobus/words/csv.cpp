// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "csv.hpp"

#include <cstdio>

namespace tool::csv {
namespace {

// Takes a quoted cell, whose first quote is gone, from `rest`, with the blanks behind it.
std::string take_quoted(std::string_view& rest, std::string& cell) {
    while (true) {
        const std::size_t quote = rest.find('"');
        if (quote == rest.npos) return "a quote is not closed";
        cell += rest.substr(0, quote);
        rest.remove_prefix(quote + 1);
        if (!rest.starts_with('"')) break;
        cell += '"';
        rest.remove_prefix(1);
    }
    const std::size_t end = rest.find_first_not_of(" \t");
    rest.remove_prefix(end == rest.npos ? rest.size() : end);
    return rest.empty() || rest[0] == ',' ? "" : "there is text behind the closing quote of a cell";
}

std::string why_no_text(std::string_view line) {
    for (const char c : line) {
        const auto code = static_cast<unsigned char>(c);
        if ((code >= ' ' || c == '\t') && code != 0x7F) continue;
        char words[64];
        (void)std::snprintf(words, sizeof words, "a control character (%02Xh): this is no UTF-8 text",
                            unsigned{code});
        return words;
    }
    return {};
}

} // namespace

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string_view without_remark(std::string_view line) {
    const std::size_t equals = line.find('=');
    const std::size_t opening = equals == line.npos ? line.npos : line.find_first_not_of(" \t", equals + 1);
    const bool is_quoted = opening != line.npos && line[opening] == '"';
    const std::size_t closing = is_quoted ? line.find('"', opening + 1) : 0;
    return trimmed(line.substr(0, closing == line.npos ? closing : line.find('#', closing)));
}

std::vector<std::string_view> parts(std::string_view cell) {
    std::vector<std::string_view> all;
    while (true) {
        const std::size_t end = cell.find(';');
        all.push_back(trimmed(cell.substr(0, end)));
        if (end == cell.npos) return all;
        cell.remove_prefix(end + 1);
    }
}

std::string shown(std::string_view text) {
    constexpr std::size_t most = 40;
    std::string plain{text.substr(0, most)};
    for (char& c : plain) {
        if (c < ' ' || c > '~') c = '?';
    }
    return '\'' + plain + (text.size() > most ? "..." : "") + '\'';
}

std::string split(std::string_view line, std::vector<std::string>& cells) {
    cells.clear();
    if (std::string why = why_no_text(line); !why.empty()) return why;
    std::string_view rest = line;
    while (true) {
        const std::size_t first = rest.find_first_not_of(" \t");
        std::string& cell = cells.emplace_back();
        if (first != rest.npos && rest[first] == '"') {
            rest.remove_prefix(first + 1);
            if (std::string why = take_quoted(rest, cell); !why.empty()) return why;
        } else {
            const std::string_view plain = rest.substr(0, rest.find(','));
            if (plain.find('"') != plain.npos) return "a quote stands inside a cell that has none around it";
            cell = trimmed(plain);
            rest.remove_prefix(plain.size());
        }
        if (rest.empty()) return {};
        rest.remove_prefix(1); // the comma
    }
}

lines::lines(std::string_view text) : rest_{text} {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

std::string_view lines::next() {
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == rest_.npos ? rest_.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number_;
    return line;
}

} // namespace tool::csv
