// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The catalogues name every code that the manuals explain. The registers of a small range without names, and the codes
// without a name, are those here: numbers, and what the manuals leave out [errata A16, B19, C14, C36, C38].
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

namespace codes_tests {

using namespace servobus;

namespace {

constexpr std::int64_t most_codes = 48;

bool is_small(const entry& e) { return e.limits.is_stated && e.limits.high - e.limits.low <= most_codes; }
std::string names_of_unnamed(const catalogue& of) {
    std::string all;
    for (const entry& e : of.entries) {
        if (!e.values.empty() || !is_small(e) || e.unit_of_count.of != measure::none) continue;
        all += std::string{all.empty() ? "" : " "} + static_cast<const char*>(e.name);
    }
    return all;
}
// Of the registers whose names are codes of the whole word: `y0_function 6 7 8`. The same codes are listed once.
std::string codes_without_name(const catalogue& of) {
    std::string all;
    std::set<std::string> listed;
    for (const entry& e : of.entries) {
        const bool has_codes = !e.values.empty() && std::ranges::all_of(e.values, [](const named_value& v) {
            return v.mask == 0xFFFF;
        });
        if (!has_codes || !is_small(e)) continue;
        std::string codes;
        for (std::int64_t n = e.limits.low; n <= e.limits.high; ++n) {
            const bool is_named =
                std::ranges::any_of(e.values, [&](const named_value& v) { return e.number(v.value) == n; });
            if (!is_named) codes += ' ' + std::to_string(n);
        }
        for (const named_value& v : e.values) CHECK(e.limits.contains(e.number(v.value)));
        if (codes.empty() || !listed.insert(codes).second) continue;
        all += (all.empty() ? "" : "; ") + std::string{e.name} + codes;
    }
    return all;
}

} // namespace

TEST_CASE("codes: a register of a small range has names, or its content is a number") {
    CHECK(names_of_unnamed(zlac8015d::catalogue) == "speed_resolution host_connected");
    CHECK(names_of_unnamed(yako::closed_loop::catalogue) == "");
    CHECK(names_of_unnamed(yako::open_loop::catalogue) == "");
    CHECK(names_of_unnamed(c630s::catalogue) ==
          "homing_time_unit stiffness_level notch_1_width notch_2_width notch_3_width notch_4_width "
          "low_frequency_resonance_filter reserved_parameter last_position_segment first_position_segment "
          "last_speed_segment");
}

TEST_CASE("codes: each code of a range has a name, but for those that the manuals do not explain") {
    CHECK(codes_without_name(zlac8015d::catalogue) ==
          "control_word 1 2 3 4 9 10 11 12 13 14 15; x0_function 1 2 3 4 5 6 7 8");
    CHECK(codes_without_name(yako::closed_loop::catalogue) ==
          "homing_method 0 15 16 31 32; y0_function 6 7 8");
    CHECK(codes_without_name(yako::open_loop::catalogue) == "homing_method 31 32 33 34; y0_function 6 7 8");
    CHECK(codes_without_name(c630s::catalogue) ==
          "di1_function 29 30; do1_function 15; homing_control 7; auxiliary_speed_source 3 4; "
          "virtual_output_1_function 15 21 22");
}

} // namespace codes_tests
