// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Checks the parts that a drive's model may leave out: each is defined or named in `leaves_out`, and a function has the form
// in which the machine calls it. A function of another name or form would never be called.
#pragma once

#include <cstdint>

#include <servobus/control/image.hpp>
#include <servobus/control/model_parts.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/step.hpp>
#include <servobus/core/response_limits.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

// A name that `Model` has, of whatever kind, is ambiguous in a class that also has it from `part_names`.
struct part_names {
    int admit, permit, fail, watchdog, slower, positions, is_fall, sets_origin, stops_after_restart,
        disable_replaces_quick_stop, moves_when_enabled, grant, grant_at_most;
};
template <class Model> struct with_part_names : Model, part_names {};

template <class Model, class Both = with_part_names<Model>> consteval bool has_part(model_part which) {
    // NOLINTBEGIN(bugprone-branch-clone): the names differ
    // clang-format off
    switch (which) {
    case model_part::admit: return !requires { &Both::admit; };
    case model_part::permit: return !requires { &Both::permit; };
    case model_part::fail: return !requires { &Both::fail; };
    case model_part::watchdog: return !requires { &Both::watchdog; };
    case model_part::slower: return !requires { &Both::slower; };
    case model_part::positions: return !requires { &Both::positions; };
    case model_part::is_fall: return !requires { &Both::is_fall; };
    case model_part::sets_origin: return !requires { &Both::sets_origin; };
    case model_part::stops_after_restart: return !requires { &Both::stops_after_restart; };
    case model_part::disable_replaces_quick_stop: return !requires { &Both::disable_replaces_quick_stop; };
    case model_part::moves_when_enabled: return !requires { &Both::moves_when_enabled; };
    case model_part::grant: return !requires { &Both::grant; };
    case model_part::grant_at_most: return !requires { &Both::grant_at_most; };
    }
    // clang-format on
    // NOLINTEND(bugprone-branch-clone)
    return false;
}
/// Returns true if the model either defines the part or leaves it out by name.
template <class Model> consteval bool is_stated(model_part which) {
    return has_part<Model>(which) != Model::leaves_out.has(which);
}

/// The forms of the functions: each is true for a function that the model leaves out.
template <class Model> struct optional_functions {
    using command = typename Model::prepared_command;
    using settings = typename Model::settings;

    static consteval bool admit() {
        return !has_part<Model>(model_part::admit) ||
               requires(Model m, command c, response_limits limits, bus_gaps gaps) {
            m.admit(c, limits, gaps);
        };
    }
    static consteval bool fail() {
        return !has_part<Model>(model_part::fail) ||
               requires(Model m, command c, const routine& steps, const routine_status& r, settings s,
                        duration watchdog) {
            m.fail(c, steps, r, true, s, watchdog);
        };
    }
    static consteval bool permit() {
        if constexpr (has_part<Model>(model_part::permit)) {
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
    static consteval bool is_fall() {
        if constexpr (has_part<Model>(model_part::is_fall)) {
            constexpr bool of_image =
                requires(const std::uint16_t* words, duration between, const settings& s) {
                Model::is_fall(words, words, between, s);
            };
            constexpr bool of_block = requires(const std::uint16_t* words, const settings& s) {
                Model::is_fall(words, words, s);
            };
            return of_image || of_block;
        } else {
            return true;
        }
    }
    static consteval bool sets_origin() {
        return !has_part<Model>(model_part::sets_origin) || requires(const command& c) {
            Model::sets_origin(c);
        };
    }
    static consteval bool moves_when_enabled() {
        return !has_part<Model>(model_part::moves_when_enabled) || requires(const settings& s) {
            Model::moves_when_enabled(s);
        };
    }
    static consteval bool grant() {
        return !has_part<Model>(model_part::grant) || requires(Model m, response_limits limits) {
            m.grant(limits);
        };
    }
    static consteval bool grant_at_most() {
        return !has_part<Model>(model_part::grant_at_most) || requires(Model m, duration response) {
            m.grant_at_most(response);
        };
    }
    static consteval bool watchdog() {
        return !has_part<Model>(model_part::watchdog) || requires(const settings& s) { Model::watchdog(s); };
    }
};

/// Compiles only if all of it is right.
template <class Model> consteval bool has_right_parts() {
    static_assert(is_stated<Model>(model_part::admit),
                  "a model defines `admit` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::permit),
                  "a model defines `permit` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::fail),
                  "a model defines `fail` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::watchdog),
                  "a model defines `watchdog` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::slower),
                  "a model defines `slower` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::positions),
                  "a model defines `positions` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::is_fall),
                  "a model defines `is_fall` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::sets_origin),
                  "a model defines `sets_origin` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::stops_after_restart),
                  "a model defines `stops_after_restart` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::disable_replaces_quick_stop),
                  "a model defines `disable_replaces_quick_stop` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::moves_when_enabled),
                  "a model defines `moves_when_enabled` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::grant),
                  "a model defines `grant` or names it in `leaves_out`: one of them");
    static_assert(is_stated<Model>(model_part::grant_at_most),
                  "a model defines `grant_at_most` or names it in `leaves_out`: one of them");
    static_assert(optional_functions<Model>::admit(),
                  "`admit` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::permit(),
                  "`permit` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::fail(),
                  "`fail` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::watchdog(),
                  "`watchdog` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::is_fall(),
                  "`is_fall` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::sets_origin(),
                  "`sets_origin` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::moves_when_enabled(),
                  "`moves_when_enabled` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::grant(),
                  "`grant` of the model has another form than device/README.md");
    static_assert(optional_functions<Model>::grant_at_most(),
                  "`grant_at_most` of the model has another form than device/README.md");
    return true;
}

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
