// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "completion.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "../devices/devices.hpp"
#include "../registers/session.hpp"
#include "../streams/messages.hpp"
#include "commands.hpp"

namespace tool {
namespace {

constexpr const char bash_script[] = R"(# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
# bash completion of servobus: the tool itself prints how to complete, then the candidates. A candidate may have a
# sentence about it after a tab, which a list shows.
_servobus() {
    local i name widest=0 line
    mapfile -t COMPREPLY < <("${1/#\~/$HOME}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
    case ${COMPREPLY[0]} in
    open) compopt -o nospace ;;
    files) compopt -o default ;;
    esac
    COMPREPLY=("${COMPREPLY[@]:1}")
    for i in "${!COMPREPLY[@]}"; do
        name=${COMPREPLY[i]%%$'\t'*}
        ((${#name} > widest)) && widest=${#name}
    done
    for i in "${!COMPREPLY[@]}"; do
        name=${COMPREPLY[i]%%$'\t'*}
        # 63: a second tab lists what there is. Anything else inserts.
        if ((COMP_TYPE == 63 && ${#COMPREPLY[@]} > 1)) && [[ $name != "${COMPREPLY[i]}" ]]; then
            printf -v line '%-*s  %s' "$widest" "$name" "${COMPREPLY[i]#*$'\t'}"
            name=${line:0:${COLUMNS:-80}-2}
        fi
        COMPREPLY[i]=$name
    done
}
complete -F _servobus servobus
)";

struct answer {
    const char* kind = "words";
    std::vector<std::string> candidates;
};

answer files() { return {.kind = "files", .candidates = {}}; }

std::vector<std::string> split(std::string_view text, char between) {
    std::vector<std::string> parts;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(between), text.size());
        if (end != 0) parts.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return parts;
}

// What was begun of a list whose items are joined by `between`: another one that is not in it yet.
answer list_of(std::string_view begun, char between, const std::vector<std::string>& items) {
    const std::size_t last = begun.rfind(between);
    const std::string before{last == begun.npos ? std::string_view{} : begun.substr(0, last + 1)};
    const std::vector<std::string> given = split(before, between);
    answer a{.kind = "open", .candidates = {}};
    for (const std::string& item : items) {
        if (std::ranges::find(given, item) == given.end()) a.candidates.push_back(before + item);
    }
    return a;
}

// The serial devices that adapters get, and the schemes of gateways. Another path is completed as a file.
answer ports(std::string_view begun) {
    answer a{.kind = "open", .candidates = {"tcp://", "mbap://"}};
    std::error_code error;
    for (std::filesystem::directory_iterator at{"/dev", error}, end; !error && at != end;
         at.increment(error)) {
        const std::string name = at->path().filename().string();
        for (const std::string_view prefix : {"ttyUSB", "ttyACM", "ttyAMA", "ttyS"}) {
            if (name.starts_with(prefix)) a.candidates.push_back("/dev/" + name);
        }
    }
    std::ranges::sort(a.candidates);
    const auto begins = [&](const std::string& candidate) { return candidate.starts_with(begun); };
    if (std::ranges::none_of(a.candidates, begins)) return files();
    if (begun.starts_with('/')) a.kind = "words";
    return a;
}

// Another word is completed as a file.
answer device_names(const command& of, std::string_view begun) {
    answer a;
    for (const device& d : devices()) a.candidates.emplace_back(d.facts().name);
    if (of.takes_raw) a.candidates.emplace_back("raw");
    const auto begins = [&](const std::string& candidate) { return candidate.starts_with(begun); };
    return std::ranges::any_of(a.candidates, begins) ? a : files();
}

// The device on the command line; null if there is none with a map.
const device* device_of(std::string_view word) { return find_device_quietly(split_device(word).name); }

enum class register_use { show, read, write };

// REG, or REG=VALUE for a write, each with its sentence after a tab. `given` are registers that the command line
// already has.
answer registers(const device* of, std::string_view begun, register_use wanted,
                 std::span<const std::string> given) {
    const bool is_write = wanted == register_use::write;
    answer a{.kind = is_write ? "open" : "words", .candidates = {}};
    if (of == nullptr) return a;
    const std::size_t equals = begun.find('=');
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of->rows_of(t)) {
            const std::string name{static_cast<const char*>(e.name)};
            if (is_write && equals != begun.npos) {
                if (name != begun.substr(0, equals)) continue;
                const bool is_code =
                    std::ranges::all_of(e.values, [](const auto& v) { return v.is_whole(); });
                const std::string before = name + "=";
                const std::string_view value = begun.substr(equals + 1);
                a = list_of(value, is_code ? '\0' : '+', names_of(e));
                if (is_code) a.kind = "words";
                for (std::string& candidate : a.candidates) candidate.insert(0, before);
                return a;
            }
            if (is_write && e.rights == servobus::access::ro) continue;
            if (wanted == register_use::read && e.rights == servobus::access::wo) continue;
            const auto is_it = [&](const std::string& word) {
                return word.substr(0, word.find('=')) == name;
            };
            if (std::ranges::none_of(given, is_it))
                a.candidates.push_back(name + (is_write ? "=\t" : "\t") + of->sentence(e, t));
        }
    }
    return a;
}

answer value_of(const option& o, std::string_view begun) {
    if (o.value == "FILE" || o.value == "PATH") return files();
    if (o.value == "LIST") return list_of(begun, ',', split(o.choices, ' '));
    if (o.value.find('|') != o.value.npos) return {.candidates = split(o.value, '|')};
    return {.candidates = split(o.choices, ' ')};
}

// The word at `index` of a command.
answer word_of(const command& of, std::span<const std::string> before, std::string_view begun) {
    const std::vector<std::string> places = split(of.words, ' ');
    if (places.empty()) return {};
    const std::size_t index = before.size();
    const bool is_past = index >= places.size();
    if (is_past && !places.back().ends_with("...")) return {};
    const std::string_view place = is_past ? places.back() : places[index];
    if (place.starts_with("PORT")) return ports(begun);
    if (place.starts_with("DEVICE")) return device_names(of, begun);
    if (place.find("FILE") != place.npos) return files();
    if (place == "[REG]") return registers(device_of(before[0]), begun, register_use::show, {});
    if (place.starts_with("REG")) {
        const bool is_write = place.starts_with("REG=VALUE");
        // Raw takes a table, which an address follows.
        const bool is_raw = before[1].substr(0, before[1].find(':')) == "raw";
        if (is_raw) return {.kind = "open", .candidates = raw_tables(is_write)};
        return registers(device_of(before[1]), begun, is_write ? register_use::write : register_use::read,
                         before.subspan(2));
    }
    const bool is_itself = place.front() >= 'a' && place.front() <= 'z';
    return is_itself ? answer{.candidates = {std::string{place}}} : answer{};
}

answer options_of(const command& of, std::span<const std::string> given) {
    answer a{.candidates = {"--help"}};
    for (const std::string_view name : of.option_names()) {
        std::string shown = "--" + std::string{name};
        if (std::ranges::find(given, shown) == given.end()) a.candidates.push_back(std::move(shown));
    }
    return a;
}

answer command_names(const command_table& all, bool has_options) {
    answer a;
    for (const command& c : all.all) a.candidates.emplace_back(c.name);
    if (has_options) a.candidates.insert(a.candidates.end(), {"help", "--help", "--version"});
    return a;
}

// `words` are those before the last one, which was begun.
answer complete(const command_table& all, std::span<const std::string> words, std::string_view begun) {
    if (words.empty()) return command_names(all, true);
    if (words[0] == "help") return words.size() == 1 ? command_names(all, false) : answer{};
    const command* const of = all.find(words[0]);
    if (of == nullptr) return {};
    std::vector<std::string> before;
    std::vector<std::string> given;
    const option* open = nullptr; // its value is the next word
    for (const std::string& word : words.subspan(1)) {
        if (open != nullptr) {
            open = nullptr;
        } else if (word.find_first_of("<>|") != word.npos) {
            return files(); // the shell's, not the tool's
        } else if (word.starts_with("--")) {
            const std::size_t equals = word.find('=');
            given.push_back(word.substr(0, equals));
            const option* const o = of->find(std::string_view{given.back()}.substr(2));
            if (o != nullptr && o->takes_value() && equals == word.npos) open = o;
        } else {
            before.push_back(word);
        }
    }
    if (open != nullptr) return value_of(*open, begun);
    const std::size_t equals = begun.find('=');
    if (begun.starts_with("--") && equals != begun.npos) {
        const option* const o = of->find(begun.substr(2, equals - 2));
        if (o == nullptr || !o->takes_value()) return {};
        answer a = value_of(*o, begun.substr(equals + 1));
        for (std::string& candidate : a.candidates) candidate.insert(0, begun.substr(0, equals + 1));
        return a;
    }
    if (begun.starts_with('-')) return options_of(*of, given);
    return word_of(*of, before, begun);
}

bool is_break(std::string_view word) { return !word.empty() && word.find_first_not_of(":=") == word.npos; }

} // namespace

int print_candidates(const command_table& all, std::span<char* const> words) {
    // The shell has replaced what precedes the last break of the word that is completed.
    std::vector<std::string> whole;
    std::size_t kept = 0;
    bool goes_on = false;
    for (const std::string_view word : words) {
        const bool is_joined = !whole.empty() && !word.empty() && (goes_on || is_break(word));
        if (!is_joined) whole.emplace_back();
        goes_on = is_break(word);
        kept = goes_on ? whole.back().size() + word.size() : whole.back().size();
        whole.back() += word;
    }
    if (whole.empty()) whole.emplace_back();
    const std::string begun = std::move(whole.back());
    whole.pop_back();

    const answer a = complete(all, whole, begun);
    (void)std::puts(a.kind);
    for (const std::string& candidate : a.candidates) {
        if (candidate.starts_with(begun))
            (void)std::puts(candidate.c_str() + std::min(kept, candidate.size()));
    }
    return done;
}

int completion(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "completion takes one shell: bash");
    if (asked.words()[0] != "bash")
        return complain(usage, "no completion for '" + asked.words()[0] + "'; bash has one");
    (void)std::fputs(bash_script, stdout);
    return done;
}

} // namespace tool
