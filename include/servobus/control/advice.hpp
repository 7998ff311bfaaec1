// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Advice tells a person at the machine what to do about a fault. The advice for each drive is in a header of its own,
// such as device/c630s/advice.hpp. No other header includes these, so a program that does not include one has none of
// its text.
//
//     constexpr advice jam{"The belt is jammed.", "Remove the carton.", not_in_manual};
//     static_assert(jam.reset == not_in_manual);
#pragma once

#include <servobus/core/cxx20.hpp>

namespace servobus {

/// The text where a manual has no cause, remedy or reset. An array, so that its address can be compared.
inline constexpr char not_in_manual[] = "The manual does not say.";

/// Advice about one fault, from the drive's manual: English sentences of ASCII characters, never null or empty.
/// Cause and remedy have 25 words at most.
struct advice {
    const char* cause;
    const char* remedy;
    const char* reset; ///< how the drive leaves the fault once its cause has ended
};

/// The advice if a drive reports no fault.
inline constexpr advice no_fault_advice{"The drive reports no fault.", "Nothing to do.", "Nothing to reset."};

} // namespace servobus
