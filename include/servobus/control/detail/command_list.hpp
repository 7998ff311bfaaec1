// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Keeps commands of several types in their order. control/take_over.hpp and control/after_enable.hpp include it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

namespace servobus::detail {

/// Commands in their order.
template <class... Commands> struct command_list {};
template <class First, class... Rest> struct command_list<First, Rest...> {
    [[no_unique_address]] First first;
    [[no_unique_address]] command_list<Rest...> rest;

    constexpr explicit command_list(const First& one, const Rest&... more) : first{one}, rest{more...} {}

    /// Calls `f` with the command at `place`, which is one of the list. Returns what it does.
    template <class F> constexpr auto visit(std::size_t place, F&& f) const {
        if constexpr (sizeof...(Rest) == 0) {
            return f(first);
        } else {
            return place == 0 ? f(first) : rest.visit(place - 1, f);
        }
    }
};

} // namespace servobus::detail
