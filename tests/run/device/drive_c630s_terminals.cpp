// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade and the functions of terminals: no assignment causes Er.130, and the wired functions that
// set_up keeps work on a drive that the facade operates.
#include <doctest/doctest.h>

#include <array>
#include <string_view>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <tests/support/driven_c630s.hpp>

namespace drive_c630s_terminals_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;
using in = input_function;

namespace {

bool same_text(const char* a, std::string_view b) { return b == a; }

constexpr u16 function_of_di(unsigned number) {
    return static_cast<u16>(di1_function.address + 2 * (number - 1));
}
constexpr u16 function_of_vdi(unsigned number) {
    return static_cast<u16>(virtual_input_functions[0].address + 2 * (number - 1));
}

std::size_t writes_of(const rig& r) {
    std::size_t n = 0;
    for (const rig::frame& f : r.requests) n += modbus::is_write(f[1]) ? 1u : 0u;
    return n;
}

/// The terminals that have this function, one bit each: DI1 to DI8, VDI1 to VDI16.
unsigned holders(rig& r, in function) {
    unsigned found = 0;
    for (unsigned n = 1; n <= 24; ++n) {
        const u16 at = n <= 8 ? function_of_di(n) : function_of_vdi(n - 8);
        if (r.model.peek(at) == static_cast<int>(function)) found |= 1u << (n - 1);
    }
    return found;
}

template <const auto& Row> command_status keep_function(rig& r, in f) {
    return r.drive.run(keep<Row>{checked(f)});
}
using keeper = command_status (*)(rig&, in);
constexpr keeper keepers[] = {keep_function<di1_function>, keep_function<di2_function>,
                              keep_function<di3_function>, keep_function<di4_function>,
                              keep_function<di5_function>, keep_function<di6_function>,
                              keep_function<di7_function>, keep_function<di8_function>};

} // namespace

TEST_CASE("6.4.1: an input does not get a function that another input has, and Er.130 does not occur") {
    rig r;
    CHECK(r.drive.conflicting_terminal() == 0);
    REQUIRE(r.make_ready());
    r.requests.clear();
    const command_status got = r.drive.run(keep<di1_function>{in::home_switch});
    CHECK(got.error() == errc::already_assigned);
    CHECK(got.outcome() == outcome::not_sent);
    CHECK(std::string_view{text(got.error())} == "another terminal has this function");
    CHECK(r.drive.conflicting_terminal() == "P03-14"_p);
    const entry* holder = c630s::catalogue.find(r.drive.conflicting_terminal());
    REQUIRE(holder != nullptr);
    CHECK(same_text(holder->name, "di7_function"));
    CHECK(writes_of(r) == 0);
    CHECK(r.drive.state() == drive_state::disabled);
    r.model.power_cycle();
    CHECK_FALSE(r.model.has_alarm(0x130));
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.conflicting_terminal() == 0);
    // Once DI7 has none, DI1 gets it.
    REQUIRE(r.drive.run(keep<di7_function>{in::none}));
    REQUIRE(r.drive.run(keep<di1_function>{in::home_switch}));
    REQUIRE(r.drive.run(keep<di1_function>{in::home_switch})); // it already has this function
    r.model.power_cycle();
    CHECK_FALSE(r.model.has_alarm(0x130));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
}

TEST_CASE("6.4.1: each function is assigned to each input, or refused because another terminal has it") {
    for (unsigned code = 0; code <= 38; ++code) {
        const auto f = static_cast<in>(code);
        if (f == in::servo_on || code == 29 || code == 30) continue;
        CAPTURE(code);
        rig r;
        REQUIRE(r.make_ready());
        for (unsigned n = 1; n <= 8; ++n) {
            CAPTURE(n);
            const unsigned others = holders(r, f) & ~(1u << (n - 1));
            const std::uint32_t stored = r.model.eeprom_writes();
            const command_status got = keepers[n - 1](r, f);
            CHECK(static_cast<bool>(got) == (f == in::none || others == 0));
            if (got) {
                CHECK(r.model.stored(function_of_di(n)) == static_cast<int>(f));
                CHECK(r.drive.conflicting_terminal() == 0);
            } else {
                CHECK(got.error() == errc::already_assigned);
                CHECK(r.model.eeprom_writes() == stored);
                CHECK(r.model.peek(r.drive.conflicting_terminal()) == static_cast<int>(f));
                CHECK(r.drive.conflicting_terminal() != function_of_di(n));
            }
        }
        r.model.power_cycle();
        CHECK_FALSE(r.model.has_alarm(0x130));
    }
}

TEST_CASE("6.4.1: an input does not get the function of any other input, from DI1 to VDI16") {
    rig r;
    REQUIRE(r.make_ready());
    for (unsigned n = 1; n <= 24; ++n) {
        CAPTURE(n);
        const u16 at = n <= 8 ? function_of_di(n) : function_of_vdi(n - 8);
        const auto set_by_hand = [&](std::int64_t f) {
            const std::uint8_t word[] = {0, static_cast<std::uint8_t>(f)};
            REQUIRE(r.model.write(at, words_view{bytes{word}}) == 0);
        };
        const std::int64_t was = r.model.peek(at);
        set_by_hand(static_cast<std::int64_t>(in::zero_clamp));
        const bool is_other = n != 2;
        const command_status got = r.drive.run(set<di2_function>{in::zero_clamp});
        CHECK(got.error() == (is_other ? errc::already_assigned : errc::ok));
        CHECK(r.drive.conflicting_terminal() == (is_other ? at : 0));
        set_by_hand(was);
    }
}

TEST_CASE("a function that is set until power-off is also compared with those of wired and virtual inputs") {
    rig r;
    REQUIRE(r.make_ready());
    r.requests.clear();
    CHECK(r.drive.run(set<di3_function>{in::jog_forward}).error() == errc::already_assigned);
    CHECK(r.drive.conflicting_terminal() == "P17-18"_p);
    CHECK(writes_of(r) == 0);
    CHECK(r.drive.run(set<di3_function>{in::negative_overtravel}));
    CHECK(r.drive.conflicting_terminal() == 0);
    CHECK(r.drive.run(set<di3_function>{in::zero_clamp}));
    CHECK(r.drive.run(set<di3_logic>{input_logic::high_level}));
    r.wire.pass(milliseconds(20));
    CHECK_FALSE(r.model.has_alarm(0x130));
    CHECK(r.model.is_active(in::zero_clamp));
}

TEST_CASE("6.4.2: a wired output does not get the function of another wired output; a virtual output may "
          "have the same") {
    rig r;
    REQUIRE(r.make_ready());
    r.requests.clear();
    CHECK(r.drive.run(keep<do4_function>{output_function::home_attained}).error() == errc::already_assigned);
    CHECK(r.drive.conflicting_terminal() == "P04-08"_p); // DO5, as the manual's own example has it
    CHECK(writes_of(r) == 0);
    REQUIRE(r.drive.run(keep<do5_function>{output_function::none}));
    REQUIRE(r.drive.run(keep<do4_function>{output_function::home_attained}));
    REQUIRE(r.drive.run(keep<do2_function>{output_function::brake})); // VDO9 has it too
    CHECK(r.drive.run(keep<do6_function>{output_function::brake}).error() == errc::already_assigned);
    CHECK(r.drive.conflicting_terminal() == "P04-02"_p);
    REQUIRE(r.drive.run(keep<do1_function>{output_function::none}));
    REQUIRE(r.drive.run(keep<do3_function>{output_function::none})); // two outputs may have no function
}

TEST_CASE("a conflict check without a response, or pre-empted by a stop, writes nothing") {
    for (std::size_t lost = 0; lost < 12; ++lost) {
        CAPTURE(lost);
        rig r;
        REQUIRE(r.make_ready());
        r.requests.clear();
        const std::size_t start = r.wire.requests();
        REQUIRE(r.drive.begin(keep<di1_function>{in::zero_clamp}) == errc::ok);
        SUBCASE("no response") {
            while (!r.drive.is_idle()) {
                r.wire.faults().lost_response = r.wire.requests() - start > lost ? 1000 : 0;
                r.turn();
            }
            CHECK(r.drive.last().outcome() == outcome::not_sent);
            CHECK(r.drive.last().error() == errc::timeout);
            CHECK(r.drive.state() == drive_state::needs_init);
            CHECK(writes_of(r) == 0);
        }
        SUBCASE("a stop") {
            while (r.wire.requests() - start <= lost) r.turn();
            REQUIRE(r.drive.begin(disable{}) == errc::ok);
            while (!r.drive.is_idle()) r.turn();
            CHECK(r.drive.last());
            CHECK(r.drive.state() == drive_state::disabled);
        }
        CHECK(r.written_to(di1_function.address).empty());
        CHECK(r.model.stored(di1_function.address) != static_cast<int>(in::zero_clamp));
    }
}

TEST_CASE("set_up keeps a wired alarm reset, which resets a fault while the servo is off") {
    rig r;
    REQUIRE(r.make_ready());
    CHECK(r.model.stored(di4_function.address) == static_cast<int>(in::alarm_reset));
    CHECK(holders(r, in::alarm_reset) == 1u << 3);
    const auto press = [&r] {
        r.model.set_input(4, true);
        r.run(20);
        r.model.set_input(4, false);
        r.run(20);
    };
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.drive.run(velocity{100 * r_per_min}));
    REQUIRE(r.live(milliseconds(300)));
    r.model.raise(0x620);
    press(); // servo-on is still set: the fault stays
    CHECK(r.model.has_alarm(0x620));
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(disable{}));
    press();
    CHECK_FALSE(r.model.has_alarm(0x620));
    CHECK_FALSE(r.model.enabled()); // S5: a reset leaves the servo off
    REQUIRE(r.live(milliseconds(300)));
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    REQUIRE(r.live(milliseconds(300)));
    CHECK(r.model.stands_still()); // S2: without the previous target
}

TEST_CASE("S1: set_up keeps the terminal of a wired homing start, and the terminal does not start a homing "
          "while the drive is enabled") {
    for (const homing how : {homing::by_input, homing::electrical_by_input, homing::at_power_on}) {
        CAPTURE(static_cast<int>(how));
        rig r;
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<homing_control>(checked(how)));
        REQUIRE(r.make_ready());
        CHECK(r.model.stored(di8_function.address) == static_cast<int>(in::homing_start));
        CHECK(r.model.stored(homing_control.address) == 0);
        CHECK(holders(r, in::homing_start) == 1u << 7);
        SUBCASE("as set_up left it") {}
        SUBCASE("set again by another program") {
            const auto token = direct.ram_only();
            REQUIRE(token);
            REQUIRE(direct.write<homing_control>(checked(how), *token));
        }
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        CHECK(r.model.peek(homing_control.address) == 0);
        r.model.set_input(8, true);
        REQUIRE(r.live(milliseconds(500)));
        r.model.set_input(8, false);
        REQUIRE(r.live(milliseconds(500)));
        CHECK(r.model.homings() == 0);
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("set_up removes from wired inputs the functions that the bus gives, and no others") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.store<di2_function>(in::jog_forward));
    REQUIRE(direct.store<di3_function>(in::step_enable));
    REQUIRE(r.make_ready());
    const std::array<in, 8> left{
        in::none,           in::none,        in::none,        in::alarm_reset, in::speed_direction,
        in::emergency_stop, in::home_switch, in::homing_start};
    for (unsigned n = 1; n <= 8; ++n) {
        CAPTURE(n);
        CHECK(r.model.stored(function_of_di(n)) == static_cast<int>(left[n - 1]));
    }
    CHECK_FALSE(r.model.has_alarm(0x130));
}

TEST_CASE(
    "6.4.1, 6.4.2: two inputs exclude each other, wired or virtual, and so do two wired outputs; no other "
    "registers do") {
    struct terminals {
        u16 first;
        u16 last;
        bool are_inputs;
    };
    using namespace c630s::literals;
    constexpr terminals exclusive[] = {{"P03-02"_p, "P03-16"_p, true},   // DI1 to DI8
                                       {"P17-00"_p, "P17-30"_p, true},   // VDI1 to VDI16
                                       {"P04-00"_p, "P04-10"_p, false}}; // DO1 to DO6
    const auto kind_of = [&](u16 address) {                              // 1: an input, 2: a wired output
        for (const terminals& t : exclusive) {
            if (address >= t.first && address <= t.last && (address - t.first) % 2 == 0)
                return t.are_inputs ? 1 : 2;
        }
        return 0;
    };
    std::vector<u16> all;
    for (const entry& e : c630s::catalogue.entries) {
        if (e.address >= 0x0200 && e.address < 0x0500) all.push_back(e.address);
        if (e.address >= 0x1700 && e.address < 0x1800) all.push_back(e.address);
    }
    std::size_t pairs = 0;
    std::size_t wrong = 0;
    for (const u16 one : all) {
        for (const u16 other : all) {
            const bool is_double = one != other && kind_of(one) != 0 && kind_of(one) == kind_of(other);
            pairs += is_double ? 1u : 0u;
            wrong += excludes(one, other) != is_double ? 1u : 0u;
        }
    }
    CHECK(wrong == 0);
    CHECK(pairs == 24 * 23 + 6 * 5);
    CHECK(excludes("P17-28"_p, "P03-08"_p));
    CHECK_FALSE(excludes("P17-33"_p, "P17-63"_p)); // virtual outputs may show the same
    CHECK_FALSE(excludes("P17-65"_p, "P17-32"_p)); // no functions of terminals
    CHECK_FALSE(excludes("P0B-00"_p, "P0B-02"_p));
}

} // namespace drive_c630s_terminals_tests
