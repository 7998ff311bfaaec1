// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The errors of a PDU as text.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/explain/detail/function_names.hpp>
#include <servobus/explain/direction.hpp>
#include <servobus/modbus/functions.hpp>

namespace servobus::detail {

/// The likely direction of a malformed PDU, judged by its function code and length.
constexpr direction likely_direction(bytes pdu) {
    using enum direction;
    if ((pdu[0] & modbus::exception_flag) != 0) return response;
    switch (pdu[0]) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04: return pdu.size() == 5 ? request : response;
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11: return response; // a request is one byte, and well-formed
    case 0x0F:
    case 0x10: return pdu.size() <= 5 ? response : request;
    case 0x17: return pdu.size() < 2 || pdu[1] != pdu.size() - 2 ? request : response;
    case 0x18: return pdu.size() <= 3 ? request : response;
    case 0x2B: return pdu.size() <= 4 ? request : response;
    default: return request;
    }
}

/// Writes the error of a PDU of a known function, or of an exception: "wrong quantity 126".
class flaw_text {
  public:
    constexpr flaw_text(direction way, bytes pdu, text_writer& out)
        : pdu_{pdu}, code_{pdu[0]}, is_request_{way == direction::request}, out_{out} {}

    constexpr void put(errc why) {
        switch (why) {
        case errc::wrong_function: out_ << "an exception is no request"; return;
        case errc::wrong_address: out_ << thing() << "s beyond 0xFFFF"; return;
        case errc::wrong_quantity: return put_quantity();
        case errc::wrong_byte_count: return put_byte_count();
        case errc::wrong_value: return put_value();
        default: put_reason(out_, why);
        }
    }
    /// Writes the error in words for a frame, where `text` has those for a register.
    static constexpr void put_reason(text_writer& out, errc why) {
        out << (why == errc::unexpected_value ? "content that the standard does not allow" : text(why));
    }

  private:
    constexpr const char* thing() const {
        if (code_ == 0x02) return "discrete input";
        return code_ == 0x01 || code_ == 0x0F ? "coil" : "register";
    }
    constexpr void put_number(std::size_t n) { out_.number(static_cast<std::int64_t>(n)); }

    constexpr void put_quantity() {
        out_ << "wrong quantity ";
        if (code_ == 0x2B) return put_number(pdu_[6]);
        put_number(load_word(pdu_, 3));
        if (code_ != 0x17) return;
        out_ << " to read, ";
        put_number(load_word(pdu_, 7));
        out_ << " to write";
    }
    constexpr void put_byte_count() {
        if (code_ == 0x08) {
            out_ << "data of half a word";
            return;
        }
        const bool is_word = code_ == 0x18;
        const std::size_t at = !is_request_ ? 1 : code_ == 0x17 ? 9 : 5;
        const std::size_t counted = is_word ? load_word(pdu_, at) : pdu_[at];
        out_ << text(errc::wrong_byte_count) << ' ';
        put_number(counted);
        out_ << " with ";
        put_number_of(out_, pdu_.size() - at - (is_word ? 2 : 1), "data byte");
        if (!is_request_) return;
        out_ << " for ";
        put_number_of(out_, load_word(pdu_, at - 2), thing());
    }
    // 05, 08 and 2Bh have values that are not free.
    constexpr void put_value() {
        out_ << "wrong value 0x";
        if (code_ == 0x2B) {
            out_.hex(pdu_[2], 2);
        } else {
            out_.hex(load_word(pdu_, 3), 4);
        }
    }

    bytes pdu_;
    std::uint8_t code_;
    bool is_request_;
    text_writer& out_;
};

} // namespace servobus::detail
