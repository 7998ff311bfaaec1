// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Finds the inputs of a C630S whose function is active, and functions that two inputs have.
// Source: manual V24.111, sections 6.4, 7.3 and 7.16.
#pragma once

#include <servobus/device/c630s/registers.hpp>

#include "check.hpp"

namespace tool::diagnosis::c630s_rules {

namespace c630s = servobus::c630s;
using c630s::input_function;

inline u16 function_register(unsigned di) {
    return static_cast<u16>(c630s::di1_function.address + 2 * (di - 1));
}
inline u16 virtual_register(unsigned vdi) { return c630s::virtual_input_functions[vdi - 1].address; }

/// A wired input, or a virtual one, by the register of its function. Its logic is in the register after it.
struct terminal {
    u16 function = 0; ///< 0: there is none
    unsigned number = 0;
    bool is_virtual = false;

    bool is_none() const { return function == 0; }
    u16 logic() const { return static_cast<u16>(function + 1); }
    u16 levels() const {
        return is_virtual ? c630s::virtual_input_levels.address : c630s::input_conduction.address;
    }
    /// Its bit: a wired input conducts, a virtual one is set.
    bool is_one(const held_registers& r) const {
        return (static_cast<unsigned>(r.word(levels())) >> (number - 1) & 1u) != 0;
    }
    bool has(const held_registers& r, input_function f) const {
        return r.word(function) == static_cast<u16>(f);
    }
};

/// The inputs that count: all wired ones, also those without a contact, and the virtual ones while they are switched
/// on.
inline std::vector<terminal> terminals(const held_registers& r) {
    std::vector<terminal> all;
    for (unsigned di = 1; di <= 8; ++di) all.push_back({function_register(di), di, false});
    for (unsigned vdi = 1; vdi <= 16 && r.word(c630s::virtual_inputs_enable) != 0; ++vdi)
        all.push_back({virtual_register(vdi), vdi, true});
    return all;
}

// A wired input that conducts is low. Edges are no levels.
inline bool is_active(const held_registers& r, const terminal& t) {
    if (t.is_virtual)
        return t.is_one(r) && r.word(t.logic()) == static_cast<u16>(c630s::virtual_input_logic::one);
    const auto logic = static_cast<c630s::input_logic>(r.word(t.logic()));
    return logic == (t.is_one(r) ? c630s::input_logic::low_level : c630s::input_logic::high_level);
}

/// The active input that has the function. `value`: the function.
inline terminal active_terminal(const held_registers& r, const check& c) {
    for (const terminal& t : terminals(r)) {
        if (t.has(r, static_cast<input_function>(c.value)) && is_active(r, t)) return t;
    }
    return {};
}
inline bool is_given(const held_registers& r, const check& c) { return !active_terminal(r, c).is_none(); }
inline watched active_registers(const held_registers& r, const check& c) {
    const terminal t = active_terminal(r, c);
    return watched::at({t.function, t.logic(), t.levels()});
}
inline std::string which_is_active(const held_registers& r, const check& c) {
    const terminal t = active_terminal(r, c);
    if (t.is_virtual) return "Another program has set virtual input " + std::to_string(t.number) + ".";
    return "DI" + std::to_string(t.number) + (t.is_one(r) ? " conducts" : " does not conduct") +
           ", which is active by its logic.";
}
// Clears the level of a virtual input, or inverts the logic of a wired one.
inline std::vector<new_value> inactive(const held_registers& r, const check& c) {
    const terminal t = active_terminal(r, c);
    if (t.is_virtual)
        return {{t.levels(), static_cast<u16>(r.word(t.levels()) & ~(1u << (t.number - 1)) & 0xFFFFu)}};
    const auto other = t.is_one(r) ? c630s::input_logic::high_level : c630s::input_logic::low_level;
    return {{t.logic(), static_cast<u16>(other)}};
}

// The wired servo-on that matters: one that is active, or that is not where the factory has it. The factory's, on DI1,
// is part of what a set-up changes.
inline terminal wired_servo_on(const held_registers& r) {
    for (const terminal& t : terminals(r)) {
        const bool is_factory = t.number == 1;
        if (!t.is_virtual && t.has(r, input_function::servo_on) && (is_active(r, t) || !is_factory)) return t;
    }
    return {};
}
inline bool has_wired_servo_on(const held_registers& r, const check&) { return !wired_servo_on(r).is_none(); }
inline watched servo_on_registers(const held_registers& r, const check&) {
    const terminal t = wired_servo_on(r);
    return watched::at({t.function, t.logic(), t.levels()});
}
inline std::vector<new_value> no_servo_on(const held_registers& r, const check&) {
    return {{wired_servo_on(r).function, static_cast<u16>(input_function::none)}};
}

/// The function registers of two inputs that have the same one.
struct terminal_pair {
    u16 first = 0;
    u16 second = 0;
};
inline terminal_pair doubled(const held_registers& r) {
    std::map<u16, u16> seen;
    for (const terminal& t : terminals(r)) {
        const u16 f = r.word(t.function);
        if (f != 0 && !seen.emplace(f, t.function).second) return {seen[f], t.function};
    }
    return {};
}
inline bool has_doubled(const held_registers& r, const check&) { return doubled(r).second != 0; }
inline watched doubled_registers(const held_registers& r, const check&) {
    return watched::at({doubled(r).first, doubled(r).second});
}
inline std::vector<new_value> free_one(const held_registers& r, const check&) {
    return {{doubled(r).second, static_cast<u16>(input_function::none)}};
}

// Bit 0: the function servo-on, or the virtual input that has it after a set-up.
inline bool has_servo_on_bit(const held_registers& r, const check& c) { return (r.word(c.of[0]) & 1u) != 0; }
inline std::vector<new_value> without_servo_on_bit(const held_registers& r, const check& c) {
    return {{c.of[0], static_cast<u16>(r.word(c.of[0]) & 0xFFFEu)}};
}

} // namespace tool::diagnosis::c630s_rules
