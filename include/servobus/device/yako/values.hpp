// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, closed loop (ESS242-, ESS257-, ESS286-Rx1) and open loop (ESD2205PR, ESD2505PR,
// YKE2405PR, YKE2608PR): the profile of the family and the values of its enumerated registers and bit fields.
// homing.hpp has the values of homing. yako/common.hpp includes it. Source: manual V2.6.0, chapters 2 to 5,
// appendices 2 and 3; [errata An] are in device/errata.md.
//
//     constexpr auto go = yako::motion_code::move(yako::positioning::absolute); // for 0027h
//     static_assert(go.to_word() == 0x0005 && go.is_start());
//     constexpr auto word = yako::motion_status::from_word(0x0014); // 0007h as read
//     static_assert(word.is_moving() && !word.is_enabled());
#pragma once

#include <cstdint>

#include <servobus/registers/cached_registers.hpp>
#include <servobus/registers/line_choices.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus::yako {

/// The family of both variants: Modbus RTU; factory settings: 115200 Bd, 8N1. The DIP switches set the
/// address, 1..15 or 1..31; while all of them are off, register 0013h sets it. Register 0019h switches the
/// word order of 32-bit values and must be read before such a value is read or written. The exception numbers
/// are not those of the standard [errata A3]. The manual states no response time. The default response limit
/// of 100 ms is far above the few milliseconds that the drive takes.
struct device {
    static constexpr exception_meaning exceptions[] = {
        {1, "CRC error"},
        {2, "function code error"},
        {3, "register address not allowed"},
        {4, "register address beyond the range"},
        {5, "more than 16 registers read"},
        {6, "register is read-only or write-only"},
        {7, "value out of range"},
    };
    static constexpr profile facts{.name = "yako",
                                   .max_read = 16,
                                   .lowest_address = 1,
                                   .highest_address = 247,
                                   .word_order = word_order::unknown,
                                   .word_order_register = 0x0019,
                                   .baud = 115200,
                                   .format = character_format::n81,
                                   .limits = {.corrupted_request = 1, .acknowledge = 0}, // [errata A3, A4]
                                   .exceptions = exceptions};
    /// Lists what the facade relies on: direction and microsteps, limits, word order and resolution, the profile of
    /// moves, the two command registers, the homing speeds, the marker.
    static constexpr address_range cached_by_facade[] = {{0x0010, 0x0011}, {0x0018, 0x001A}, {0x0020, 0x0023},
                                                         {0x0027, 0x0027}, {0x002D, 0x002D}, {0x0032, 0x0033},
                                                         {0x00BA, 0x00BB}};
    /// 0014h and 0015h, from the next power-on; saved first, since it is not stated what is lost else [errata A53].
    static constexpr rate_choice rates[] = {{115'200, 0}, {38'400, 1}, {19'200, 2}, {9'600, 3}};
    static constexpr format_choice formats[] = {{character_format::n81, 0},
                                                {character_format::n82, 1},
                                                {character_format::e81, 2},
                                                {character_format::o81, 3}};
    static constexpr line_choices on_line{.rates = rates,
                                          .formats = formats,
                                          .rate_register = 0x0014,
                                          .format_register = 0x0015,
                                          .needs_save = true,
                                          .needs_power_cycle = true};
};

namespace detail {
constexpr profile under_the_name(const char* name) {
    profile facts = device::facts;
    facts.name = name;
    return facts;
}
} // namespace detail

// Status

/// 0003h: the positions of the DIP switches.
struct switches {
    std::uint16_t bits = 0;
    static constexpr switches from_word(std::uint16_t w) { return {w}; }
    constexpr std::uint16_t to_word() const { return bits; }
    /// True if switch `number`, 1..7, printed SW1..SW7, is on; false for any other number.
    constexpr bool is_on(unsigned number) const {
        return number >= 1 && number <= 7 && (bits >> (number - 1) & 1u) != 0;
    }
    friend constexpr bool operator==(switches, switches) = default;
};

/// 0007h motion status. Its bit for "motor enable" is 0 while the motor is enabled [errata A35].
struct motion_status {
    static constexpr std::uint16_t in_position_bit = 0x0001;
    static constexpr std::uint16_t homed_bit = 0x0002;
    static constexpr std::uint16_t moving_bit = 0x0004;
    static constexpr std::uint16_t alarm_bit = 0x0008;
    static constexpr std::uint16_t released_bit = 0x0010;
    static constexpr std::uint16_t positive_limit_bit = 0x0020; ///< beyond the software limit
    static constexpr std::uint16_t negative_limit_bit = 0x0040;

    std::uint16_t bits = released_bit; ///< by default not enabled: only a read shows that a drive is

    static constexpr motion_status from_word(std::uint16_t w) { return {w}; }
    constexpr std::uint16_t to_word() const { return bits; }
    constexpr bool is_in_position() const { return has(in_position_bit); }
    constexpr bool is_homed() const { return has(homed_bit); }
    constexpr bool is_moving() const { return has(moving_bit); }
    constexpr bool has_alarm() const { return has(alarm_bit); }
    constexpr bool is_enabled() const { return !has(released_bit); }
    constexpr bool is_beyond_positive_limit() const { return has(positive_limit_bit); }
    constexpr bool is_beyond_negative_limit() const { return has(negative_limit_bit); }
    friend constexpr bool operator==(motion_status, motion_status) = default;

  private:
    constexpr bool has(std::uint16_t bit) const { return (bits & bit) != 0; }
};

// Basic control

/// 0010h: the direction in which positive positions and speeds turn the motor.
enum class direction : std::uint16_t { normal = 0, reversed = 1 };

/// 0014h RS485 baud rate.
enum class baud_rate : std::uint16_t {
    baud_115200 = 0,
    baud_38400 = 1,
    baud_19200 = 2,
    baud_9600 = 3,
};

/// 0015h: parity and stop bits; there are always eight data bits.
enum class serial_format : std::uint16_t { n81 = 0, n82 = 1, e81 = 2, o81 = 3 };

/// 0017h: how the motor stops when it passes a limit.
enum class over_travel_stop : std::uint16_t {
    coast = 0, ///< the motor is released
    emergency_stop = 1,
};

/// 0018h: whether the software limits 0037h and 0039h are in effect.
enum class limit_enable : std::uint16_t { disabled = 0, after_homing = 1 };

/// 0019h: which word of a 32-bit value is at the lower address. Within a register the high byte always comes
/// first [errata A23].
enum class word_order_setting : std::uint16_t { high_first = 0, low_first = 1 };

/// 001Ah, closed loop: one count of a speed. The manual does not state which registers it rescales
/// [errata A37].
enum class speed_count : std::uint16_t { one_r_per_min = 0, tenth_r_per_min = 1 };

// Commands

/// 0050h, 0065h + 6n, and bit 2 of 0027h: whether a target position is relative or absolute.
enum class positioning : std::uint16_t { relative = 0, absolute = 1 };

/// Bit 3 of 0027h: what the drive does with a start of a move while another move is in progress.
enum class while_moving : std::uint8_t {
    ignore,    ///< ignores the new move
    interrupt, ///< starts the new move immediately, in place of the other
};

/// 0027h motion command. The manual states neither what several commands in one word do nor what the register
/// reads back [errata A47]. Each of the named functions below makes a word with one command.
struct motion_code {
    static constexpr std::uint16_t start_position_bit = 0x0001;
    static constexpr std::uint16_t start_speed_bit = 0x0002;
    static constexpr std::uint16_t absolute_bit = 0x0004;
    static constexpr std::uint16_t interrupt_bit = 0x0008; ///< with a position only
    static constexpr std::uint16_t start_homing_bit = 0x0010;
    static constexpr std::uint16_t stop_bit = 0x0100;           ///< [errata A11]
    static constexpr std::uint16_t emergency_stop_bit = 0x0200; ///< [errata A10]

    std::uint16_t bits = 0;

    static constexpr motion_code from_word(std::uint16_t w) { return {w}; }
    constexpr std::uint16_t to_word() const { return bits; }

    /// Starts the move to `target_position`.
    static constexpr motion_code move(positioning from, while_moving then = while_moving::ignore) {
        const unsigned absolute = from == positioning::absolute ? absolute_bit : 0u;
        const unsigned interrupt = then == while_moving::interrupt ? interrupt_bit : 0u;
        return {static_cast<std::uint16_t>(start_position_bit | absolute | interrupt)};
    }
    /// Starts a move without a target at `jog_speed`, whose sign is the direction.
    static constexpr motion_code jog() { return {start_speed_bit}; }
    /// Starts homing by `homing_method`.
    static constexpr motion_code home() { return {start_homing_bit}; }
    /// Stops with the deceleration time that was set before the move.
    static constexpr motion_code stop() { return {stop_bit}; }
    /// Stops without a ramp.
    static constexpr motion_code emergency_stop() { return {emergency_stop_bit}; }

    /// True if the word has a command that may start the motor.
    constexpr bool is_start() const {
        return (bits & (start_position_bit | start_speed_bit | start_homing_bit)) != 0;
    }
    constexpr bool is_stop() const { return (bits & (stop_bit | emergency_stop_bit)) != 0; }
    friend constexpr bool operator==(motion_code, motion_code) = default;
};

/// 002Dh auxiliary command. The manual does not state what the register reads back [errata A47].
enum class auxiliary : std::uint16_t {
    none = 0x0000,
    release = 0x0011, ///< as CiA 402's disable: the shaft is free
    enable = 0x0012,
    clear_alarm = 0x0021,
    clear_position = 0x0031,
    restore_parameters = 0x0041, ///< to the factory settings; ignored while the motor moves
    save_parameters = 0x0042,    ///< all parameters; ignored while the motor moves
};

// Terminals

/// 0041h..0047h input function. PIN3..PIN0 choose a segment as a binary number, 0 for the first segment;
/// their levels must not change from 5 ms before the trigger to 5 ms after it.
enum class input_function : std::uint16_t {
    undefined = 0,
    home = 1,
    positive_limit = 2,
    negative_limit = 3,
    motor_free = 4, ///< "MF": the motor is released while active
    stop = 5,
    emergency_stop = 6,
    position_move = 7, ///< starts at the edge
    speed_move = 8,    ///< while active; the sign of 001Dh is the direction
    jog_positive = 9,  ///< while active
    jog_negative = 10, ///< while active
    homing = 11,       ///< starts at the edge
    pt_trigger = 12,   ///< starts a position segment at the edge
    pv_trigger = 13,   ///< starts a speed segment; see 0051h [errata A34]
    pin0 = 14,
    pin1 = 15,
    pin2 = 16,
    pin3 = 17,
    speed_segment_direction = 18, ///< [errata A24]
};

/// 004Ch..004Eh output function. 6, 7 and 8 have no meaning.
enum class output_function : std::uint16_t {
    undefined = 0,
    alarm = 1,
    driver_status = 2, ///< active while the motor moves
    homing_complete = 3,
    in_position = 4,
    brake = 5,  ///< active while the motor is held, inactive while it is released
    user_0 = 9, ///< set by 004Fh [errata A28]
    user_1 = 10,
    user_2 = 11,
};

/// 0051h: whether the level or the rising edge of the PV trigger input starts a speed segment. It must be
/// `rising_edge` if speed segments and position segments are used together.
enum class pv_trigger : std::uint16_t { level = 0, rising_edge = 1 };

// Performance

/// 0100h, closed loop: the control algorithm.
enum class control_algorithm : std::uint16_t {
    open_loop = 1,
    switching = 2, ///< between open and closed loop, by the angle
    closed_loop = 3,
};

namespace closed_loop {

/// 0008h input levels (1: active), 0040h input polarity (1: normally closed).
struct inputs {
    bool x0 = false;
    bool x1 = false;
    bool x2 = false;
    bool x3 = false;
    static constexpr inputs from_word(std::uint16_t w) {
        return {(w & 1u) != 0, (w & 2u) != 0, (w & 4u) != 0, (w & 8u) != 0};
    }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((x0 ? 1u : 0u) | (x1 ? 2u : 0u) | (x2 ? 4u : 0u) | (x3 ? 8u : 0u));
    }
    friend constexpr bool operator==(inputs, inputs) = default;
};

/// 0009h output levels, 004Fh user outputs (1: active), 004Bh output polarity (1: normally closed).
struct outputs {
    bool y0 = false;
    bool y1 = false;
    static constexpr outputs from_word(std::uint16_t w) { return {(w & 1u) != 0, (w & 2u) != 0}; }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((y0 ? 1u : 0u) | (y1 ? 2u : 0u));
    }
    friend constexpr bool operator==(outputs, outputs) = default;
};

} // namespace closed_loop

namespace open_loop {

/// 0008h input levels (1: active), 0040h input polarity (1: normally closed).
struct inputs {
    bool x0 = false;
    bool x1 = false;
    bool x2 = false;
    bool x3 = false;
    bool x4 = false;
    bool x5 = false;
    bool x6 = false;
    static constexpr inputs from_word(std::uint16_t w) {
        return {(w & 1u) != 0,  (w & 2u) != 0,  (w & 4u) != 0, (w & 8u) != 0,
                (w & 16u) != 0, (w & 32u) != 0, (w & 64u) != 0};
    }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((x0 ? 1u : 0u) | (x1 ? 2u : 0u) | (x2 ? 4u : 0u) | (x3 ? 8u : 0u) |
                                          (x4 ? 16u : 0u) | (x5 ? 32u : 0u) | (x6 ? 64u : 0u));
    }
    friend constexpr bool operator==(inputs, inputs) = default;
};

/// 0009h output levels, 004Fh user outputs (1: active), 004Bh output polarity (1: normally closed). Y2 of
/// 004Fh is not documented [errata A27, A28].
struct outputs {
    bool y0 = false;
    bool y1 = false;
    bool y2 = false;
    static constexpr outputs from_word(std::uint16_t w) {
        return {(w & 1u) != 0, (w & 2u) != 0, (w & 4u) != 0};
    }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((y0 ? 1u : 0u) | (y1 ? 2u : 0u) | (y2 ? 4u : 0u));
    }
    friend constexpr bool operator==(outputs, outputs) = default;
};

} // namespace open_loop

} // namespace servobus::yako
