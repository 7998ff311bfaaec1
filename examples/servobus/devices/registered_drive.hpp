// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive registers itself with the tool: a source file among the tool's sources has an object at namespace scope, and
// nothing else names the drive. Programs of a drive's own include it; own_device/own_tool_drive.cpp is an example.
//
//     const registered_drive of_winch{{.map = winch::catalogue, .simulate = simulate, .alarms = alarms,
//                                      .at_rest = at_rest, .stops = stops}};
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "device.hpp"

namespace tool {

/// Holds what a row of the tool's drives must give. A row that leaves it out does not compile.
template <class T> class required {
  public:
    constexpr required(T& given) : given_{&given} {} // NOLINT: implicit, a row names what it gives
    constexpr T* get() const { return given_; }

  private:
    T* given_;
};

/// A row of the tool's drives, see `device`.
struct known_drive {
    required<const servobus::catalogue> map;
    required<int(const simulation&)> simulate;
    required<std::vector<alarm_row>()> alarms;
    required<repose(session&)> at_rest;
    required<bool(u16 address, u16 word)> stops;
    std::optional<save_command> save = std::nullopt;
    int (*number)(std::string_view) = nullptr;
    unsigned most_stored = 0;
    bool (*excludes)(u16 one, u16 other) = nullptr;
    std::span<const interpretation> interpretations{};
    void (*probe)(probe_bench&, findings&) = nullptr;
    u16 version_register = 0;
    turned_shafts (*turning)(session&) = nullptr;
    const servobus::line_choices* on_line = nullptr;
    u16 node_register = 0;
    const diagnosis::examination* examination = nullptr;
    bool has_watchdog = true; ///< any request feeds it; false for a drive that certainly has none

    constexpr operator device() const { // NOLINT: implicit, a row is a device
        return {.map = map.get(),
                .simulate = simulate.get(),
                .alarms = alarms.get(),
                .at_rest = at_rest.get(),
                .stops = stops.get(),
                .save = save,
                .number = number,
                .most_stored = most_stored,
                .excludes = excludes,
                .interpretations = interpretations,
                .probe = probe,
                .version_register = version_register,
                .turning = turning,
                .on_line = on_line,
                .node_register = node_register,
                .examination = examination,
                .has_watchdog = has_watchdog};
    }
};

/// Registers a drive before `main` begins. The program ends there if another drive has its name.
class registered_drive {
  public:
    explicit registered_drive(const known_drive& row);
};

} // namespace tool
