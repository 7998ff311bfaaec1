// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drives of a machine file on their line: what apply and diff share.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../command_line/arguments.hpp"
#include "../registers/session.hpp"
#include "machine_file.hpp"

namespace tool {

/// Where a drive responds.
struct place {
    std::uint8_t node = 1;
    std::uint32_t baud = 0;
    servobus::character_format format = servobus::character_format::n81;

    friend bool operator==(const place&, const place&) = default;
};
/// `node 2, 115200 baud 8N1`
std::string text_of(const place& where);

/// The sections of a command line's file that it names, all if it names none; from the words `PORT FILE [NAME...]` and
/// the option `--at`. Sections that say no rate have that of the command line. Returns `done`, or the exit status after
/// a complaint.
int choose_sections(const arguments& asked, std::vector<machine_section>& sections);

/// A session with a drive of the file.
struct found_drive {
    std::unique_ptr<session> on{};
    target of{};
    place where{};
};

/// Looks for the drive where the machine file has it, and where the command line says that it is now: by `--at`,
/// `--baud` and `--format`. Refused if two drives respond. Returns `done`, or the exit status after a complaint.
int find_drive(const arguments& asked, const machine_section& wanted, found_drive& found);
/// The first of these places at which the drive responds; no complaint if there is none.
int find_among(const arguments& asked, const machine_section& wanted, const std::vector<place>& places,
               std::optional<found_drive>& found);
/// Where the file has it.
place finished_place(const machine_section& wanted);

/// Compares what a section requires, and prints what differs with `[name]` in front of each register. Sets `differing`.
int compare_required(found_drive& at, const machine_section& wanted, std::size_t& differing);

} // namespace tool
