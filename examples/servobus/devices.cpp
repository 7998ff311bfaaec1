// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drives by name, and the devices of files by their paths.
#include <deque>

#include <servobus/device/c630s/assignments.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "text/device_file.hpp"
#include "text/nearest.hpp"
#include "tool.hpp"

namespace tool {
namespace {

int c630s_parameter(std::string_view text) {
    return servobus::c630s::detail::parameter_address(text.data(), text.size());
}

constexpr save_command zlac8015d_save{servobus::zlac8015d::save_parameters.address,
                                      static_cast<u16>(servobus::zlac8015d::parameter_save::save_all),
                                      servobus::zlac8015d::mode_of_operation.address}; // [errata B11]
constexpr save_command yako_save{servobus::yako::auxiliary_command.address,
                                 static_cast<u16>(servobus::yako::auxiliary::save_parameters)};

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

const device* find_known(std::string_view name) {
    for (const device& d : devices()) {
        if (name == d.facts().name) return &d;
    }
    return nullptr;
}

} // namespace

std::span<const device> devices() {
    static constexpr device known[] = {
        known_drive{.map = servobus::zlac8015d::catalogue,
                    .simulate = simulate_zlac8015d,
                    .alarms = zlac8015d_alarms,
                    .at_rest = zlac8015d_at_rest,
                    .stops = zlac8015d_stops,
                    .save = zlac8015d_save},
        known_drive{.map = servobus::yako::closed_loop::catalogue,
                    .simulate = simulate_yako_closed_loop,
                    .alarms = yako_alarms,
                    .at_rest = yako_at_rest,
                    .stops = yako_stops,
                    .save = yako_save},
        known_drive{.map = servobus::yako::open_loop::catalogue,
                    .simulate = simulate_yako_open_loop,
                    .alarms = yako_alarms,
                    .at_rest = yako_at_rest,
                    .stops = yako_stops,
                    .save = yako_save},
        // More than 200 stored parameters raise the alarm Er.942.
        known_drive{.map = servobus::c630s::catalogue,
                    .simulate = simulate_c630s,
                    .alarms = c630s_alarms,
                    .at_rest = c630s_at_rest,
                    .stops = c630s_stops,
                    .number = c630s_parameter,
                    .most_stored = 200,
                    .excludes = servobus::c630s::excludes},
    };
    return known;
}

const device* find_device(std::string_view word) {
    if (is_file(word)) {
        std::string why;
        const device* const of = load(word, why);
        if (of == nullptr) complain(usage, why);
        return of;
    }
    if (const device* const of = find_known(word)) return of;
    std::vector<std::string_view> names;
    std::string known = "; known: ";
    for (const device& d : devices()) {
        known += names.empty() ? "" : ", ";
        known += d.facts().name;
        names.push_back(d.facts().name);
    }
    complain(usage, "unknown device '" + std::string{word} + "'" + did_you_mean(word, names, known));
    return nullptr;
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

std::string device::display_name(u16 address) const {
    const servobus::entry* e = map->find(address);
    return (e != nullptr ? std::string{e->name} : std::string{"register"}) + " (" + hex_word(address) + ")";
}

} // namespace tool
