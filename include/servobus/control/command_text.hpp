// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names of commands and of steps, for messages. Programs that print how their commands ended include it; it costs
// other programs nothing.
//
//     template <class Drive, class Command> bool tried(Drive& drive, const Command& wanted) {
//         const command_status r = drive.run(wanted);
//         if (!r) std::printf("%s: %s\n", command_text<Command>, text(r.error())); // move_by: no response
//         return static_cast<bool>(r);
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>

#include <servobus/control/step.hpp>

namespace servobus {

namespace detail {
struct type_name {
    char letters[48]{};
};
// The compiler spells the type in the name of the function, after "Command = ".
template <class Command> consteval type_name name_of_type() {
    const char* const all = __PRETTY_FUNCTION__; // NOLINT: it decays on purpose
    constexpr char before[] = "Command = ";
    std::size_t at = 0;
    for (std::size_t matched = 0; matched + 1 < sizeof before; ++at)
        matched = all[at] == before[matched] ? matched + 1 : all[at] == before[0] ? 1 : 0;
    std::size_t first = at; // after the last "::" of its namespaces
    for (; all[at] != ']' && all[at] != ';' && all[at] != '<'; ++at) first = all[at] == ':' ? at + 1 : first;
    type_name name;
    for (std::size_t i = 0; first + i < at && i + 1 < sizeof name.letters; ++i)
        name.letters[i] = all[first + i];
    return name;
}
template <class Command> inline constexpr type_name name_of = name_of_type<Command>();
} // namespace detail

/// The name of a command's class without its namespace, at most 47 letters: "move_by". An alias has the name of its
/// class template, `yako::closed_loop::home` "basic_home".
template <class Command> inline constexpr const char* command_text = detail::name_of<Command>.letters;

/// The work of a step in words. Its register is `command_status::register_address()` of a command that ended there.
constexpr const char* text(step::kind what) {
    switch (what) {
    case step::kind::write: return "write";
    case step::kind::expect: return "read and compare";
    case step::kind::until: return "read until it is as expected";
    case step::kind::fetch: return "read";
    case step::kind::permit: return "read whether the command may begin";
    case step::kind::confirm: return "read until the command is carried out";
    case step::kind::witness: return "read whether the drive has restarted";
    }
    return "unknown";
}

} // namespace servobus
