// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "devices.hpp"

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <string>
#include <vector>

#include "../device_file/device_file.hpp"
#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "registered_drive.hpp"

namespace tool {
namespace {

constexpr std::size_t largest_file = 32'000'000; // bytes

// A device of a file, which the program keeps until it ends.
struct loaded_device {
    std::string path;
    device_file content;
    device of;
};

bool is_file(std::string_view word) { return word.find(".csv") != word.npos || word.find('/') != word.npos; }

// Null if `why` says that it cannot be loaded.
const device* load(std::string_view path, std::string& why) {
    static std::deque<loaded_device> all;
    for (const loaded_device& l : all) {
        if (l.path == path) return &l.of;
    }
    const std::string text = read_text_file(std::string{path}, largest_file, why);
    if (!why.empty()) return nullptr;
    loaded_device& one = all.emplace_back();
    one.path = path;
    why = one.content.parse(path, text);
    if (!why.empty()) {
        why = one.path + ':' + why;
        all.pop_back();
        return nullptr;
    }
    one.of.tables = one.content.tables().data();
    one.of.map = &one.content.tables()[static_cast<std::size_t>(servobus::table::holding_registers)];
    one.of.file = one.path.c_str();
    one.of.has_flags = one.content.has_flags();
    return &one.of;
}

// Filled before `main` begins, and not changed after.
std::vector<device>& all_drives() {
    static std::vector<device> all;
    return all;
}

const device* find_known(std::string_view name) {
    for (const device& d : devices()) {
        if (name == d.facts().name) return &d;
    }
    return nullptr;
}

} // namespace

std::span<const device> devices() { return all_drives(); }

registered_drive::registered_drive(const known_drive& row) {
    const device added = row;
    std::vector<device>& all = all_drives();
    const auto name = [](const device& d) { return std::string_view{d.facts().name}; };
    const auto place = std::ranges::lower_bound(all, name(added), {}, name);
    if (place != all.end() && name(*place) == name(added)) {
        (void)complain(failed, "two drives of this program have the name " + std::string{name(added)});
        std::_Exit(failed);
    }
    all.insert(place, added);
}

const device* find_device(std::string_view word, std::string& why) {
    if (is_file(word)) return load(word, why);
    if (const device* const of = find_known(word)) return of;
    std::vector<std::string_view> names;
    std::string known = "; known: ";
    for (const device& d : devices()) {
        known += names.empty() ? "" : ", ";
        known += d.facts().name;
        names.push_back(d.facts().name);
    }
    why = "unknown device '" + std::string{word} + "'" + did_you_mean(word, names, known);
    return nullptr;
}

const device* find_device(std::string_view word) {
    std::string why;
    const device* const of = find_device(word, why);
    if (of == nullptr) complain(usage, why);
    return of;
}

const device* find_device_quietly(std::string_view word) {
    std::string why;
    return is_file(word) ? load(word, why) : find_known(word);
}

device_word split_device(std::string_view text) {
    const std::size_t colon = is_file(text) ? text.rfind(':') : text.find(':');
    if (colon == text.npos) return {text};
    const std::string_view rest = text.substr(colon + 1);
    const bool is_in_path = is_file(rest) || rest.find('\\') != rest.npos;
    if (is_file(text) && is_in_path) return {text};
    return {text.substr(0, colon), rest};
}

asked_row first_readable(const device& of) {
    if (of.node_register != 0) return {of.map->find(of.node_register)};
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            if (e.rights != servobus::access::wo) return {&e, t};
        }
    }
    return {};
}

std::string device::display_name(u16 address) const {
    const servobus::entry* e = map->find(address);
    return (e != nullptr ? std::string{e->name} : std::string{"register"}) + " (" + hex_word(address) + ")";
}

} // namespace tool
