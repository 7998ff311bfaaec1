// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the inputs of the simulated C630S: real and virtual terminals, their functions and logics, the
// functions that are active, and the edges that have not been used yet. Source: manual V24.111, sections 6.4,
// 7.3, 7.12 and 7.16.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/sim/c630s/detail/memory.hpp>

namespace servobus::sim::detail {

/// A set of input functions, FunIN.n as bit n.
struct c630s_functions {
    std::uint64_t bits = 0;

    static constexpr std::uint64_t bit_of(std::int64_t function) {
        return function > 0 && function < 64 ? std::uint64_t{1} << function : 0;
    }
    constexpr bool has(coolmay::input_function f) const {
        return (bits & bit_of(static_cast<std::int64_t>(f))) != 0;
    }
};

class c630s_inputs {
  public:
    using function = coolmay::input_function;
    using memory = c630s_memory;

    constexpr bool is_active(function f) const { return active_.has(f); }
    /// True once for each edge of a terminal with this function.
    constexpr bool take_edge(function f) {
        const bool came = edges_.has(f);
        edges_.bits &= ~c630s_functions::bit_of(static_cast<std::int64_t>(f));
        return came;
    }
    constexpr void drop_edges() { edges_ = {}; }

    /// The levels of DI1 to DI8, after forcing: bit n - 1, 1 for high.
    constexpr std::uint16_t levels(const memory& m) const {
        const auto forcing = m.get(coolmay::terminal_forcing);
        const bool is_forced = forcing == coolmay::forcing::inputs_only || forcing == coolmay::forcing::both;
        return is_forced ? static_cast<std::uint16_t>(m[coolmay::forced_inputs.address] & 0xFF) : levels_;
    }
    /// Switches the current through DI `number`, 1..8. An open terminal is high.
    constexpr void set_conduction(unsigned number, bool conducts, const memory& m) {
        if (number < 1 || number > 8) return;
        const unsigned bit = 1u << (number - 1);
        levels_ = static_cast<std::uint16_t>(conducts ? levels_ & ~bit : levels_ | bit);
        look(m);
    }
    /// Makes every DI with this function active or inactive.
    constexpr void drive(function f, bool is_active, const memory& m) {
        for (unsigned n = 1; n <= 8; ++n) {
            if (di_function(m, n) != static_cast<std::int64_t>(f)) continue;
            const bool high_is_active = logic_of(m, n) == coolmay::input_logic::high_level;
            set_conduction(n, is_active != high_is_active, m);
        }
    }
    /// Sets all virtual levels, as a write on the bus does.
    constexpr void set_virtual(std::uint16_t word, const memory& m) {
        virtual_ = word;
        look(m);
    }

    /// Power on: present levels do not count as edges.
    constexpr void switch_on(const memory& m) {
        virtual_ = static_cast<std::uint16_t>(m[coolmay::virtual_inputs_at_power_on.address] |
                                              m[coolmay::virtual_input_levels.address]);
        at_power_on_ = static_cast<std::uint64_t>(m[coolmay::power_on_functions_1_to_16.address]) << 1 |
                       static_cast<std::uint64_t>(m[coolmay::power_on_functions_17_to_32.address]) << 17 |
                       static_cast<std::uint64_t>(m[coolmay::power_on_functions_33_to_48.address]) << 33;
        restart(m);
    }
    /// Recomputes the active functions after functions or logics have changed; no edge results.
    constexpr void restart(const memory& m) {
        seen_ = levels(m);
        seen_virtual_ = virtual_;
        active_ = find_active(m);
        edges_ = {};
    }
    /// Recomputes the active functions if a parameter has changed.
    constexpr void refresh(const memory& m) {
        if (m.changes() != seen_changes_) look(m);
    }

    /// True if two terminals have the same function: Er.130. `counts_disabled`: virtual terminals count even
    /// while they are disabled.
    static constexpr bool has_duplicates(const memory& m, bool counts_disabled) {
        std::uint64_t seen = 0;
        bool is_double = false;
        const auto add = [&](std::int64_t f) {
            const std::uint64_t bit = c630s_functions::bit_of(f);
            is_double = is_double || (seen & bit) != 0;
            seen |= bit;
        };
        for (unsigned n = 1; n <= 8; ++n) add(di_function(m, n));
        const bool counts_virtual = counts_disabled || m.is_on(coolmay::virtual_inputs_enable);
        for (unsigned n = 1; n <= 16 && counts_virtual; ++n) add(vdi_function(m, n));
        return is_double;
    }

  private:
    static constexpr std::uint16_t at(std::uint16_t first, unsigned number) {
        return static_cast<std::uint16_t>(first + 2 * (number - 1));
    }
    static constexpr std::int64_t di_function(const memory& m, unsigned n) {
        return m[at(coolmay::di1_function.address, n)];
    }
    static constexpr std::int64_t vdi_function(const memory& m, unsigned n) {
        return m[at(coolmay::virtual_input_functions[0].address, n)];
    }
    // A home switch and XintInhibit use levels only: an edge logic counts as the level after the edge.
    static constexpr coolmay::input_logic logic_of(const memory& m, unsigned n) {
        using logic = coolmay::input_logic;
        const auto set = static_cast<logic>(m[at(coolmay::di1_logic.address, n)]);
        const auto f = static_cast<function>(di_function(m, n));
        if (f != function::home_switch && f != function::interrupt_inhibit) return set;
        if (set == logic::rising_edge) return logic::high_level;
        return set == logic::falling_edge || set == logic::both_edges ? logic::low_level : set;
    }
    static constexpr bool has_virtual_edge(const memory& m, unsigned n) {
        return m[at(coolmay::virtual_input_logics[0].address, n)] != 0;
    }
    static constexpr bool is_edge(coolmay::input_logic l, bool is_high) {
        using logic = coolmay::input_logic;
        return l == logic::both_edges || l == (is_high ? logic::rising_edge : logic::falling_edge);
    }

    // Finds edges and active functions after a change of levels, functions or logics.
    constexpr void look(const memory& m) {
        const unsigned now = levels(m);
        for (unsigned n = 1; n <= 8; ++n) {
            const bool is = (now >> (n - 1) & 1u) != 0;
            const bool was = (static_cast<unsigned>(seen_) >> (n - 1) & 1u) != 0;
            if (is != was && is_edge(logic_of(m, n), is))
                edges_.bits |= c630s_functions::bit_of(di_function(m, n));
        }
        for (unsigned n = 1; n <= 16 && m.is_on(coolmay::virtual_inputs_enable); ++n) {
            const bool rises = (virtual_ & ~seen_virtual_ & 1u << (n - 1)) != 0;
            if (rises && has_virtual_edge(m, n)) edges_.bits |= c630s_functions::bit_of(vdi_function(m, n));
        }
        seen_ = static_cast<std::uint16_t>(now);
        seen_virtual_ = virtual_;
        seen_changes_ = m.changes();
        const c630s_functions found = find_active(m);
        edges_.bits |= found.bits & ~active_.bits; // for edge functions on a level
        active_ = found;
    }

    constexpr c630s_functions find_active(const memory& m) const {
        std::uint64_t bits = at_power_on_;
        const unsigned now = levels(m);
        for (unsigned n = 1; n <= 8; ++n) {
            const bool is_high = (now >> (n - 1) & 1u) != 0;
            const coolmay::input_logic l = logic_of(m, n);
            if (l == (is_high ? coolmay::input_logic::high_level : coolmay::input_logic::low_level))
                bits |= c630s_functions::bit_of(di_function(m, n));
        }
        for (unsigned n = 1; n <= 16 && m.is_on(coolmay::virtual_inputs_enable); ++n) {
            const bool is_one = (virtual_ >> (n - 1) & 1) != 0;
            if (is_one && !has_virtual_edge(m, n)) bits |= c630s_functions::bit_of(vdi_function(m, n));
        }
        return {bits};
    }

    std::uint64_t at_power_on_ = 0;
    c630s_functions active_{};
    c630s_functions edges_{};
    std::uint16_t levels_ = 0xFF;
    std::uint16_t seen_ = 0xFF;
    std::uint16_t virtual_ = 0;
    std::uint16_t seen_virtual_ = 0;
    std::uint32_t seen_changes_ = 0;
};

} // namespace servobus::sim::detail
