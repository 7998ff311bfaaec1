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

#include <servobus/control/command_status.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/prepared_command.hpp>
#include <servobus/device/c630s/routines.hpp>

namespace servobus::c630s {

namespace detail {
/// Up to the step where the routine ended it wrote R, a constant or from the arguments.
template <const auto& R> constexpr bool may_have_written(routine table, const command_status& r) {
    for (std::size_t i = 0; i <= r.step() && i < table.size(); ++i) {
        if (table[i].what == step::kind::write && table[i].address == R.address) return true;
    }
    return false;
}
} // namespace detail

/// The functions that return a prepared command return what follows; it has no steps if nothing does.
class set_up_progress {
  public:
    /// An `init` has read its words: the blocks follow. `awaits_power_cycle`: by the mark of a set-up before.
    constexpr prepared_command take_over(bool awaits_power_cycle) {
        found_ = drive_state::needs_set_up;
        awaits_power_cycle_ = awaits_power_cycle;
        return begin(false);
    }
    /// The state that an `init` has found.
    constexpr drive_state found() const { return found_; }
    /// A block was read by an `init`. Puts what follows into `c`.
    constexpr void look(prepared_command& c, slice<const std::uint16_t> words, cached_settings& known) {
        bool is_right = false;
        c = judge(words, is_right);
        if (!c.steps.empty()) return;
        if (is_right) found_ = awaits_power_cycle_ ? drive_state::needs_power_cycle : drive_state::disabled;
        if (awaits_power_cycle_) { // P0B-33 shows it to the next `init` too
            known.state = found_;
            return;
        }
        c = {.steps = is_right ? routine{routines::mark_session} : routine{routines::choose_present_alarm},
             .arguments = {0, is_right ? terminal::marker : std::uint16_t{0}},
             .then = effect::taken_over};
    }
    /// The drive has kept something that works only once the power has been off.
    constexpr void note_kept() { awaits_power_cycle_ = true; }

    /// A part of an `init` or of a set-up: the drive is unknown if it fails.
    static constexpr bool is_part(effect e) {
        switch (e) {
        case effect::looked:
        case effect::taken_over:
        case effect::examined:
        case effect::keeping:
        case effect::block_set:
        case effect::set_up: return true;
        default: return false;
        }
    }
    /// The drive refused something while P0C-13 is 1: what is written next would wear the EEPROM.
    constexpr bool leaves_keeping(effect was, routine failed, const command_status& r) const {
        const bool is_refusal = r.error() == errc::exception || r.error() == errc::unexpected_value;
        const bool is_in_set_up = is_keeping_ && (was == effect::examined || was == effect::block_set);
        return is_refusal && was != effect::none &&
               (is_in_set_up || detail::may_have_written<eeprom_update>(failed, r));
    }

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
    bool is_keeping_ = false;                       // writes go into the EEPROM
    drive_state found_ = drive_state::needs_set_up; // by `init`
    bool awaits_power_cycle_ = false;
};

} // namespace servobus::c630s
