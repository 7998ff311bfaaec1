// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What matters of a machine's drives, as a person writes it and a diff shows it:
//
//     servobus-machine format=1
//     [lift] device=yako-closed-loop node=2
//     require microstep_resolution=1000   # compared, never written
//     max_current=3.0 A
//     x0_function=home
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/registers/profile.hpp>

#include "../devices/device.hpp"
#include "../parameters/parameters.hpp"
#include "../words/csv.hpp"

namespace tool {

/// A line `REG=VALUE` of a section.
struct machine_line {
    const servobus::entry* row;
    std::vector<u16> words; ///< in the order of row_words.hpp
    std::size_t line;
    bool is_required; ///< compared, never written
};

/// A drive of the machine. What the header line does not say is that of the device's factory.
struct machine_section {
    std::string name;
    std::size_t line = 0;
    const device* kind = nullptr;
    std::uint8_t node = 1; ///< on the finished machine
    std::uint32_t baud = 0;
    servobus::character_format format = servobus::character_format::n81;
    bool says_rate = false; ///< `baud=` or `character_format=`; else the command line may
    std::vector<machine_line> lines{};

    /// The registers of these lines with what they should hold.
    std::vector<parameter> required() const { return parameters(true); }
    std::vector<parameter> wanted() const { return parameters(false); }

  private:
    std::vector<parameter> parameters(bool is_required) const;
};

/// A whole file, which is checked before anything is sent.
class machine_file {
  public:
    /// Takes the text of a file apart; called once. `path` is where devices from files are looked for. Returns what is
    /// wrong, `LINE: why`; empty if nothing is.
    std::string parse(std::string_view path, std::string_view text);

    const std::vector<machine_section>& sections() const { return sections_; }
    /// Null if there is no section of that name.
    const machine_section* find(std::string_view name) const;

  private:
    std::string take_first_line(std::string_view line) const;
    std::string take_section(std::string_view line);
    std::string take_key(machine_section& to, std::string_view key, std::string_view value);
    std::string take_setting(std::string_view line);
    std::string contradiction(const machine_section& in, const machine_line& added) const;

    csv::lines lines_{{}};
    std::string folder_{};
    std::vector<machine_section> sections_{};
};

} // namespace tool
