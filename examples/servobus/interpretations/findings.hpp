// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Where a drive's manual can be read in several ways, and which of them a drive follows. findings_file.hpp has
// them as a file.
#pragma once

#include <cstddef>
#include <cstdlib>
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
    void set(std::size_t i, unsigned way) { ways_[i] = way; }
    /// Neither name may be misspelt: the program ends.
    void set(std::string_view name, std::string_view way) {
        for (std::size_t i = 0; i < of_.size(); ++i) {
            for (unsigned w = 0; name == of_[i].name && w < of_[i].ways.size(); ++w) {
                if (way == of_[i].ways[w]) return set(i, w);
            }
        }
        std::abort();
    }
    /// The numbers of the ways, 0 where nothing is known.
    std::vector<unsigned> numbers() const {
        std::vector<unsigned> all;
        for (const std::optional<unsigned>& way : ways_) all.push_back(way.value_or(0));
        return all;
    }

    std::string firmware{}; ///< its version; empty if it is not known

  private:
    std::span<const interpretation> of_;
    std::vector<std::optional<unsigned>> ways_;
};

} // namespace tool
