// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Checks that the parsers of requests and responses share: length, function code and exception, byte count.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus::detail {

/// `too_short` or `too_long` if the PDU has another length.
constexpr errc check_length(bytes pdu, std::size_t length) {
    if (pdu.size() == length) return errc::ok;
    return pdu.size() < length ? errc::too_short : errc::too_long;
}

/// The checks that come first in every response: two bytes at least, the exception, the function code.
constexpr status check_head(function asked, bytes pdu) {
    const auto code = static_cast<std::uint8_t>(asked);
    if (pdu.size() < 2) return status::sent(errc::too_short);
    if (pdu[0] == (code ^ exception_flag))
        return pdu.size() == 2 ? status::sent(errc::exception, pdu[1]) : status::sent(errc::too_long);
    return pdu[0] == code ? status{} : status::sent(errc::wrong_function);
}

/// The head and the length of a response whose length is known.
constexpr status check_fixed(function asked, bytes pdu, std::size_t length) {
    const status head = check_head(asked, pdu);
    if (!head) return head;
    const errc wrong = check_length(pdu, length);
    return wrong == errc::ok ? status{} : status::sent(wrong);
}

/// The head of a response whose second byte counts the bytes after it, and that they are `least` .. `most`.
constexpr status check_counted(function asked, bytes pdu, std::size_t least, std::size_t most) {
    const status head = check_head(asked, pdu);
    if (!head) return head;
    const bool is = pdu[1] == pdu.size() - 2 && pdu[1] >= least && pdu[1] <= most;
    return is ? status{} : status::sent(errc::wrong_byte_count);
}

} // namespace servobus::modbus::detail
