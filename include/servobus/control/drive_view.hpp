// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a facade tells of its drive: its state, how its last command ended, and, to the drive's own facade, its
// feedback. control/facade.hpp includes it.
//
//     template <class Model, class Line> bool may_enable(const drive_view<Model, Line>& seen) {
//         return seen.is_idle() && seen.state() == drive_state::disabled;
//     }
#pragma once

#include <cstdint>

#include <servobus/control/drive_machine.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/drive_traits.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// A machine with its line, as a facade shows it.
template <class Model, class Line> class drive_view {
    static_assert(Model::kinds.is_complete(),
                  "an effect has no kind: each is listed in the `kinds` of the model");
    static_assert(Model::kinds.are_origins_stated(),
                  "which commands have a new origin is stated: `with_new_origin()` of `kinds`, for none too");
    static_assert(image_block<Model>.words != 0, "the feedback of a model is at least one register");
    static_assert(image_block<Model>.words <= steps::longest,
                  "the feedback of a model is at most 11 registers");
    static_assert(Model::traits.stops_without_line == (Model::watchdog(Model::unknown) != duration{}),
                  "a drive that stops without its line has a watchdog, also while its settings are unknown");
    static_assert(drive_model<Model>,
                  "a model has each part of device/README.md, in the form that it has there");

  public:
    using model_type = Model;
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;
    using machine_type = drive_machine<Model, typename Line::exchange>;
    /// In which respects the drive differs from others.
    static constexpr drive_traits traits = Model::traits;

    /// True if no command is under way, nor a stop of a supervisor.
    constexpr bool is_idle() const { return machine_.slot().is_idle(); }
    /// How the application's last command ended; meaningful when idle. A copy, since the next command has another.
    constexpr routine_status last() const { return machine_.slot().report(); }
    /// `faulted` if the last feedback shows a fault.
    constexpr drive_state state() const { return machine_.known().state(); }
    /// Returns the settings as far as they are known now.
    constexpr settings cached() const { return machine_.known().cached(); }
    /// Why the drive stopped following its last motion command; `unknown` while it follows.
    constexpr stop_cause cause() const { return machine_.known().cause(); }
    /// The drive does not respond. One with a watchdog has not for its time; any other has not to three refreshes in a
    /// row, and is then read once a second, on a bus once in the retry period of its plan.
    constexpr bool is_absent() const { return machine_.known().is_absent(); }

    constexpr std::uint8_t address() const { return machine_.address(); }
    constexpr Line& line() const { return *line_; }
    /// Gives a bus, or a test, the machine: what is to be sent, and since when it waits.
    constexpr machine_type& machine() { return machine_; }
    constexpr const machine_type& machine() const { return machine_; }

  protected:
    template <class Node>
    constexpr drive_view(Line& on, const Node& at, duration feedback, command_timeout limit)
        : line_{&on}, machine_{at, feedback, limit} {}
    ~drive_view() = default;

    constexpr const Model& model() const { return machine_.known().model(); }
    constexpr Model& model() { return machine_.model(); }
    constexpr const std::uint16_t* image() const { return machine_.known().image(); }
    /// Errors of feedback that may be at most so old: `needs_init` where nothing is known of the drive, `busy` while a
    /// command changes settings, `timeout` if it is older or none was read since.
    constexpr errc check_feedback(duration oldest) const {
        if (!machine_.known().is_known()) return errc::needs_init;
        // The command under way may change what values mean.
        const auto& slot = machine_.slot();
        if (slot.is_at(command_kind::setting) || slot.is_at(command_kind::take_over)) return errc::busy;
        return machine_.known().is_young(oldest, line_->now()) ? errc::ok : errc::timeout;
    }
    /// Returns what the last routine fetched.
    constexpr slice<const std::uint16_t> words() const { return machine_.slot().run().words(); }
    /// From the start of the last motion to the image; zero for an image that is older. It goes back from two minutes
    /// to one: times are not compared over a wrap of the clock.
    constexpr duration since_start() const { return machine_.known().since_start(); }
    /// True while a move begins: the one before has no arrival any more.
    constexpr bool is_move_beginning() const { return machine_.slot().is_at(command_kind::move); }
    /// A move that seems to be under way has been cut by a fault: its stop may be under way.
    constexpr bool is_ended_by_fault(arrival_state how) const {
        return how == arrival_state::under_way && cause() == stop_cause::fault;
    }
    /// The settings are those of the drive as it is now: no request without a response since the last check.
    constexpr bool is_verified() const { return machine_.known().is_verified(line_->epoch(address())); }
    constexpr const prepared_command& current() const { return machine_.slot().command(); }
    constexpr bool is_faulted() const { return machine_.known().is_faulted(); }
    /// The blocks of the feedback that are read less often.
    constexpr const slower_blocks<Model>& slower() const { return machine_.known().polling().slower(); }

    Line* line_;
    machine_type machine_;
};

} // namespace servobus
