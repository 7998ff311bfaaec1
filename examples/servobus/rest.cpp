// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whether a drive's parameters may be changed now, and what brings it to rest: the rules, one for each drive.
// Enabled counts as not at rest, since a parameter can move an enabled motor.
#include <array>

#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

#include "session.hpp"

namespace tool {
namespace {

// Reads registers that the tool needs for itself.
template <std::size_t Count>
servobus::status read_words(session& on, u16 address, std::array<u16, Count>& words) {
    return on.read(chosen{"", address, static_cast<u16>(Count), nullptr}, words);
}

bool is_ok(const servobus::status& why) { return why.error() == servobus::errc::ok; }

} // namespace

// A wheel rests if its shaft is released, or in alarm, and it does not turn. A locked one is enabled, or held
// from power-on, and one in emergency stop is held. The running bits may not tell of a wheel that rolls, nor
// the shaft's bits of a drive that is enabled in torque mode [errata B30, B31].
repose zlac8015d_at_rest(session& on) {
    namespace zlac = servobus::zlac8015d;
    std::array<u16, 1> word{};
    if (const auto why = read_words(on, zlac::status_word.address, word); !is_ok(why)) return {why, {}};
    const auto status = zlac::status_flags::from_word(word[0]);
    if (status.is_running()) return {{}, "a wheel turns; stop it first"};
    for (const zlac::axis_status& axis : {status.left, status.right}) {
        if (axis.shaft == zlac::shaft_state::locked || axis.shaft == zlac::shaft_state::emergency_stop)
            return {{}, "a shaft is held, the drive is enabled; control_word=stop releases it"};
    }
    std::array<u16, 2> speeds{};
    if (const auto why = read_words(on, zlac::left_actual_speed.address, speeds); !is_ok(why))
        return {why, {}};
    for (const u16 speed : speeds) {
        constexpr int slowest = 20; // 0.1 r/min
        const int count = static_cast<std::int16_t>(speed);
        if (count > slowest || count < -slowest) return {{}, "a wheel turns; stop it first"};
    }
    std::array<u16, 1> mode{};
    if (const auto why = read_words(on, zlac::mode_of_operation.address, mode); !is_ok(why)) return {why, {}};
    if (mode[0] == static_cast<u16>(zlac::operating_mode::torque)) {
        return {{},
                "the drive is in torque mode, where its status may not tell that it is enabled; "
                "control_word=stop, "
                "then mode_of_operation=undefined"};
    }
    return {};
}

// A stepper is enabled from power-on.
repose yako_at_rest(session& on) {
    using servobus::yako::motion_status;
    std::array<u16, 1> word{};
    if (const auto why = read_words(on, servobus::yako::status_word.address, word); !is_ok(why))
        return {why, {}};
    if ((word[0] & motion_status::moving_bit) != 0) return {{}, "the motor moves; stop it first"};
    if ((word[0] & motion_status::released_bit) == 0) {
        return {{},
                "the motor is enabled; auxiliary_command=release releases it, and its position is to be "
                "referenced anew then"};
    }
    return {};
}

// No documented register says whether the servo is on: it is if a terminal with the function S-ON, a real one
// or a virtual one, is active.
repose c630s_at_rest(session& on) {
    namespace c630s = servobus::c630s;
    constexpr auto servo_on = static_cast<u16>(c630s::input_function::servo_on);
    constexpr auto low_level = static_cast<u16>(c630s::input_logic::low_level);
    std::array<u16, 1> speed{};
    if (const auto why = read_words(on, c630s::actual_speed.address, speed); !is_ok(why)) return {why, {}};
    if (speed[0] != 0) return {{}, "the motor turns; stop it first"};

    std::array<u16, 1> levels{};
    if (const auto why = read_words(on, c630s::virtual_input_levels.address, levels); !is_ok(why))
        return {why, {}};
    // What is active since power-on shows nowhere: P31-00 reads 0 then.
    std::array<u16, 1> at_power_on{};
    if (const auto why = read_words(on, c630s::power_on_functions_1_to_16.address, at_power_on); !is_ok(why))
        return {why, {}};
    if ((at_power_on[0] & 1u) != 0)
        return {
            {},
            "power_on_functions_1_to_16 enables the servo at power-on; take servo_on out of it, and switch "
            "the drive off and on"};
    if (const auto why = read_words(on, c630s::virtual_inputs_at_power_on.address, at_power_on); !is_ok(why))
        return {why, {}};
    constexpr std::size_t half = 8;
    for (std::size_t first = 0; first < 16; first += half) {
        std::array<u16, 2 * half> rows{}; // function, logic, function, …
        const u16 address = c630s::virtual_input_functions[first].address;
        if (const auto why = read_words(on, address, rows); !is_ok(why)) return {why, {}};
        for (std::size_t i = 0; i < half; ++i) {
            if (rows[2 * i] == servo_on && (unsigned{at_power_on[0]} >> (first + i) & 1u) != 0) {
                return {{},
                        "virtual input " + std::to_string(first + i + 1) +
                            " enables the servo at power-on; take it out of virtual_inputs_at_power_on, and "
                            "switch the drive off and on"};
            }
            if (rows[2 * i] == servo_on && (unsigned{levels[0]} >> (first + i) & 1u) != 0) {
                return {{},
                        "virtual input " + std::to_string(first + i + 1) +
                            " enables the servo; take it out of virtual_input_levels first"};
            }
        }
    }

    std::array<u16, 1> conducts{};
    std::array<u16, 2 * half> rows{};
    if (const auto why = read_words(on, c630s::input_conduction.address, conducts); !is_ok(why))
        return {why, {}};
    if (const auto why = read_words(on, c630s::di1_function.address, rows); !is_ok(why)) return {why, {}};
    for (std::size_t i = 0; i < half; ++i) {
        const bool conducting = (unsigned{conducts[0]} >> i & 1u) != 0;
        if (rows[2 * i] == servo_on && conducting == (rows[2 * i + 1] == low_level))
            return {{}, "terminal DI" + std::to_string(i + 1) + " enables the servo; open it first"};
    }
    return {};
}

bool zlac8015d_stops(u16 address, u16 word) {
    namespace zlac = servobus::zlac8015d;
    if (address == zlac::left_target_speed.address || address == zlac::right_target_speed.address)
        return word == 0;
    return address == zlac::control_word.address &&
           (word == static_cast<u16>(zlac::control_code::quick_stop) ||
            word == static_cast<u16>(zlac::control_code::stop));
}

bool yako_stops(u16 address, u16 word) {
    using servobus::yako::motion_code;
    return address == servobus::yako::motion_command.address &&
           (word == motion_code::stop().bits || word == motion_code::emergency_stop().bits);
}

bool c630s_stops(u16 address, u16 word) {
    namespace c630s = servobus::c630s;
    return word == 0 &&
           (address == c630s::virtual_input_levels.address || address == c630s::target_speed.address);
}

} // namespace tool
