// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Devices from files: the output of `servobus map` with other registers, in any order and with any of its columns.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../words/csv.hpp"
#include "device_profile.hpp"
#include "device_row.hpp"

namespace tool {

/// The registers that a file describes, with their texts. It stays where it was made.
class device_file {
  public:
    device_file() = default;
    device_file(const device_file&) = delete;
    device_file& operator=(const device_file&) = delete;

    /// Takes the text of a file apart; called once. `path` is for the name of a device that has none. Returns what is
    /// wrong, `LINE: why`; empty if nothing is.
    std::string parse(std::string_view path, std::string_view text);

    /// The rows of each table, in the order of `servobus::table`.
    const std::array<servobus::catalogue, 4>& tables() const { return tables_; }
    /// True if the file has the column `flags`. Without it nothing says what moves a machine.
    bool has_flags() const { return has_column(map_column::flags); }

  private:
    struct found_row {
        servobus::entry entry;
        const char* sentence;
        servobus::value_form* form = nullptr; // the entry's
        servobus::table in = servobus::table::holding_registers;
        std::size_t line = 0;
        std::string factor_row{}; // the name or the address of the row that scales it
    };
    struct taken_bits {
        unsigned mask;
        std::size_t line;
    };
    struct found_table {
        std::vector<std::uint32_t> line_of_address{}; // empty while there is no row
        std::vector<found_row> rows{};
        std::vector<servobus::entry> entries{};
        std::vector<servobus::description> descriptions{};
    };

    bool has_column(map_column column) const { return place_of_[static_cast<std::size_t>(column)] != absent; }
    std::string take_profile(std::string_view path);
    std::string take_header();
    std::string take_rows();
    std::string take_row();
    std::string add(const device_row& row, std::string_view sentence);
    std::string take_addresses(const servobus::entry& e, servobus::table in);
    std::string take_bits(const servobus::entry& e, servobus::table in);
    std::string take_factors();
    servobus::value_form* keep_form(const device_row& row);
    void finish();
    std::string at_line(std::size_t number, const std::string& why) const;
    const char* keep(std::string_view text);

    static constexpr std::size_t absent = SIZE_MAX;

    csv::lines lines_{{}};
    std::string_view line_{};
    std::vector<std::string> cells_{};
    std::array<std::size_t, std::size(map_columns)> place_of_{}; // of each column in a row
    std::size_t columns_ = 0;

    owned_profile profile_{};
    std::map<std::string, std::size_t, std::less<>> line_of_key_{};
    std::map<std::string, std::size_t, std::less<>> line_of_name_{};

    std::deque<std::string> texts_{};
    std::deque<std::vector<servobus::named_value>> values_{};
    std::deque<std::vector<std::int64_t>> none_{};
    std::deque<servobus::value_form> forms_{};
    std::map<std::pair<servobus::table, std::uint16_t>, std::vector<taken_bits>> parts_{}; // of each register
    std::array<found_table, 4> found_{};
    std::array<servobus::catalogue, 4> tables_{};
};

/// The whole content of a file. Sets `why` if it cannot be read, is no file (a folder, a port) or has more than `most`
/// bytes.
std::string read_text_file(const std::string& path, std::size_t most, std::string& why);

} // namespace tool
