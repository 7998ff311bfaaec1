// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC steppers, closed and open loop, as the tool knows them.
#include <array>
#include <string>

#include <servobus/device/yako/advice.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/common.hpp>
#include <servobus/device/yako/feedback.hpp>
#include <servobus/device/yako/model.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>

#include "../devices/registered_drive.hpp"
#include "../doctor/yako.hpp"
#include "../interpretations/yako_switches.hpp"
#include "../probe/yako.hpp"
#include "../registers/at_rest.hpp"
#include "../simulators/simulators.hpp"

namespace tool {
namespace {

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

bool yako_stops(u16 address, u16 word) {
    using servobus::yako::motion_code;
    return address == servobus::yako::motion_command.address &&
           (word == motion_code::stop().bits || word == motion_code::emergency_stop().bits);
}

std::vector<alarm_row> yako_alarms() {
    namespace yako = servobus::yako;
    std::vector<alarm_row> rows;
    for (u16 error = 1; error <= yako::error_code.limits.high; ++error)
        rows.push_back(
            {std::to_string(error), "alarm", "unstated", yako::text(error), yako::advice_for(error)});
    return rows;
}

// Of an open loop the position is what was commanded, which no hand changes.
turned_shafts yako_turning(session& on) {
    std::array<u16, 1> steps{};
    if (const auto why = read_words(on, servobus::yako::microstep_resolution.address, steps); !is_ok(why))
        return {why, {}};
    return {{}, {{"motor", servobus::yako::actual_position.address, steps[0], "microstep_resolution"}}};
}

constexpr save_command yako_save{servobus::yako::auxiliary_command.address,
                                 static_cast<u16>(servobus::yako::auxiliary::save_parameters)};

template <bool HasEncoder> void probe_yako(probe_bench& on, findings& found) {
    yako_probe{on, found, HasEncoder}.run();
}

// Makes the row of a stepper with what both have in common.
template <class Device>
known_drive stepper(const servobus::catalogue& map, int (&simulate)(const simulation&)) {
    return {.map = map,
            .simulate = simulate,
            .alarms = yako_alarms,
            .at_rest = yako_at_rest,
            .stops = yako_stops,
            .save = yako_save,
            .interpretations = yako_interpretations,
            .version_register = servobus::yako::drive_version.address,
            .on_line = &servobus::yako::device::on_line,
            .node_register = servobus::yako::node_address.address,
            .has_watchdog = servobus::yako::model<Device>::traits.stops_without_line};
}
known_drive closed_loop_stepper() {
    known_drive d = stepper<servobus::yako::closed_loop::device>(servobus::yako::closed_loop::catalogue,
                                                                 simulate_yako_closed_loop);
    d.probe = probe_yako<true>;
    d.turning = yako_turning;
    d.examination = &diagnosis::yako_closed_loop_examination;
    return d;
}
known_drive open_loop_stepper() {
    known_drive d = stepper<servobus::yako::open_loop::device>(servobus::yako::open_loop::catalogue,
                                                               simulate_yako_open_loop);
    d.probe = probe_yako<false>;
    d.examination = &diagnosis::yako_open_loop_examination;
    return d;
}

const registered_drive of_yako_closed_loop{closed_loop_stepper()};
const registered_drive of_yako_open_loop{open_loop_stepper()};

} // namespace
} // namespace tool
