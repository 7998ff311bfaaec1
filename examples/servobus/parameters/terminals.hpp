// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whether terminals would get a function that another one has, before anything is written.
#pragma once

#include <string>

#include "../devices/device.hpp"
#include "../registers/session.hpp"

namespace tool {

/// A word that is to be written to a register.
struct assignment {
    u16 address;
    u16 word;
};

/// Why terminals cannot have these functions.
struct clash {
    u16 address = 0;        ///< the register that was to be written, or could not be read
    u16 holder = 0;         ///< the one that holds the same function; 0: `why`
    servobus::status why{}; ///< it could not be read

    bool is_none() const { return holder == 0 && why.error() == servobus::errc::ok; }
};

/// True if the register holds a terminal's function that no other may have too.
bool is_exclusive(const device& of, u16 address);

/// Compares what is to be written, in this order, with what the drive's terminals hold. Reads nothing unless
/// a terminal is to get a function.
clash find_clash(session& on, const target& of, std::span<const assignment> wanted);

/// For the complaint.
std::string clash_text(const target& of, const clash& c, const session& on);

} // namespace tool
