// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a drive's model answers: may a command begin, what does the feedback say, what has a command changed, how is the
// drive stopped? `drive_model` checks every name and every form. device/README.md explains each.
//
//     template <servobus::drive_model Model> constexpr bool stops(servobus::stop_priority how) {
//         return Model::stop_for(how, Model::unknown, false).stop == how;
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>

#include <servobus/control/command_status.hpp>
#include <servobus/control/drive_traits.hpp>
#include <servobus/control/image.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// A constant of a model that has no default: one that is left out does not compile.
template <class T> class must_be_stated {
  public:
    constexpr must_be_stated(T value) : value_{value} {} // NOLINT: implicit, `.after_restart = true`
    constexpr operator T() const { return value_; }      // NOLINT: likewise

  private:
    T value_;
};

/// When a drive is stopped although no command asks for it, and what its stops replace.
struct stop_rules {
    /// The stop that answers a fault.
    must_be_stated<stop_priority> at_fault;
    /// True for a drive that may be energised after a restart: a command may reach it before the restart shows.
    must_be_stated<bool> after_restart;
    /// True if `disable` also replaces a quick stop that is under way.
    must_be_stated<bool> disable_replaces_quick_stop;
};

/// The answers to a step that asks the model.
struct situation {
    const std::uint16_t* image;       ///< the process image
    slice<const std::uint16_t> words; ///< what the routine has read (`steps::fetch`)
    /// From the start of the last motion to the image, kept between one and two minutes once it is longer. Of a command
    /// that energises the motor or frees it: from the step before.
    duration waited;
};

/// A block of the feedback that has come.
struct block_feedback {
    std::uint8_t block;                    ///< its number in the model's `blocks`
    const std::uint16_t* words;            ///< as many as it has registers
    const std::uint16_t* before = nullptr; ///< to `has_fallen`: the words of the refresh before it; else null
    duration between{};                    ///< to `has_fallen`: from that refresh to this one
    instant taken{};                       ///< when its request began to leave: the values are no older
    std::uint16_t epoch = 0;               ///< positions of two refreshes can be compared if it is the same
};

/// The end of a command.
struct ending {
    bool is_done;                     ///< false: it has failed
    routine steps;                    ///< the table that has ended
    const command_status& status;     ///< how, and at which of its steps
    slice<const std::uint16_t> words; ///< what it has read
    /// The time of the drive's watchdog, which a command that failed may have made shorter.
    duration& watchdog;
    /// The limits of the drive's responses, for a drive that says itself how late they come.
    response_limits& limits;
};

namespace detail {
template <class Model, class Command, class Settings>
concept answers = requires(Model m, Command& c, const Command& planned, Settings& known, const Settings& read,
                           const situation& now, const block_feedback& r, const ending& e) {
    { m.admit(c, duration{}) } -> std::same_as<errc>;
    { m.permit(c, now, known) } -> std::same_as<errc>;
    { Model::is_faulted(now.image, read) } -> std::same_as<bool>;
    { m.judge(now.image, known) } -> std::same_as<servobus::verdict>;
    { m.has_fallen(r, read) } -> std::same_as<bool>;
    m.note(r, known);
    { m.confirm(planned, now, known) } -> std::same_as<errc>;
    { m.learn(c, e, known) } -> std::same_as<errc>;
    m.preempt(planned);
    { Model::stop_for(stop_priority::halt, read, true) } -> std::same_as<Command>;
    { Model::witness(read, planned) } -> std::same_as<steps::recheck>;
    { Model::watchdog(read) } -> std::same_as<duration>;
    { Model::kinds[c.then] } -> std::same_as<command_kind>;
    { Model::kinds.sets_origin(c.then) } -> std::same_as<bool>;
    { Model::kinds.moves(c.then) } -> std::same_as<bool>;
};
} // namespace detail

/// A class that describes a drive for its facade: constants, and answers to the questions of device/README.md.
template <class Model>
concept drive_model = requires {
    { Model::traits } -> std::convertible_to<drive_traits>;
    { Model::unknown } -> std::convertible_to<typename Model::settings>;
    { Model::stops } -> std::convertible_to<stop_rules>;
    { Model::kinds.is_complete() } -> std::same_as<bool>;
    { Model::blocks[0] } -> std::convertible_to<register_block>;
    requires Model::blocks.positions() < Model::blocks.size();
}
&&detail::answers<Model, typename Model::prepared_command, typename Model::settings>;

} // namespace servobus
