// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The checks of `servobus doctor` on a C630S, against the simulated drive and its facade: of a drive from the factory,
// and of one that was set up.
#include <memory>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/sim/c630s.hpp>

#include <examples/servobus/doctor/c630s.hpp>
#include <tests/support/driven_doctored.hpp>
#include <tests/support/mended_findings.hpp>

namespace doctor_c630s_tests {
namespace {

namespace c630s = servobus::c630s;
using doctored::u16;
using servobus::sim::c630s_options;
using bench = doctored::bench<servobus::sim::c630s, c630s::drive>;
constexpr const auto& list = tool::diagnosis::c630s_checks;
constexpr const auto& map = c630s::catalogue;

template <u16 Address, u16 Word> bool put(bench& b) {
    const bool is = b.model.put(Address, {Word});
    b.pass(2);
    return is;
}
template <u16 Address, u16 Word> bool force(bench& b) {
    b.model.forced[Address] = Word;
    return true;
}
template <u16 Code, bool Lasts> bool raise(bench& b) {
    b.model.raise(Code, Lasts);
    return true;
}
template <unsigned Input> bool conduct(bench& b) {
    b.model.set_input(Input, true);
    b.pass(5);
    return true;
}
// Another program has switched the servo on, and lets it turn.
bool turn(bench& b) {
    b.pass(1);
    const bool is = b.model.put(0x0200, {0}) && b.model.put(0x0603, {60}) && b.model.put(0x3100, {1});
    b.pass(800);
    return is && b.model.enabled();
}

constexpr doctored::state<bench> states[] = {
    {"nothing", [](bench&) { return true; }},
    {"low voltage",
     [](bench& b) {
         b.model.set_bus_voltage(1900);
         b.pass(5);
         return true;
     },
     " recorded_alarm: the servo"},
    {"high voltage, over now",
     [](bench& b) {
         b.model.set_bus_voltage(4300);
         b.pass(5);
         b.model.set_bus_voltage(3100);
         b.pass(5);
         return true;
     },
     " recorded_alarm: the servo"},
    {"a fault that lasts", raise<0x620, true>, " recorded_alarm: the servo"},
    {"a fault whose cause has ended", raise<0xB00, false>, " recorded_alarm: the servo"},
    {"a fault that needs the power", raise<0x740, false>, " recorded_alarm: the servo"},
    {"an encoder battery", raise<0x731, false>, " recorded_alarm: the servo"},
    {"a warning", raise<0x909, false>, " recorded_alarm: the drive has a warning"},
    {"a positive limit", conduct<2>, " input_conduction: the positive"},
    {"a negative limit", conduct<3>, " input_conduction: the negative"},
    {"an emergency stop", conduct<6>, " input_conduction: the emergency"},
    {"an emergency stop by the bus", put<0x0D05, 1>, " emergency_stop"},
    {"terminals forced", put<0x0D11, 1>, " terminal_forcing"},
    {"the factory's servo-on", put<0x0302, 1>},
    {"another wired servo-on", put<0x0308, 1>, " di1_function: a wired"},
    {"a stop by a virtual input", [](bench& b) { return put<0x1716, 34>(b) && put<0x3100, 0x0800>(b); },
     " input_conduction: the emergency"},
    {"a limit whose logic is inverted", put<0x0307, 1>, " input_conduction: the negative"},
    {"a wired servo-on, active", [](bench& b) { return put<0x0302, 1>(b) && conduct<1>(b); },
     " di1_function: a wired"},
    {"servo-on from power-on on", put<0x0300, 1>, " power_on_functions_1_to_16"},
    {"the virtual one too", put<0x0C0A, 1>, " virtual_inputs_at_power_on"},
    {"no virtual inputs", put<0x0C09, 0>, " virtual_inputs_enable: the terminals"},
    {"another virtual input", put<0x1704, 12>, " virtual_inputs_enable: the terminals"},
    {"another virtual output", put<0x1721, 2>, " virtual_inputs_enable: the terminals"},
    {"a function twice", [](bench& b) { return put<0x0306, 14>(b); }, " virtual_inputs_enable: two inputs"},
    {"homing at power-on", put<0x051E, 3>, " virtual_inputs_enable: the terminals"},
    {"the mark of a set-up", put<0x0B21, 9>, " selected_fault_record"},
    {"an old record", put<0x0B21, 3>},
    {"high word first", put<0x0C1A, 0>},
    {"no word order", force<0x0C1A, 2>, " pair_word_order"},
    {"writes wear the EEPROM", put<0x0C0D, 1>, " eeprom_update"},
    {"a slow response", put<0x0C19, 55>, " response_delay"},
    {"no speed", put<0x0607, 0>, " max_speed"},
    {"no speed forward", put<0x0608, 0>, " max_forward_speed"},
    {"no speed in reverse", put<0x0609, 0>, " max_reverse_speed"},
    {"torque by an analogue input", put<0x0707, 2>, " torque_limit_source"},
    {"no torque forward", put<0x0709, 0>, " positive_internal_torque_limit"},
    {"no torque in reverse", put<0x070A, 0>, " negative_internal_torque_limit"},
    {"no position gain", put<0x0802, 0>, " position_loop_gain"},
    {"no second position gain, which is not in force", put<0x0805, 0>},
    {"no second position gain", [](bench& b) { return put<0x0805, 0>(b) && put<0x0809, 7>(b); },
     " second_position_loop_gain"},
    {"modes that inputs switch", put<0x0200, 6>},
    {"a gear beside P05-02",
     [](bench& b) {
         return b.model.put(0x0507, {1, 0});
     },
     " pulses_per_revolution"},
    {"enabled", put<0x3100, 1>, " virtual_input_levels"},
    {"turning", turn, " actual_speed"},
    {"not ready", [](bench& b) { return force<0x1720, 0>(b); }, " virtual_output_levels: S-RDY"},
    // The brake of an enabled drive is released as it should be.
    {"a brake that is released",
     [](bench& b) { return (b.model.peek(0x3100) & 1) == 0 && force<0x1720, 0x0101>(b); },
     " virtual_output_levels: the brake"},
};

// A drive that was set up and switched off and on.
std::unique_ptr<bench> make_of(const c630s_options& o) {
    auto b = std::make_unique<bench>(o);
    REQUIRE(b->drive.run(servobus::init{}));
    REQUIRE(b->drive.run(c630s::set_up{}));
    b->model.power_cycle();
    REQUIRE(b->drive.run(servobus::init{}));
    return b;
}
// The same, set up once.
auto maker_of(const c630s_options& o) {
    return [o, ready = servobus::sim::c630s{make_of(o)->model}] {
        auto b = std::make_unique<bench>(o);
        static_cast<servobus::sim::c630s&>(b->model) = ready;
        return b;
    };
}
std::unique_ptr<bench> make() {
    static const auto maker = maker_of(c630s_options{});
    return maker();
}

TEST_CASE("doctor refuses a C630S exactly where its facade does not enable it") {
    (void)doctored::play(states, list, map, make, 150);
}

TEST_CASE("doctor finds each state of a C630S") {
    std::set<std::string> said;
    doctored::expect_findings(states, list, map, make, said);
    doctored::expect_all(list, map, said);
}

// A drive that shows its brake on wired outputs only, or as always released, is never seen to be enabled: doctor says
// so, as long as no wired output has the function.
bool is_open(const doctored::held_registers&) { return true; }

TEST_CASE("doctor refuses a C630S exactly under each other interpretation of the manual too") {
    namespace sim = servobus::sim;
    using choice = c630s_options;
    constexpr void (*choices[])(choice&) = {
        [](choice& o) { o.stores_eeprom_off = false; },
        [](choice& o) { o.resets_while_enabled = true; },
        [](choice& o) { o.virtual_brake_delays = false; },
        [](choice& o) { o.restart_keeps = sim::c630s_restart::everything; },
        [](choice& o) { o.bus_stop = sim::c630s_bus_stop::resets; },
        [](choice& o) { o.bus_stop = sim::c630s_bus_stop::frees_shaft; },
        [](choice& o) { o.commands_end = false; },
        [](choice& o) { o.shows_last_alarm = true; },
        [](choice& o) { o.disabled_inputs_count = true; },
        [](choice& o) { o.delay_is_additional = true; },
    };
    (void)doctored::play_under(states, list, map, choices, maker_of, nullptr);
}

TEST_CASE("doctor says that an enable of a C630S is refused if its brake does not show") {
    namespace sim = servobus::sim;
    doctored::tally count;
    for (const auto shows : {sim::c630s_brake::wired_only, sim::c630s_brake::always_released}) {
        c630s_options options;
        options.brake = shows;
        doctored::compare(*make_of(options), list, map, count, is_open);
    }
    CHECK(count.refused == 2);
    CHECK(count.open == 1); // an always released brake refuses it for certain
}

TEST_CASE("the commands that doctor names mend its findings about a C630S") {
    std::set<std::string> mended;
    doctored::expect_mended(states, list, map, make, mended);
    doctored::expect_all_mended(list, mended);
}

TEST_CASE("doctor names the input of a C630S that is active, and its logic") {
    const auto b = make();
    REQUIRE(put<0x0307, 1>(*b));
    const auto held = doctored::read_of(b->model, list, map);
    for (const doctored::check* c : tool::diagnosis::find(list, held)) {
        if (doctored::first_of(*c, map) != "input_conduction") continue;
        const auto shown = c->shown_by(held, *c);
        CHECK(std::vector<u16>(shown.all().begin(), shown.all().end()) ==
              std::vector<u16>{c630s::di3_function.address, c630s::di3_logic.address,
                               c630s::input_conduction.address});
        CHECK(c->more(held, *c) == "DI3 does not conduct, which is active by its logic.");
        CHECK(c->by.compose(held, *c) == std::vector<doctored::new_value>{{c630s::di3_logic.address, 0}});
        return;
    }
    FAIL("the input is not found");
}

TEST_CASE("doctor has nothing else to say of a C630S that is set up") {
    const auto b = make();
    const auto names = [&] {
        std::string all;
        for (const doctored::check* c : tool::diagnosis::find(list, doctored::read_of(b->model, list, map)))
            all += doctored::first_of(*c, map) + ' ';
        return all;
    };
    CHECK(names() == "do6_function ");
    REQUIRE(put<0x040A, 9>(*b));
    CHECK(names() == "");
}

TEST_CASE("doctor refuses a C630S from the factory, and says what its set-up lacks") {
    bench b{c630s_options{}};
    const auto held = doctored::read_of(b.model, list, map);
    const auto found = tool::diagnosis::find(list, held);
    REQUIRE(!found.empty());
    CHECK(found[0]->is == tool::diagnosis::refuses);
    // Each register once.
    const auto differing = found[0]->differing(held, *found[0]);
    CHECK(differing.size() == 30);
    std::set<u16> addresses;
    for (const doctored::new_value& one : differing) {
        addresses.insert(one.address);
        CHECK(held.word(one.address) != one.bits);
    }
    CHECK(addresses.size() == differing.size());
    // The other factory settings are harmless, but the EEPROM wears.
    REQUIRE(found.size() == 2);
    CHECK(doctored::first_of(*found[1], map) == "eeprom_update");
    doctored::tally count;
    doctored::compare(b, list, map, count);
    CHECK(count.refused == 1);
}

TEST_CASE("the limits of the checks of a C630S") {
    const auto held = doctored::read_of(make()->model, list, map);
    const std::size_t usual = tool::diagnosis::find(list, held).size();
    struct limit {
        u16 address;
        u16 last_good;
        u16 first_bad;
    };
    constexpr limit limits[] = {{0x0C19, 50, 51}, {0x0B00, 2, 3}, {0x0B00, 0xFFFE, 0xFFFD}, {0x0C1A, 1, 2}};
    for (const limit& l : limits) {
        CAPTURE(l.address);
        auto changed = held;
        changed.put(l.address, l.last_good);
        CHECK(tool::diagnosis::find(list, changed).size() == usual);
        changed.put(l.address, l.first_bad);
        CHECK(tool::diagnosis::find(list, changed).size() == usual + 1);
    }
}

TEST_CASE("doctor says nothing of an emergency stop while the motor of a C630S turns") {
    const auto b = make_of({});
    const auto says = [&](const char* what) {
        const auto held = doctored::read_of(b->model, list, map);
        for (const doctored::check* c : tool::diagnosis::find(list, held)) {
            const std::string more = c->more != nullptr ? c->more(held, *c) : "";
            if ((std::string{c->why} + more).find(what) != std::string::npos) return true;
        }
        return false;
    };
    constexpr const char* warning = "Er.900, emergency stop by input";
    constexpr const char* input = "the emergency stop is active";
    REQUIRE(turn(*b));
    REQUIRE(put<0x0D05, 1>(*b));
    b->pass(500);
    CHECK(says(warning)); // at rest
    REQUIRE(put<0x0D05, 0>(*b));
    b->pass(800);
    REQUIRE(b->model.peek(0x0B00) != 0);
    REQUIRE(b->model.peek(0x0B22) == 0x900); // until a reset
    CHECK_FALSE(says(warning));
    CHECK(says("the motor turns"));
    REQUIRE(conduct<6>(*b));
    b->pass(500);
    CHECK(says(warning));
    CHECK(says(input));
    b->model.forced[0x0B00] = 60; // terminals that are forced, or a function that waits for power-on
    CHECK_FALSE(says(warning));
    CHECK_FALSE(says(input));
}

} // namespace
} // namespace doctor_c630s_tests
