// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The feedback of a drive: its blocks with their ages, what is held back until the witness is read, and the origin of
// its positions. It knows neither the settings of the drive nor what its model makes of a block.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/held_feedback.hpp>
#include <servobus/control/detail/polling.hpp>
#include <servobus/control/drive_model.hpp>

namespace servobus::detail {

template <class Model> class drive_feedback {
  public:
    using polls = detail::polling<Model>;

    constexpr explicit drive_feedback(duration every) : polling_{every} {}

    constexpr polls& polling() { return polling_; }
    constexpr const polls& polling() const { return polling_; }
    constexpr held_feedback& held() { return held_; }
    constexpr const held_feedback& held() const { return held_; }

    constexpr const std::uint16_t* image() const { return polling_.image().words; }
    constexpr bool has_image() const { return polling_.image().has_words(); }
    /// When the request for the image began to leave.
    constexpr instant taken() const { return polling_.image().taken; }
    constexpr bool is_young(duration oldest, instant now) const {
        return polling_.image().is_current() && since(taken(), now) <= oldest;
    }
    /// From `from`, a moment ago, to the image.
    constexpr duration until_image(instant from) const {
        return went_back(from, taken()) ? duration{} : since(from, taken());
    }

    /// Makes all feedback old, since the settings have changed. The image still shows whether the drive has a fault.
    /// `is_taken_over`: the drive may be another one, or have restarted before.
    constexpr void make_old(bool is_taken_over) {
        if (is_taken_over) {
            is_origin_new_ = false;
            ++epoch_of_positions_;
        }
        held_.drop();
        polling_.make_old();
    }
    constexpr void forget() {
        is_origin_new_ = true;
        polling_.forget();
        held_.drop();
    }
    constexpr void forget_positions() {
        if constexpr (Model::blocks.positions() != 0) {
            held_.drop();
            polling_.slower().forget(Model::blocks.positions());
        }
    }

    /// Positions may be counted from elsewhere since the image.
    constexpr void note_origin() { is_origin_new_ = true; }
    constexpr bool is_origin_new() const { return is_origin_new_; }
    /// The model has had the image. `is_origin_open`: the next one may be counted from elsewhere too.
    constexpr void end_image(bool is_origin_open) { is_origin_new_ = is_origin_new_ && is_origin_open; }
    /// Another number: positions may be counted from elsewhere since.
    constexpr std::uint16_t epoch_of_positions() const { return epoch_of_positions_; }

    constexpr block_feedback block_of(std::uint8_t block, const std::uint16_t* words, instant taken) const {
        return {.block = block, .words = words, .taken = taken, .epoch = epoch_of_positions_};
    }
    /// A block that counts. While a command sets an origin each refresh may count from another one.
    constexpr block_feedback next_block(std::uint8_t block, const std::uint16_t* words, instant taken) {
        epoch_of_positions_ = static_cast<std::uint16_t>(epoch_of_positions_ + is_origin_new_);
        return block_of(block, words, taken);
    }

  private:
    // The bytes first: short instructions of a small core reach no further.
    bool is_origin_new_ = false;
    held_feedback held_{};
    polls polling_;
    std::uint16_t epoch_of_positions_ = 0;
};

} // namespace servobus::detail
