// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive as `servobus doctor` examines it: the row that a drive registers with the tool names one.
//
//     constexpr examination of_winch{.checks = {winch_checks}, .status = winch_status};
#pragma once

#include "check.hpp"

namespace tool::diagnosis {

struct examination {
    check_list checks;
    /// What is read first, and whether a person is asked before more is read; null: never.
    std::span<const u16> status;
    bool (*must_ask)(const held_registers&) = nullptr;
};

} // namespace tool::diagnosis
