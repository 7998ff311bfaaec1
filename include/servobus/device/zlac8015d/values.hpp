// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D dual hub servo: its profile and the values of its enumerated registers and bit fields.
// zlac8015d/registers.hpp includes it. Source: RS485 manual V1.07, sections 2, 3 and 4; [errata Bn] are in
// device/errata.md.
//
//     constexpr auto word = zlac8015d::status_flags::from_word(0x4041); // 20A2h as read
//     static_assert(word.left.shaft == zlac8015d::shaft_state::locked && word.right.is_running);
//     constexpr auto set = zlac8015d::faults::from_word(0x0404); // 20A5h as read
//     static_assert(set.has(zlac8015d::fault::overcurrent) && !set.has(zlac8015d::fault::encoder));
#pragma once

#include <cstdint>

#include <servobus/registers/cached_registers.hpp>
#include <servobus/registers/line_choices.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus::zlac8015d {

/// The ZLAC8015D: Modbus RTU, 8N1, addresses 1..127; factory settings: address 1, 115200 Bd. The manual states no
/// response time. Of 1508 exchanges with a drive the longest took 6.9 ms: device/field.md. The limit has room for
/// an adapter's latency timer of 16 ms, and a margin. The quarantine drops a later response.
struct device {
    static constexpr exception_meaning exceptions[] = {
        {1, "illegal function"}, {2, "illegal data address"}, {3, "illegal data value"}};
    static constexpr profile facts{.name = "zlac8015d",
                                   .lowest_address = 1,
                                   .highest_address = 127,
                                   .word_order = word_order::high_first,
                                   .baud = 115200,
                                   .format = character_format::n81,
                                   .limits = {.response = milliseconds(32)},
                                   .exceptions = exceptions};
    /// Lists what the facade relies on: watchdog, positions cleared, top speed and factory settings, mode, control word
    /// and synchronisation, resolution, encoder lines.
    static constexpr address_range cached_by_facade[] = {{0x2000, 0x2000}, {0x2005, 0x2006}, {0x2008, 0x2009},
                                                         {0x200D, 0x200F}, {0x2022, 0x2022}, {0x2030, 0x2030},
                                                         {0x2060, 0x2060}};
    /// 2002h. It has no register for the format. When a code takes effect is not stated.
    static constexpr rate_choice rates[] = {{128'000, 1}, {115'200, 2}, {57'600, 3},
                                            {38'400, 4},  {19'200, 5},  {9'600, 6}};
    static constexpr line_choices on_line{
        .rates = rates, .rate_register = 0x2002, .needs_save = true, .needs_power_cycle = true};
};

/// 2002h RS485 baud rate. Its codes begin at 1 [errata B22].
enum class baud_rate : std::uint16_t {
    baud_128000 = 1,
    baud_115200 = 2,
    baud_57600 = 3,
    baud_38400 = 4,
    baud_19200 = 5,
    baud_9600 = 6,
};

/// 200Bh CAN baud rate. Its codes begin at 0 [errata B22].
enum class can_baud_rate : std::uint16_t {
    kbit_1000 = 0,
    kbit_500 = 1,
    kbit_250 = 2,
    kbit_125 = 3,
    kbit_100 = 4
};

/// 2005h, 2006h: the wheels whose position is set to zero.
enum class wheels : std::uint16_t { none = 0, left = 1, right = 2, both = 3 };

/// 2007h: the state of the shaft at power-on. Neither value enables the motor.
enum class power_on_shaft : std::uint16_t { unlocked = 0, locked = 1 };

/// 2009h
enum class parameter_reset : std::uint16_t { none = 0, factory_defaults = 1 };

/// 200Ch, 2020h, 2023h, 201Fh
enum class off_on : std::uint16_t { off = 0, on = 1 };

/// 200Dh mode of operation. The numbers are not those of CiA 402's 6060h. After power-on the mode is
/// `undefined`.
enum class operating_mode : std::uint16_t {
    undefined = 0,
    relative_position = 1,
    absolute_position = 2,
    velocity = 3,
    torque = 4,
};

/// 200Eh control word. It takes one value at a time, not the bits of CiA 402's 6040h.
enum class control_code : std::uint16_t {
    undefined = 0x00,
    quick_stop = 0x05,
    fault_reset = 0x06,
    stop = 0x07, ///< ends the operation, as CiA 402's disable; the wheels may roll
    enable = 0x08,
    start_both = 0x10,  ///< position modes, synchronous
    start_left = 0x11,  ///< position modes
    start_right = 0x12, ///< position modes
};

/// 200Fh: whether a position start moves one wheel or both.
enum class synchronisation : std::uint16_t { asynchronous = 0, synchronous = 1 };

/// 2010h
enum class parameter_save : std::uint16_t { none = 0, save_all = 1 };

/// 2011h: how a quick stop stops the motor; the drive then stays in quick stop. The ramp of each code is
/// taken from section 3.7.
enum class quick_stop_option : std::uint16_t {
    deceleration = 5,      ///< by the deceleration time, 2082h/2083h
    fast_deceleration = 6, ///< by the quick-stop deceleration time, 2084h/2085h
    immediate = 7,
};

/// 2012h shutdown option, 2013h disable option. No control word of the RS485 interface names these
/// transitions [errata B14].
enum class stop_option : std::uint16_t { none = 0, deceleration = 1 };

/// 2014h halt option [errata B14].
enum class halt_option : std::uint16_t { deceleration = 1, fast_deceleration = 2, immediate = 3 };

/// 2017h, 2018h input function; 1..8 are not connected.
enum class input_function : std::uint16_t { undefined = 0, emergency_stop = 9 };

/// 201Ah (B0, left), 201Bh (B1, right): the manual's codes 0 "抱闸开启" and 1 "抱闸关闭". The words mean "the
/// brake opens, closes" as well as "the brake's output is on, off", so the manual does not determine which
/// code holds the shaft [errata B29]. Try the codes on the machine, with the load supported, and name the
/// result in the program:
///
///     constexpr auto released = zlac8015d::brake::code_0; // tried on this lift
enum class brake : std::uint16_t { code_0 = 0, code_1 = 1 };

/// 201Ch (Y0), 201Dh (Y1)
enum class output_function : std::uint16_t { undefined = 0, alarm = 1, driver_status = 2, in_position = 3 };

/// 2021h: the state of the shaft after the emergency-stop input was active.
enum class input_stop_action : std::uint16_t {
    lock_shaft = 0, ///< zero speed with holding torque
    free_shaft = 1, ///< PWM off
};

/// The state of one shaft in 20A2h, two bits for each axis.
enum class shaft_state : std::uint8_t { released = 0, locked = 1, emergency_stop = 2, alarm = 3 };

/// Half of the status word: one axis.
struct axis_status {
    shaft_state shaft = shaft_state::released;
    bool is_running = false;
    friend constexpr bool operator==(axis_status, axis_status) = default;
};

/// 20A2h status word: high byte left, low byte right; in each bits 7:6 the shaft, bit 0 running [errata B9].
struct status_flags {
    axis_status left{};
    axis_status right{};

    static constexpr std::uint16_t left_running_bit = 0x0100;
    static constexpr std::uint16_t right_running_bit = 0x0001;
    static constexpr std::uint16_t running_bits = left_running_bit | right_running_bit;
    static constexpr std::uint16_t shaft_bits = 0xC0C0;
    static constexpr std::uint16_t both_locked = 0x4040;
    static constexpr std::uint16_t both_stopped_in_emergency = 0x8080;

    static constexpr status_flags from_word(std::uint16_t w) {
        return {{static_cast<shaft_state>(w >> 14), (w & 0x0100u) != 0},
                {static_cast<shaft_state>(w >> 6 & 3u), (w & 0x0001u) != 0}};
    }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>(half(left) << 8 | half(right));
    }
    constexpr bool is_running() const { return left.is_running || right.is_running; }
    friend constexpr bool operator==(const status_flags&, const status_flags&) = default;

  private:
    static constexpr unsigned half(axis_status a) {
        return static_cast<unsigned>(a.shaft) << 6 | (a.is_running ? 1u : 0u);
    }
};

/// 2003h input levels, 2016h input polarity (1: inverted).
struct inputs {
    bool x0 = false;
    bool x1 = false;
    static constexpr inputs from_word(std::uint16_t w) { return {(w & 1u) != 0, (w & 2u) != 0}; }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((x0 ? 1u : 0u) | (x1 ? 2u : 0u));
    }
    friend constexpr bool operator==(inputs, inputs) = default;
};

/// 2004h output states. The brake outputs are not reported [errata B24].
struct outputs {
    bool y0 = false;
    bool y1 = false;
    static constexpr outputs from_word(std::uint16_t w) { return {(w & 1u) != 0, (w & 2u) != 0}; }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((y0 ? 1u : 0u) | (y1 ? 2u : 0u));
    }
    friend constexpr bool operator==(outputs, outputs) = default;
};

/// 2019h output polarity (1: inverted).
struct output_polarity {
    bool y0 = false;
    bool y1 = false;
    bool b0 = false;
    bool b1 = false;
    static constexpr output_polarity from_word(std::uint16_t w) {
        return {(w & 1u) != 0, (w & 2u) != 0, (w & 4u) != 0, (w & 8u) != 0};
    }
    constexpr std::uint16_t to_word() const {
        return static_cast<std::uint16_t>((y0 ? 1u : 0u) | (y1 ? 2u : 0u) | (b0 ? 4u : 0u) | (b1 ? 8u : 0u));
    }
    friend constexpr bool operator==(output_polarity, output_polarity) = default;
};

/// One fault of 20A5h, 20A6h. Several may be set together, as the one-bit values in the manual imply.
enum class fault : std::uint16_t {
    none = 0x0000,
    overvoltage = 0x0001,
    undervoltage = 0x0002,
    overcurrent = 0x0004,
    overload = 0x0008,
    current_deviation = 0x0010, ///< reserved
    following_error = 0x0020,
    speed_deviation = 0x0040, ///< "reserved" in the manual, but 2023h switches it [errata B8]
    reference_voltage = 0x0080,
    eeprom = 0x0100,
    hall = 0x0200,
    motor_overtemperature = 0x0400,
    encoder = 0x0800,
    speed_command = 0x2000, ///< a commanded speed above the rated one
};

/// Every fault that the manual lists, in its order.
inline constexpr fault all_faults[] = {
    fault::overvoltage,
    fault::undervoltage,
    fault::overcurrent,
    fault::overload,
    fault::current_deviation,
    fault::following_error,
    fault::speed_deviation,
    fault::reference_voltage,
    fault::eeprom,
    fault::hall,
    fault::motor_overtemperature,
    fault::encoder,
    fault::speed_command,
};

constexpr const char* text(fault f) {
    switch (f) {
    case fault::none: return "none";
    case fault::overvoltage: return "overvoltage";
    case fault::undervoltage: return "undervoltage";
    case fault::overcurrent: return "overcurrent";
    case fault::overload: return "overload";
    case fault::current_deviation: return "current deviation";
    case fault::following_error: return "following error";
    case fault::speed_deviation: return "speed deviation";
    case fault::reference_voltage: return "reference voltage";
    case fault::eeprom: return "eeprom";
    case fault::hall: return "hall";
    case fault::motor_overtemperature: return "motor overtemperature";
    case fault::encoder: return "encoder";
    case fault::speed_command: return "speed command";
    }
    return "unlisted fault";
}

/// 20A5h (left), 20A6h (right): the set of faults of one axis.
struct faults {
    std::uint16_t bits = 0;
    static constexpr faults from_word(std::uint16_t w) { return {w}; }
    constexpr std::uint16_t to_word() const { return bits; }
    constexpr bool any() const { return bits != 0; }
    constexpr bool has(fault f) const { return (bits & static_cast<std::uint16_t>(f)) != 0; }
    /// The fault of the lowest bit; `fault::none` if none is set. A bit that the manual does not list is returned as
    /// its number.
    constexpr fault first() const { return static_cast<fault>(bits & (0u - bits)); }
    friend constexpr bool operator==(faults, faults) = default;
};

/// 20A3h: the Hall inputs of both motors, 0..7 each; 0 and 7 are faults. Two axes in one word [errata B9].
using hall_inputs = left_right<std::uint8_t>;
/// 20A4h: the temperatures of both motors, 1 degC, -55..120. Two axes in one word [errata B9].
using motor_temperatures = left_right<std::int8_t>;

} // namespace servobus::zlac8015d
