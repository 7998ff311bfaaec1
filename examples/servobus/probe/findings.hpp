// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Where a drive's manual can be read in several ways, and which of them a drive follows. A file of findings is
//
//     servobus-findings format=1 device=zlac8015d
//     firmware=107
//     save=marked
//     by_fault=?     # open
//
// and says nothing of its machine and its owner.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tool {

/// A place of the manual, and what a simulated drive may do there.
struct interpretation {
    const char* name;
    std::span<const char* const> ways; ///< the first is that of a simulator without findings
    const char* place;                 ///< of the manual, and what it leaves open
};

/// One way for each interpretation of a drive, as far as it is known.
class findings {
  public:
    explicit findings(std::span<const interpretation> of) : of_{of}, ways_(of.size()) {}

    std::span<const interpretation> all() const { return of_; }
    std::optional<unsigned> way(std::size_t i) const { return ways_[i]; }
    /// Neither name may be misspelt: the program ends.
    void set(std::string_view name, std::string_view way);
    /// Nothing is known of it.
    void forget(std::string_view name) { ways_[index_of(name)].reset(); }
    /// The numbers of the ways, 0 where nothing is known.
    std::vector<unsigned> numbers() const;

    /// What stands in front of the ways, such as the firmware's version: key and value.
    std::vector<std::pair<std::string, std::string>> facts{};

    std::string file_text(std::string_view device) const;
    /// Takes a file apart. Returns what is wrong, `LINE: why`; empty if nothing is.
    std::string parse(std::string_view device, std::string_view text);

  private:
    std::size_t index_of(std::string_view name) const;
    std::string take(std::string_view key, std::string_view value);

    std::span<const interpretation> of_;
    std::vector<std::optional<unsigned>> ways_;
};

} // namespace tool
