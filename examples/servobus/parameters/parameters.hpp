// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's parameters: which registers they are, as a file's text, and as the drive holds them. A file is
//
//     servobus-backup format=1 device=zlac8015d rows=89
//     host_timeout=1000 # 1000 ms
//     left_max_current=? # 400, outside 0.0 A .. 30.0 A
//     crc16=0x1234
//
// Each register has its raw number; a float the shortest number that gives its bits again; a text is in quotes. It has
// a ? if the drive refused to give it or holds what the manual does not allow: restore leaves such a register alone.
// The CRC, that of Modbus, is of everything before its line.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../devices/device.hpp"
#include "../registers/session.hpp"
#include "../streams/progress.hpp"

namespace tool {

/// A register and the words that it holds, in the order of row_words.hpp; nothing for ?.
struct parameter {
    const servobus::entry* row = nullptr;
    std::optional<std::vector<u16>> words{};
    std::string remark{};
};

/// What a backup has: what can be read and written, but no trigger and no target.
bool is_parameter(const servobus::entry& e);
/// What restore writes of it: not the settings of the line.
bool is_restorable(const servobus::entry& e);

std::string file_text(const device& of, std::span<const parameter> all);

/// What a file holds, in its order; rows that are no parameters are in it too. Complains by itself if
/// anything about the file is wrong.
std::optional<std::vector<parameter>> parse_file(const device& of, const std::string& path);

/// Reads these rows, which are in address order, in as few requests as they take. Words are missing where
/// the drive refused. Complains by itself about anything else, and about an interruption.
std::optional<std::vector<parameter>> read_parameters(session& on, const target& of,
                                                      std::span<const servobus::entry* const> rows);

} // namespace tool
