// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The terminals of each drive get their functions: what contradicts itself is refused before a frame, what another
// terminal does is found by reading, freed, and assigned anew. Judged by the frames and by what the simulated drive
// holds.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/c630s/wiring.hpp>
#include <servobus/device/yako/wiring.hpp>
#include <servobus/device/zlac8015d/wiring.hpp>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_c630s.hpp>
#include <tests/support/enabled_yako.hpp>

namespace wiring_tests {

using namespace servobus;

namespace {

namespace c6 = servobus::c630s;
namespace ya = servobus::yako;
namespace zl = servobus::zlac8015d;
using servo = simulated::driven_c630s;
using in = c6::input_function;

constexpr u16 di(unsigned n) { return static_cast<u16>(c6::di1_function.address + 2 * (n - 1)); }
constexpr u16 dout(unsigned n) { return static_cast<u16>(c6::do1_function.address + 2 * (n - 1)); }

// The writes of a frame list from `first` on: address and word.
struct written {
    u16 address;
    u16 word;
    friend bool operator==(const written&, const written&) = default;
};
template <class Frames> std::vector<written> writes_in(const Frames& frames, std::size_t first) {
    std::vector<written> all;
    for (std::size_t i = first; i < frames.size(); ++i) {
        if (frames[i][1] == 0x06) all.push_back({load_word(frames[i], 2), load_word(frames[i], 4)});
    }
    return all;
}

} // namespace

TEST_CASE("C630S: a function of a hidden input is freed, then assigned, in one session of P0C-13") {
    servo r;
    REQUIRE(r.make_ready());
    REQUIRE(r.model.peek(di(7)) == 31); // the home switch, from the factory
    const std::size_t first = r.requests.size();
    const auto before = r.model.eeprom_writes();
    REQUIRE(r.drive.run(c6::wire_inputs{.di1 = in::home_switch, .di3 = in::none}));
    const std::vector<written> expected{
        {c6::eeprom_update.address, 1}, {di(3), 0}, {di(7), 0}, {di(1), 31}, {c6::eeprom_update.address, 0}};
    CHECK(writes_in(r.requests, first) == expected);
    CHECK(r.model.stored(di(1)) == 31);
    CHECK(r.model.stored(di(7)) == 0);
    CHECK(r.model.stored(di(3)) == 0);
    CHECK(r.model.peek(c6::eeprom_update.address) == 0);
    CHECK(r.model.eeprom_writes() - before <= 4);
    CHECK(r.drive.state() == drive_state::disabled);
    // Once more: nothing is left to write.
    const std::size_t again = r.requests.size();
    REQUIRE(r.drive.run(c6::wire_inputs{.di1 = in::home_switch, .di3 = in::none}));
    CHECK(writes_in(r.requests, again).empty());
    CHECK(r.requests.size() > again); // it has looked
    r.model.power_cycle();
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{}));
    CHECK_FALSE(r.model.has_fault());
}

TEST_CASE("C630S: two inputs change places") {
    servo r;
    REQUIRE(r.make_ready());
    const auto of = [&](unsigned n) { return static_cast<in>(r.model.peek(di(n))); };
    const in second = of(2), third = of(3);
    REQUIRE(second != in::none);
    REQUIRE(third != in::none);
    const std::size_t first = r.requests.size();
    REQUIRE(r.drive.run(c6::wire_inputs{.di2 = third, .di3 = second}));
    CHECK(of(2) == third);
    CHECK(of(3) == second);
    // At no time do two inputs have one function.
    std::vector<written> held{{di(2), static_cast<u16>(second)}, {di(3), static_cast<u16>(third)}};
    for (const written& w : writes_in(r.requests, first)) {
        for (written& h : held) {
            if (h.address == w.address) h.word = w.word;
        }
        CHECK((held[0].word != held[1].word || held[0].word == 0));
    }
}

TEST_CASE(
    "C630S: what contradicts itself is refused before a frame, a virtual input's function before a write") {
    servo r;
    REQUIRE(r.make_ready());
    const std::size_t frames = r.requests.size();
    const auto refused = [&](const c6::wire_inputs& wanted, errc why, u16 at) {
        const command_status got = r.drive.run(wanted);
        CHECK(got.error() == why);
        CHECK(got.register_address() == at);
        CHECK(got.outcome() == outcome::not_sent);
        CHECK(r.requests.size() == frames);
    };
    refused({.di2 = in::home_switch, .di5 = in::home_switch}, errc::bad_argument, di(5));
    refused({.di2 = static_cast<in>(39)}, errc::out_of_range, di(2));
    refused({.di8 = in::servo_on}, errc::out_of_range, di(8));
    // Jog forward is virtual input 10.
    const command_status got = r.drive.run(c6::wire_inputs{.di4 = in::jog_forward});
    CHECK(got.error() == errc::already_assigned);
    CHECK(got.register_address() == c6::virtual_input_functions[9].address);
    CHECK(writes_in(r.requests, frames).empty());
    CHECK(r.drive.state() == drive_state::disabled);

    REQUIRE(r.drive.run(enable{}));
    CHECK(r.drive.run(c6::wire_inputs{.di1 = in::home_switch}).error() == errc::wrong_state);
    servo fresh;
    CHECK(fresh.drive.run(c6::wire_inputs{.di1 = in::home_switch}).error() == errc::needs_init);
    CHECK(fresh.requests.empty());
}

TEST_CASE("C630S: outputs likewise, among themselves") {
    servo r;
    REQUIRE(r.make_ready());
    const auto fifth = static_cast<c6::output_function>(r.model.peek(dout(5)));
    REQUIRE(fifth != c6::output_function::none);
    REQUIRE(r.drive.run(c6::wire_outputs{.do1 = fifth}));
    CHECK(r.model.stored(dout(1)) == static_cast<u16>(fifth));
    CHECK(r.model.stored(dout(5)) == 0);
    const std::size_t frames = r.requests.size();
    CHECK(r.drive.run(c6::wire_outputs{.do2 = fifth, .do6 = fifth}).register_address() == dout(6));
    CHECK(r.drive.run(c6::wire_outputs{.do6 = static_cast<c6::output_function>(21)}).error() ==
          errc::out_of_range);
    CHECK(r.requests.size() == frames);
}

TEST_CASE(
    "C630S: after several requests that are refused in a row, no write wears the EEPROM, or the drive needs "
    "init") {
    unsigned kept = 0, struck = 0;
    for (const std::size_t count : {std::size_t{2}, std::size_t{3}}) {
        for (std::size_t n = 1; n < 60; ++n) {
            CAPTURE(count);
            CAPTURE(n);
            servo r;
            REQUIRE(r.make_ready());
            const std::size_t first = r.requests.size();
            const auto step_until_idle = [&](const auto& part) {
                if (const command_status begun = r.drive.begin(part); !begun) return begun;
                while (!r.drive.is_idle()) {
                    const std::size_t at = r.requests.size() - first;
                    r.model.refuses = at >= n && at < n + count;
                    r.turn();
                }
                return r.drive.last();
            };
            (void)c6::wire_inputs{.di1 = in::home_switch}.run_by(r.drive, step_until_idle);
            r.model.refuses = false;
            if (r.model.refused == 0) break;
            ++struck;
            if (r.drive.state() != drive_state::disabled) continue;
            ++kept;
            CHECK(r.model.peek(c6::eeprom_update.address) == 0);
        }
    }
    CHECK(struck >= 30);
    CHECK(kept >= 5);
}

TEST_CASE(
    "C630S: after each request that is refused or lost, no write wears the EEPROM, or the drive needs init") {
    unsigned refusals = 0, losses = 0;
    for (const bool is_lost : {false, true}) {
        for (std::size_t n = 1; n < 60; ++n) {
            CAPTURE(is_lost);
            CAPTURE(n);
            servo r;
            REQUIRE(r.make_ready());
            const std::size_t first = r.requests.size();
            const std::uint32_t struck = r.wire.struck();
            const auto has_struck = [&] { return r.model.refused != 0 || r.wire.struck() != struck; };
            const auto step_until_idle = [&](const auto& part) {
                if (const command_status begun = r.drive.begin(part); !begun) return begun;
                while (!r.drive.is_idle()) {
                    const bool is_now = r.requests.size() == first + n && !has_struck();
                    r.model.refuses = is_now && !is_lost;
                    r.wire.faults().lost_response = is_now && is_lost ? 1000 : 0;
                    r.turn();
                }
                return r.drive.last();
            };
            const command_status got =
                c6::wire_inputs{.di1 = in::home_switch}.run_by(r.drive, step_until_idle);
            r.model.refuses = false;
            r.wire.faults() = {};
            if (!has_struck()) {
                CHECK(got);
                break;
            }
            (is_lost ? losses : refusals) += 1;
            const bool is_known = r.drive.state() == drive_state::disabled;
            if (is_known) CHECK(r.model.peek(c6::eeprom_update.address) == 0);
            if (got) {
                CHECK(r.model.stored(di(1)) == 31);
                CHECK(r.model.stored(di(7)) == 0);
            }
            // Twice the same function: never, whatever became of it.
            unsigned homes = 0;
            for (unsigned k = 1; k <= 8; ++k) homes += r.model.peek(di(k)) == 31 ? 1u : 0u;
            CHECK(homes <= 1);
            REQUIRE(r.drive.run(init{}));
            CHECK(r.model.peek(c6::eeprom_update.address) == 0);
            REQUIRE(r.drive.run(c6::wire_inputs{.di1 = in::home_switch}));
            CHECK(r.model.stored(di(1)) == 31);
        }
    }
    CHECK(refusals >= 15);
    CHECK(losses >= 15);
}

TEST_CASE("YAKO: the input that has a function gives it away; save keeps it") {
    using ya::input_function;
    simulated::open_axis a;
    enabled_yako::take(a);
    CHECK(a.drive.run(ya::wire_inputs{.x4 = input_function::home}).error() == errc::wrong_state);
    REQUIRE(a.drive.run(disable{}));
    const std::size_t first = a.requests.size();
    REQUIRE(a.drive.run(ya::wire_inputs{.x1 = input_function::negative_limit,
                                        .x2 = input_function::positive_limit,
                                        .x4 = input_function::home}));
    const std::vector<written> expected{{0x0041, 0}, {0x0042, 0}, {0x0043, 0},
                                        {0x0042, 3}, {0x0043, 2}, {0x0045, 1}};
    CHECK(writes_in(a.requests, first) == expected);
    CHECK(a.model.peek(0x0041) == 0);
    CHECK(a.model.peek(0x0045) == 1);
    const std::size_t again = a.requests.size();
    REQUIRE(a.drive.run(ya::wire_inputs{.x4 = input_function::home}));
    CHECK(writes_in(a.requests, again).empty());
    const std::size_t frames = a.requests.size();
    const command_status twice =
        a.drive.run(ya::wire_inputs{.x0 = input_function::stop, .x6 = input_function::stop});
    CHECK(twice.error() == errc::bad_argument);
    CHECK(twice.register_address() == 0x0047);
    CHECK(a.drive.run(ya::wire_inputs{.x5 = static_cast<input_function>(19)}).register_address() == 0x0046);
    CHECK(a.requests.size() == frames);
    REQUIRE(
        a.drive.run(ya::wire_outputs{.y0 = ya::output_function::brake, .y2 = ya::output_function::brake}));
    CHECK(a.model.peek(0x004C) == 5);
    CHECK(a.model.peek(0x004D) == 0);
    CHECK(a.model.peek(0x004E) == 5);
    CHECK(a.drive.run(ya::wire_outputs{.y1 = static_cast<ya::output_function>(7)}).register_address() ==
          0x004D);

    // The drive refuses the second write.
    const ya::wire_inputs wanted{.x0 = input_function::stop, .x1 = input_function::motor_free};
    std::size_t parts = 0;
    const command_status cut = wanted.run_by(a.drive, [&](const auto& part) {
        a.model.refuses = ++parts == 3; // after the look and the first input
        return a.drive.run(part);
    });
    a.model.refuses = false;
    CHECK(cut.outcome() == outcome::refused);
    CHECK(cut.exception() == 4);
    CHECK(cut.register_address() == 0x0042);
    CHECK(a.model.peek(0x0041) == 5);

    simulated::closed_axis c;
    REQUIRE(c.drive.run(init{}));
    REQUIRE(c.drive.run(disable{}));
    // The drive has no X4, so nothing is sent, for the inputs before it either.
    const std::size_t nothing = c.requests.size();
    for (const ya::wire_inputs& beyond :
         {ya::wire_inputs{.x4 = input_function::home},
          ya::wire_inputs{.x0 = input_function::stop, .x4 = input_function::home}}) {
        const command_status none = c.drive.run(beyond);
        CHECK(none.error() == errc::bad_argument);
        CHECK(none.register_address() == 0x0045);
    }
    CHECK(c.requests.size() == nothing);
    REQUIRE(c.drive.run(ya::wire_inputs{.x3 = input_function::home}));
    CHECK(c.model.peek(0x0041) == 0);
    CHECK(c.model.peek(0x0044) == 1);
    CHECK(c.drive.run(ya::wire_outputs{.y2 = ya::output_function::alarm}).error() == errc::bad_argument);
}

TEST_CASE("ZLAC8015D: inputs and outputs are set while disabled, those that are not named stay") {
    simulated::driven_zlac8015d r;
    CHECK(r.drive.run(zl::wire_inputs{.x0 = zl::input_function::undefined}).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(zl::wire_inputs{.x1 = zl::input_function::emergency_stop}));
    CHECK(r.model.peek(0x2017) == 9);
    CHECK(r.model.peek(0x2018) == 9);
    REQUIRE(r.drive.run(zl::wire_inputs{.x0 = zl::input_function::undefined}));
    CHECK(r.model.peek(0x2017) == 0);
    CHECK(r.model.peek(0x2018) == 9);
    REQUIRE(r.drive.run(
        zl::wire_outputs{.y0 = zl::output_function::alarm, .y1 = zl::output_function::in_position}));
    CHECK(r.model.peek(0x201C) == 1);
    CHECK(r.model.peek(0x201D) == 3);
    const command_status wrong = r.drive.run(zl::wire_outputs{.y1 = static_cast<zl::output_function>(4)});
    CHECK(wrong.error() == errc::out_of_range);
    CHECK(wrong.register_address() == 0x201D);
    const std::size_t frames = r.log.frames.size();
    const auto none = static_cast<zl::input_function>(10);
    CHECK(r.drive.run(zl::wire_inputs{.x0 = none, .x1 = zl::input_function::undefined}).register_address() ==
          0x2017);
    CHECK(r.drive.run(zl::wire_outputs{.y0 = static_cast<zl::output_function>(4)}).register_address() ==
          0x201C);
    CHECK(r.log.frames.size() == frames);
}

} // namespace wiring_tests
