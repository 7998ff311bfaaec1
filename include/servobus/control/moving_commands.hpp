// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Tells at compile time which commands energise a motor or move it, for what must not do so by itself: a take-over. The
// author of a drive declares those whose plan does not show it.
//
//     static_assert(!may_move<zlac8015d::model, zlac8015d::ramps>);
//     static_assert(may_move<zlac8015d::model, zlac8015d::wheel_velocities> && may_move<zlac8015d::model, enable>);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <type_traits>
#include <utility>

#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>

namespace servobus {

namespace detail {
template <class Command>
concept stated_to_move = requires(const Command* c) {
    moves_or_energises(c);
};
template <class Command>
concept stated_not_to_move = requires(const Command* c) {
    neither_moves_nor_energises(c);
};
// A command without arguments, or with ones that have a default, is planned as if nothing were known of the drive.
template <class Model, class Command>
concept planned_by_default = requires {
    typename std::bool_constant<(static_cast<void>(Command{}.prepare(Model::unknown)), true)>;
};

template <class Model, class Command> consteval bool is_moving_command() {
    if constexpr (std::same_as<Command, enable> || stated_to_move<Command>) {
        return true;
    } else if constexpr (!stated_not_to_move<Command> && planned_by_default<Model, Command>) {
        constexpr auto then = Command{}.prepare(Model::unknown).then;
        constexpr command_kind kind = Model::kinds[then];
        return kind == command_kind::endless_motion || kind == command_kind::move || Model::kinds.moves(then);
    } else {
        return false;
    }
}
} // namespace detail

/// True for `enable`, for the commands for which the drive's namespace declares `moves_or_energises(const Command*)`,
/// and for those whose plan has the kind of a motion by `Model::kinds`. A drive whose plan of a command shows less
/// declares it, as one with an `enable` of its own does; `neither_moves_nor_energises` for one whose plan shows more.
template <class Model, class Command>
inline constexpr bool may_move = detail::is_moving_command<Model, Command>();

namespace detail {
template <class Drive>
using model_of_drive = std::remove_cvref_t<decltype(std::declval<const Drive&>().machine().known().model())>;
} // namespace detail

} // namespace servobus
