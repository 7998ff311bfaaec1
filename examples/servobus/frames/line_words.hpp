// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line in words: what was heard on it, what that may come from, and what mends it.
#pragma once

#include <string>
#include <vector>

#include "overheard.hpp"

namespace tool {

/// How the line was asked, and what its remarks name.
struct line_terms {
    std::string who{};     ///< `node 1`
    std::string setting{}; ///< `at 115200 8N1`
    servobus::duration limit{};
    bool removes_echo = false;
    bool is_network = false;
    /// The same command again: with `--echo on`, without it, with `--timeout N`.
    std::string with_echo{};
    std::string without_echo{};
    std::string with_timeout{}; ///< without the number, at its end
    std::string with_pause{};   ///< the same with `--inter-byte`
    std::string scan{};
};

struct remark {
    std::string what;
    std::string act;
};

/// `14.5`
std::string ms_text(servobus::duration d);

/// What is wrong, the cause of the others first; nothing where each read had one response, and early.
std::vector<remark> remarks_on(const line_account& heard, const line_terms& terms);

/// A --timeout for responses that begin after `most`.
unsigned timeout_for(servobus::duration most);

/// Bytes that came while nothing was asked.
std::string words_on_unasked(const line_account& heard);

/// Bytes in place of responses.
std::string words_on_damage(const line_account& heard, const std::string& who);

/// A response in pieces, and an --inter-byte for it.
std::string words_on_pause(const line_account& heard);
unsigned pause_for(const line_account& heard);

/// Two responses to one request. `differ`: in their bytes.
std::string words_on_two_responses(const std::string& who, bool differ);

} // namespace tool
