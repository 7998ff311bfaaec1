// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The word order of a cyclic read, as a bus keeps it. A plan without 32-bit values needs none.
#pragma once

#include <servobus/core/epoch.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus::detail {

template <bool HasPairs> struct read_order {
    verified<word_order> learned{word_order::high_first, {}};
    word_order taken_in = word_order::high_first; ///< in which the values came
};
template <> struct read_order<false> {};

} // namespace servobus::detail
