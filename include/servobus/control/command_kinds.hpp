// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The kind of each effect that a drive's commands have: a table that the compiler checks to be complete. The author of
// a drive gives it as `kinds` of the model; control/facade.hpp reads it.
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
inline void a_kind_is_given_before_what_else_an_effect_does() {}
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
        // A drive that is taken over may be another one, or have restarted.
        if (kind == command_kind::take_over) (all.mark(those, new_origin), ...);
        return all;
    }
    /// States the effects after which positions are counted from elsewhere: a homing, a position that is cleared. None
    /// is stated too: `with_new_origin()`.
    template <class... Effects> consteval command_kinds with_new_origin(Effects... those) const {
        command_kinds all = *this;
        all.are_origins_stated_ = true;
        (all.mark(those, new_origin), ...);
        return all;
    }
    /// States the effects of commands that energise a motor which then moves by itself.
    template <class... Effects> consteval command_kinds with_motion(Effects... those) const {
        command_kinds all = *this;
        (all.mark(those, motion), ...);
        return all;
    }
    /// True if `with_new_origin` was stated.
    constexpr bool are_origins_stated() const { return are_origins_stated_; }
    /// True if each effect has a kind.
    constexpr bool is_complete() const {
        for (const std::uint8_t kind : kinds_) {
            if (kind == missing) return false;
        }
        return true;
    }
    constexpr command_kind operator[](Effect e) const {
        return static_cast<command_kind>(kinds_[static_cast<std::size_t>(e)] & ~(new_origin | motion));
    }
    /// True if an effect has a motion by itself.
    constexpr bool has_motion() const {
        for (const std::uint8_t kind : kinds_) {
            if (kind != missing && (kind & motion) != 0) return true;
        }
        return false;
    }
    constexpr bool sets_origin(Effect e) const { return has(e, new_origin); }
    constexpr bool moves(Effect e) const { return has(e, motion); }

  private:
    static constexpr std::uint8_t missing = 0xFF;
    static constexpr std::uint8_t new_origin = 0x80;
    static constexpr std::uint8_t motion = 0x40;

    constexpr bool has(Effect e, std::uint8_t mark) const {
        return (kinds_[static_cast<std::size_t>(e)] & mark) != 0;
    }
    consteval void mark(Effect e, std::uint8_t as) {
        std::uint8_t& entry = kinds_[static_cast<std::size_t>(e)];
        if (entry == missing) detail::a_kind_is_given_before_what_else_an_effect_does();
        entry = static_cast<std::uint8_t>(entry | as);
    }

    consteval void set(command_kind kind, Effect e) {
        std::uint8_t& entry = kinds_[static_cast<std::size_t>(e)];
        if (entry != missing) detail::an_effect_has_one_kind();
        entry = static_cast<std::uint8_t>(kind);
    }

    std::uint8_t kinds_[effects]{};
    bool are_origins_stated_ = false;
};

} // namespace servobus
