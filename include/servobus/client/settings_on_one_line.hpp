// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Finds the fastest baud rate and the frame format that several devices can have on one line, and what each of them
// needs to get there from its factory settings. Programs with devices of different makers on a line include it.
//
//     constexpr auto shared = settings_on_one_line(node<zlac8015d::device>{1}, node<yako::closed_loop::device>{2});
//     static_assert(shared.baud == 115200 && shared.format == character_format::n81 && !shared.changes[0]);
//     const auto open = [](auto& port) { return port.open("/dev/ttyUSB0", posix::settings_of(shared)); };
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/client/node.hpp>
#include <servobus/core/result.hpp>
#include <servobus/registers/line_choices.hpp>
#include <servobus/registers/profile.hpp>

namespace servobus {

/// A register that must be written, and the code for it.
struct line_write {
    std::uint16_t address = 0;
    std::uint16_t code = 0;
    bool is_needed = false; ///< false: the factory setting is right

    constexpr explicit operator bool() const { return is_needed; }
};

/// What brings a device from its factory settings to those of the line. It is true if anything must be written. Write
/// it while the device is alone on the line, or shares its old settings with all others. Of a device that changes
/// immediately write rate and format in one frame, as `c630s::change_line` does: after the first of two it is somewhere
/// else.
struct line_change {
    line_write rate;
    line_write format;
    bool needs_save = false;        ///< then save: else it is lost with the power
    bool needs_power_cycle = false; ///< then switch the device off and on

    constexpr explicit operator bool() const { return rate.is_needed || format.is_needed; }
};

/// The settings of a line with `N` devices; `changes` has one entry for each, in their order.
template <std::size_t N> struct shared_uart_settings : uart_settings { line_change changes[N]; };

/// A device as far as its line is concerned.
struct device_on_line {
    const profile* facts;
    const line_choices* choices;
};

namespace detail {
inline constexpr line_choices no_choices{};

template <class Device> constexpr device_on_line as_on_line() {
    if constexpr (requires { Device::on_line.rates.begin(); }) {
        return {&Device::facts, &Device::on_line};
    } else {
        return {&Device::facts, &no_choices};
    }
}
template <class Device> Device device_of_node(const node<Device>&);
template <class Device, std::uint8_t Address> Device device_of_node(const fixed_node<Device, Address>&);
template <device_class Device> Device device_of_node(const Device&);
template <class Node>
inline constexpr device_on_line
    on_line_of = as_on_line<decltype(device_of_node(std::declval<const Node&>()))>();

/// A register that holds the wanted value, does not, or the device cannot have it.
struct found_choice {
    line_write write{};
    bool is_possible = false;
};
constexpr found_choice rate_of(const device_on_line& d, std::uint32_t baud) {
    const bool is_factory = d.facts->baud == baud;
    if (d.choices->rates.is_empty()) return {.is_possible = is_factory};
    for (const rate_choice& c : d.choices->rates) {
        if (c.baud == baud) return {{d.choices->rate_register, c.code, !is_factory}, true};
    }
    return {};
}
constexpr found_choice format_of(const device_on_line& d, character_format format) {
    const bool is_factory = d.facts->format == format;
    if (d.choices->formats.is_empty()) return {.is_possible = is_factory};
    for (const format_choice& c : d.choices->formats) {
        if (c.format == format) return {{d.choices->format_register, c.code, !is_factory}, true};
    }
    return {};
}

/// The fastest rate up to `most` that all can have; 0: none.
constexpr std::uint32_t fastest_of(const device_on_line* all, std::size_t count, std::uint32_t most) {
    const auto shares = [&](std::uint32_t baud) {
        for (std::size_t i = 0; i < count; ++i) {
            if (!rate_of(all[i], baud).is_possible) return false;
        }
        return baud <= most;
    };
    std::uint32_t fastest = shares(all->facts->baud) ? all->facts->baud : 0;
    for (const rate_choice& c : all->choices->rates) {
        if (c.baud > fastest && shares(c.baud)) fastest = c.baud;
    }
    return fastest;
}
/// The format that all can have and the fewest must be set to, of several 8N1 first; `is_possible`: there is one.
struct found_format {
    character_format format = character_format::n81;
    bool is_possible = false;
};
constexpr found_format format_of_all(const device_on_line* all, std::size_t count) {
    using enum character_format;
    found_format best;
    std::size_t fewest = count + 1;
    constexpr character_format all_formats[] = {n81, n82, e81, o81};
    for (const character_format f : all_formats) {
        std::size_t changes = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const found_choice own = format_of(all[i], f);
            changes += !own.is_possible ? count + 1 : own.write.is_needed ? 1u : 0u;
        }
        if (changes >= fewest) continue;
        fewest = changes;
        best = {f, true};
    }
    return best;
}
} // namespace detail

/// Faster than any UART: no limit.
inline constexpr std::uint32_t any_rate = 0xFFFF'FFFF;

/// The settings that all devices of a list can have, at most `most` bits a second, for a program that learns at run
/// time which devices are there. Errors: `bad_argument` if they have no rate or no format in common.
template <std::size_t N>
constexpr result<shared_uart_settings<N>> find_settings_on_one_line(const device_on_line (&all)[N],
                                                                    std::uint32_t most = any_rate) {
    const std::uint32_t baud = detail::fastest_of(all, N, most);
    const detail::found_format format = detail::format_of_all(all, N);
    if (baud == 0 || !format.is_possible) return errc::bad_argument;
    shared_uart_settings<N> shared{{baud, format.format}, {}};
    for (std::size_t i = 0; i < N; ++i) {
        line_change& own = shared.changes[i];
        own.rate = detail::rate_of(all[i], baud).write;
        own.format = detail::format_of(all[i], format.format).write;
        if (!own) continue;
        own.needs_save = all[i].choices->needs_save;
        own.needs_power_cycle = all[i].choices->needs_power_cycle;
    }
    return shared;
}

/// The same for a device whose type is known: what `find_settings_on_one_line` takes.
template <device_class Device> constexpr device_on_line on_line() { return detail::as_on_line<Device>(); }

/// The fastest rate, at most `Most` bits a second, and the format that all these nodes or devices can have. Of several
/// formats it is the one that the fewest devices must be set to. What a device can have is known by its type, so
/// devices that share no settings do not compile.
template <std::uint32_t Most = any_rate, class... Nodes>
constexpr shared_uart_settings<sizeof...(Nodes)> settings_on_one_line(const Nodes&...) {
    static_assert(sizeof...(Nodes) != 0, "a line has devices");
    constexpr device_on_line all[] = {detail::on_line_of<Nodes>...};
    static_assert(detail::fastest_of(all, sizeof...(Nodes), Most) != 0,
                  "these devices have no baud rate in common: they cannot share a line");
    static_assert(detail::format_of_all(all, sizeof...(Nodes)).is_possible,
                  "these devices have no frame format in common: they cannot share a line");
    return *find_settings_on_one_line(all, Most);
}

} // namespace servobus
