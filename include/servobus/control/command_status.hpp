// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a command ended, and where: at which step, register or terminal, and of a take-over in which part. `begin`, `run`
// and `last()` of a facade return it.
//
//     const command_status moved = wheels.run(move_by{4096 * pulse, 4096 * pulse});
//     if (!moved && moved.has_register()) // 208Ah: the targets, 200Eh: the start
//         std::printf("%s, at %04Xh\n", text(moved.error()), moved.register_address());
#pragma once

#include <cstdint>

#include <servobus/core/status.hpp>

namespace servobus {

/// The parts of a take-over, and what a drive may lack at its end.
enum class take_over_part : std::uint8_t {
    init,        ///< stops the drive, reads its settings
    fault_reset, ///< of a drive with a fault, if it was asked for
    setting,     ///< a command of the list
    reading,     ///< of the feedback
    power_cycle, ///< what was set up works once the drive has been switched off and on
    set_up,      ///< the drive cannot be used before its set-up, which was not among the settings
};

constexpr const char* text(take_over_part p) {
    switch (p) {
    case take_over_part::init: return "init";
    case take_over_part::fault_reset: return "fault reset";
    case take_over_part::setting: return "setting";
    case take_over_part::reading: return "reading";
    case take_over_part::power_cycle: return "power cycle";
    case take_over_part::set_up: return "set-up";
    }
    return "unknown";
}

/// The end of a command; true for success alone. `done`: every step. `refused`: an exception at `step()`, which was not
/// done, nor any after it. `not_sent`: it ended before anything that changes the drive was sent. `unknown`: something
/// was sent that is not known to have worked, or a later step failed. Of `begin`: the command is under way, or nothing
/// of it was sent.
class [[nodiscard]] command_status {
  public:
    // Inlined: a copy of either would cost a small core 12 bytes, and a call of it at each command.

    /// Done.
    [[gnu::always_inline]] constexpr command_status() {}
    /// Nothing was sent.
    [[gnu::always_inline]] constexpr command_status(errc why)
        : status_{why} {} // NOLINT: implicit, `return errc::busy;`
    /// An end at no step.
    constexpr explicit command_status(const servobus::status& how) : status_{how} {}
    /// An end at a step whose first register has the address `after - 1`; 0: at none. `has_changed`: a step before it
    /// has written.
    constexpr command_status(const servobus::status& how, std::uint8_t step, bool has_changed,
                             std::uint16_t after = 0)
        : status_{how}, step_{step}, has_changed_{has_changed}, after_{after} {}

    constexpr explicit operator bool() const { return static_cast<bool>(status_); }
    constexpr errc error() const { return status_.error(); }
    constexpr servobus::outcome outcome() const { return status_.outcome(); }
    /// As of `status`.
    constexpr std::uint8_t exception() const { return status_.exception(); }
    /// Without its place.
    constexpr operator servobus::status() const { return status_; } // NOLINT: implicit
    /// Compares the error alone.
    friend constexpr bool operator==(const command_status& s, errc why) { return s.error() == why; }
    /// Not with a `status`: a command that succeeded was sent, and `status{}` was not.
    friend bool operator==(const command_status&, const servobus::status&) = delete;

    /// The number of the step where it ended.
    constexpr std::uint8_t step() const { return step_; }
    /// A step before that one has written something.
    constexpr bool has_changed() const { return has_changed_; }
    /// False if nothing was begun; if the step asks the feedback or the witness; if a stop replaced the command; if one
    /// of several stops failed, while the steps after it were done.
    constexpr bool has_register() const { return after_ != 0; }
    /// The address of the first register of the step where it ended; a device's catalogue has its name. Of a wiring:
    /// the register of the terminal that has the function already, or was to get it. The drive is checked for a restart
    /// before some steps: a step at which that check failed was not sent.
    constexpr std::uint16_t register_address() const { return static_cast<std::uint16_t>(after_ - 1u); }
    /// The part where a take-over ended; `reading` if it is done.
    constexpr take_over_part part() const {
        return place_ >= first_part ? static_cast<take_over_part>(place_ - first_part)
                                    : take_over_part::setting;
    }
    /// The number of the setting of a take-over that failed, from 1; 0 for another part.
    constexpr unsigned setting() const { return place_ >= first_part ? 0u : place_; }
    static constexpr unsigned most_settings = 119; ///< of a take-over

    // --- For who carries commands out

    /// The same, of a part of a take-over. `number`: of the setting, from 1.
    constexpr command_status in_part(take_over_part p, unsigned number) const {
        command_status s = *this;
        const unsigned place = p == take_over_part::setting ? number : first_part + static_cast<unsigned>(p);
        s.place_ = static_cast<std::uint8_t>(place & 0x7Fu);
        return s;
    }
    /// The same, at the terminal with this register.
    constexpr command_status at_terminal(std::uint16_t address) const {
        command_status s = *this;
        s.after_ = static_cast<std::uint16_t>(address + 1u);
        return s;
    }
    /// Replaces the error; the rest is kept.
    constexpr void end(errc why) { status_.end(why); }

  private:
    static constexpr unsigned first_part = most_settings + 1;

    servobus::status status_{};
    std::uint8_t step_ = 0;
    bool has_changed_ : 1 = false;
    std::uint8_t place_ : 7 = 0; // the number of a setting, or `first_part` and a part
    std::uint16_t after_ = 0;
};
static_assert(sizeof(command_status) == 8);

} // namespace servobus
