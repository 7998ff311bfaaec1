// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads what a drive's model may leave out, and checks that its optional functions have the form in which its machine
// calls them: one of another form would never be called.
#pragma once

#include <cstdint>

#include <servobus/control/routine_status.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

template <class Model> struct optional_functions {
    using command = typename Model::prepared_command;
    using settings = typename Model::settings;

    static consteval bool admit() {
        if constexpr (requires { &Model::admit; }) {
            return requires(Model m, command c, response_limits limits, bus_gaps gaps) {
                m.admit(c, limits, gaps);
            };
        } else {
            return true;
        }
    }
    static consteval bool fail() {
        if constexpr (requires { &Model::fail; }) {
            return requires(Model m, command c, const routine& steps, const routine_status& r, settings s,
                            duration watchdog) {
                m.fail(c, steps, r, true, s, watchdog);
            };
        } else {
            return true;
        }
    }
    static consteval bool permit() {
        if constexpr (requires { &Model::permit; }) {
            constexpr bool by_image = requires(Model m, command c, const std::uint16_t* image, settings s) {
                m.permit(c, image, s);
            };
            constexpr bool by_words =
                requires(Model m, command c, slice<const std::uint16_t> words, settings s) {
                m.permit(c, words, s);
            };
            return by_image || by_words;
        } else {
            return true;
        }
    }
    static consteval bool watchdog() {
        if constexpr (requires { &Model::watchdog; }) {
            return requires(const settings& s) { Model::watchdog(s); };
        } else {
            return true;
        }
    }
};

/// Returns true for a drive that may be energised after a restart, which is therefore stopped.
template <class Model> consteval bool stops_after_restart() {
    if constexpr (requires { Model::stops_after_restart; }) {
        return Model::stops_after_restart;
    } else {
        return false;
    }
}
/// Returns true for a command that changes where positions are counted from.
template <class Model> constexpr bool sets_origin(const typename Model::prepared_command& c) {
    if constexpr (requires { Model::sets_origin(c); }) {
        return Model::sets_origin(c);
    } else {
        return false;
    }
}

} // namespace servobus::detail
