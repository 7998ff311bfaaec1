// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "nearest.hpp"

#include <algorithm>

namespace tool {
namespace {

constexpr std::size_t most_names = 3;
constexpr std::size_t longest = 64; // no name is longer; bounds the work for a long word

std::string folded(std::string_view text) {
    std::string plain{text};
    for (char& c : plain) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
        if (c == '-' || c == ' ') c = '_';
    }
    return plain;
}

// Letters that are inserted, left out or replaced, and neighbours that are exchanged; none of them twice
// (optimal string alignment).
std::size_t distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before(b.size() + 1); // row i - 2
    std::vector<std::size_t> last(b.size() + 1);
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        std::swap(before, last);
        std::swap(last, row);
    }
    return last[b.size()];
}

std::size_t tolerance(std::string_view word) { return std::min<std::size_t>(word.size() / 3, 3); }

std::vector<std::string_view> parts(std::string_view text) {
    std::vector<std::string_view> all;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('_'), text.size());
        if (end != 0) all.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return all;
}

// Each part of the word is a part of the name, its beginning, or differs from it by few letters.
bool has_each_part(std::string_view name, std::string_view word) {
    const std::vector<std::string_view> own = parts(name);
    const std::vector<std::string_view> wanted = parts(word);
    return !wanted.empty() && std::ranges::all_of(wanted, [&](std::string_view part) {
        return std::ranges::any_of(own, [&](std::string_view other) {
            if (part.size() < 3) return part == other;
            return other.starts_with(part) || distance(part, other) <= tolerance(part);
        });
    });
}

struct candidate {
    std::size_t order; // by letters; by parts with the same end; by parts
    std::size_t away;
    std::string_view name;
};

std::size_t difference(std::size_t a, std::size_t b) { return a < b ? b - a : a - b; }

} // namespace

std::vector<std::string_view> nearest(std::string_view word, std::span<const std::string_view> names) {
    const std::string wanted = folded(word);
    if (wanted.size() < 2 || wanted.size() > longest || parts(wanted).empty()) return {};
    std::vector<candidate> found;
    for (const std::string_view name : names) {
        const std::string own = folded(name);
        const std::size_t away = distance(wanted, own);
        const bool is_whole_in_it = wanted.size() >= 3 && own.find(wanted) != own.npos;
        if (away <= (is_whole_in_it ? 1 : tolerance(wanted))) {
            found.push_back({0, away, name});
        } else if (is_whole_in_it || has_each_part(own, wanted)) {
            // left_actual_speed is the register of a speed, left_speed_kp is none.
            const bool has_end = parts(own).back() == parts(wanted).back();
            found.push_back({has_end ? 1u : 2u, difference(own.size(), wanted.size()), name});
        }
    }
    std::ranges::stable_sort(found, [](const candidate& a, const candidate& b) {
        return a.order != b.order ? a.order < b.order : a.away < b.away;
    });
    std::vector<std::string_view> result;
    for (const candidate& c : found) {
        // After a name that differs by a letter, others would distract.
        if (found[0].order == 0 && (c.order != 0 || c.away > found[0].away + 1)) break;
        if (result.size() < most_names) result.push_back(c.name);
    }
    return result;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> names,
                         std::string_view otherwise, std::string_view before) {
    const std::vector<std::string_view> meant = nearest(word, names);
    if (meant.empty()) return std::string{otherwise};
    std::string text = "; did you mean ";
    for (std::size_t i = 0; i < meant.size(); ++i) {
        if (i != 0) text += i + 1 == meant.size() ? " or " : ", ";
        text += before;
        text += meant[i];
    }
    return text + "?";
}

} // namespace tool
