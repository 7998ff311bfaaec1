// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Snapshots as text for programs. README.md has the formats, which scripts and spreadsheets rely on.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../registers/snapshot.hpp"

namespace tool {

/// The numbers of a snapshot, in the order of the command line: one a register, one a word without a map, two
/// where a register holds a value of each axis in its two bytes.
class columns {
  public:
    columns() = default;

    /// None, after a complaint, if two columns would have the same name.
    static std::optional<columns> of(std::span<const chosen> wanted);

    /// Lines with their ends. No cell has a comma, a quote or a line end, since ModbusScope splits a row at
    /// every comma.
    std::string csv_header() const;
    std::string csv_row(const snapshot& s) const;

    /// An object in one line, and how each of them begins.
    std::string json_line(const snapshot& s) const;
    static constexpr std::string_view json_begin = "{\"time\":\"";

  private:
    enum class part : unsigned char { whole, left, right };

    struct column {
        std::string name;
        std::string unit{};                   ///< empty: none
        const servobus::entry* row = nullptr; ///< null: raw
        raw_form form{};                      ///< of raw
        std::size_t of = 0;                   ///< the register's place on the command line
        std::size_t word = 0;                 ///< the place of its first word in the reading
        part which = part::whole;
    };

    void add(const chosen& what, std::size_t place);
    static std::string number_text(const column& c, const reading& r);
    static std::string name_text(const column& c, const reading& r);

    std::vector<column> columns_{};
    std::vector<std::string> registers_{}; ///< as errors name them
};

} // namespace tool
