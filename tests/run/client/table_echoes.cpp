// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Calls for rows of all tables at their limits: responses that an echo could be on a line without one, word orders that
// become void before or during a call, and masks on a device that sends byte counts.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/any_device.hpp>
#include <servobus/bus/bus.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/bus/scheduled_line.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/line/blocking_line.hpp>

#include <tests/support/line_and_client.hpp>

#include <tests/support/tank.hpp>

namespace table_echoes_tests {

using namespace servobus;
using namespace servobus::units;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct device {
    static constexpr profile facts{
        .name = "learner", .word_order = word_order::unknown, .word_order_register = 0x0019};
};
inline constexpr discrete_input<device> input{0x0000};
inline constexpr input_reg<u32, device> energy{0x0000, full<u32>, no_unit, no_default};
inline constexpr reg<u16, access::rw, device> order{0x0019, {0, 1}, no_unit, 0};
inline constexpr reg<u16, access::rw, device> light{0x0300, full<u16>, no_unit, 0};
inline constexpr reg<u32, access::rw, device> place{0x0301, full<u32>, no_unit, 0};
// Five registers from 0A00h on: a response of function 17h as long as its request for one value, with the byte count at
// the place of the address's high byte.
inline constexpr reg_array<reg<u16, access::rw, device>, 5> five{{0x0A00, full<u16>, no_unit, 0}, 1};
using five_rows = rows<at<five, 0>, at<five, 1>, at<five, 2>, at<five, 3>, at<five, 4>>;
// 24 coils from 0300h on: a response as long as its request, likewise.
template <std::size_t N> inline constexpr coil<access::rw, device> bit{static_cast<u16>(0x0300u + N)};
using bits = std::make_index_sequence<24>;

struct any_line {
    using line = servobus::scheduled_line<tests::waiting_scripted_port>;
    static line on(tests::waiting_scripted_port& port) { return line{port, timing}; }
};
struct small_line {
    using line = blocking_line<tests::waiting_scripted_port, timing>;
    static line on(tests::waiting_scripted_port& port) { return line{port}; }
};

template <class Kind> struct setup {
    tests::waiting_scripted_port port;
    tests::plain_tables tables{};
    typename Kind::line on = Kind::on(port);
    client<typename Kind::line, device> drive{on, node<device>{1}};

    setup() {
        for (unsigned at = 0x300; at < 0x318; ++at) tables.coils[at] = at % 3 == 0;
        tables.discrete_inputs[0] = true;
        for (const unsigned at : {0u, 1u}) tables.input_registers[at] = at + 1;
        for (const unsigned at : {0x19u, 0x300u, 0x301u, 0x302u}) tables.holding_registers[at] = 0;
        for (unsigned at = 0xA00; at < 0xA05; ++at) tables.holding_registers[at] = at;
        answers();
    }
    setup(const setup&) = delete;
    void answers() {
        port.device = [this](scripted_port& p, const sent_frame& f) { tables(p, f, 1); };
    }
    /// The device's own response equals the request.
    void repeats() {
        port.device = [](scripted_port& p, const sent_frame& f) { p.say(500, f.data); };
    }
    std::uint32_t step_us = 200; ///< between two calls of `step`
    template <class Call> void finish(Call& call) {
        for (int i = 0; i < 20'000 && !call.done(); ++i) {
            (void)call.step();
            port.time += step_us;
        }
        REQUIRE(call.done());
    }
};
using line_setup = setup<any_line>;
using test_client = decltype(line_setup::drive);

template <std::size_t... N> auto stepped_bits(line_setup& s, std::index_sequence<N...>) {
    stepped_read<test_client, bit<N>...> call{s.drive};
    CHECK(call.begin() == errc::ok);
    s.finish(call);
    CHECK(call.step() == duration{}); // nothing is left to do
    return call.value();
}
template <std::size_t... N> consteval auto cyclic_bits(std::index_sequence<N...>) {
    return cyclic<bit<N>...>(node<device>{1}, milliseconds(50));
}
constexpr auto bits_entry = cyclic_bits(bits{});
constexpr poll_plan bits_plan{timing, bits_entry};
} // namespace

#define TABLE_ECHOES_ON_EACH_LINE any_line, small_line

TEST_CASE("G3: bits that repeat their request are values where an echo is ruled out") {
    line_setup r;
    const auto seen = stepped_bits(r, bits{});
    REQUIRE(seen);
    CHECK((seen->get<bit<0>>() && seen->get<bit<21>>() && !seen->get<bit<1>>() && !seen->get<bit<23>>()));
    CHECK(r.on.is_echo_ruled_out());
    r.repeats(); // 03 00 00 18 after the function: byte count 3, and of the data 00 00 18
    const auto repeated = stepped_bits(r, bits{});
    REQUIRE(repeated);
    CHECK((!repeated->get<bit<0>>() && repeated->get<bit<19>>() && repeated->get<bit<20>>()));

    bus<bits_plan, any_line::line> all{r.on};
    all.run_for(milliseconds(200));
    const auto latest = all.latest<bit<18>, bit<19>, bit<20>>(milliseconds(100));
    REQUIRE(latest);
    CHECK((!latest->get<bit<18>>() && latest->get<bit<19>>() && latest->get<bit<20>>()));
}

TEST_CASE("a response as long as its request that is found in one piece is no echo where it differs") {
    line_setup r;
    r.step_us = 20'000;
    const auto seen = stepped_bits(r, bits{});
    REQUIRE(seen);
    CHECK((seen->get<bit<0>>() && seen->get<bit<21>>() && !seen->get<bit<1>>() && !seen->get<bit<23>>()));
    CHECK(r.on.is_echo_ruled_out());

    line_setup other;
    other.step_us = 20'000;
    stepped_write_then_read<test_client, five_rows, light> both{other.drive};
    CHECK(both.begin(raw(7)) == errc::ok);
    other.finish(both);
    REQUIRE(both.value());
    CHECK(both.value()->get<at<five, 4>>() == 0xA04);
    CHECK(other.on.is_echo_ruled_out());
}

TEST_CASE_TEMPLATE("G3: words of function 17h that repeat the request are values where an echo is ruled out",
                   Kind, TABLE_ECHOES_ON_EACH_LINE) {
    setup<Kind> r;
    r.port.device = [](scripted_port& p, const sent_frame&) { p.say(500, framed({1, 0x97, 4})); };
    const auto refused = r.drive.template write_then_read<five_rows, light>(raw(7));
    CHECK(refused.error() == errc::exception);
    CHECK(refused.status().exception() == 4);
    r.answers();
    const auto seen = r.drive.template write_then_read<five_rows, light>(raw(7));
    REQUIRE(seen);
    CHECK(seen->template get<at<five, 4>>() == 0xA04);
    r.repeats();
    const auto repeated = r.drive.template write_then_read<five_rows, light>(raw(7));
    REQUIRE(repeated);
    CHECK(repeated->template get<at<five, 1>>() == 0x0503); // 17 0A 00 00 05 03 00 00 01 02 00 07
    CHECK(repeated->template get<at<five, 4>>() == 7);
}

TEST_CASE("a stepped call of a node that the device cannot have does not begin") {
    line_setup r;
    test_client nobody{r.on, node<device>{248}};
    stepped_read<test_client, input> read{nobody};
    CHECK(read.begin() == errc::bad_argument);
    stepped_write<test_client, bit<0>> one{nobody};
    CHECK(one.begin(true) == errc::bad_argument);
    stepped_write<test_client, bit<0>, bit<1>> two{nobody};
    CHECK(two.begin(true, false) == errc::bad_argument);
    CHECK(two.status() == errc::bad_argument);
    stepped_change_bits<test_client, light, 3> change{nobody};
    CHECK(change.begin(1) == errc::bad_argument);
    stepped_write_then_read<test_client, five_rows, light> both{nobody};
    CHECK(both.begin(raw(7)) == errc::bad_argument);
    CHECK(r.port.frames.empty());
}

TEST_CASE("a stepped call that needs the word order does not begin without it") {
    line_setup r;
    stepped_read<test_client, energy> one{r.drive};
    CHECK(one.begin() == errc::needs_word_order);
    stepped_read<test_client, energy, input> several{r.drive};
    CHECK(several.begin() == errc::needs_word_order);
    CHECK(several.value().error() == errc::needs_word_order);
    stepped_write_then_read<test_client, rows<place>, light> both{r.drive};
    CHECK(both.begin(raw(7)) == errc::needs_word_order);
    CHECK(r.port.frames.empty());
}

TEST_CASE("G21, G22: what a stepped call read with a word order that became void is not delivered") {
    line_setup r;
    r.drive.node().word_order = word_order::high_first;
    stepped_read<test_client, energy> one{r.drive};
    stepped_read<test_client, energy, input> several{r.drive};
    CHECK(one.begin() == errc::ok);
    CHECK(several.begin() == errc::ok);
    r.port.device = nullptr; // another client gets no response: perhaps the device restarts
    client other{r.on, node<device>{1}};
    u16 word = 0;
    CHECK(other.read_words(0x0300, slice<u16>{&word, 1}) == errc::timeout);
    r.answers();
    r.finish(one);
    r.finish(several);
    CHECK(one.status() == errc::ok);
    CHECK(one.value().error() == errc::needs_word_order);
    CHECK(several.status() == errc::ok);
    CHECK(several.value().error() == errc::needs_word_order);

    r.drive.node().word_order = word_order::high_first;
    stepped_write_then_read<test_client, rows<place>, light> both{r.drive};
    CHECK(both.begin(raw(7)) == errc::ok);
    r.port.frames.clear();
    while (r.port.frames.empty()) {
        (void)both.step();
        r.port.time += 200;
    }
    r.drive.node().word_order = word_order::unknown; // the program does so while the response is awaited
    r.finish(both);
    CHECK(both.status() == errc::ok);
    CHECK(both.value().error() == errc::needs_word_order);
    CHECK(r.tables.holding_registers[0x300] == 7);
}

TEST_CASE_TEMPLATE("G21, G22: a read whose first attempt got no response needs the word order again", Kind,
                   TABLE_ECHOES_ON_EACH_LINE) {
    setup<Kind> r;
    REQUIRE(r.drive.learn_word_order());
    CHECK(r.drive.template read<energy>().error() == errc::ok);
    bool is_lost = true;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (!std::exchange(is_lost, false)) r.tables(p, f, 1);
    };
    const std::size_t before = r.port.frames.size();
    CHECK(r.drive.template read<energy>().error() == errc::needs_word_order);
    CHECK(r.port.frames.size() == before + 2);
    CHECK(r.drive.template read<energy, input>().error() == errc::needs_word_order);
    CHECK(r.port.frames.size() == before + 2); // not asked for
}

TEST_CASE_TEMPLATE("16h on a device that answers 10h with its byte count: both masks are compared", Kind,
                   TABLE_ECHOES_ON_EACH_LINE) {
    setup<Kind> r;
    CHECK(r.drive.template read<input>());
    r.drive.node().limits.echoes_byte_count = true;
    const auto change = [&] { return r.drive.template change_bits<light, 0x000C>(4).error(); };
    CHECK(change() == errc::ok);
    CHECK(r.tables.holding_registers[0x300] == 4);
    const auto answer = [&](tests::byte_list body) {
        r.port.device = [body](scripted_port& p, const sent_frame&) { p.say(500, framed(body)); };
    };
    answer({1, 0x16, 3, 0, 0xFF, 0xF3, 0, 5});
    CHECK(change() == errc::wrong_value);
    answer({1, 0x16, 3, 0, 0xFF, 0xF1, 0, 4});
    CHECK(change() == errc::wrong_value);
    answer({1, 0x96, 2});
    CHECK(change() == errc::exception);
}

TEST_CASE("17h: the first of several wrong values is reported, and nothing is written") {
    namespace tank = tests::tank;
    tests::waiting_scripted_port port;
    any_line::line on = any_line::on(port);
    client drive{on, node<tank::device>{1}};
    const auto first = drive.write_then_read<rows<tank::state>, tank::ramp, tank::target>(
        checked(1 * part<2>(millisecond)), checked(raw(5'000'000'000LL)));
    CHECK(first.error() == errc::inexact);
    const auto second = drive.write_then_read<rows<tank::state>, tank::ramp, tank::target>(
        1 * millisecond, checked(raw(5'000'000'000LL)));
    CHECK(second.error() == errc::out_of_range);
    CHECK(port.frames.empty());
}

} // namespace table_echoes_tests
