// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The length of a response while its bytes arrive, for every function of the standard. Programs include it that receive
// responses without a line of the library.
//
//     constexpr auto response = hex("01 03 CD 6B 05");
//     modbus::growing_response growing{hex("01 00 13 00 13")};
//     if (growing.least_length(response) == response.size) return 0; // it is whole
//
// Source: Modbus Application Protocol V1.1b3, section 6.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

/// Finds the length of one response's PDU while it arrives. The work is linear in its bytes, whatever they are.
class growing_response {
  public:
    /// `request` is the PDU of the request; only this call reads it.
    constexpr explicit growing_response(bytes request) {
        if (request.empty()) return;
        code_ = request[0];
        const bool is_return_query_data =
            code_ == 0x08 && request.size() <= max_pdu && request.size() >= 5 && load_word(request, 1) == 0;
        if (is_return_query_data) query_data_ = static_cast<std::uint8_t>(request.size());
    }

    /// The bytes that the PDU has at least; it is whole when it has as many. `begun` is all that has arrived of it, one
    /// byte or several more than at the call before. What cannot be a response to the request, or would be longer than
    /// a PDU, counts as whole where that shows.
    constexpr std::size_t least_length(bytes begun) {
        while (!is_known_ && begun.size() >= length_) grow(begun);
        return length_;
    }

  private:
    /// Reads what the first `length_` bytes tell.
    constexpr void grow(bytes begun) {
        if (length_ == 2) {
            is_known_ = true;
            if (begun[0] == code_) begin(begun[1]);
        } else if (code_ == 0x18) {
            end_at(load_word(begun, 1), 3);
        } else if (length_ == 7) { // of 2Bh: code, MEI type, kind, conformity, more, next, count
            objects_ = begun[6];
            add_object(0);
        } else {
            add_object(begun[length_ - 1u]); // the length of a value
        }
    }

    /// The function's rule; `second` is the byte after the code. 07, and what has no rule, ends with it.
    constexpr void begin(std::uint8_t second) {
        switch (code_) {
        case 0x01:
        case 0x02:
        case 0x03:
        case 0x04:
        case 0x0C:
        case 0x11:
        case 0x17: return end_at(second, 2);
        case 0x05:
        case 0x06:
        case 0x0B:
        case 0x0F:
        case 0x10: return end_at(0, 5);
        case 0x08: return end_at(0, query_data_);
        case 0x16: return end_at(0, 7);
        case 0x18: return go_on(3);
        case 0x2B: return go_on(7);
        }
    }

    constexpr void go_on(std::uint8_t length) {
        length_ = length;
        is_known_ = false;
    }
    /// The PDU ends `more` bytes after `at`, unless it would be too long.
    constexpr void end_at(std::uint16_t more, std::uint8_t at) {
        is_known_ = true;
        if (more <= max_pdu - at) length_ = static_cast<std::uint8_t>(at + more);
    }
    /// A value of `size` bytes comes, then the head of the next object if one is left.
    constexpr void add_object(std::uint8_t size) {
        const bool is_last = objects_ == 0;
        const std::uint16_t more = static_cast<std::uint16_t>(size + (is_last ? 0u : 2u));
        const std::uint8_t before = length_;
        end_at(more, length_);
        is_known_ = is_last || length_ == before;
        if (!is_last) --objects_;
    }

    std::uint8_t code_ = 0;
    std::uint8_t length_ = 2;     // known so far
    std::uint8_t query_data_ = 5; // the length of a response of function 08
    std::uint8_t objects_ = 0;    // whose head has not come
    bool is_known_ = false;
};

} // namespace servobus::modbus
