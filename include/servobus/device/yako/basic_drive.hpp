// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: what the facades of both variants share. Commands (commands.hpp,
// parameters.hpp) are run to their end, or begun and stepped in a loop that never waits. The facade caches
// the settings of the drive and invalidates them when they may have changed; it is not a safety function.
// yako/drive.hpp includes it; code for both variants takes a `basic_drive`:
//
//     template <class Device, class Line> bool advance(yako::basic_drive<Device, Line>& axis) {
//         const yako::arrival there = axis.run(move_by{5000 * pulse}, wait_reached{});
//         return there.how == arrival_state::reached;
//     }
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/device/yako/model.hpp>

namespace servobus::yako {

/// One drive on a line; `closed_loop::drive` or `open_loop::drive`.
///
///     yako::closed_loop::drive axis{wire, 1};
///     if (!axis.run(init{})) ...
///     if (!axis.run(enable{})) ...
///     if (!axis.run(home{homing::home_24})) ...
///     if (!axis.run(move_to{5000 * pulse})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` in each loop iteration. After an unknown
/// outcome or a restart of the drive the state is `needs_init`, and no motion is commanded until `init` has run.
/// A restart shows as `restart_visible()` says.
template <class Device, class Line, class Model = model<Device>>
class basic_drive : public facade<Model, Line> {
    using base = facade<Model, Line>;

  public:
    constexpr explicit basic_drive(Line& on, std::uint8_t at = 1, const supervision& by = without_watchdog)
        : basic_drive{on, servobus::node<Device>{at}, by} {}
    /// With limits and gaps of its own.
    constexpr basic_drive(Line& on, const servobus::node<Device>& at,
                          const supervision& by = without_watchdog)
        : base{on, at, by.feedback, by.command_timeout} {}

    /// The word order of 32-bit values; `unknown` before `init`, while a command may change it, and after a
    /// request without a response until the drive was checked.
    constexpr word_order current_word_order() const {
        const effect due = this->is_idle() ? effect::none : this->current().then;
        const bool may_change =
            due == effect::word_order_set || due == effect::forgotten || due == effect::reset;
        return may_change || !this->is_verified() ? word_order::unknown : this->cached().word_order;
    }
    /// Whether a restart of the drive shows: by a marker in a register that the drive loses, read every 500 ms,
    /// after each request without a response, and before and after each motion command. False before `init`,
    /// and where position segment 16, which has the marker, is in use: then a restart shows only by a homing, a
    /// word order, a speed resolution or a profile that is lost. A drive that keeps all registers over a
    /// restart, which the manual does not rule out, shows none [errata A53, A55].
    constexpr bool restart_visible() const { return this->cached().is_marked; }

    /// The feedback, read at most `oldest` ago. Errors: `needs_init`; `busy` while a command changes settings, and
    /// during `init`; `timeout` if it is older or none was read.
    constexpr result<basic_feedback<Device>> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return last_feedback();
    }
    /// Whether the last motion that was commanded was seen to begin; after a start that ended `unknown`,
    /// whether the motor was found running or away from its place. `unknown` for a move that interrupts
    /// another: which of the two runs cannot be seen; and for one to zero that is over when the feedback is
    /// read, since a drive that keeps its registers over a restart may look the same [errata A55].
    constexpr motion_check motion() const { return this->model().motion(); }
    /// Where the last move has come to, by the last feedback; `none` in the state `needs_init`, for a move whose target
    /// is not known since it interrupted another, and for one beyond 2^31 pulses that ends where a counter may stop. A
    /// wired stop, a limit switch or a software limit is its cause once `wait_reached` or `wait_standstill` has read
    /// the inputs, if they are still active.
    constexpr yako::arrival arrival() const {
        if (this->is_move_beginning()) return {};
        yako::arrival a = this->model().arrival_of(this->image(), this->since_start(), this->cached());
        if (this->is_ended_by_fault(a.how)) a.how = arrival_state::stopped_short;
        if (a.how != arrival_state::stopped_short) return a;
        a.cause = this->cause() != stop_cause::unknown ? this->cause() : this->model().cause();
        return a;
    }

    constexpr yako::arrival arrival(const wait_reached&) const { return arrival(); }

    /// Runs a command to its end. Waits. Errors: those of the command.
    template <class Wanted> [[gnu::always_inline]] command_status run(const Wanted& wanted) {
        check_variant<Wanted>();
        return base::run(wanted);
    }
    /// Runs a command that is made of others, such as `take_over`. Waits. Returns which of them failed, and how.
    template <commands::made_of_commands Wanted> command_status run(const Wanted& wanted) {
        return wanted.run_by(*this, [this](const auto& part) { return this->run(part); });
    }
    /// Starts a command; `step` moves it on. Errors: those of the command.
    template <class Wanted> [[gnu::always_inline]] constexpr command_status begin(const Wanted& wanted) {
        check_variant<Wanted>();
        return base::begin(wanted);
    }
    /// Runs a move and waits for its end. Returns how that was; `none` if the move did not begin, as `last`
    /// says.
    template <class Move> yako::arrival run(const Move& move, const wait_reached& end) {
        commands::check_target<Move>();
        if (!run(move)) return {};
        (void)base::run(end);
        return arrival();
    }

    /// Reads error, status, terminals, position and speed in one frame.
    result<basic_feedback<Device>> read() {
        const command_status r = base::run(read_feedback{});
        if (!r) return servobus::status{r};
        return last_feedback();
    }

  private:
    constexpr basic_feedback<Device> last_feedback() const {
        const cached_settings& known = this->cached();
        return basic_feedback<Device>::from_words({this->image(), Model::blocks.image().words},
                                                  known.word_order, known.resolution);
    }
    template <class Wanted> static constexpr void check_variant() {
        if constexpr (requires { typename Wanted::device; }) {
            static_assert(belongs_to<typename Wanted::device, Device>,
                          "this command belongs to the other variant of the drive");
        }
    }
};

} // namespace servobus::yako
