// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The checks of `servobus doctor` on a ZLAC8015D, against the simulated drive and its facade.
#include <memory>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <examples/servobus/doctor/zlac8015d.hpp>
#include <tests/support/driven_doctored.hpp>
#include <tests/support/mended_findings.hpp>

namespace doctor_zlac8015d_tests {
namespace {

namespace zlac = servobus::zlac8015d;
using doctored::u16;
using servobus::sim::zlac8015d_options;
using bench = doctored::bench<servobus::sim::zlac8015d, zlac::drive>;
constexpr const auto& list = tool::diagnosis::zlac8015d_checks;
constexpr const auto& map = zlac::catalogue;

constexpr u16 mode = zlac::mode_of_operation.address;
constexpr u16 control = zlac::control_word.address;
constexpr u16 word_of(zlac::control_code c) { return static_cast<u16>(c); }

// Another program has enabled the drive in this mode, and has set the targets; its line is alive meanwhile.
bool operate(bench& b, zlac::operating_mode in, u16 speed, u16 torque) {
    b.pass(1);
    bool is_done = b.model.put(mode, {static_cast<u16>(in)});
    is_done = b.model.put(control, {word_of(zlac::control_code::enable)}) && is_done;
    is_done = b.model.put(zlac::left_target_speed.address, {speed, speed}) && is_done;
    is_done = b.model.put(zlac::left_target_torque.address, {torque, torque}) && is_done;
    b.pass(300);
    return is_done && b.model.enabled();
}
template <u16 Address, u16 Word> bool put(bench& b) { return b.model.put(Address, {Word}); }
template <u16 Address, u16 Word> bool force(bench& b) {
    b.model.forced[Address] = Word;
    return true;
}

// In this order: a state that others would undo comes after them.
constexpr doctored::state<bench> states[] = {
    {"nothing", [](bench&) { return true; }},
    {"X0 active",
     [](bench& b) {
         b.model.set_input(true, false);
         b.pass(5);
         return true;
     },
     " x0_function"},
    {"X1 active, without a function",
     [](bench& b) {
         b.model.set_input(false, true);
         return true;
     }},
    {"X1 is a stop and active",
     [](bench& b) {
         b.model.set_input(false, true);
         b.pass(5);
         return put<0x2018, 9>(b);
     },
     " x1_function"},
    {"X0 has no function", put<0x2017, 0>},
    {"X0 inverted", [](bench& b) { return put<0x2016, 1>(b); }, " x0_function"},
    {"both inverted", [](bench& b) { return put<0x2016, 3>(b); }, " x0_function"},
    {"a resolution of 0.1 r/min", put<0x2022, 10>, " speed_resolution"},
    {"a resolution of 0", force<0x2022, 0>, " speed_resolution: it is outside"},
    {"a resolution of 11", force<0x2022, 11>, " speed_resolution: it is outside"},
    {"no timeout", put<0x2000, 0>, " host_timeout"},
    {"a timeout of 20 ms", put<0x2000, 20>, " host_timeout"},
    {"a timeout of 150 ms", put<0x2000, 150>, " host_timeout"},
    {"a timeout of 30 s", put<0x2000, 30000>, " host_timeout"},
    {"parking", put<0x200C, 1>, " parking_mode"},
    {"held at power-on",
     [](bench& b) {
         const bool is = put<0x2007, 1>(b) && put<0x2010, 1>(b);
         b.model.power_cycle();
         return is;
     },
     " status_word"},
    {"a brake", put<0x201A, 1>, " left_brake"},
    {"the other brake", put<0x201B, 1>, " right_brake"},
    {"released by a stop", put<0x2021, 1>, " input_stop"},
    {"no current", put<0x2034, 0>, " left_max_current"},
    {"no current at the right", put<0x2064, 0>, " right_max_current"},
    {"rated above maximum", [](bench& b) { return put<0x2034, 100>(b); }, " left_rated_current"},
    {"rated above maximum, right", [](bench& b) { return put<0x2064, 100>(b); }, " right_rated_current"},
    {"no speed gain", put<0x203C, 0>, " left_speed_kp: the speed loop"},
    {"no speed gain at the right", put<0x206C, 0>, " right_speed_kp: the speed loop"},
    {"no position gain", put<0x203F, 0>, " left_position_kp: the position loop"},
    {"no position gain at the right", put<0x206F, 0>, " right_position_kp: the position loop"},
    {"no encoder", put<0x2030, 0>, " left_encoder_lines"},
    {"no encoder at the right", put<0x2060, 0>, " right_encoder_lines"},
    {"unlike rated currents", put<0x2033, 100>, " left_rated_current: the wheels"},
    {"unlike speeds of moves", put<0x208E, 60>, " left_max_speed: the wheels"},
    {"unlike encoders", put<0x2060, 4096>, " left_encoder_lines"},
    {"unlike poles", put<0x2045, 10>, " left_pole_pairs"},
    {"unlike ramps", put<0x2080, 100>, " left_acceleration_time: the wheels have unlike ramps"},
    {"unlike ramps down", put<0x2083, 100>, " left_deceleration_time: the wheels have unlike ramps"},
    {"a long ramp", [](bench& b) { return put<0x2080, 601>(b) && put<0x2081, 601>(b); },
     " left_acceleration_time: the ramp begins anew"},
    {"a long ramp down", [](bench& b) { return put<0x2082, 900>(b) && put<0x2083, 900>(b); },
     " left_deceleration_time: the ramp begins anew"},
    {"unlike quick stops", put<0x2084, 500>, " left_quick_stop_time: the wheels have unlike ramps"},
    {"unlike overload factors", put<0x2032, 100>, " left_overload_factor"},
    {"unlike overload times", put<0x2065, 100>, " left_overload_time"},
    {"unlike following errors", put<0x2036, 100>, " left_following_error_limit"},
    {"slow", put<0x2008, 60>, " left_max_speed"},
    {"another rate from power-on on", put<0x2002, 6>, " rs485_baud_rate"},
    {"another address from power-on on", put<0x2001, 7>, " node_address"},
    {"targets are left",
     [](bench& b) {
         return b.model.put(0x2088, {30, 30});
     },
     " left_target_speed"},
    {"a target is left at the right", put<0x2089, 30>, " right_target_speed"},
    {"torques are left",
     [](bench& b) {
         return b.model.put(0x2090, {1000, 1000});
     },
     " left_target_torque"},
    {"a torque is left at the right", put<0x2091, 1000>, " right_target_torque"},
    {"enabled", [](bench& b) { return operate(b, zlac::operating_mode::velocity, 0, 0); }, " status_word"},
    {"turning", [](bench& b) { return operate(b, zlac::operating_mode::velocity, 30, 0); }, " status_word"},
    {"in torque mode", [](bench& b) { return operate(b, zlac::operating_mode::torque, 0, 2000); },
     " status_word"},
    {"quick-stopped",
     [](bench& b) { return operate(b, zlac::operating_mode::velocity, 30, 0) && put<0x200E, 5>(b); },
     " status_word"},
    {"warm",
     [](bench& b) {
         b.model.set_motor_temperature(75, 20);
         return true;
     },
     " motor_temperature: the left"},
    {"too hot",
     [](bench& b) {
         b.model.set_motor_temperature(20, 90);
         return true;
     },
     " right_faults"},
    {"a hot drive",
     [](bench& b) {
         b.model.set_driver_temperature(750);
         return true;
     },
     " driver_temperature"},
    {"undervoltage",
     [](bench& b) {
         b.model.raise(zlac::fault::undervoltage, zlac::fault::none);
         return true;
     },
     " left_faults"},
    {"a Hall fault",
     [](bench& b) {
         b.model.raise(zlac::fault::none, zlac::fault::hall);
         return true;
     },
     " hall_state"},
    {"a fault whose cause has ended",
     [](bench& b) {
         b.model.raise(zlac::fault::overload, zlac::fault::none);
         b.model.end_faults();
         return true;
     },
     " left_faults"},
    {"a fault that was reset",
     [](bench& b) {
         b.model.raise(zlac::fault::overload, zlac::fault::none);
         b.model.end_faults();
         return put<0x200E, 6>(b);
     }},
    {"a code that stays", force<0x20A5, 4>, " left_faults: the wheel is in no alarm"},
    {"a code that stays at the right", force<0x20A6, 4>, " right_faults: the wheel is in no alarm"},
    {"an alarm without a code",
     [](bench& b) {
         b.model.forced[0x20A2] = 0x00C0;
         return force<0x20A5, 0>(b) && force<0x20A6, 0>(b);
     },
     " status_word: a shaft"},
};

std::unique_ptr<bench> make() { return std::make_unique<bench>(zlac8015d_options{}); }

TEST_CASE("doctor refuses a ZLAC8015D exactly where its facade does not enable it") {
    (void)doctored::play(states, list, map, make, 150);
}

TEST_CASE("doctor finds each state of a ZLAC8015D") {
    std::set<std::string> said;
    doctored::expect_findings(states, list, map, make, said);
    doctored::expect_all(list, map, said);
}

TEST_CASE("the commands that doctor names mend its findings about a ZLAC8015D") {
    std::set<std::string> mended;
    doctored::expect_mended(states, list, map, make, mended);
    // The state of its shaft is forced in the test.
    doctored::expect_all_mended(list, mended, {"a shaft is in alarm, without a fault code"});
}

TEST_CASE("doctor has nothing to say of a ZLAC8015D from the factory") {
    const auto b = make();
    CHECK(tool::diagnosis::find(list, doctored::read_of(b->model, list, map)).empty());
}

TEST_CASE("a ramp is too long where a program has said how often it sends setpoints") {
    auto held = doctored::read_of(make()->model, list, map);
    const auto findings_at = [&](std::uint32_t period_ms) {
        held.on.period_ms = period_ms;
        return tool::diagnosis::find(list, held).size();
    };
    CHECK(findings_at(0) == 0);
    CHECK(findings_at(499) == 2);
    CHECK(findings_at(500) == 0);
}

TEST_CASE("the limits of the checks of a ZLAC8015D") {
    const auto held = doctored::read_of(make()->model, list, map);
    const auto count_with = [&](u16 address, u16 word) {
        auto changed = held;
        changed.put(address, word);
        return tool::diagnosis::find(list, changed).size();
    };
    struct limit {
        u16 address;
        u16 last_good;
        u16 first_bad;
    };
    constexpr limit limits[] = {
        {0x2000, 182, 181},       {0x2000, 1000, 1001},     {0x2022, 1, 0},     {0x2022, 1, 2},
        {0x20A4, 0x461F, 0x471F}, {0x20A4, 0x1F46, 0x1F47}, {0x20B0, 700, 701}, {0x20A3, 0x0601, 0x0701},
        {0x20A3, 0x0106, 0x0107}, {0x20A3, 0x0101, 0x0001}, {0x20AB, 20, 21},   {0x20AC, 0xFFEC, 0xFFEB},
        {0x208E, 120, 121}, // the other wheel has 120
    };
    for (const limit& l : limits) {
        CAPTURE(l.address);
        CAPTURE(l.first_bad);
        CHECK(count_with(l.address, l.last_good) == 0);
        CHECK(count_with(l.address, l.first_bad) == 1);
    }
    auto equal = held; // rated and maximum current of both wheels
    for (const u16 address : {u16{0x2033}, u16{0x2034}, u16{0x2063}, u16{0x2064}}) equal.put(address, 150);
    CHECK(tool::diagnosis::find(list, equal).empty());
    equal.put(0x2033, 151);
    equal.put(0x2063, 151);
    CHECK(tool::diagnosis::find(list, equal).size() == 2);
    for (u16 resolution = 1; resolution < 13; ++resolution)
        CHECK(count_with(0x2022, resolution) == (resolution == 1 ? 0 : 1));
}

TEST_CASE("doctor asks for consent exactly while a ZLAC8015D is enabled") {
    namespace rules = tool::diagnosis::zlac8015d_rules;
    for (const auto shaft : {zlac8015d_options::shaft::locked, zlac8015d_options::shaft::released}) {
        zlac8015d_options chosen;
        chosen.in_torque_mode = shaft;
        for (const zlac::operating_mode in : {zlac::operating_mode::velocity, zlac::operating_mode::torque}) {
            bench b{chosen};
            const auto asks = [&] {
                tool::diagnosis::held_registers seen;
                for (const u16 address : rules::status) seen.put(address, b.model.peek(address));
                return rules::is_watched(seen);
            };
            CAPTURE(static_cast<int>(in));
            b.pass(1);
            REQUIRE(b.model.put(mode, {static_cast<u16>(in)}));
            CHECK_FALSE(asks()); // never enabled
            REQUIRE(operate(b, in, 0, 0));
            CHECK(asks());
            REQUIRE(b.model.put(control, {word_of(zlac::control_code::fault_reset)})); // still enabled
            REQUIRE(b.model.enabled());
            CHECK(asks());
            REQUIRE(b.model.put(control, {word_of(zlac::control_code::stop)}));
            b.pass(1000);
            REQUIRE_FALSE(b.model.enabled());
            CHECK_FALSE(asks());
        }
    }
}

// A watchdog time of 0, and one in which a stop lasts, may refuse an enable: doctor says so, and leaves it open.
bool is_open(const doctored::held_registers& r) { return r.word(zlac::host_timeout) < 20; }

TEST_CASE("doctor refuses a ZLAC8015D exactly under each other interpretation of the manual too") {
    using choice = zlac8015d_options;
    constexpr void (*choices[])(choice&) = {
        [](choice& o) { o.resumes_after_watchdog = false; },
        [](choice& o) { o.save = choice::kept::all; },
        [](choice& o) { o.host_timeout = choice::zero::stops; },
        [](choice& o) { o.while_turning = choice::shaft::released; },
        [](choice& o) { o.in_torque_mode = choice::shaft::released; },
        [](choice& o) { o.after_quick_stop = choice::stopped::locked; },
        [](choice& o) { o.bit = choice::running::driven; },
        [](choice& o) { o.bit = choice::running::enabled; },
        [](choice& o) { o.code = choice::fault_code::until_restart; },
        [](choice& o) { o.by_fault = choice::switched_off::its_wheel; },
        [](choice& o) { o.code_1 = choice::brake::releases; },
    };
    const auto make_of = [](const choice& o) { return [o] { return std::make_unique<bench>(o); }; };
    const auto count = doctored::play_under(states, list, map, choices, make_of, is_open);
    CHECK(count.open > 10);
}

TEST_CASE("doctor says where an enable of a ZLAC8015D is refused under one interpretation alone") {
    zlac8015d_options stays;
    stays.resumes_after_watchdog = false;
    zlac8015d_options always;
    always.host_timeout = zlac8015d_options::zero::stops;
    doctored::tally count;
    for (const auto& [options, timeout] : {std::pair{stays, u16{1}}, std::pair{always, u16{0}}}) {
        bench b{options};
        REQUIRE(b.model.put(0x2000, {timeout}));
        doctored::compare(b, list, map, count, is_open);
    }
    CHECK(count.open == 2);
    CHECK(count.refused == 2);
}

} // namespace
} // namespace doctor_zlac8015d_tests
