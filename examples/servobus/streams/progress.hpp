// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How far a long command is: a moving line on a terminal, a few lines elsewhere, on standard error.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

#include "descriptors.hpp"

namespace tool {

class progress {
  public:
    progress(std::string doing, std::size_t all)
        : doing_{std::move(doing)}, all_{all}, moves_{streams::is_terminal(stderr)} {}
    progress(const progress&) = delete;
    progress& operator=(const progress&) = delete;
    ~progress() { end(); }

    void at(std::size_t count) {
        if (moves_) {
            (void)std::fprintf(stderr, "\r\x1b[K%s: %zu of %zu", doing_.c_str(), count, all_);
            (void)std::fflush(stderr);
            has_line_ = true;
            return;
        }
        const std::size_t quarter = all_ == 0 ? 4 : count * 4 / all_;
        if (quarter <= shown_) return;
        shown_ = quarter;
        (void)std::fprintf(stderr, "servobus: %s: %zu of %zu\n", doing_.c_str(), count, all_);
    }
    /// Takes the moving line away, for what is said next.
    void end() {
        if (has_line_) (void)std::fputs("\r\x1b[K", stderr);
        has_line_ = false;
    }

  private:
    std::string doing_;
    std::size_t all_;
    std::size_t shown_ = 0;
    bool moves_;
    bool has_line_ = false;
};

} // namespace tool
