// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Lines of a file of comma-separated values, as spreadsheets and people write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tool::csv {

/// `text` without blanks and tabs around it.
std::string_view trimmed(std::string_view text);

/// A line `name=value # remark` without the remark, and without blanks around it. A text in quotes may have a `#`.
std::string_view without_remark(std::string_view line);

/// The parts of a cell that `;` separates, without blanks around them.
std::vector<std::string_view> parts(std::string_view cell);

/// At most 40 characters of what a file has, for a complaint: control characters and bytes beyond ASCII are `?`.
std::string shown(std::string_view text);

/// Splits a line without its end into cells. Blanks around a cell are dropped, unless they are inside its quotes; a
/// quote in a quoted cell is doubled. Returns the reason why the line is none; empty if it is one.
std::string split(std::string_view line, std::vector<std::string>& cells);

/// The lines of a text, one by one. A line ends with LF, or with CR LF.
class lines {
  public:
    /// A byte order mark of UTF-8 in front of the text is skipped.
    explicit lines(std::string_view text);

    bool is_at_end() const { return rest_.empty(); }
    std::string_view next();
    /// The number of the line that `next` returned last, from 1 on.
    std::size_t number() const { return number_; }

  private:
    std::string_view rest_;
    std::size_t number_ = 0;
};

} // namespace tool::csv
