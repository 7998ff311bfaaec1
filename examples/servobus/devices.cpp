// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drives by name.
#include <servobus/device/c630s/assignments.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "text/nearest.hpp"
#include "tool.hpp"

namespace tool {
namespace {

int c630s_parameter(std::string_view text) {
    return servobus::c630s::detail::parameter_address(text.data(), text.size());
}

constexpr save_command zlac8015d_save{servobus::zlac8015d::save_parameters.address,
                                      static_cast<u16>(servobus::zlac8015d::parameter_save::save_all),
                                      servobus::zlac8015d::mode_of_operation.address}; // [errata B11]
constexpr save_command yako_save{servobus::yako::auxiliary_command.address,
                                 static_cast<u16>(servobus::yako::auxiliary::save_parameters)};

} // namespace

std::span<const device> devices() {
    static constexpr device known[] = {
        {.map = &servobus::zlac8015d::catalogue,
         .simulate = simulate_zlac8015d,
         .alarms = zlac8015d_alarms,
         .at_rest = zlac8015d_at_rest,
         .stops = zlac8015d_stops,
         .save = zlac8015d_save},
        {.map = &servobus::yako::closed_loop::catalogue,
         .simulate = simulate_yako_closed_loop,
         .alarms = yako_alarms,
         .at_rest = yako_at_rest,
         .stops = yako_stops,
         .save = yako_save},
        {.map = &servobus::yako::open_loop::catalogue,
         .simulate = simulate_yako_open_loop,
         .alarms = yako_alarms,
         .at_rest = yako_at_rest,
         .stops = yako_stops,
         .save = yako_save},
        // More than 200 stored parameters raise the alarm Er.942.
        {.map = &servobus::c630s::catalogue,
         .simulate = simulate_c630s,
         .alarms = c630s_alarms,
         .at_rest = c630s_at_rest,
         .stops = c630s_stops,
         .number = c630s_parameter,
         .most_stored = 200,
         .excludes = servobus::c630s::excludes},
    };
    return known;
}

const device* find_device(std::string_view name) {
    std::vector<std::string_view> names;
    std::string known = "; known: ";
    for (const device& d : devices()) {
        if (name == d.facts().name) return &d;
        known += names.empty() ? "" : ", ";
        known += d.facts().name;
        names.push_back(d.facts().name);
    }
    complain(usage, "unknown device '" + std::string{name} + "'" + did_you_mean(name, names, known));
    return nullptr;
}

std::string device::display_name(u16 address) const {
    const servobus::entry* e = map->find(address);
    return (e != nullptr ? std::string{e->name} : std::string{"register"}) + " (" + hex_word(address) + ")";
}

} // namespace tool
