// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the blocks of the C630S's set-up one after the other: read, compared with what terminals.hpp says,
// and written where they differ. c630s/model.hpp includes it. `init` only reads them; the first difference that
// `set_up` finds makes the drive keep its writes, and a mark (P0B-33 = 9) shows that the power has to be switched
// off and on.
//
//     const std::array<std::uint16_t, 4> factory{};
//     c630s::set_up_progress all;
//     const bool has_begun = all.begin(false).then == c630s::effect::looked; // reads the first block
#pragma once

#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

/// Each function returns the routine that follows; without steps if nothing does.
class set_up_progress {
  public:
    /// Writes go into the EEPROM.
    constexpr bool is_keeping() const { return is_keeping_; }

    constexpr prepared_command begin(bool may_write) {
        may_write_ = may_write;
        is_keeping_ = false;
        block_ = 0;
        return look();
    }
    /// A block was read. `is_right`: the drive is set up so far.
    constexpr prepared_command judge(slice<const std::uint16_t> held, bool& is_right) {
        steps::arguments wanted{};
        is_right = true;
        for (std::size_t i = 0; i < detail::block_size; ++i) {
            const auto address = static_cast<std::uint16_t>(detail::set_up_blocks[block_] + i);
            wanted[i] = detail::set_up_word(address, held[i]);
            is_right = is_right && held[i] == wanted[i];
        }
        if (is_right) return next();
        if (!may_write_) return {.steps = no_steps};
        if (!is_keeping_) return {.steps = routines::begin_keeping, .then = effect::keeping};
        return {
            .steps = routines::set_block, .arguments = wanted, .then = effect::block_set, .shift = shift()};
    }
    constexpr prepared_command keep() {
        is_keeping_ = true;
        return look();
    }
    constexpr prepared_command next() {
        if (++block_ < detail::set_up_block_count) return look();
        if (!is_keeping_) return {.steps = no_steps};
        return {.steps = routines::end_keeping, .then = effect::set_up};
    }

  private:
    constexpr std::uint16_t shift() const {
        return detail::as_word(detail::set_up_blocks[block_] - routines::first_of_blocks);
    }
    constexpr prepared_command look() const {
        return {.steps = routines::look_at_block,
                .then = may_write_ ? effect::examined : effect::looked,
                .shift = shift()};
    }

    std::uint8_t block_ = 0;
    bool may_write_ = false;
    bool is_keeping_ = false;
};

} // namespace servobus::c630s
