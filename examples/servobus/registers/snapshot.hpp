// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers of a command line as they were read in one round: what read and watch show and record.
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "session.hpp"

namespace tool {

/// What came of one register.
struct reading {
    std::vector<u16> words; ///< see row_words.hpp for their order
    servobus::status status{};
    std::string why{};           ///< in words; empty if it was read
    bool was_asked = true;       ///< false: the port was lost before, and `why` says so
    servobus::row_scale scale{}; ///< that another row gives

    bool is_read() const { return status.error() == servobus::errc::ok; }
};

struct snapshot {
    std::chrono::system_clock::time_point began; ///< when its first request was due
    std::vector<reading> readings{};             ///< in the order of the command line

    bool has_answer() const;
    bool has_port() const;
};

/// Reads registers in the fewest requests; see read_groups.hpp. None if a signal ended it in between; see
/// os/interrupts.hpp.
std::optional<snapshot> take_snapshot(session& on, const target& of, std::span<const chosen> wanted);

} // namespace tool
