// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The kind of each effect that a drive's commands have: a table that the compiler checks to be complete. The author of a
// drive gives it as `kinds` of the model; control/facade.hpp reads it.
//
//     enum class effect : std::uint8_t { none, initialised, enabled, disabled, end };
//     constexpr auto kinds = command_kinds<effect>{}
//                                .of(command_kind::other, effect::none)
//                                .of(command_kind::take_over, effect::initialised)
//                                .of(command_kind::power, effect::enabled, effect::disabled);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/control/states.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a table that calls one does not compile, and the error names the rule.
inline void an_effect_has_one_kind() {}
} // namespace detail

/// A kind for each enumerator of `Effect`, which has no gaps. The last one is `end`, which has no kind.
template <class Effect> class command_kinds {
  public:
    static constexpr std::size_t effects = static_cast<std::size_t>(Effect::end);

    consteval command_kinds() {
        for (std::uint8_t& kind : kinds_) kind = missing;
    }
    /// Returns the table with these effects added. An effect that has a kind already does not compile.
    template <class... Effects> consteval command_kinds of(command_kind kind, Effects... those) const {
        command_kinds all = *this;
        (all.set(kind, those), ...);
        return all;
    }
    /// True if each effect has a kind.
    constexpr bool is_complete() const {
        for (const std::uint8_t kind : kinds_) {
            if (kind == missing) return false;
        }
        return true;
    }
    constexpr command_kind operator[](Effect e) const {
        return static_cast<command_kind>(kinds_[static_cast<std::size_t>(e)]);
    }

  private:
    static constexpr std::uint8_t missing = 0xFF;

    consteval void set(command_kind kind, Effect e) {
        std::uint8_t& entry = kinds_[static_cast<std::size_t>(e)];
        if (entry != missing) detail::an_effect_has_one_kind();
        entry = static_cast<std::uint8_t>(kind);
    }

    std::uint8_t kinds_[effects]{};
};

} // namespace servobus
