// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which functions of a C630S's terminals are active, and which of them two terminals have. Source: manual V24.111,
// sections 6.4, 7.3 and 7.16.
#pragma once

#include <servobus/device/c630s/registers.hpp>

#include "check.hpp"

namespace tool::diagnosis::c630s_rules {

namespace c630s = servobus::c630s;
using c630s::input_function;

/// The name of a parameter: P0B-17.
inline std::string parameter(u16 address) {
    constexpr char digits[] = "0123456789ABCDEF";
    const unsigned index = address & 0xFFu;
    return {'P', digits[address >> 12], digits[address >> 8 & 15],
            '-', digits[index / 10],    digits[index % 10]};
}

inline u16 function_register(unsigned di) {
    return static_cast<u16>(c630s::di1_function.address + 2 * (di - 1));
}
inline u16 virtual_register(unsigned vdi) { return c630s::virtual_input_functions[vdi - 1].address; }
// A terminal that conducts is low. A virtual one counts while they are switched on.
inline bool is_active(const held_registers& r, input_function f) {
    for (unsigned di = 1; di <= 8; ++di) {
        const u16 at = function_register(di);
        const bool conducts = (static_cast<unsigned>(r.word(c630s::input_conduction)) >> (di - 1) & 1u) != 0;
        const auto logic = static_cast<c630s::input_logic>(r.word(static_cast<u16>(at + 1)));
        const bool is_level =
            logic == c630s::input_logic::low_level || logic == c630s::input_logic::high_level;
        if (r.word(at) == static_cast<u16>(f) && is_level &&
            conducts == (logic == c630s::input_logic::low_level))
            return true;
    }
    for (unsigned vdi = 1; vdi <= 16 && r.word(c630s::virtual_inputs_enable) != 0; ++vdi) {
        const bool is_one =
            (static_cast<unsigned>(r.word(c630s::virtual_input_levels)) >> (vdi - 1) & 1u) != 0;
        const bool is_level = r.word(static_cast<u16>(virtual_register(vdi) + 1)) == 0;
        if (r.word(virtual_register(vdi)) == static_cast<u16>(f) && is_one && is_level) return true;
    }
    return false;
}
// `value`: the function.
inline bool is_given(const held_registers& r, const check& c) {
    return is_active(r, static_cast<input_function>(c.value));
}
inline unsigned wired_servo_on(const held_registers& r) {
    for (unsigned di = 1; di <= 8; ++di) {
        if (r.word(function_register(di)) == static_cast<u16>(input_function::servo_on)) return di;
    }
    return 0;
}
inline bool has_wired_servo_on(const held_registers& r, const check&) { return wired_servo_on(r) != 0; }
inline std::string which_servo_on(const held_registers& r, const check&) {
    return "DI" + std::to_string(wired_servo_on(r)) + " has it.";
}
inline std::string no_servo_on(const held_registers& r, const check&) {
    return parameter(function_register(wired_servo_on(r))) + "=0";
}
struct terminal_pair {
    u16 first = 0;
    u16 second = 0;
};
// Terminals that are not wired out count too, and so do virtual ones that are switched on.
inline terminal_pair doubled(const held_registers& r) {
    std::map<u16, u16> seen;
    const auto look = [&](u16 at) {
        const u16 f = r.word(at);
        return f == 0 || seen.emplace(f, at).second ? terminal_pair{} : terminal_pair{seen[f], at};
    };
    for (unsigned di = 1; di <= 8; ++di) {
        if (const terminal_pair p = look(function_register(di)); p.second != 0) return p;
    }
    for (unsigned vdi = 1; vdi <= 16 && r.word(c630s::virtual_inputs_enable) != 0; ++vdi) {
        if (const terminal_pair p = look(virtual_register(vdi)); p.second != 0) return p;
    }
    return {};
}
inline bool has_doubled(const held_registers& r, const check&) { return doubled(r).second != 0; }
inline std::string which_doubled(const held_registers& r, const check&) {
    return parameter(doubled(r).first) + " and " + parameter(doubled(r).second) + " have the same.";
}
inline std::string free_one(const held_registers& r, const check&) {
    return parameter(doubled(r).second) + "=0";
}
inline bool enables_at_power_on(const held_registers& r, const check& c) {
    return (r.word(c.of[0]) & 1u) != 0;
}

} // namespace tool::diagnosis::c630s_rules
