// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drives by name, and the devices of files by their paths.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "device.hpp"

namespace tool {

/// The drives that the tool knows, by their names, without those of files. Each registers itself: see
/// registered_drive.hpp.
std::span<const device> devices();
/// The drive of that name, or the device of a file; a word with `.csv` or `/` is a file's path. The same word is the
/// same device. Complains by itself.
const device* find_device(std::string_view word);
/// As above, but sets `why` in place of a complaint.
const device* find_device(std::string_view word, std::string& why);
/// As above, but null without a reason.
const device* find_device_quietly(std::string_view word);

/// A row to ask whether a device responds; null if none can be read.
struct asked_row {
    const servobus::entry* row = nullptr;
    servobus::table in = servobus::table::holding_registers;
};
/// The register of its address, else the first row that can be read.
asked_row first_readable(const device& of);

/// DEVICE[:NODE] in its parts. The colon of `C:/meter.csv` is none before a node.
struct device_word {
    std::string_view name;
    std::optional<std::string_view> node{};
};
device_word split_device(std::string_view text);

} // namespace tool
