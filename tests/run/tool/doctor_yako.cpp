// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The checks of `servobus doctor` on YAKOTEC steppers, against the simulated drives and their facades.
#include <memory>

#include <doctest/doctest.h>

#include <servobus/device/yako.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/sim/yako.hpp>

#include <examples/servobus/doctor/yako.hpp>
#include <tests/support/driven_doctored.hpp>
#include <tests/support/mended_findings.hpp>

namespace doctor_yako_tests {
namespace {

namespace yako = servobus::yako;
using doctored::u16;
using servobus::sim::yako_options;
using yako::input_function;

template <class Bench, u16 Address, u16 Word> bool put(Bench& b) { return b.model.put(Address, {Word}); }
template <class Bench, u16 Address, u16 Word> bool force(Bench& b) {
    b.model.forced[Address] = Word;
    return true;
}
// The input has the function and is active.
template <class Bench, unsigned Input, input_function Does> bool wire(Bench& b) {
    const bool is = b.model.put(static_cast<u16>(0x0041 + Input), {static_cast<u16>(Does)});
    b.model.set_input(Input, true);
    b.pass(20);
    return is;
}
template <class Bench> bool reverse_limits(Bench& b) {
    return b.model.put(0x0018, {1}) && b.model.put(0x0037, {0, 0}) && b.model.put(0x0039, {0, 100});
}
// Each input has a function of its own until a state gives it another one.
template <class Bench> bool jog(Bench& b) {
    b.pass(1);
    const bool is = b.model.put(0x001D, {60}) && b.model.put(0x0027, {2});
    b.pass(300);
    return is;
}
template <class Bench> bool home(Bench& b) {
    b.pass(1);
    const bool is = b.model.put(0x0031, {35}) && b.model.put(0x0027, {0x10});
    b.pass(100);
    return is;
}

// Homed, and the limits are around another place.
template <class Bench, int From, int To> bool be_beyond(Bench& b) {
    const auto words = [](int n) { return static_cast<u16>(n < 0 ? 0xFFFF : 0); };
    return home(b) && b.model.put(0x0018, {1}) &&
           b.model.put(0x0037, {words(To), static_cast<u16>(To & 0xFFFF)}) &&
           b.model.put(0x0039, {words(From), static_cast<u16>(From & 0xFFFF)});
}
// The states that one variant has alone.
template <class B> bool is_open_loop(B& b) { return b.model.peek(0) == 2505; }
template <class B> bool is_closed_loop(B& b) { return !is_open_loop(b); }

template <class B> struct of {
    static constexpr doctored::state<B> states[] = {
        {"nothing", [](B&) { return true; }},
        {"low word first", put<B, 0x0019, 1>, " pair_word_order: 32-bit"},
        {"no word order", force<B, 0x0019, 2>, " pair_word_order: it is neither"},
        {"no limits or limits", force<B, 0x0018, 2>, " software_limits: it is neither"},
        {"limits without home", put<B, 0x0018, 1>, " software_limits: the drive is not homed"},
        {"limits at one place", put<B, 0x0018, 1>, " software_limits: both limits"},
        {"limits without a way", reverse_limits<B>, " software_limits: the positive"},
        {"an emergency stop at a limit", put<B, 0x0017, 1>},
        {"no current", put<B, 0x0105, 0>, " open_loop_max_current"},
        {"no base current", put<B, 0x0104, 0>, " base_current"},
        {"no holding current", put<B, 0x0106, 0>, " holding_current"},
        {"another rate from power-on on", put<B, 0x0014, 3>, " rs485_baud_rate"},
        {"another format from power-on on", put<B, 0x0015, 1>, " rs485_format"},
        {"homed", home<B>},
        {"beyond the positive limit", be_beyond<B, -500, -100>,
         " status_word: the position is beyond the positive"},
        {"beyond the negative limit", be_beyond<B, 100, 500>,
         " status_word: the position is beyond the negative"},
        {"released", [](B& b) { return b.model.put(0x002D, {0x0011}); }},
        {"blocked",
         [](B& b) {
             b.model.block_shaft(true);
             return true;
         }},
        {"X0 active",
         [](B& b) {
             b.model.set_input(0, true);
             b.pass(20);
             return true;
         }},
        {"X1 active, a limit", wire<B, 1, input_function::positive_limit>, " x1_function: the limit"},
        {"X2 active, a limit", wire<B, 2, input_function::negative_limit>, " x2_function: the limit"},
        {"X3 stops", wire<B, 3, input_function::stop>,
         " x3_function: the input is active: the drive ignores"},
        {"X2 stops", wire<B, 2, input_function::emergency_stop>,
         " x2_function: the input is active: the drive ignores"},
        {"X3 jogs", wire<B, 3, input_function::jog_positive>,
         " x3_function: the input is active: the motor runs"},
        {"X2 runs", wire<B, 2, input_function::speed_move>,
         " x2_function: the input is active: the motor runs"},
        {"X1 runs a segment", wire<B, 1, input_function::pv_trigger>,
         " x1_function: the input is active: the motor runs"},
        {"X3 frees the motor", wire<B, 3, input_function::motor_free>,
         " x3_function: the input is active and releases"},
        {"X0 frees the motor", wire<B, 0, input_function::motor_free>,
         " x0_function: the input is active and releases"},
        {"X1 frees the motor", wire<B, 1, input_function::motor_free>,
         " x1_function: the input is active and releases"},
        {"X2 frees the motor", wire<B, 2, input_function::motor_free>,
         " x2_function: the input is active and releases"},
        {"no resolution", force<B, 0x001A, 2>, " speed_resolution: it is neither", is_closed_loop<B>},
        {"X4 frees the motor", wire<B, 4, input_function::motor_free>,
         " x4_function: the input is active and releases", is_open_loop<B>},
        {"X5 frees the motor", wire<B, 5, input_function::motor_free>,
         " x5_function: the input is active and releases", is_open_loop<B>},
        {"X6 frees the motor", wire<B, 6, input_function::motor_free>,
         " x6_function: the input is active and releases", is_open_loop<B>},
        {"X1 has the function, inactive", put<B, 0x0042, 4>},
        {"two inputs have one function", put<B, 0x0044, 2>, " x3_function: an input before"},
        {"X0 to X2 inverted", put<B, 0x0040, 7>, " x1_function: the limit"},
        {"an alarm",
         [](B& b) {
             b.model.raise_alarm(3);
             return true;
         },
         " status_word: the motor is not enabled"},
        {"an alarm whose cause has ended",
         [](B& b) {
             b.model.raise_alarm(2);
             b.model.end_alarm();
             return true;
         },
         " status_word: the motor is not enabled"},
        {"an alarm that was cleared",
         [](B& b) {
             b.model.raise_alarm(2);
             b.model.end_alarm();
             return b.model.put(0x002D, {0x0021});
         }},
    };
};

using closed_bench = doctored::bench<servobus::sim::yako_closed_loop, yako::closed_loop::drive>;
using open_bench = doctored::bench<servobus::sim::yako_open_loop, yako::open_loop::drive>;
constexpr const auto& closed_list = tool::diagnosis::yako_closed_loop_checks;
constexpr const auto& open_list = tool::diagnosis::yako_open_loop_checks;
constexpr const auto& closed_map = yako::closed_loop::catalogue;
constexpr const auto& open_map = yako::open_loop::catalogue;

template <class Bench> std::unique_ptr<Bench> make() { return std::make_unique<Bench>(yako_options{}); }

// An active input runs the motor. The registers do not tell whether its motion is the one that is under way, and ends
// for good once it is stopped, or is still to come: then it begins while the drive is taken over. Nor do they tell,
// while the motor is released, whether it comes once it is enabled, and runs into a limit that releases the motor.
bool is_open(const doctored::held_registers& r) {
    const u16 status = r.word(yako::status_word);
    if ((status & (yako::motion_status::moving_bit | yako::motion_status::released_bit)) == 0) return false;
    for (unsigned input = 0; input < 7; ++input) {
        const bool is_active = (static_cast<unsigned>(r.word(u16{0x0008})) >> input & 1u) != 0;
        const auto does = static_cast<input_function>(r.word(static_cast<u16>(0x0041 + input)));
        const bool runs = does == input_function::jog_positive || does == input_function::jog_negative ||
                          does == input_function::speed_move || does == input_function::pv_trigger;
        if (is_active && runs) return true;
    }
    return false;
}

TEST_CASE("doctor refuses a YAKO stepper exactly where its facade does not enable it") {
    (void)doctored::play(of<closed_bench>::states, closed_list, closed_map, make<closed_bench>, 150, is_open);
    (void)doctored::play(of<open_bench>::states, open_list, open_map, make<open_bench>, 150, is_open);
}

TEST_CASE("doctor refuses a YAKO stepper exactly under each other interpretation of the manual too") {
    namespace sim = servobus::sim;
    using choice = yako_options;
    constexpr void (*choices[])(choice&) = {
        [](choice& o) { o.is_enabled_at_power_on = false; },
        [](choice& o) { o.kept = sim::yako_kept::marked; },
        [](choice& o) { o.in_position = sim::yako_in_position::at_target; },
        [](choice& o) { o.homed = sim::yako_homed::until_place_lost; },
        [](choice& o) { o.homed = sim::yako_homed::always; },
        [](choice& o) { o.alarm = sim::yako_alarm::clearing_enables; },
        [](choice& o) { o.alarm = sim::yako_alarm::holds; },
        [](choice& o) { o.refuses_unfit = true; },
        [](choice& o) { o.commands_read_back = true; },
        [](choice& o) { o.stops_homing = false; },
    };
    const auto make_of = [](const choice& o) { return [o] { return std::make_unique<closed_bench>(o); }; };
    (void)doctored::play_under(of<closed_bench>::states, closed_list, closed_map, choices, make_of, is_open);
}

// Collects the sentences of the rules of inputs, at each input.
template <class Bench>
void say_inputs(const tool::diagnosis::check_list& list, const servobus::catalogue& map, unsigned inputs,
                std::set<std::string>& said) {
    for (unsigned input = 0; input < inputs; ++input) {
        const std::string name = " x" + std::to_string(input) + "_function";
        for (const auto& rule : tool::diagnosis::yako_rules::input_rules) {
            CAPTURE(name);
            CAPTURE(std::string{rule.why});
            const auto enter = [&](Bench& b, bool is_active) {
                const bool is = b.model.put(static_cast<u16>(0x0041 + input), {static_cast<u16>(rule.does)});
                b.model.set_input(input, is_active);
                b.pass(20);
                return is;
            };
            const auto says = [&](bool is_active) {
                const auto b = make<Bench>();
                REQUIRE(enter(*b, is_active));
                for (const doctored::check* c :
                     tool::diagnosis::find(list, doctored::read_of(b->model, list, map))) {
                    const std::string sentence = doctored::first_of(*c, map) + ": " + c->why;
                    if (c->why == rule.why && ' ' + doctored::first_of(*c, map) == name)
                        return said.insert(sentence), true;
                }
                return false;
            };
            CHECK(says(true));
            CHECK(!says(false));
        }
        if (input == 0) continue;
        const auto b = make<Bench>();
        REQUIRE(b->model.put(0x0041, {11}));
        REQUIRE(b->model.put(static_cast<u16>(0x0041 + input), {11}));
        for (const doctored::check* c : tool::diagnosis::find(list, doctored::read_of(b->model, list, map)))
            said.insert(doctored::first_of(*c, map) + ": " + c->why);
    }
}

constexpr doctored::state<closed_bench> of_closed[] = {
    {"0.1 r/min", put<closed_bench, 0x001A, 1>, " speed_resolution: speeds count"},
    {"no current in closed loop", put<closed_bench, 0x0103, 0>, " closed_loop_max_current"},
};

TEST_CASE("doctor finds each state of a YAKO stepper, and has no row without one") {
    std::set<std::string> said;
    doctored::expect_findings(of_closed, closed_list, closed_map, make<closed_bench>, said);
    doctored::expect_findings(of<closed_bench>::states, closed_list, closed_map, make<closed_bench>, said);
    say_inputs<closed_bench>(closed_list, closed_map, 4, said);
    doctored::expect_all(closed_list, closed_map, said);
    said.clear();
    doctored::expect_findings(of<open_bench>::states, open_list, open_map, make<open_bench>, said);
    say_inputs<open_bench>(open_list, open_map, 7, said);
    doctored::expect_all(open_list, open_map, said);
}

TEST_CASE("the commands that doctor names mend its findings about a YAKO stepper") {
    std::set<std::string> mended;
    doctored::expect_mended(of_closed, closed_list, closed_map, make<closed_bench>, mended);
    doctored::expect_mended(of<closed_bench>::states, closed_list, closed_map, make<closed_bench>, mended);
    doctored::expect_all_mended(closed_list, mended);
    mended.clear();
    doctored::expect_mended(of<open_bench>::states, open_list, open_map, make<open_bench>, mended);
    doctored::expect_all_mended(open_list, mended);
}

// The simulator's current is 0, since the manual states none from the factory.
TEST_CASE("doctor says of a YAKO stepper from the factory what would surprise its owner") {
    const auto whys = [](auto b, const auto& list, const auto& map) {
        std::string all;
        for (const doctored::check* c : tool::diagnosis::find(list, doctored::read_of(b->model, list, map)))
            all += doctored::first_of(*c, map) + ": " + c->why + '\n';
        return all;
    };
    const std::string expected =
        "over_travel_stop_mode: at a limit the motor is released and coasts, and a load that hangs falls; so "
        "from the factory\n"
        "max_current: the motor gets no current and does not turn; the manual states no value from the "
        "factory\n";
    CHECK(whys(make<closed_bench>(), closed_list, closed_map) == expected);
    CHECK(whys(make<open_bench>(), open_list, open_map) == expected);
}

TEST_CASE("doctor warns of a YAKO stepper whose input may start it while it is taken over") {
    const auto b = make<closed_bench>();
    REQUIRE(jog(*b));
    REQUIRE(wire<closed_bench, 3, input_function::jog_positive>(*b));
    doctored::tally count;
    doctored::compare(*b, closed_list, closed_map, count, is_open);
    CHECK(count.open == 1);
    CHECK(count.refused == 1);
}

} // namespace
} // namespace doctor_yako_tests
