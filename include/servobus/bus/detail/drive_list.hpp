// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facades of a bus, which are of different types.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

namespace servobus::detail {

/// References to drives, numbered in their order.
template <class... Drives> class drive_list {
  public:
    template <class Call> constexpr void each(Call&&, std::size_t = 0) const {}
};
template <class First, class... More> class drive_list<First, More...> {
  public:
    constexpr explicit drive_list(First& first, More&... more) : first_{&first}, more_{more...} {}

    /// Calls `call(number, drive)` for each.
    template <class Call> constexpr void each(Call&& call, std::size_t number = 0) const {
        call(number, *first_);
        more_.each(call, number + 1);
    }

  private:
    First* first_;
    [[no_unique_address]] drive_list<More...> more_;
};

} // namespace servobus::detail
