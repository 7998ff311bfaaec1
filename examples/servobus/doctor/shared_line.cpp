// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Several devices on one line: the rate and the format that they have to share.
#include <cstdio>
#include <utility>
#include <vector>

#include <servobus/client/settings_on_one_line.hpp>

#include "../registers/typed_value.hpp"
#include "line_findings.hpp"

namespace tool::diagnosis {
namespace {

// A device without choices has the factory's settings alone.
servobus::device_on_line on_line_of(const target& of) {
    static constexpr servobus::line_choices none{};
    return {&of.facts(), of.kind->on_line != nullptr ? of.kind->on_line : &none};
}

std::string settings_text(std::uint32_t baud, servobus::character_format format) {
    return std::to_string(baud) + " " + text(format);
}

// Lists the writes that bring a device from the factory's settings to those of the line.
std::string way_of(const target& of, const servobus::line_change& change) {
    std::string writes;
    for (const servobus::line_write& w : {change.rate, change.format}) {
        if (!w) continue;
        const servobus::entry* const row = of.kind->map->find(w.address);
        writes += ' ' + typed_assignment(choose(*row), std::span<const u16>{&w.code, 1});
    }
    if (change.needs_save) writes += ", then save";
    if (change.needs_power_cycle) writes += ", then switch it off and on";
    return writes;
}

template <std::size_t Count> std::optional<servobus::uart_settings> settings_of(std::span<const target> all) {
    servobus::device_on_line devices[Count];
    for (std::size_t i = 0; i < Count; ++i) devices[i] = on_line_of(all[i]);
    const auto shared = servobus::find_settings_on_one_line(devices);
    if (!shared) {
        std::string each;
        for (const target& of : all) {
            each += (each.empty() ? "" : ", ") + of.word() + " has " +
                    settings_text(of.facts().baud, of.facts().format);
        }
        std::printf(
            "%-8s these devices have no rate and format in common: %s -> put them on lines of their own\n",
            "refused", each.c_str());
        return std::nullopt;
    }
    const std::string line = settings_text(shared->baud, shared->format);
    for (std::size_t i = 0; i < Count; ++i) {
        const servobus::profile& facts = all[i].facts();
        const std::string factory = settings_text(facts.baud, facts.format);
        std::printf("%-8s %s: %s from the factory, %s on a line with the others%s%s\n", "line",
                    all[i].word().c_str(), factory.c_str(), line.c_str(), shared->changes[i] ? ":" : "",
                    shared->changes[i] ? way_of(all[i], shared->changes[i]).c_str() : "");
    }
    return servobus::uart_settings{shared->baud, shared->format};
}

template <std::size_t... Counts>
std::optional<servobus::uart_settings> choose_count(std::span<const target> all,
                                                    std::index_sequence<Counts...>) {
    std::optional<servobus::uart_settings> found;
    (void)((all.size() == Counts + 2 && (found = settings_of<Counts + 2>(all), true)) || ...);
    return found;
}

} // namespace

std::optional<servobus::uart_settings> judge_shared_line(std::span<const target> all) {
    return choose_count(all, std::make_index_sequence<most_devices - 1>{});
}

} // namespace tool::diagnosis
