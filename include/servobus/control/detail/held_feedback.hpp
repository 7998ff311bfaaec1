// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Feedback that may be of before a restart. Its positions count once the witness, or the image after them, shows that
// the drive has not restarted. It stays at the beginning of the facade's response buffer; the responses of the next
// frames lie after it.
//
//     feedback --it raises a suspicion--> held --the drive is the same--> taken
//                                          held --it has restarted, or a frame needs the room--> dropped
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/step.hpp>
#include <servobus/core/bytes.hpp>

namespace servobus::detail {

class held_feedback {
  public:
    /// Bytes of a response buffer that holds an image of `words` registers and the response to a witness, and the
    /// longest response of a step.
    static constexpr std::size_t room(std::size_t words) {
        const std::size_t with_witness = response(words) + response(longest_witness);
        return with_witness > response(steps::longest) + 1 ? with_witness : response(steps::longest) + 1;
    }

    constexpr bool is_any() const { return size_ != 0; }
    constexpr bool is_image() const { return is_any() && !is_block_; }
    constexpr bool is_block() const { return is_any() && is_block_; }
    /// Bytes; 0: none.
    constexpr std::size_t size() const { return size_; }
    constexpr words_view words(const std::uint8_t* buffer) const {
        return words_view{bytes{buffer, size_}.subspan(3, size_ - 5u)};
    }

    /// Holds a response of the image, which lies in `buffer`, in place of what was held before.
    constexpr void hold_image(std::uint8_t* buffer, bytes read) { hold(buffer, read, false); }
    /// Holds a response of a slower block likewise.
    constexpr void hold_block(std::uint8_t* buffer, bytes read) { hold(buffer, read, true); }
    constexpr void drop() { size_ = 0; }

  private:
    static constexpr std::size_t longest_witness = sizeof(steps::recheck{}.words) / sizeof(std::uint16_t);
    static constexpr std::size_t response(std::size_t words) { return 5 + 2 * words; }

    constexpr void hold(std::uint8_t* buffer, bytes read, bool is_block) {
        for (std::size_t i = 0; i < read.size(); ++i) buffer[i] = read[i];
        size_ = static_cast<std::uint8_t>(read.size());
        is_block_ = is_block;
    }

    std::uint8_t size_ = 0;
    bool is_block_ = false;
};

} // namespace servobus::detail
