// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stepped calls of every form that are refused: begun while one is under way, for a node that cannot be, outside
// the range or the address space, without a word order; and settings of the line, before which an echo is ruled
// out. A refused call sends nothing and leaves the one under way as it is.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <optional>

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace stepped_refusals_tests {

using namespace servobus;
using namespace tests::typed;
using tests::framed;
using tests::scripted_port;

namespace {

template <class Call, class Rig> void finish(Rig& r, Call& call) {
    for (int i = 0; i < 20'000 && !call.done(); ++i) {
        (void)call.step();
        r.port.time += 200;
    }
    REQUIRE(call.done());
}

/// Begins a call twice: the second is refused, and the first ends as it would have.
template <class Rig, class Call, class Begin> void check_begun_twice(Rig& r, Call& call, Begin begin) {
    r.port.frames.clear();
    CHECK(begin(call) == errc::ok);
    CHECK(begin(call) == errc::busy);
    (void)call.step();
    CHECK(begin(call) == errc::busy);
    CHECK(call.status() == errc::busy);
    finish(r, call);
    CHECK(call.status() == errc::ok);
    CHECK(r.port.frames.size() == 1);
}

using test_client = decltype(rig<>::drive);
using switchable_client = decltype(rig<switchable>::drive);

} // namespace

TEST_CASE("a stepped call that is begun while it is under way is refused, and goes on") {
    rig r;
    CHECK(r.drive.read<fixture::state>());
    const std::array<u16, 2> words{1, 2};
    stepped_read<test_client, fixture::time> one{r.drive};
    check_begun_twice(r, one, [](auto& c) { return c.begin(); });
    stepped_read<test_client, fixture::position> pair{r.drive};
    check_begun_twice(r, pair, [](auto& c) { return c.begin(); });
    stepped_read<test_client, fixture::steps> element{r.drive};
    check_begun_twice(r, element, [](auto& c) { return c.begin(1); });
    stepped_read<test_client, fixture::time, fixture::speed> several{r.drive};
    check_begun_twice(r, several, [](auto& c) { return c.begin(); });
    stepped_read_words<test_client, 2> some{r.drive};
    check_begun_twice(r, some, [](auto& c) { return c.begin(0x0100, 2); });
    stepped_write<test_client, fixture::position> put{r.drive};
    check_begun_twice(r, put, [](auto& c) { return c.begin(5); });
    stepped_write<test_client, fixture::steps> put_element{r.drive};
    check_begun_twice(r, put_element, [](auto& c) { return c.begin(1, -5); });
    stepped_write<test_client, fixture::time, fixture::speed> put_several{r.drive};
    check_begun_twice(r, put_several, [](auto& c) { return c.begin(5, 6); });
    stepped_write_words<test_client, 2> put_words{r.drive};
    check_begun_twice(r, put_words, [&](auto& c) {
        return c.begin(0x0100, slice<const u16>{words.data(), 2});
    });
    check_begun_twice(r, put_words, [](auto& c) { return c.begin(0x0100, u16{7}); });
}

TEST_CASE("a stepped call to a node that cannot be is refused, and sends nothing") {
    for (const std::uint8_t address : {std::uint8_t{0}, std::uint8_t{100}, std::uint8_t{248}}) {
        CAPTURE(address);
        rig r{address};
        const std::array<u16, 2> words{1, 2};
        stepped_read<test_client, fixture::time> one{r.drive};
        CHECK(one.begin() == errc::bad_argument);
        CHECK(one.value().error() == errc::bad_argument);
        stepped_read<test_client, fixture::steps> element{r.drive};
        CHECK(element.begin(1) == errc::bad_argument);
        stepped_read<test_client, fixture::time, fixture::state> several{r.drive};
        CHECK(several.begin() == errc::bad_argument);
        CHECK(several.value().error() == errc::bad_argument);
        stepped_read_words<test_client, 2> some{r.drive};
        CHECK(some.begin(0x0100, 2) == errc::bad_argument);
        stepped_write<test_client, fixture::time> put{r.drive};
        CHECK(put.begin(5) == errc::bad_argument);
        stepped_write<test_client, fixture::steps> put_element{r.drive};
        CHECK(put_element.begin(1, -5) == errc::bad_argument);
        stepped_write<test_client, fixture::time, fixture::speed> put_several{r.drive};
        CHECK(put_several.begin(5, 6) == errc::bad_argument);
        stepped_write_words<test_client, 2> put_words{r.drive};
        CHECK(put_words.begin(0x0100, slice<const u16>{words.data(), 2}) == errc::bad_argument);
        CHECK(put_words.begin(0x0100, u16{7}) == errc::bad_argument);
        CHECK(r.port.calls == 0);
    }
}

TEST_CASE("a stepped write outside a range or the address space is refused, and sends nothing") {
    rig r;
    CHECK(r.drive.read<fixture::state>());
    r.port.frames.clear();
    const std::array<u16, 2> words{1, 2};
    stepped_write<test_client, fixture::position> pair{r.drive};
    CHECK(pair.begin(clamped(5)) == errc::ok);
    pair.cancel();
    stepped_write<test_client, fixture::steps> element{r.drive};
    CHECK(element.begin(1, checked(-101)) == errc::out_of_range);
    CHECK(element.begin(4, checked(-101)) == errc::bad_argument);
    stepped_write_words<test_client, 2> some{r.drive};
    CHECK(some.begin(0xFFFF, slice<const u16>{words.data(), 2}) == errc::bad_argument);
    CHECK(some.status() == errc::bad_argument);
    CHECK(r.port.frames.empty());
    CHECK(some.begin(0x0100, slice<const u16>{words.data(), 2}) == errc::ok);
    finish(r, some);
    CHECK(some.status());
}

TEST_CASE(
    "a stepped call of several registers: the first wrong value is named, and one failed part fails all") {
    rig r;
    stepped_write<test_client, fixture::time, fixture::speed> put{r.drive};
    CHECK(put.begin(checked(-1), checked(301)) == errc::out_of_range);
    r.port.device = nullptr;
    stepped_read<test_client, fixture::time, fixture::state> both{r.drive};
    CHECK(both.begin() == errc::ok);
    finish(r, both);
    CHECK(both.value().error() == errc::timeout);
    CHECK(both.step() == duration{});
    CHECK(both.value().error() == errc::timeout);
}

TEST_CASE("G3: a stepped write that is given up before an echo was ruled out is unknown") {
    rig r;
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) {
        if (f.data[1] == 0x06) p.say(500, f.data);
    };
    stepped_write<test_client, fixture::time> time{r.drive};
    CHECK(time.begin(500) == errc::ok);
    while (r.port.frames.size() < 2) { // the write, and the read that is to rule an echo out
        (void)time.step();
        r.port.time += 50;
    }
    time.cancel();
    CHECK(time.status() == errc::own_echo);
    CHECK(time.status().outcome() == outcome::unknown);
}

TEST_CASE("G22: stepped calls of 32 bits without a word order are refused, and send nothing") {
    rig<switchable> r;
    stepped_read<switchable_client, fixture::place> one{r.drive};
    CHECK(one.begin() == errc::needs_word_order);
    CHECK(one.value().error() == errc::needs_word_order);
    one.cancel(); // of a call that has ended
    CHECK(one.status() == errc::needs_word_order);
    stepped_read<switchable_client, fixture::places> element{r.drive};
    CHECK(element.begin(1) == errc::needs_word_order);
    stepped_read<switchable_client, fixture::place, fixture::word> several{r.drive};
    CHECK(several.begin() == errc::needs_word_order);
    CHECK(several.value().error() == errc::needs_word_order);
    stepped_write<switchable_client, fixture::place> put{r.drive};
    CHECK(put.begin(5) == errc::needs_word_order);
    stepped_write<switchable_client, fixture::places> put_element{r.drive};
    CHECK(put_element.begin(1, 5) == errc::needs_word_order);
    stepped_write<switchable_client, fixture::place, fixture::word> put_several{r.drive};
    CHECK(put_several.begin(5, 6) == errc::needs_word_order);
    CHECK(r.port.calls == 0);
    r.drive.node().word_order = word_order::high_first;
    check_begun_twice(r, one, [](auto& c) { return c.begin(); });
    check_begun_twice(r, element, [](auto& c) { return c.begin(1); });
    check_begun_twice(r, several, [](auto& c) { return c.begin(); });
    check_begun_twice(r, put, [](auto& c) { return c.begin(5); });
    check_begun_twice(r, put_element, [](auto& c) { return c.begin(1, 5); });
    check_begun_twice(r, put_several, [](auto& c) { return c.begin(5, 6); });
}

namespace {
using yako_client = client<line<tests::waiting_scripted_port>, yako::closed_loop::device>;
using format_write = stepped_write<yako_client, yako::rs485_format>;
constexpr auto wanted = yako::serial_format{1};
const tests::byte_list format_frame = framed({1, 6, 0x00, 0x15, 0x00, 0x01});
} // namespace

TEST_CASE("G21, G22: what was read with a word order that became void is not delivered") {
    rig<yako::closed_loop::device> r;
    r.drive.node().word_order = word_order::high_first;
    for (u16 a = 0x0006; a < 0x0030; ++a) r.file.words[a] = 1;
    stepped_read<yako_client, yako::actual_position> one{r.drive};
    stepped_read<yako_client, yako::status_word, yako::actual_position> several{r.drive};
    CHECK(one.begin() == errc::ok);
    CHECK(several.begin() == errc::ok);
    r.port.device = nullptr; // another client gets no response: perhaps the drive restarts
    client other{r.on, node<yako::closed_loop::device>{1}};
    u16 word = 0;
    CHECK(other.read_words(0x0006, slice<u16>{&word, 1}) == errc::timeout);
    r.port.device = [&](scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    finish(r, one);
    finish(r, several);
    CHECK(one.status() == errc::ok);
    CHECK(one.value().error() == errc::needs_word_order);
    CHECK(several.status() == errc::ok);
    CHECK(several.value().error() == errc::needs_word_order);
}

TEST_CASE("G22: a value that was read stays the same when its node's word order becomes another one") {
    rig<yako::closed_loop::device> r;
    r.file.words[0x0019] = 1; // low word first
    for (u16 a = 0x0006; a < 0x0010; ++a) r.file.words[a] = a;
    node<yako::closed_loop::device> stated{1};
    stated.word_order = word_order::high_first;
    client drive{r.on, stated};
    REQUIRE(drive.learn_word_order());
    stepped_read<yako_client, yako::actual_position> one{drive};
    stepped_read<yako_client, yako::status_word, yako::actual_position> several{drive};
    const auto take_all = [&] {
        const auto alone = one.value();
        const auto among = several.value();
        REQUIRE(alone);
        REQUIRE(among);
        return std::array{*alone, among->get<yako::actual_position>()};
    };
    REQUIRE(one.begin() == errc::ok);
    finish(r, one);
    REQUIRE(several.begin() == errc::ok);
    finish(r, several);
    const auto taken = take_all();
    constexpr u16 at = yako::actual_position.address;
    CHECK(taken[0] == taken[1]);
    CHECK(taken[0].count() == (at + 1) * 0x1'0000 + at);

    r.port.device = nullptr; // no response: what was learned is stale, and the stated word order holds again
    CHECK(drive.read<yako::status_word>().error() == errc::timeout);
    CHECK(drive.node().word_order == word_order::high_first);
    CHECK(take_all() == taken);
}

TEST_CASE("G3: before a stepped write of a setting of the line leaves, an echo is ruled out") {
    for (const bool was_ruled_out : {false, true}) {
        CAPTURE(was_ruled_out);
        rig<yako::closed_loop::device> r;
        r.file.words[yako::rs485_format.address] = 0;
        u16 word = 0;
        if (was_ruled_out) CHECK(r.drive.read_words(yako::rs485_format.address, slice<u16>{&word, 1}));
        r.port.frames.clear();
        format_write format{r.drive};
        CHECK(format.begin(wanted) == errc::ok);
        CHECK(format.begin(wanted) == errc::busy);
        finish(r, format);
        CHECK(format.status());
        REQUIRE(r.port.frames.size() == (was_ruled_out ? 1 : 2));
        CHECK(r.port.frames.back().data == format_frame);
    }
}

TEST_CASE("G3: on a line that only echoes, a stepped write of a setting of the line is not sent") {
    rig<yako::closed_loop::device> r;
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) { p.say(500, f.data); };
    format_write format{r.drive};
    CHECK(format.begin(wanted) == errc::ok);
    finish(r, format);
    CHECK(format.status() == errc::own_echo);
    CHECK(format.status().outcome() == outcome::not_sent);
    for (const auto& f : r.port.frames) CHECK(f.data[1] == 0x03);
}

TEST_CASE("a stepped write of a setting of the line that is given up before it leaves was not sent") {
    for (int steps = 0; steps < 40; ++steps) {
        CAPTURE(steps);
        for (const bool is_destroyed : {false, true}) {
            rig<yako::closed_loop::device> r;
            r.port.device = nullptr;
            std::optional<format_write> format;
            format.emplace(r.drive);
            CHECK(format->begin(wanted) == errc::ok);
            for (int i = 0; i < steps; ++i) {
                (void)format->step();
                r.port.time += 150;
            }
            if (is_destroyed) {
                format.reset();
            } else {
                format->cancel();
                CHECK(format->status() == errc::busy);
                CHECK(format->status().outcome() == outcome::not_sent);
            }
            r.port.time += 1'000'000;
            for (const auto& f : r.port.frames) CHECK(f.data[1] == 0x03);
        }
    }
}

} // namespace stepped_refusals_tests
