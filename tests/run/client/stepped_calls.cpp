// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stepped calls of a client over a scripted port: the frames and values are those of the blocking calls, no
// step waits, several share a line, and what is begun twice, cancelled or destroyed is never sent twice.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace stepped_calls_tests {

using namespace servobus;
using namespace tests::typed;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {

using test_client = decltype(rig<>::drive);
template <const auto&... Rs> using read_of = stepped_read<test_client, Rs...>;
template <const auto&... Rs> using write_of = stepped_write<test_client, Rs...>;

constexpr std::uint32_t loop_us = 200; // an iteration of the program

// Steps a call to its end, as a main loop does.
template <class Rig, class Call> void finish(Rig& r, Call& call) {
    for (int i = 0; i < 20'000 && !call.done(); ++i) {
        const std::uint64_t before = r.port.time;
        const std::uint64_t calls = r.port.calls;
        (void)call.step();
        REQUIRE(r.port.time - before <= 4 * (r.port.calls - calls) + 16); // only the time of the port's calls
        r.port.time += loop_us;
    }
    REQUIRE(call.done());
}

std::vector<byte_list> sent(const scripted_port& port) {
    std::vector<byte_list> all;
    for (const auto& f : port.frames) all.push_back(f.data);
    return all;
}

// What a blocking call and a stepped one leave: both are given a machine of their own.
template <class Blocking, class Stepped>
void check_same(const Blocking& blocking, const Stepped& stepped, bool has_answered) {
    rig a;
    rig b;
    for (rig<>* const r : {&a, &b}) {
        r->file.words[0x0100] = 1234;
        r->file.words[0x0102] = 0xFFFE;
        r->file.words[0x0103] = 0x0007;
        if (has_answered) CHECK(r->drive.read<fixture::state>());
    }
    blocking(a);
    stepped(b);
    CHECK(sent(a.port) == sent(b.port));
    CHECK(a.file.words == b.file.words);
}

} // namespace

TEST_CASE("a stepped read sends the frames of the blocking one, and has its value") {
    check_same([](auto& r) { CHECK(r.drive.template read<fixture::time>()->count() == 1234); },
               [](auto& r) {
                   read_of<fixture::time> time{r.drive};
                   CHECK(time.begin() == errc::ok);
                   CHECK(time.status() == errc::busy);
                   CHECK(time.value().error() == errc::busy);
                   finish(r, time);
                   CHECK(time.status() == errc::ok);
                   CHECK(time.value()->count() == 1234);
               },
               false);
    check_same([](auto& r) { CHECK(r.drive.template read<fixture::position>()); },
               [](auto& r) {
                   const auto known = r.drive.template read<fixture::position>();
                   r.port.frames.clear();
                   read_of<fixture::position> position{r.drive};
                   CHECK(position.begin() == errc::ok);
                   finish(r, position);
                   CHECK(position.value()->count() == known->count());
               },
               false);
    check_same([](auto& r) { CHECK(r.drive.template read<fixture::steps>(2)->count() == 12); },
               [](auto& r) {
                   read_of<fixture::steps> step{r.drive};
                   CHECK(step.begin(4) == errc::bad_argument);
                   CHECK(step.value().error() == errc::bad_argument);
                   CHECK(step.begin(2) == errc::ok);
                   finish(r, step);
                   CHECK(step.value()->count() == 12);
               },
               false);
    check_same(
        [](auto& r) { CHECK((r.drive.template read<fixture::state, fixture::position, fixture::time>())); },
        [](auto& r) {
            read_of<fixture::state, fixture::position, fixture::time> all{r.drive};
            for (int again = 0; again < 2; ++again) {
                r.port.frames.clear();
                CHECK(all.begin() == errc::ok);
                finish(r, all);
                const auto values = all.value();
                REQUIRE(values);
                CHECK(get<fixture::time>(*values).count() == 1234);
                CHECK(get<fixture::state>(*values) == 0xBEEF);
                CHECK(get<fixture::position>(*values).count() ==
                      (device::facts.word_order == word_order::high_first ? -131'065 : 524'286));
            }
        },
        false);
    check_same(
        [](auto& r) {
            std::array<u16, 3> words{};
            CHECK(r.drive.read_words(0x0100, words, modbus::function::read_input_registers));
        },
        [](auto& r) {
            stepped_read_words<test_client, 4> words{r.drive};
            CHECK(words.begin(0x0100, 5) == errc::bad_argument);
            CHECK(words.begin(0x0100, 0) == errc::bad_argument);
            CHECK(words.begin(0xFFFE, 4) == errc::bad_argument);
            CHECK(words.words().size() == 0);
            CHECK(words.begin(0x0100, 3, modbus::function::read_input_registers) == errc::ok);
            CHECK(words.words().size() == 0);
            finish(r, words);
            REQUIRE(words.words().size() == 3);
            CHECK(words.words()[0] == 1234);
            CHECK(words.words()[2] == 0xFFFE);
        },
        false);
}

TEST_CASE("a stepped write sends the frames of the blocking one; G3: also the read that rules out an echo") {
    for (const bool has_answered : {false, true}) {
        CAPTURE(has_answered);
        check_same([](auto& r) { CHECK(r.drive.template write<fixture::time>(500)); },
                   [](auto& r) {
                       write_of<fixture::time> time{r.drive};
                       CHECK(time.begin(checked(5001)) == errc::out_of_range);
                       CHECK(time.status() == errc::out_of_range);
                       CHECK(time.begin(500) == errc::ok);
                       finish(r, time);
                       CHECK(time.status() == errc::ok);
                       CHECK(time.status().outcome() == outcome::done);
                   },
                   has_answered);
        check_same([](auto& r) { CHECK(r.drive.template write<fixture::position>(-70'000)); },
                   [](auto& r) {
                       write_of<fixture::position> position{r.drive};
                       CHECK(position.begin(-70'000) == errc::ok);
                       finish(r, position);
                       CHECK(position.status());
                   },
                   has_answered);
        check_same([](auto& r) { CHECK(r.drive.template write<fixture::steps>(3, -100)); },
                   [](auto& r) {
                       write_of<fixture::steps> step{r.drive};
                       CHECK(step.begin(4, -100) == errc::bad_argument);
                       CHECK(step.begin(3, -100) == errc::ok);
                       finish(r, step);
                       CHECK(step.status());
                   },
                   has_answered);
        check_same(
            [](auto& r) {
                CHECK((r.drive.template write<fixture::time, fixture::speed, fixture::position>(5, -6, 7)));
            },
            [](auto& r) {
                write_of<fixture::time, fixture::speed, fixture::position> all{r.drive};
                CHECK(all.begin(5, checked(301), 7) == errc::out_of_range);
                CHECK(all.begin(5, -6, 7) == errc::ok);
                finish(r, all);
                CHECK(all.status());
            },
            has_answered);
        check_same(
            [](auto& r) {
                const std::array<u16, 2> words{0xAB, 0xCD};
                CHECK(r.drive.write_words(0x0100, words));
                CHECK(r.drive.write_word(0x0104, 9));
            },
            [](auto& r) {
                const std::array<u16, 5> words{0xAB, 0xCD};
                stepped_write_words<test_client, 4> call{r.drive};
                CHECK(call.begin(0x0100, slice<const u16>{words.data(), 5}) == errc::bad_argument);
                CHECK(call.begin(0x0100, slice<const u16>{words.data(), 0}) == errc::bad_argument);
                CHECK(call.begin(0x0100, slice<const u16>{words.data(), 2}) == errc::ok);
                finish(r, call);
                CHECK(call.status());
                CHECK(call.begin(0x0104, u16{9}) == errc::ok);
                finish(r, call);
                CHECK(call.status());
            },
            has_answered);
    }
}

TEST_CASE("G3: a stepped write is not done where nothing but echoes was received") {
    rig r;
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) { p.say(500, f.data); };
    write_of<fixture::time> time{r.drive};
    CHECK(time.begin(500) == errc::ok);
    finish(r, time);
    CHECK(time.status() == errc::own_echo);
    CHECK(time.status().outcome() == outcome::unknown);
    CHECK(r.port.frames.size() == 2 + device::facts.read_retries); // the write, and reads
    CHECK(r.port.frames[0].data[1] == 0x06);
    for (std::size_t i = 1; i < r.port.frames.size(); ++i) CHECK(r.port.frames[i].data[1] == 0x03);
}

TEST_CASE("G2: a stepped read is retried as often as the node says, a stepped write never") {
    for (std::size_t missed = 0; missed <= 4; ++missed) {
        CAPTURE(missed);
        rig r;
        CHECK(r.drive.read<fixture::state>());
        r.port.frames.clear();
        r.port.device = [&](scripted_port& p, const tests::sent_frame& f) {
            if (p.frames.size() > missed) r.file(p, f);
        };
        read_of<fixture::time> time{r.drive};
        CHECK(time.begin() == errc::ok);
        finish(r, time);
        const std::size_t attempts = 1 + device::facts.read_retries;
        CHECK(time.status() == (missed < attempts ? errc::ok : errc::timeout));
        CHECK(r.port.frames.size() == (missed < attempts ? missed + 1 : attempts));
        if (missed == 0) continue;
        r.port.frames.clear();
        write_of<fixture::time> write{r.drive};
        CHECK(write.begin(77) == errc::ok);
        finish(r, write);
        CHECK(write.status() == errc::timeout);
        CHECK(write.status().outcome() == outcome::unknown);
        CHECK(r.port.frames.size() == 1);
    }
}

TEST_CASE(
    "a stepped call that was not begun, is begun twice or has ended changes nothing and sends nothing") {
    rig r;
    write_of<fixture::time> time{r.drive};
    CHECK(time.done());
    CHECK(time.status() == errc::bad_argument);
    for (int i = 0; i < 10; ++i) CHECK(time.step() == duration{});
    time.cancel();
    CHECK(r.port.calls == 0);
    CHECK(r.drive.read<fixture::state>());
    r.port.frames.clear();

    CHECK(time.begin(500) == errc::ok);
    CHECK(time.begin(600) == errc::busy);
    CHECK(time.begin(checked(-5)) == errc::busy);
    finish(r, time);
    CHECK(time.status());
    CHECK(time.begin(checked(-5)) == errc::out_of_range);
    for (int i = 0; i < 10; ++i) CHECK(time.step() == duration{});
    REQUIRE(r.port.frames.size() == 1);
    CHECK(r.last() == framed({1, 6, 0x01, 0x00, 0x01, 0xF4}));

    read_of<fixture::time, fixture::state> both{r.drive};
    CHECK(both.begin() == errc::ok);
    (void)both.step();
    CHECK(both.begin() == errc::busy);
    finish(r, both);
    CHECK(both.begin() == errc::ok); // begun, and never stepped
    CHECK(r.port.frames.size() == 3);
}

TEST_CASE("G33: a stepped call that is cancelled or destroyed in any state is not sent again") {
    const byte_list whole = framed({1, 6, 0x01, 0x00, 0x01, 0xF4});
    for (const bool is_destroyed : {false, true}) {
        for (int steps = 0; steps < 90; ++steps) {
            CAPTURE(is_destroyed);
            CAPTURE(steps);
            rig r;
            r.port.takes_at_most = 1;
            if (steps % 2 == 0) CHECK(r.drive.read<fixture::state>());
            r.port.frames.clear();
            std::optional<write_of<fixture::time>> time;
            time.emplace(r.drive);
            CHECK(time->begin(500) == errc::ok);
            for (int i = 0; i < steps; ++i) {
                (void)time->step();
                r.port.time += 90;
            }
            const bool has_begun = !r.port.frames.empty();
            if (is_destroyed) {
                time.reset();
            } else {
                const bool was_done = time->done();
                time->cancel();
                CHECK(time->done());
                CHECK(time->status().was_sent() == has_begun);
                if (!was_done) CHECK_FALSE(time->status());
                CHECK(time->step() == duration{});
            }
            const auto state = r.drive.read<fixture::state>(); // the line is in order
            REQUIRE(state);
            CHECK(*state == 0xBEEF);
            int writes = 0;
            for (const auto& f : r.port.frames) // whole, or its first bytes
                writes += std::equal(f.data.begin(), f.data.end(), whole.begin());
            CHECK(writes == (has_begun ? 1 : 0));
        }
    }
}

TEST_CASE("several stepped calls share a line, and a stop goes before those that have not begun to leave") {
    rig r;
    r.file.words[0x0100] = 11;
    r.file.words[0x0101] = 22;
    CHECK(r.drive.read<fixture::state>());
    r.port.frames.clear();
    read_of<fixture::time> time{r.drive};
    read_of<fixture::speed> speed{r.drive};
    read_of<fixture::state> state{r.drive};
    write_of<fixture::current> current{r.drive};
    CHECK(time.begin() == errc::ok);
    CHECK(speed.begin() == errc::ok);
    CHECK(state.begin() == errc::ok);
    CHECK(current.begin(raw(7)) == errc::ok);
    const byte_list stop = framed({1, 6, 0x01, 0x00, 0, 0});
    std::array<std::uint8_t, 8> response{};
    const response_limits limits{};
    modbus::exchange stopping{stop, response, r.on.timing(), limits, priority::stop};
    for (int i = 0; i < 2000 && !(time.done() && speed.done() && state.done() && current.done()); ++i) {
        (void)time.step();
        (void)speed.step();
        (void)state.step();
        (void)current.step();
        if (!r.port.frames.empty()) (void)r.on.step(stopping, {});
        r.port.time += 50;
    }
    CHECK(time.value()->count() == 11);
    CHECK(speed.value()->count() == 22);
    CHECK(*state.value() == 0xBEEF);
    CHECK(current.status());
    CHECK(stopping.status());
    REQUIRE(r.port.frames.size() == 5);
    CHECK(r.port.frames[1].data == stop);
}

TEST_CASE("a port that takes and gives one byte a call, or nothing for a while, delays a stepped call only") {
    for (const bool is_slow : {false, true}) {
        rig r;
        r.port.takes_at_most = r.port.gives_at_most = 1;
        r.port.empty_reads = 2;
        if (is_slow) r.port.takes_nothing_until = 120'000;
        r.file.words[0x0100] = 1234;
        read_of<fixture::time> time{r.drive};
        CHECK(time.begin() == errc::ok);
        finish(r, time);
        CHECK(time.value()->count() == 1234);
        CHECK(r.port.frames.size() == 1);
    }
    rig r;
    r.port.lost_from_call = 1;
    read_of<fixture::time> time{r.drive};
    CHECK(time.begin() == errc::ok);
    finish(r, time);
    CHECK(time.value().error() == errc::port_lost);
    CHECK(r.port.frames.empty());
}

TEST_CASE("G22: a stepped write of 32 bits does not leave once the word order is void") {
    using yako_client = client<line<tests::waiting_scripted_port>, yako::closed_loop::device>;
    rig<yako::closed_loop::device> r;
    static_assert(std::is_same_v<yako_client, decltype(r.drive)>);
    r.drive.node().word_order = word_order::high_first;
    stepped_write<yako_client, yako::closed_loop::target_position> target{r.drive};
    stepped_read<yako_client, yako::closed_loop::target_position> back{r.drive};
    CHECK(target.begin(checked(100)) == errc::ok);
    CHECK(back.begin() == errc::ok);
    (void)target.step();
    r.port.device = nullptr;
    u16 word = 0;
    client other{r.on, node<yako::closed_loop::device>{1}};
    target.cancel();
    CHECK(target.status() == errc::busy);
    CHECK(target.begin(checked(100)) == errc::ok);
    CHECK(other.read_words(0x0000, slice<u16>{&word, 1}) == errc::timeout); // the drive may have restarted
    r.port.frames.clear();
    finish(r, target);
    CHECK(target.status() == errc::needs_word_order);
    CHECK(target.status().outcome() == outcome::not_sent);
    CHECK(r.port.frames.empty());
    r.port.device = [&](scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    finish(r, back);
    CHECK(back.value().error() != errc::ok);
    CHECK(back.begin() == errc::needs_word_order);
}

TEST_CASE("G22: a stepped read in two requests gives no value if the word order changes between them") {
    constexpr const auto& far = at<fixture::places, 1>;
    using two_requests =
        stepped_read<decltype(rig<switchable>::drive), fixture::place, at<fixture::places, 1>>;
    static_assert(far.address == 0x0402);
    for (const bool changes : {false, true}) {
        rig<switchable> r;
        r.file.words[0x0103] = 5;
        r.file.words[0x0403] = 6;
        r.drive.node().word_order = word_order::high_first;
        two_requests both{r.drive};
        CHECK(both.begin() == errc::ok);
        while (r.port.frames.size() < 2) {
            (void)both.step();
            r.port.time += loop_us;
        }
        if (changes) r.drive.node().word_order = word_order::low_first;
        finish(r, both);
        CHECK(both.value().error() == (changes ? errc::needs_word_order : errc::ok));
        if (!changes) CHECK(get<fixture::place>(*both.value()).count() == 5);
        if (!changes) CHECK(get<at<fixture::places, 1>>(*both.value()).count() == 6);
        CHECK(r.port.frames.size() == 2);
        CHECK(both.begin() == errc::ok);
        finish(r, both);
        CHECK(both.value());
    }
}

TEST_CASE("G17: a stepped write whose token gets void before it leaves is not sent") {
    rig<c630s::device> r;
    r.file.words[0x0C0D] = 0;
    r.file.words[c630s::jog_speed.address] = 1;
    using servo_client = decltype(r.drive);
    const auto token = r.drive.ram_only();
    REQUIRE(token);
    stepped_write<servo_client, c630s::jog_speed> jog{r.drive};
    CHECK(jog.begin(checked(100), *token) == errc::ok);
    finish(r, jog);
    CHECK(jog.status());
    CHECK(r.file.words[c630s::jog_speed.address] == 100);

    CHECK(jog.begin(checked(200), *token) == errc::ok);
    r.port.device = nullptr;
    u16 word = 0;
    CHECK(r.drive.read_words(0x0C0D, slice<u16>{&word, 1}) == errc::timeout);
    r.port.frames.clear();
    finish(r, jog);
    CHECK(jog.status() == errc::needs_init);
    CHECK(jog.begin(checked(200), *token) == errc::needs_init);
    CHECK(r.port.frames.empty());

    r.port.device = [&](scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    stepped_store<servo_client, c630s::jog_speed> store{r.drive};
    CHECK(store.begin(checked(300)) == errc::ok);
    finish(r, store);
    CHECK(store.status());
    CHECK(r.file.words[c630s::jog_speed.address] == 300);
}

TEST_CASE("G17, G18: a stepped write of the switch of the EEPROM by its own token leaves, as the blocking "
          "one does") {
    rig<c630s::device> r;
    r.file.words[0x0C0D] = 0;
    r.file.words[c630s::jog_speed.address] = 1;
    r.file.words[c630s::pair_word_order.address] = 0;
    using servo_client = decltype(r.drive);
    const auto token = r.drive.ram_only();
    REQUIRE(token);
    SUBCASE("the switch") {
        stepped_write<servo_client, c630s::eeprom_update> put{r.drive};
        SUBCASE("at once") {
            CHECK(put.begin(c630s::off_on::on, *token) == errc::ok);
            finish(r, put);
            CHECK(put.status());
            CHECK(r.file.words[0x0C0D] == 1);
        }
        SUBCASE("not after a request without a response while it waited") {
            CHECK(put.begin(c630s::off_on::on, *token) == errc::ok);
            r.port.device = nullptr;
            u16 word = 0;
            CHECK(r.drive.read_words(0x0C0D, slice<u16>{&word, 1}) == errc::timeout);
            r.port.frames.clear();
            finish(r, put);
            CHECK(put.status() == errc::needs_init);
            CHECK(r.port.frames.empty());
        }
    }
    SUBCASE("the word order") {
        stepped_write<servo_client, c630s::pair_word_order> put{r.drive};
        CHECK(put.begin(c630s::word_order_setting::low_first, *token) == errc::ok);
        finish(r, put);
        CHECK(put.status());
    }
    r.port.device = [&](scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    r.port.frames.clear();
    CHECK(r.drive.write<c630s::jog_speed>(checked(300), *token) == errc::needs_init);
    CHECK(r.port.frames.empty());
}

} // namespace stepped_calls_tests
