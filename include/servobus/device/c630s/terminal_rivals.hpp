// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A terminal of a C630S gets a function which no other may have: the blocks of terminals are read one after the other,
// and then the function is written. For the model of the drive. Source: manual V24.111, sections 6.4 and 7.4.
//
//     c630s::terminal_rivals none; // before any command
//     bool has_conflict() { return none.conflict() != 0; }
#pragma once

#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/prepared_command.hpp>
#include <servobus/device/c630s/routines.hpp>

namespace servobus::c630s {

class terminal_rivals {
  public:
    /// The register that holds a function which another terminal was to get; 0: none.
    constexpr std::uint16_t conflict() const { return conflict_; }
    constexpr void forget() { conflict_ = 0; }

    /// A block was read, `held`. Puts the next steps into `c`, or returns `already_assigned`.
    constexpr errc judge(prepared_command& c, slice<const std::uint16_t> held) {
        const auto block = static_cast<std::uint16_t>(c.shift + routines::first_of_blocks);
        for (std::uint16_t i = 0; i < detail::block_size; i += 2) {
            const auto address = static_cast<std::uint16_t>(block + i);
            if (held[i] != c.arguments[0] || address == c.arguments[1]) continue;
            conflict_ = address;
            return errc::already_assigned;
        }
        const std::uint16_t other = detail::next_rivals(block);
        c.steps = routines::look_at_block;
        c.shift = detail::as_word(other - routines::first_of_blocks);
        if (other == 0) { // none has it
            c.steps = c.arguments[2] != 0 ? routine{routines::keep_one} : routine{routines::set_one};
            c.then = effect::assigned;
            c.shift = detail::as_word(c.arguments[1] - target_speed.address);
        }
        return errc::ok;
    }

  private:
    std::uint16_t conflict_ = 0;
};

} // namespace servobus::c630s
