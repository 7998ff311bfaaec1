// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The operating system's part of the tool: its ports, its words for errors. Files are in
// locked_file.hpp and file_target.hpp, signals in interrupts.hpp.
#pragma once

#include <string>
#include <string_view>

#ifdef _WIN32
#include <servobus/windows/mbap.hpp>
#include <servobus/windows/serial.hpp>
#else
#include <servobus/posix/mbap.hpp>
#include <servobus/posix/serial.hpp>
#endif

namespace tool {

#ifdef _WIN32
namespace native = servobus::windows;
#else
namespace native = servobus::posix;
#endif

namespace os {

/// Why a port cannot be opened that another program has.
#ifdef _WIN32
inline constexpr const char* in_use_text =
    "another program uses it, or access is denied"; // the same error there
#else
inline constexpr const char* in_use_text = "another program uses it";
#endif

/// An error number of a port, in words.
std::string error_text(int error);
/// Who may open a device that this user may not, to append to its error; empty if that is not known.
std::string advice_on_access(const char* path);
/// Sets how the system switches the port's RS-485 driver: `on` as it is configured, `rts-on-send` or `rts-after-send`,
/// each with `,BEFORE` and `,AFTER`, delays in whole ms. Empty, or what is wrong with `how`.
std::string set_rs485(native::serial_settings& settings, std::string_view how);
/// The number of an error of name resolution, in words.
std::string resolve_error_text(int error);

} // namespace os
} // namespace tool
