// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The result of `explain` besides its text. explain/explain.hpp includes it.
//
//     constexpr explanation found{.why = errc::bad_crc};
//     static_assert(!found.is_valid());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

#include <servobus/core/status.hpp>
#include <servobus/explain/direction.hpp>

namespace servobus {

/// The result of `explain` besides the text.
struct explanation {
    std::size_t size = 0; ///< number of characters written; truncated text ends in "..."
    /// `ok` for a well-formed frame; `why.exception` has the number of an exception response. Otherwise
    /// the error, see `explain`.
    status why{};
    /// Why the frame is not a response to the given request: `wrong_node`, `wrong_function`,
    /// `wrong_byte_count`, `wrong_address`, `wrong_value` or `wrong_quantity`; for functions beyond registers any error
    /// of `modbus::check_response`. `ok` if it is one, or if no request was given.
    errc mismatch = errc::ok;
    /// The direction found. `unknown` if the frame is not well-formed, or if it was parsed as both directions
    /// and is the same in both: a write of one register equals its response. A frame whose content is not known
    /// keeps the direction that was given.
    direction way = direction::unknown;

    constexpr bool is_valid() const { return why.error() == errc::ok; }
};

} // namespace servobus
