// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the virtual terminals as the facade uses them. The bus reaches servo-on, segments and
// jogging through virtual inputs only, and reads the drive's state from virtual outputs: this header has
// the fixed assignment of both, and what each register of the set-up has to hold. c630s/routines.hpp
// includes it; programs use `status`. Source: manual V24.111, sections 6.1.3, 6.4, 7.3, 7.12 and 7.16;
// [errata Cn] are in device/errata_c630s.md.
//
//     constexpr auto state = c630s::status_flags::from_word(0x0105); // P17-32 as read, after `set_up`
//     static_assert(state.is_ready() && state.is_brake_released() && !state.is_rotating());
//     static_assert(c630s::terminal::for_segment(2) == 0x0008); // P31-00 chooses segment 3
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/device/c630s/registers.hpp>

namespace servobus::c630s {

/// The virtual inputs in P31-00, as `set_up` assigns them. VDI2, VDI9 and VDI12 to VDI16 have no function:
/// the facade resets alarms by P0D-01 and homes by P05-30, and leaves FunIN.2 and FunIN.32 to wired inputs.
/// `marker` is the level of one of these: a restart clears it, and so is found.
namespace terminal {
inline constexpr std::uint16_t servo_on = 0x0001;      ///< VDI1, FunIN.1, a level
inline constexpr std::uint16_t segment_bits = 0x003C;  ///< VDI3 to 6, FunIN.6 to 9, levels: segment - 1
inline constexpr std::uint16_t segment_start = 0x0040; ///< VDI7, FunIN.28, an edge [errata C23]
inline constexpr std::uint16_t step_start = 0x0080;    ///< VDI8, FunIN.20, an edge
inline constexpr std::uint16_t jog_forward = 0x0200;   ///< VDI10, FunIN.18, a level
inline constexpr std::uint16_t jog_reverse = 0x0400;   ///< VDI11, FunIN.19, a level
inline constexpr std::uint16_t marker = 0x8000;        ///< VDI16, without a function

/// The levels that choose a segment, 0 for the first.
constexpr std::uint16_t for_segment(unsigned index) {
    return static_cast<std::uint16_t>((index << 2) & segment_bits);
}
} // namespace terminal

/// P17-32 as `set_up` arranges it: VDO n shows FunOUT.n up to VDO11 and at VDO16, each 1 while active.
struct status_flags {
    std::uint16_t bits = 0;

    static constexpr std::uint16_t ready_bit = 0x0001;      ///< VDO1, S-RDY
    static constexpr std::uint16_t rotating_bit = 0x0002;   ///< VDO2, TGON
    static constexpr std::uint16_t zero_speed_bit = 0x0004; ///< VDO3, ZERO [errata C22]
    static constexpr std::uint16_t at_speed_bit = 0x0008;   ///< VDO4, V-CMP
    static constexpr std::uint16_t completed_bit = 0x0010;  ///< VDO5, COIN
    static constexpr std::uint16_t near_bit = 0x0020;       ///< VDO6, NEAR
    static constexpr std::uint16_t brake_bit = 0x0100;      ///< VDO9, BK: active while the brake is released
    static constexpr std::uint16_t warning_bit = 0x0200;    ///< VDO10, WARN
    static constexpr std::uint16_t fault_bit = 0x0400;      ///< VDO11, ALM
    static constexpr std::uint16_t electrical_bit = 0x2000; ///< VDO14, ElecHomeAttain
    static constexpr std::uint16_t homed_bit = 0x8000;      ///< VDO16, HomeAttain

    static constexpr status_flags from_word(std::uint16_t word) { return {word}; }
    constexpr std::uint16_t to_word() const { return bits; }

    constexpr bool is_ready() const { return has(ready_bit); }
    constexpr bool is_rotating() const { return has(rotating_bit); }
    constexpr bool is_at_zero_speed() const { return has(zero_speed_bit); }
    constexpr bool is_at_speed() const { return has(at_speed_bit); }
    constexpr bool is_completed() const { return has(completed_bit); }
    constexpr bool is_near() const { return has(near_bit); }
    constexpr bool is_torque_limited() const { return has(0x0040); }
    constexpr bool is_speed_limited() const { return has(0x0080); }
    constexpr bool is_brake_released() const { return has(brake_bit); }
    constexpr bool has_warning() const { return has(warning_bit); }
    constexpr bool has_fault() const { return has(fault_bit); }
    constexpr bool has_reached_speed() const { return has(0x0800); }
    constexpr bool has_reached_torque() const { return has(0x1000); }
    constexpr bool is_electrically_home() const { return has(electrical_bit); }
    constexpr bool is_home() const { return has(homed_bit); }
    friend constexpr bool operator==(status_flags, status_flags) = default;

  private:
    constexpr bool has(std::uint16_t bit) const { return (bits & bit) != 0; }
};

namespace detail {

struct virtual_input_use {
    input_function does;
    virtual_input_logic when;
};

// clang-format off
inline constexpr virtual_input_use virtual_input_uses[16] = {
    {input_function::servo_on,               virtual_input_logic::one},
    {},
    {input_function::segment_selection_1,    virtual_input_logic::one},
    {input_function::segment_selection_2,    virtual_input_logic::one},
    {input_function::segment_selection_3,    virtual_input_logic::one},
    {input_function::segment_selection_4,    virtual_input_logic::one},
    {input_function::position_segment_start, virtual_input_logic::rising_edge},
    {input_function::step_enable,            virtual_input_logic::rising_edge},
    {},
    {input_function::jog_forward,            virtual_input_logic::one},
    {input_function::jog_reverse,            virtual_input_logic::one},
    {}, {}, {}, {}, {},
};

inline constexpr output_function virtual_output_uses[16] = {
    output_function::servo_ready,              output_function::rotating,
    output_function::zero_speed,               output_function::speed_coincidence,
    output_function::positioning_completed,    output_function::positioning_near,
    output_function::torque_limited,           output_function::speed_limited,
    output_function::brake,                    output_function::warning,
    output_function::fault,                    output_function::speed_reached,
    output_function::torque_reached,           output_function::electrical_home_attained,
    output_function::angle_identified,         output_function::home_attained,
};
// clang-format on

constexpr bool is_virtual_input(std::uint16_t function) {
    for (const virtual_input_use& use : virtual_input_uses) {
        if (function != 0 && function == static_cast<std::uint16_t>(use.does)) return true;
    }
    return false;
}

/// The bits of a word of power-on functions, the first of which is `first`, that the facade gives by the bus.
constexpr std::uint16_t virtual_functions_from(unsigned first) {
    unsigned bits = 0;
    for (const virtual_input_use& use : virtual_input_uses) {
        const auto function = static_cast<unsigned>(use.does);
        if (function >= first && function < first + 16) bits |= 1u << (function - first);
    }
    return static_cast<std::uint16_t>(bits);
}

/// The set-up in blocks of four adjacent registers; wired inputs lose their functions before the virtual ones
/// get them, or the drive would see one twice (Er.130). Two blocks share DI7.
inline constexpr std::size_t block_size = 4;
inline constexpr std::uint16_t set_up_blocks[] = {
    "P03-00"_p, "P03-04"_p, "P03-08"_p, "P03-12"_p, "P03-14"_p, "P05-30"_p, "P17-00"_p, "P17-04"_p,
    "P17-08"_p, "P17-12"_p, "P17-16"_p, "P17-20"_p, "P17-24"_p, "P17-28"_p, "P17-33"_p, "P17-37"_p,
    "P17-41"_p, "P17-45"_p, "P17-49"_p, "P17-53"_p, "P17-57"_p, "P17-61"_p, "P0C-09"_p,
};
inline constexpr std::size_t set_up_block_count = sizeof set_up_blocks / sizeof set_up_blocks[0];
static_assert(set_up_block_count * block_size < 200, "more changes at a time raise Er.942");

/// What a register of the set-up has to hold, given what it holds.
constexpr std::uint16_t set_up_word(std::uint16_t address, std::uint16_t held) {
    const unsigned place = address & 0xFFu;
    switch (address >> 8) {
    case 0x03: // nothing that the bus does is also done by a wired input or at power-on
        if (address == power_on_functions_1_to_16.address)
            return static_cast<std::uint16_t>(held & ~virtual_functions_from(1));
        if (address == power_on_functions_17_to_32.address)
            return static_cast<std::uint16_t>(held & ~virtual_functions_from(17));
        return place % 2 == 0 && is_virtual_input(held) ? std::uint16_t{0} : held;
    case 0x05: // no homing at power-on, by an input, or because it was stored
        return address == homing_control.address ? std::uint16_t{0} : held;
    case 0x0C: // the virtual terminals on, and no virtual input active at power-on
        if (address == virtual_inputs_at_power_on.address) return 0;
        return address == virtual_output_defaults.address ? held : std::uint16_t{1};
    case 0x17:
        if (place < 32) {
            const virtual_input_use use = virtual_input_uses[place / 2];
            return place % 2 == 0 ? static_cast<std::uint16_t>(use.does)
                                  : static_cast<std::uint16_t>(use.when);
        }
        return place % 2 == 1 ? static_cast<std::uint16_t>(virtual_output_uses[(place - 33) / 2])
                              : std::uint16_t{0};
    default: return held;
    }
}

} // namespace detail
} // namespace servobus::c630s
