// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value that the device may not have, such as the power of an inverter at night. It is no number: a program asks
// before it takes the value out. Readings of registers/value_types.hpp are such values.
//
//     constexpr maybe<int> none{};
//     static_assert(!none && none.value_or(7) == 7 && *maybe{3} == 3);
#pragma once

#include <servobus/core/cxx20.hpp>

namespace servobus {

/// A `V`, or none.
template <class V> class maybe {
  public:
    constexpr maybe() = default;
    constexpr explicit maybe(V value) : value_{value}, has_value_{true} {}

    constexpr explicit operator bool() const { return has_value_; }
    constexpr bool has_value() const { return has_value_; }
    /// The value. Only for a `maybe` that has one.
    constexpr const V& operator*() const { return value_; }
    constexpr const V* operator->() const { return &value_; }
    constexpr V value_or(V other) const { return has_value_ ? value_ : other; }

    friend constexpr bool operator==(const maybe&, const maybe&) = default;

  private:
    V value_{};
    bool has_value_ = false;
};

} // namespace servobus
