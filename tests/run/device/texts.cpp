// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The text of each state, cause and error that a drive or its facade reports.
#include <doctest/doctest.h>

#include <iterator>
#include <string>

#include <servobus/control/command_text.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/servobus.hpp>

namespace texts_tests {

using namespace servobus;

/// The values from 0 on have these texts, and the next one has the last text.
template <class Enum, class... Texts> void check_texts(Texts... expected) {
    unsigned value = 0;
    for (const char* one : {expected...}) {
        CAPTURE(value);
        CHECK(text(static_cast<Enum>(value)) == std::string{one});
        ++value;
    }
}

TEST_CASE("the states of a facade have texts") {
    check_texts<stop_priority>("no stop", "halt", "disable", "quick stop", "unknown");
    check_texts<verdict>("as expected", "faulted", "faulted and without power",
                         "held by an input or another program", "disabled", "perhaps restarted", "unknown");
    check_texts<stop_cause>("unknown", "fault", "stop input or limit switch", "software limit", "blocked",
                            "stop of this program", "restart", "unknown");
    check_texts<arrival_state>("no move", "under way", "reached", "stopped short", "unknown");
    check_texts<motion_check>("not asked", "seen", "not seen", "unknown", "unknown");
    check_texts<step::kind>("write", "read and compare", "read until it is as expected", "read",
                            "read whether the command may begin", "read until the command is carried out",
                            "read whether the drive has restarted", "unknown");
    check_texts<outcome>("done", "refused", "not sent", "unknown", "unknown");
}

TEST_CASE("the states of a drive have texts") {
    check_texts<drive_state>("needs init", "needs set-up", "needs a power cycle", "disabled", "enabled",
                             "quick-stopped", "faulted", "unknown");
}

TEST_CASE("YAKO: an error code has the name that the catalogue gives it") {
    const entry& row = *yako::closed_loop::catalogue.find(0x0006);
    REQUIRE(row.values.size() == 6);
    for (const named_value& v : row.values)
        CHECK(yako::text(static_cast<u16>(v.value)) == std::string{v.name});
    CHECK(yako::text(6) == std::string{"unlisted error"});
    CHECK(yako::text(0xFFFF) == std::string{"unlisted error"});
}

TEST_CASE("C630S: an alarm has the name that the catalogue gives it") {
    const entry& row = *c630s::catalogue.find(c630s::recorded_alarm.address);
    REQUIRE(row.values.size() == std::size(c630s::alarms) + 1);
    for (const named_value& v : row.values)
        CHECK(c630s::text(static_cast<u16>(v.value)) == std::string{v.name});
    for (const c630s::alarm& a : c630s::alarms) CHECK(text(a) == std::string{c630s::text(a.code)});
    CHECK(c630s::text(0x999) == std::string{"unlisted alarm"});
}

TEST_CASE("ZLAC8015D: a fault has the name that the catalogue gives it") {
    const entry& row = *zlac8015d::catalogue.find(zlac8015d::left_faults.address);
    std::size_t named = 0;
    for (const zlac8015d::fault f : zlac8015d::all_faults) {
        for (const named_value& v : row.values) named += text(f) == std::string{v.name} ? 1u : 0u;
    }
    CHECK(named == std::size(zlac8015d::all_faults));
}

static_assert(text(stop_cause::blocked)[0] == 'b' && yako::text(2)[6] == '2');

} // namespace texts_tests
