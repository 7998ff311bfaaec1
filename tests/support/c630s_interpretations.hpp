// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interpretations of the C630S's manual under which its safety tests run: the switches of the simulated drive, but
// for `gear_keeps_rest`, which moves the motor by less than a count of its encoder.
// The whole product (SERVOBUS_INTERPRETATIONS=whole) is formed of the switches on which a promise may depend. The
// switches that concern the wire, a unit of measure or a wired terminal change with each choice, so that each
// of their positions is combined with many choices of the product.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/sim/c630s.hpp>
#include <tests/support/interpretations.hpp>

namespace c630s_interpretations {

using ::interpretations::choice;

/// One interpretation of the manual, and its number. Number 0 is the simulator's default.
struct interpretation {
    servobus::sim::c630s_options options{};
    std::size_t number = 0;
    choice positions{};

    std::size_t share = 1;
    std::size_t share_of_rows = 1;
    bool is_of_whole_product = false;

    /// For tests that inject a fault at each frame of each command. The default interpretation, and interpretations
    /// that differ from it in one switch, take every frame. Any other interpretation takes a share of the frames, and
    /// the share differs from interpretation to interpretation.
    bool takes(std::size_t frame) const { return is_near_default() || (frame + number) % share == 0; }
    bool takes_row(std::size_t row) const { return is_near_default() || (row + number) % share_of_rows == 0; }

  private:
    bool is_near_default() const { return ::interpretations::switched(positions) <= 1; }
};

namespace detail {
inline const std::vector<unsigned> sizes{5, 2, 3, 2, 3, 2, 2, 2, 2, 2, 2, 2};
inline const std::vector<unsigned> sizes_of_field{2, 2, 2, 2, 2, 2, 2};
} // namespace detail

/// The number of positions of each switch of `options_of`.
inline std::vector<unsigned> switches() {
    std::vector<unsigned> all = detail::sizes;
    all.insert(all.end(), detail::sizes_of_field.begin(), detail::sizes_of_field.end());
    return all;
}

inline servobus::sim::c630s_options options_of(const choice& c) {
    using namespace servobus::sim;
    return {.stores_eeprom_off = c[1] == 0,
            .resets_while_enabled = c[10] != 0,
            .virtual_brake_delays = c[3] == 0,
            .echoes_byte_count = c[12] != 0,
            .home_output_falls = c[9] == 0,
            .restart_keeps = static_cast<c630s_restart>(c[0]),
            .software_reset_is_power_on = c[6] == 0,
            .brake = static_cast<c630s_brake>(c[2]),
            .bus_stop = static_cast<c630s_bus_stop>(c[4]),
            .commands_end = c[5] == 0,
            .homing_command_ends = c[17] != 0,
            .segment_start_is_level = c[7] != 0,
            .jog_follows_command = c[8] != 0,
            .shows_last_alarm = c[11] != 0,
            .bus_voltage_in_volts = c[13] != 0,
            .delay_is_additional = c[14] != 0,
            .disabled_inputs_count = c[15] != 0,
            .first_output_shows = c[16] != 0,
            .servo_on_waits_for_power_on = c[18] == 0};
}

namespace detail {
inline std::vector<choice> choices_of_run() { return ::interpretations::chosen(sizes, sizes_of_field); }
} // namespace detail

/// All interpretations, the default first.
inline const std::vector<interpretation>& all() {
    static const std::vector<interpretation> found_once = [] {
        std::vector<interpretation> found;
        const std::vector<choice> choices = detail::choices_of_run();
        const bool is_whole = choices.size() > 1000;
        for (const choice& c : choices)
            found.push_back({options_of(c), found.size(), c, 4, is_whole ? 16u : 1u, is_whole});
        return found;
    }();
    return found_once;
}

/// Plays `scenes(interpretation)` under each interpretation; it returns how many scenes it played. For tests of the
/// suite "interpretations". If SERVOBUS_INTERPRETATIONS is set, prints the number of choices and scenes.
template <class Scenes> void under(const Scenes& scenes) {
    std::size_t played = 0;
    for (const interpretation& r : all()) {
        const std::string positions = ::interpretations::name(r.positions);
        CAPTURE(positions);
        played += scenes(r);
    }
    CHECK(played >= all().size() / 16);
    if (std::getenv("SERVOBUS_INTERPRETATIONS") != nullptr)
        std::printf("interpretations: c630s: %zu choices, %zu scenes: %s\n", all().size(), played,
                    doctest::getContextOptions()->currentTest->m_name);
}

} // namespace c630s_interpretations
