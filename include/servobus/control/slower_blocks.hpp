// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Blocks of a drive's feedback that a facade reads less often than the first. The `model.hpp` of a drive that has
// them includes it.
//
//     static_assert(slower_blocks<c630s::model>::size == 4); // speed and torque, position, deviation, alarm
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/image.hpp>
#include <servobus/control/step.hpp>

namespace servobus {

namespace detail {
/// The words of the first `count` blocks.
constexpr std::size_t words_of(const register_block* blocks, std::size_t count) {
    std::size_t words = 0;
    for (std::size_t i = 0; i < count; ++i) words += blocks[i].words;
    return words;
}
} // namespace detail

/// Further blocks of a model's image, `Model::slower`: one of them, in turn, after every
/// `Model::readings_between` readings of the first, or when a step reads from it.
template <class Model>
requires requires { Model::slower; }
class slower_blocks<Model> {
  public:
    static constexpr std::size_t size = sizeof(Model::slower) / sizeof(register_block);
    static constexpr std::uint8_t none = 0xFF;
    static_assert(
        [] {
            for (const register_block& b : Model::slower) {
                if (b.words > steps::longest) return false;
            }
            return true;
        }(),
        "a block of the feedback is at most 11 registers");

    constexpr const std::uint16_t* words(std::size_t block) const { return words_ + offset_of(block); }
    /// When a block was read last.
    constexpr instant taken(std::size_t block) const { return taken_[block]; }
    /// Each block was read, and no longer ago than `oldest`.
    constexpr bool are_younger(duration oldest, instant now) const {
        for (std::size_t i = 0; i < size; ++i) {
            if ((read_ >> i & 1u) == 0 || since(taken_[i], now) > oldest) return false;
        }
        return true;
    }
    /// One of them is to be read.
    constexpr bool is_due() const { return images_ >= Model::readings_between; }
    constexpr void count_image() { images_ = is_due() ? images_ : static_cast<std::uint8_t>(images_ + 1); }

    /// The block that the step under way reads from, or `none`.
    template <class Run> constexpr std::uint8_t block_for(const Run& run) const {
        for (std::uint8_t i = 0; i < size; ++i) {
            if (!run.asks_model() && run.reads(Model::slower[i])) return i;
        }
        return none;
    }
    /// What the next frame reads. `is_image_due`: that is the first block, before the step's.
    template <class Run> constexpr register_block choose(const Run& run, bool is_image_due) {
        in_flight_ = is_image_due ? none : block_for(run);
        if (is_image_due) return Model::image;
        if (in_flight_ == none && is_due()) in_flight_ = next_;
        return in_flight_ == none ? Model::image : Model::slower[in_flight_];
    }
    constexpr std::uint8_t block() const { return in_flight_; }
    constexpr bool is_in_flight() const { return in_flight_ != none; }
    /// The frame has ended.
    constexpr void land() {
        if (in_flight_ == next_ && is_due()) {
            next_ = next_ + 1u == size ? std::uint8_t{0} : static_cast<std::uint8_t>(next_ + 1);
            images_ = 0;
        }
        in_flight_ = none;
    }
    /// A block was read by a request that began to leave at `began`.
    template <class Exchange> constexpr void take(std::size_t block, const Exchange& x, instant began) {
        taken_[block] = began;
        read_ = static_cast<std::uint8_t>(read_ | 1u << block);
        for (std::size_t i = 0; i < Model::slower[block].words; ++i)
            words_[offset_of(block) + i] = x.words()[i];
    }

  private:
    static constexpr std::size_t offset_of(std::size_t block) {
        return detail::words_of(Model::slower, block);
    }

    static_assert(size <= 8, "a model has at most 8 further blocks");

    instant taken_[size]{};
    std::uint16_t words_[detail::words_of(Model::slower, size)]{};
    std::uint8_t read_ = 0; // a bit for each block that was read
    std::uint8_t next_ = 0;
    std::uint8_t images_ = 0; // readings of the first block since one of these
    std::uint8_t in_flight_ = none;
};

} // namespace servobus
