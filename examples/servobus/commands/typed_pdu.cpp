// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "typed_pdu.hpp"

#include <cstdio>
#include <string_view>

#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/response_rules.hpp>

#include "../streams/messages.hpp"

namespace tool {
namespace {

namespace modbus = servobus::modbus;

// A word may be in quotes for the shell, and have blanks.
bool append_bytes(std::string_view word, frame_bytes& pdu) {
    constexpr std::string_view digits = "0123456789ABCDEF0123456789abcdef";
    std::size_t half = 0; // digits of a byte that has begun
    for (const char c : word) {
        if (c == ' ' && half == 0) continue;
        const std::size_t digit = digits.find(c);
        if (digit == digits.npos) return false;
        if (half == 0) pdu.push_back(0);
        pdu.back() = static_cast<std::uint8_t>(unsigned{pdu.back()} << 4 | (digit & 0xFu));
        half = 1 - half;
    }
    return half == 0;
}

// The standard's functions have requests of a length of their own; a response to another one has no known length.
bool has_own_length(const frame_bytes& pdu) {
    frame_bytes frame{1};
    frame.insert(frame.end(), pdu.begin(), pdu.end());
    frame.insert(frame.end(), 2, 0); // the place of the CRC
    return modbus::expected_response(frame) != 0;
}

} // namespace

std::string function_text(const frame_bytes& pdu) {
    char text[8];
    (void)std::snprintf(text, sizeof text, "%02Xh", unsigned{pdu[0]});
    return text;
}

std::optional<frame_bytes> parse_pdu(std::span<const std::string> words) {
    frame_bytes pdu;
    const auto refuse = [](const std::string& why) {
        complain(usage, why);
        return std::nullopt;
    };
    for (const std::string& word : words) {
        if (!append_bytes(word, pdu))
            return refuse("'" + word + "' is no bytes in hex, two digits each: 42, or 03 20 A1 00 01");
    }
    if (pdu.empty()) return refuse("no bytes: a request begins with its function code, such as 42");
    if (pdu.size() > modbus::max_pdu)
        return refuse(std::to_string(pdu.size()) + " bytes are too many: a request has at most " +
                      std::to_string(modbus::max_pdu));
    if (pdu[0] == 0 || pdu[0] >= modbus::exception_flag)
        return refuse("function " + function_text(pdu) + " is none of a request: these are 01h to 7Fh");
    if (!has_own_length(pdu))
        return refuse("no request of function " + function_text(pdu) +
                      " is so: its length, or its quantity, is another");
    return pdu;
}

bool is_pure_read(const frame_bytes& pdu) {
    constexpr std::uint8_t read_file_record = 0x14;
    return modbus::only_reads(pdu) || pdu[0] == read_file_record;
}

} // namespace tool
