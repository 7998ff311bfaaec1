// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The response to a request as its bytes arrive: each is compared with the request's byte at its place and
// stored, and the whole is judged once. `exchange` and `blocking_line` derive from it; so does a line of your
// own.
//
//     struct response : modbus::gathering<std::uint8_t> {
//         bool is_over(std::uint8_t byte) { // false: more bytes are to come
//             if (compare(byte)) store(byte);
//             return is_whole() && !may_be_echo();
//         }};
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/response_rules.hpp>

namespace servobus::modbus {

/// The error of an exception. `limits` say which number acknowledges, and whether a gateway may respond in the
/// node's place.
template <class Limits> constexpr errc error_of_exception(std::uint8_t number, const Limits& limits) {
    if (limits.has_gateway && is_of_gateway(number)) return errc::gateway_exception;
    return number != 0 && number == limits.acknowledge ? errc::acknowledged : errc::exception;
}

/// Judges the end of an exchange on Modbus TCP: exceptions 0Ah and 0Bh, and each exception to a broadcast, are the
/// gateway's. Returns true if this was one.
constexpr bool note_gateway(status& ended, bool is_broadcast) {
    if (ended.error() != errc::exception && ended.error() != errc::acknowledged) return false;
    if (!is_broadcast && !is_of_gateway(ended.exception())) return false;
    ended.end(errc::gateway_exception);
    return true;
}

/// For lines whose responses all have known lengths; see modbus/response_lengths.hpp.
struct fixed_lengths {
    static constexpr bool are_open = false;
};

/// `Size` has the length of a frame: 8 bits for frames of up to 255 bytes. Request and response may share
/// memory: a byte is compared before the byte at its place is stored.
template <class Size, class Lengths = fixed_lengths> class gathering {
  protected:
    constexpr gathering() = default;

    /// Starts anew: nothing has arrived.
    constexpr void begin_gathering() {
        same_ = size_;
        count_ = 0;
    }
    /// Compares the next byte; `store` follows. Returns false for a first byte that is not the request's: the
    /// frame is another node's. Inline in the two loops that run it for each byte.
    [[gnu::always_inline]] constexpr bool compare(unsigned byte) {
        if (count_ < same_ && byte != request_[count_]) {
            if (count_ == 0) return false;
            // Five bytes of an exception are of use, and none of another function.
            if (count_ == 1) length_ = (byte ^ request_[1]) == exception_flag ? Size{5} : Size{2};
            same_ = count_;
        }
        return true;
    }
    constexpr void store(unsigned byte) {
        response_[count_++] = static_cast<std::uint8_t>(byte);
        if constexpr (Lengths::are_open) grow();
    }
    /// The response is to be as long as `of` finds; `length_` is the room for it.
    constexpr void begin_open(const Lengths& of) {
        lengths_ = of;
        if (!lengths_.is_open()) return;
        lengths_.set_room(length_);
        length_ = lengths_.ends_by_gap() ? length_ : Size{4};
    }
    /// A gap has ended the response, or it is whole. Four bytes are the function alone if their CRC fits, else a part.
    template <crc_engine Crc> constexpr void end_open() {
        if (!lengths_.ends_by_gap() || count_ < 4 || count_ >= length_) return;
        if (count_ > 4 || (same_ != 1 && crc16<Crc>(bytes{response_, 4}) == 0)) length_ = count_;
    }
    constexpr bool is_whole() const { return count_ == length_; }
    /// True if each byte so far is the request's, and the request goes on: the next byte, or a gap, tells
    /// whether this is its echo.
    constexpr bool may_be_echo() const { return same_ > length_; }

    /// What the bytes are. `like`: the function whose response is of the same kind (`modbus::like`). `cut`: the error
    /// of a response that ended too early. `has_more`: another byte came after the whole one. A wrong value of a 05, 06
    /// or 16h is reported as `wrong_quantity`, its place in a 10h. Tells `owner` what else follows: `rule_out_echo()`,
    /// `end_cleanly()` where no byte came after the response, `note_exception(number)`.
    template <crc_engine Crc, bool HasOtherFunctions, class Limits, class Owner>
    [[gnu::always_inline]] constexpr errc judged(std::uint8_t like, errc cut,
                                                 [[maybe_unused]] const Limits& limits, bool has_more,
                                                 Owner& owner) const {
        const unsigned same = same_;
        if constexpr (Lengths::are_open) {
            if (lengths_.is_too_long()) return errc::too_long;
        }
        if (length_ == 2) return errc::wrong_function;
        if (same == 1) { // an exception: no header to compare
        } else if (has_count(like)) {
            if (count_ > 2 && response_[2] != length_ - 5)
                return is_request_so_far() ? errc::own_echo : errc::wrong_byte_count;
        } else if (same + 2u < length_ && (!HasOtherFunctions || like != like_none)) {
            if (same < 4) return errc::wrong_address;
            if (!limits.echoes_byte_count || (HasOtherFunctions && length_ != 8) || same != 5 ||
                response_[5] != size_ - 9)
                return errc::wrong_quantity;
        }
        if (count_ < length_) return cut;
        if (crc16<Crc>(bytes{response_, length_}) != 0)
            return is_request_so_far() ? errc::own_echo : errc::bad_crc;
        if (same == 1) {
            const errc why = error_of_exception(response_[2], limits);
            owner.note_exception(response_[2]);
            // A gateway's word is no response of the node: not even an echo is ruled out by it.
            if (why == errc::exception || why == errc::acknowledged) {
                owner.rule_out_echo();
                owner.end_cleanly();
            }
            return why;
        }
        if (same < size_) { // no echo differs from its request
            owner.rule_out_echo();
            if (has_more) return errc::ok;
        } else if (has_more || size_ < length_) { // or zeros after the echo: they keep a CRC that is right
            return errc::own_echo;
        }
        owner.end_cleanly();
        return errc::ok;
    }

    // The request came in place of a response that must differ from it.
    constexpr bool is_request_so_far() const { return same_ >= (count_ < length_ ? count_ : length_); }

    // The bytes first, where a short instruction of a small core reaches them.
    Size size_ = 0;   ///< of the request
    Size length_ = 0; ///< of the whole response
    Size count_ = 0;  ///< of its bytes that came
    Size same_ = 0;   ///< so many of them are the request's first ones, or the request's size: all so far
    const std::uint8_t* request_ = nullptr;
    std::uint8_t* response_ = nullptr;
    [[no_unique_address]] Lengths lengths_{};

  private:
    // The byte that has come may tell how many follow. Exceptions and other functions have their length.
    constexpr void grow() {
        if (!lengths_.is_open() || lengths_.ends_by_gap() || same_ == 1 || count_ + 2u < length_) return;
        const std::size_t length = lengths_.least_length({response_ + 1, count_ - std::size_t{1}}) + 3;
        if (lengths_.fits(length))
            length_ = static_cast<Size>(length);
        else
            length_ = count_; // ends here
    }
};

} // namespace servobus::modbus
