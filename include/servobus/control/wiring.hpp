// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The functions that a wiring gives to a drive's terminals, and in which order it writes them. The `wiring.hpp` of a
// device includes it.
//
//     const command_status got = wheels.run(zlac8015d::wire_inputs{.x0 = zlac8015d::input_function::undefined});
//     if (!got) std::printf("%s, at %04Xh\n", text(got.error()), got.register_address());
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/command_status.hpp>
#include <servobus/core/slice.hpp>

namespace servobus {

/// A function for a terminal. Made of nothing, the terminal keeps its own.
template <class Function> class wired {
  public:
    constexpr wired() = default;
    constexpr wired(Function does)
        : word_{static_cast<std::uint16_t>(does)} {} // NOLINT: `.di1 = home_switch`
    constexpr std::uint16_t word() const { return word_; }

    static constexpr std::uint16_t as_it_is = 0xFFFF;

  private:
    std::uint16_t word_ = as_it_is;
};

namespace commands {

/// Explains why a wiring has no plan. Not constexpr on purpose.
template <class Known> constexpr void is_run_by_a_facade() {
    static_assert(sizeof(Known) == 0, "a wiring is several commands: the facade of the drive runs it");
}

/// Decides which terminals are freed and which are assigned. Function 0 is none.
class wiring {
  public:
    static constexpr std::size_t most = 8;
    static constexpr std::size_t nowhere = most;

    constexpr explicit wiring(slice<const std::uint16_t> wanted) : size_{wanted.size()} {
        for (std::size_t i = 0; i < size_; ++i) wanted_[i] = wanted[i];
    }
    constexpr std::size_t size() const { return size_; }
    constexpr bool is_named(std::size_t i) const { return wanted_[i] != wired<std::uint16_t>::as_it_is; }
    constexpr std::uint16_t wanted(std::size_t i) const { return wanted_[i]; }
    /// The terminal that is to get this function; `nowhere` if none is.
    constexpr std::size_t place_of(std::uint16_t function) const {
        for (std::size_t i = 0; function != 0 && i < size_; ++i) {
            if (wanted_[i] == function) return i;
        }
        return nowhere;
    }
    /// The first terminal that is to get the function of one before it; `nowhere` if none is.
    constexpr std::size_t twice() const {
        for (std::size_t i = 0; i < size_; ++i) {
            if (is_named(i) && wanted_[i] != 0 && place_of(wanted_[i]) != i) return i;
        }
        return nowhere;
    }

    constexpr void hold(std::size_t i, std::uint16_t function) { held_[i] = function; }
    /// True if another terminal is to get the function of this one, or this one is to have none.
    constexpr bool is_freed(std::size_t i) const {
        const std::size_t to = place_of(held_[i]);
        return held_[i] != 0 && ((to != nowhere && to != i) || wanted_[i] == 0);
    }
    /// True if the terminal is to have a function that it does not have.
    constexpr bool is_assigned(std::size_t i) const {
        return is_named(i) && wanted_[i] != 0 && wanted_[i] != held_[i];
    }
    constexpr bool is_as_wanted() const {
        for (std::size_t i = 0; i < size_; ++i) {
            if (is_freed(i) || is_assigned(i)) return false;
        }
        return true;
    }
    /// Calls `put(i, function)` for each terminal that is freed, then for each that is assigned, until one fails.
    template <class Put> constexpr command_status each(Put&& put) const {
        for (unsigned pass = 0; pass < 2; ++pass) {
            const bool assigns = pass == 1;
            for (std::size_t i = 0; i < size_; ++i) {
                if (assigns ? !is_assigned(i) : !is_freed(i)) continue;
                const command_status how = put(i, assigns ? wanted_[i] : std::uint16_t{0});
                if (!how) return how;
            }
        }
        return {};
    }

  private:
    std::size_t size_;
    std::uint16_t wanted_[most]{};
    std::uint16_t held_[most]{};
};

} // namespace commands
} // namespace servobus
