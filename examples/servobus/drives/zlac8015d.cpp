// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D as the tool knows it.
#include <array>

#include <servobus/device/zlac8015d/advice.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

#include "../devices/registered_drive.hpp"
#include "../doctor/zlac8015d.hpp"
#include "../interpretations/zlac8015d_switches.hpp"
#include "../probe/zlac8015d.hpp"
#include "../registers/at_rest.hpp"
#include "../simulators/simulators.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

// A wheel rests if its shaft is released, or in alarm, and it does not turn. A locked one is enabled, or held from
// power-on. One in emergency stop is held, unless the last command, which 200Eh keeps, leaves it without power. The
// running bits may not tell of a wheel that rolls, nor the shaft's bits of a drive that is enabled in torque mode
// [errata B30, B31].
repose zlac8015d_at_rest(session& on) {
    namespace zlac = servobus::zlac8015d;
    std::array<u16, 1> word{};
    if (const auto why = read_words(on, zlac::status_word.address, word); !is_ok(why)) return {why, {}};
    const auto status = zlac::status_flags::from_word(word[0]);
    if (status.is_running()) return {{}, "a wheel turns; stop it first"};
    const auto is_either = [&](zlac::shaft_state shaft) {
        return status.left.shaft == shaft || status.right.shaft == shaft;
    };
    bool is_held = is_either(zlac::shaft_state::locked);
    if (!is_held && is_either(zlac::shaft_state::emergency_stop)) {
        std::array<u16, 1> last{};
        if (const auto why = read_words(on, zlac::control_word.address, last); !is_ok(why)) return {why, {}};
        is_held = last[0] != static_cast<u16>(zlac::control_code::stop) &&
                  last[0] != static_cast<u16>(zlac::control_code::undefined);
    }
    if (is_held) return {{}, "a shaft is held, the drive is enabled; control_word=stop releases it"};
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

bool zlac8015d_stops(u16 address, u16 word) {
    namespace zlac = servobus::zlac8015d;
    if (address == zlac::left_target_speed.address || address == zlac::right_target_speed.address)
        return word == 0;
    return address == zlac::control_word.address &&
           (word == static_cast<u16>(zlac::control_code::quick_stop) ||
            word == static_cast<u16>(zlac::control_code::stop));
}

std::vector<alarm_row> zlac8015d_alarms() {
    namespace zlac = servobus::zlac8015d;
    std::vector<alarm_row> rows;
    for (const zlac::fault f : zlac::all_faults)
        rows.push_back({hex_word(static_cast<u16>(f)), "fault", "unstated", text(f), zlac::advice_for(f)});
    return rows;
}

// That the encoder's lines count four times follows from the manual's example, 20480 counts for five turns of 4096.
turned_shafts zlac8015d_turning(session& on) {
    namespace zlac = servobus::zlac8015d;
    std::array<u16, 1> left{}, right{};
    if (const auto why = read_words(on, zlac::left_encoder_lines.address, left); !is_ok(why))
        return {why, {}};
    if (const auto why = read_words(on, zlac::right_encoder_lines.address, right); !is_ok(why))
        return {why, {}};
    return {{},
            {{"left", zlac::left_actual_position.address, 4 * left[0], "4 x left_encoder_lines"},
             {"right", zlac::right_actual_position.address, 4 * right[0], "4 x right_encoder_lines"}}};
}

constexpr save_command zlac8015d_save{servobus::zlac8015d::save_parameters.address,
                                      static_cast<u16>(servobus::zlac8015d::parameter_save::save_all),
                                      servobus::zlac8015d::mode_of_operation.address}; // [errata B11]

const registered_drive of_zlac8015d{{.map = servobus::zlac8015d::catalogue,
                                     .simulate = simulate_zlac8015d,
                                     .alarms = zlac8015d_alarms,
                                     .at_rest = zlac8015d_at_rest,
                                     .stops = zlac8015d_stops,
                                     .save = zlac8015d_save,
                                     .interpretations = zlac8015d_interpretations,
                                     .probe =
                                         [](probe_bench& on, findings& found) {
                                             zlac8015d_probe{on, found}.run();
                                         },
                                     .version_register = servobus::zlac8015d::software_version.address,
                                     .turning = zlac8015d_turning,
                                     .on_line = &servobus::zlac8015d::device::on_line,
                                     .node_register = servobus::zlac8015d::node_address.address,
                                     .examination = &diagnosis::zlac8015d_examination}};

} // namespace
} // namespace tool
