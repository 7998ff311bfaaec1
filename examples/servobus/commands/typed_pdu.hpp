// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A request as a person types it: its function code and data in hexadecimal.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "../frames/log_line.hpp"

namespace tool {

/// The bytes of `42`, of `03 20 A1 00 01` in one word or in several, and of `0320A10001`. Complains by itself: also if
/// they are no request, or one of the standard whose length or quantity is wrong.
std::optional<frame_bytes> parse_pdu(std::span<const std::string> words);

/// True if the standard says that the request changes nothing in a device.
bool is_pure_read(const frame_bytes& pdu);

/// `42h`
std::string function_text(const frame_bytes& pdu);

} // namespace tool
