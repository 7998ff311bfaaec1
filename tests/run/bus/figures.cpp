// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Figures on which programs rely without seeing them: the defaults, and a plan's times to the microsecond,
// calculated here by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/bus/bus.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/bare_drive.hpp>
#include <tests/support/scripted_port.hpp>

namespace figures_tests {

using namespace servobus;

static_assert(profile{.name = ""}.max_read == 125 && profile{.name = ""}.max_write == 123);
static_assert(profile{.name = ""}.lowest_address == 1 && profile{.name = ""}.highest_address == 247);
static_assert(profile{.name = ""}.word_order == word_order::high_first && profile{.name = ""}.baud == 9600);
static_assert(profile{.name = ""}.quarantine == milliseconds(100) && profile{.name = ""}.gap == duration{});
static_assert(profile{.name = ""}.read_retries == 2 && profile{.name = ""}.eeprom_switch == 0);
static_assert(response_limits{}.response == milliseconds(100) &&
              response_limits{}.turnaround == milliseconds(10));
static_assert(response_limits{}.leading_bytes == 4 && response_limits{}.corrupted_request == 0);
static_assert(!response_limits{}.echoes_byte_count);
static_assert(back_off{}.failures == 3 && back_off{}.retry_every == milliseconds(1000));
static_assert(back_off{}.stop_every == milliseconds(100));
static_assert(modbus::request{}.quantity == 0 && modbus::response{}.quantity == 0);
static_assert(command_status{}.step() == 0 && !command_status{}.has_changed());
static_assert(detail::ratio{}.numerator == 1 && detail::ratio{}.denominator == 1);

TEST_CASE("the exceptions of the Modbus standard have its numbers") {
    const std::array<std::uint8_t, 6> numbers{1, 2, 3, 4, 5, 6};
    std::size_t i = 0;
    for (const exception_meaning& e : standard_exceptions) CHECK(e.number == numbers.at(i++));
    CHECK(i == numbers.size());
}

TEST_CASE("the frame of a request that no device accepts has size 0") {
    volatile std::uint16_t last = 0xFFFF; // a constant would not compile
    CHECK(modbus::read_frame(1, last, 2).size == 0);
    CHECK(modbus::read_frame(1, last, 1).size == 8);
    CHECK(modbus::read_frame(1, 0, static_cast<std::uint16_t>(last - 0xFFFFu)).size == 0);
    CHECK(modbus::write_frame(1, last, std::array<std::uint16_t, 2>{1, 2}).size == 0);
    CHECK(modbus::write_frame(1, last, std::array<std::uint16_t, 1>{1}).size == 11);
}

namespace figures {

struct quick {
    static constexpr std::uint8_t address = 1;
    static constexpr profile facts{
        .name = "quick", .limits = {.response = milliseconds(30)}, .quarantine = milliseconds(100)};
};
struct slow {
    static constexpr std::uint8_t address = 2;
    static constexpr profile facts{.name = "slow",
                                   .limits = {.response = milliseconds(50)},
                                   .quarantine = milliseconds(150),
                                   .gap = milliseconds(6)};
};
struct not_polled {
    static constexpr std::uint8_t address = 3;
    static constexpr profile facts{.name = "not polled",
                                   .limits = {.response = milliseconds(80)},
                                   .quarantine = milliseconds(300),
                                   .gap = milliseconds(9)};
};
// Its watchdog is that of a ZLAC8015D, whose feedback has 11 words.
struct watched : quick {};
bare::model model_of(const quick&);
bare::model model_of(const slow&);
bare::model model_of(const not_polled&);
zlac8015d::model model_of(const watched&);

constexpr reg<u16, access::ro, quick> status_word{0x0010, full<u16>, no_unit, no_default};
constexpr reg<u16, access::ro, slow> current{0x0020, full<u16>, no_unit, no_default};
constexpr reg<u16, access::ro, slow> voltage{0x0021, full<u16>, no_unit, no_default};

// A character takes 1146 us, t3.5 is 4011 us, and the shortest gap that a host can detect is 20 ms.
template <class... Drives> consteval auto two_with(back_off rules) {
    return poll_plan{
        modbus::timing_at(9600), controlled(node<Drives>{Drives::address}, unsupervised)...,
        cyclic<status_word>(node<quick>{quick::address}, milliseconds(100)).keeps_alive(milliseconds(5000)),
        cyclic<current, voltage>(node<slow>{slow::address}, milliseconds(200)), rules};
}
template <class... Drives> constexpr auto two = two_with<Drives...>({});
constexpr const auto& plan = two<quick>;

// gap + request + response limit + the plan's longest quarantine + a late response of 7 or 9 bytes + quarantine
constexpr std::uint32_t first = 4011 + 9168 + 30'000 + 150'000 + 8022 + 150'000;
constexpr std::uint32_t second = 6000 + 9168 + 50'000 + 150'000 + 10'314 + 150'000;
// The longest that responses of 8, 9 and 27 bytes take: a pause of 20 ms, or t1.5 (1719 us) with each byte.
constexpr std::uint32_t of_8 = 20'000 + 9168;
constexpr std::uint32_t of_9 = 20'000 + 10'314;
constexpr std::uint32_t of_27 = 27 * (1146 + 1719);
// The longest response limit of the drives, whatever that of a read is.
constexpr std::uint32_t of_quick = 30'000;
constexpr std::uint32_t of_slow = 50'000;
// a frame of a facade: a read, the drives' response limit, the gap after it, a response of 27 bytes
constexpr std::uint32_t in_flight = 9168 + of_quick + 4011 + of_27;
// a write of 21 bytes, the drives' response limit, a late response of 27 bytes
constexpr std::uint32_t command_of(std::uint32_t response) {
    return 6000 + 24'066 + response + 150'000 + 30'942 + 150'000;
}
constexpr std::uint32_t command = command_of(of_quick);
constexpr std::uint32_t command_of_both = command_of(of_slow);
// one of the three frames of a stop: 13 bytes, the response limit, the gap after it, a response of 8 bytes, a gap
constexpr std::uint32_t stop_frame(std::uint32_t response, std::uint32_t gap) {
    return 14'898 + response + gap + of_8 + gap;
}
constexpr std::uint32_t stop = 3 * stop_frame(of_quick, 4011) + 150'000 + 9168 + 150'000;
constexpr std::uint32_t stop_of_both = 3 * stop_frame(of_slow, 6000) + 150'000 + 9168 + 150'000;

} // namespace figures

using namespace figures;

TEST_CASE("G19, G25, G28: a plan's times are those of its frames and gaps, to the microsecond") {
    CHECK(plan.polls[0].keep_alive == milliseconds(5000));
    CHECK(plan.polls[1].keep_alive == duration{});
    CHECK(plan.words == 3);
    CHECK(plan.response_room == 9);
    CHECK(plan.offset_of(1) == 1);
    // gap + request + t3.5 + response of 7 and of 9 bytes
    CHECK(plan.shortest(plan.polls[0]).us == 4011 + 9168 + 4011 + 8022);
    CHECK(plan.shortest(plan.polls[1]).us == 6000 + 9168 + 4011 + 10314);
    CHECK(plan.load_per_mille() == 400);
    CHECK(plan.longest(plan.polls[0]).us == first);
    CHECK(plan.longest(plan.polls[1]).us == second);
    CHECK(plan.longest_stop().us == stop);
    CHECK(plan.longest_gap(plan.polls[0]).us == 100'000 + first + second); // its facade sends requests too
    CHECK(plan.longest_gap(plan.polls[1]).us == 200'000 + second + first + 2 * command + stop);
    CHECK(plan.longest_gap(plan.controlled[0]).us == second + command); // a read, and its own frame
    CHECK(plan.longest_stop_pause().us == 100'000 + second + command);
    static constexpr auto hasty = two_with<quick, slow>({.stop_every = milliseconds(7)});
    CHECK(hasty.longest_stop_pause().us == 7'000 + second + 2 * command_of_both);
    static constexpr auto once = two_with<quick>({.stop_every = {}});
    CHECK(once.longest_stop_pause() == duration{0xFFFF'FFFF}); // stops are not repeated
    // and the stop itself: its drive's gap, and 13 bytes
    CHECK(plan.worst_case_stop_latency().us == in_flight + 4011 + 14'898);
    CHECK(plan.worst_case_stop_latency(3).us == in_flight + 4011 + 14'898 + 2 * stop_frame(of_quick, 4011));
    const std::uint32_t turn = first + second + 2 * command + stop;
    CHECK(plan.rediscovery_bound().us == 200'000 + 2 * (1'000'000 + turn));
    static constexpr auto soon = two_with<quick>({.retry_every = milliseconds(10)});
    CHECK(soon.rediscovery_bound(1).us == 200'000 + 10'000 + turn);
    // Without a facade the longest exchange in progress is a read whose response comes at the last moment.
    CHECK(two<>.worst_case_stop_latency().us == 9168 + 50'000 + 4011 + of_9 + 4011 + 14'898);
    CHECK(two<>.longest_gap(two<>.polls[0]).us == 100'000 + first + second);
    CHECK(two<>.longest_stop() == duration{});
    const auto& both = two<quick, slow>;
    CHECK(both.longest_gap(both.polls[0]).us ==
          100'000 + first + second + 2 * command_of_both + stop_of_both);
    CHECK(both.longest_gap(both.controlled[1]).us == second + 2 * command_of_both + stop_of_both);
}

namespace figures {
constexpr std::uint32_t silent = 6000 + 9168 + 50'000 + 150'000; // a read without a response
constexpr std::uint32_t silent_drive = 4011 + 9168 + of_quick + 150'000;
constexpr auto retrying = two_with<quick>({.retry_every = duration{silent}});
constexpr auto retrying_later = two_with<quick>({.retry_every = duration{silent + 1}});

// Of a drive at 9600 Bd whose image is one word, that is commanded and has a read.
consteval auto polled_with(back_off rules, duration commands) {
    return poll_plan{modbus::timing_at(9600),
                     cyclic<current, voltage>(node<slow>{slow::address}, milliseconds(200)),
                     controlled(node<quick>{quick::address},
                                {.feedback = milliseconds(100), .command_timeout = no_command_timeout})
                         .commands(commands),
                     rules};
}
constexpr auto polled = polled_with({}, {});
constexpr auto commanded = polled_with({}, milliseconds(200));
} // namespace figures

TEST_CASE("G28: what absent nodes and drives cost, and when they are found, to the microsecond") {
    CHECK(plan.absent_load_per_mille() == 216); // the facade reads nothing by itself
    CHECK(retrying.absent_load_per_mille() == 1000);
    CHECK(retrying_later.absent_load_per_mille() == 1000);
    CHECK(polled.absent_load_per_mille() == (silent + silent_drive) / 1000 + 1);
    CHECK(polled.retry_period() == milliseconds(1000)); // it is the only drive
    CHECK(two<quick, slow>.retry_period() == milliseconds(2000));
    const std::uint32_t own = second + command; // a read, and its own frame
    CHECK(polled.rediscovery_bound(0).us == 1'000'000 + own);
    CHECK(polled.rediscovery_bound(1).us == 200'000 + 1'000'000 + second + command + stop);
}

TEST_CASE("the load of a plan counts reads, images, witnesses and commands") {
    constexpr std::uint32_t read = 6000 + 9168 + 4011 + 10'314;
    constexpr std::uint32_t image = 4011 + 9168 + 4011 + 7 * 1146;
    constexpr std::uint32_t witness = 4011 + 9168 + 4011 + 9 * 1146;
    constexpr std::uint32_t write = 4011 + 14'898 + 4011 + 9168;
    CHECK(polled.load_per_mille() == (5 * read + 10 * image + 2 * witness) / 1000 + 1);
    CHECK(commanded.load_per_mille() == (5 * (read + write) + 10 * image + 2 * witness) / 1000 + 1);
}

namespace figures {
// A C630S, whose feedback is one word; the longest of its further blocks, of which one is read with every second
// refresh, has four.
constexpr poll_plan of_a_servo{modbus::timing_at(9600),
                               controlled(node<c630s::device>{1}, {.feedback = milliseconds(100),
                                                                   .command_timeout = no_command_timeout})};
} // namespace figures

TEST_CASE("the load of a drive whose feedback has further blocks counts the longest of them") {
    const auto read = [](std::uint32_t response) { return 4011 + 9168 + 4011 + response * 1146; };
    CHECK(of_a_servo.load_per_mille() == (10 * read(7) + 5 * read(13) + 2 * read(9)) / 1000 + 1);
}

namespace figures {
consteval auto watched_for(duration watchdog, duration feedback) {
    return poll_plan{
        modbus::timing_at(9600),
        controlled(node<watched>{1}, {.feedback = feedback, .command_timeout = milliseconds(300)})
            .keeps_alive(watchdog)};
}
} // namespace figures

TEST_CASE("G19: a facade reads a drive with a watchdog four times within it, and the plan counts a sixteenth "
          "less") {
    constexpr auto every_100_ms = watched_for(milliseconds(2000), milliseconds(100));
    CHECK(every_100_ms.controlled[0].keep_alive == milliseconds(1875));
    const std::uint32_t own = 4011 + 24'066 + 30'000 + 100'000 + 30'942 + 100'000;
    CHECK(every_100_ms.longest_gap(every_100_ms.controlled[0]).us == 100'000 + own);
    constexpr auto seldom = watched_for(milliseconds(2000), milliseconds(5000));
    CHECK(seldom.longest_gap(seldom.controlled[0]).us == 1'875'000 / 4 + own);
    CHECK(seldom.absent_load_per_mille() ==
          0); // its state is unknown before it is absent, and then it is not read
    constexpr auto not_read = watched_for(milliseconds(2000), {});
    CHECK(not_read.load_per_mille() == 0);
    CHECK(at_least(milliseconds(2000)) == milliseconds(1875));
    // As a program that does not know the times beforehand says it.
    static constexpr auto unchanged = controlled(node<watched>{1}, unsupervised);
    CHECK(unchanged.keeps_alive(milliseconds(2000)).keep_alive == milliseconds(1875));
    CHECK(unchanged.commands(milliseconds(30)).command_period == milliseconds(30));
    static constexpr auto without_watchdog = controlled(node<quick>{1}, unsupervised);
    CHECK(without_watchdog.keeps_alive(milliseconds(2000)).keep_alive == duration{});
}

TEST_CASE("G19, G25: the response limits of a drive that only its facade addresses count in a plan's times") {
    constexpr const auto& other = two<not_polled>;
    const std::uint32_t others_in_flight = 9168 + 80'000 + 9000 + of_27;
    CHECK(other.worst_case_stop_latency().us == others_in_flight + 9000 + 14'898);
    const std::uint32_t others_stop = 3 * (14'898 + 80'000 + 9000 + of_8 + 9000) + 300'000 + 9168 + 300'000;
    CHECK(other.longest_stop().us == others_stop);
    const std::uint32_t reads = 4011 + 9168 + 30'000 + 8022 + 6000 + 9168 + 50'000 + 10'314 + 4 * 300'000;
    const std::uint32_t others_command = 9000 + 24'066 + 80'000 + 300'000 + 30'942 + 300'000;
    CHECK(other.longest_gap(other.polls[0]).us == 100'000 + reads + 2 * others_command + others_stop);
}

namespace {
struct rig {
    tests::scripted_port port;
    scheduled_line<tests::scripted_port> wire{port, modbus::timing_at(9600)};
    bus<two<>, scheduled_line<tests::scripted_port>> all{wire};
    bool answers = true;

    rig() {
        port.character_us = 1146;
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) {
            if (answers)
                p.say(5000, tests::read_response(f.data[0], std::vector<std::uint16_t>(f.data[5], 0x0102)));
        };
    }
};
} // namespace

TEST_CASE("an idle bus wants to be stepped every 5 ms at least, or when the next read is due") {
    rig r;
    r.all.run_for(milliseconds(100));
    duration longest{};
    for (const std::uint64_t end = r.port.time + 300'000; r.port.time < end;) {
        const duration idle = r.all.step();
        if (r.wire.is_free()) longest = longer_of(longest, idle);
    }
    CHECK(longest == milliseconds(5));
}

TEST_CASE("G28: three failures in a row make a drive absent, and two after a good response do not") {
    rig r;
    r.all.run_for(milliseconds(500));
    REQUIRE(r.all.count(1) > 1);
    r.answers = false;
    const std::size_t asked = r.port.frames.size();
    std::size_t failed = 0;
    while (!r.all.is_absent(2)) {
        r.all.run_for(milliseconds(1));
        REQUIRE(r.port.frames.size() < asked + 20);
    }
    for (std::size_t i = asked; i < r.port.frames.size(); ++i) failed += r.port.frames[i].data[0] == 2;
    CHECK(failed == 3);
    r.answers = true;
    r.all.run_for(milliseconds(5'000));
    REQUIRE_FALSE(r.all.is_absent(2));
    const auto requests = [&] {
        return std::count_if(r.port.frames.begin(), r.port.frames.end(),
                             [](const auto& f) { return f.data[0] == 2; });
    };
    for (int round = 0; round < 4; ++round) {
        r.answers = false;
        for (const auto before = requests(); requests() < before + 2;) r.all.run_for(milliseconds(1));
        r.all.run_for(milliseconds(1)); // the second one is lost too
        r.answers = true;
        const auto good = r.all.count(1);
        for (int ms = 0; ms < 3'000 && r.all.count(1) == good; ++ms) {
            REQUIRE_FALSE(r.all.is_absent(2));
            r.all.run_for(milliseconds(1));
        }
        REQUIRE(r.all.count(1) > good);
    }
}

TEST_CASE("G19: a drive with a keep-alive becomes absent once its keep-alive has passed, and not before") {
    rig r;
    r.all.run_for(milliseconds(500));
    r.answers = false;
    const std::uint64_t begun = r.port.time;
    const std::size_t asked = r.port.frames.size();
    while (!r.all.is_absent(1)) {
        r.all.run_for(milliseconds(1));
        REQUIRE(r.port.time - begun < 2u * plan.polls[0].keep_alive.us);
    }
    CHECK(r.port.time - begun + plan.polls[0].period.us > plan.polls[0].keep_alive.us);
    std::size_t failed = 0;
    for (std::size_t i = asked; i < r.port.frames.size(); ++i) failed += r.port.frames[i].data[0] == 1;
    CHECK(failed > 3);
}

TEST_CASE("a facade reads three times in all by default") {
    static constexpr step look[] = {steps::fetch<status_word>(0)};
    tests::scripted_port port;
    scheduled_line<tests::scripted_port> wire{port, modbus::timing_at(9600)};
    node<quick> at{quick::address};
    at.limits.response = milliseconds(10);
    bare::drive drive{wire, at};
    CHECK(drive.run(bare::command{.steps = look}).error() == errc::timeout);
    CHECK(port.frames.size() == 3);
}

TEST_CASE("G29: an exchange that is not stepped any more holds the line for its whole time limit, to the "
          "microsecond") {
    for (const std::uint32_t kept : {0u, 1u}) {
        tests::scripted_port port;
        port.call_us = 0;
        port.character_us = 1146;
        scheduled_line<tests::scripted_port> wire{port, modbus::timing_at(9600)};
        const response_limits limits{.response = milliseconds(70)};
        const bus_gaps gaps{milliseconds(5), milliseconds(120)};
        const auto request = modbus::read_frame(1, 0x10, 1);
        std::array<std::uint8_t, 8> response{};
        modbus::exchange x{request, response, wire.timing(), limits};
        while (!wire.is_sending()) {
            (void)wire.step(x, gaps);
            ++port.time;
        }
        const std::uint64_t left = port.time - 1;
        const std::uint32_t lease = 240'000 + 512 * 1146        // the line is never quiet
                                    + 16 * 1146 + 20'000 + 4011 // the request
                                    + 70'000 + 7 * (20'000 + 1146);
        port.time = left + lease + kept;
        CHECK(wire.is_free() == (kept == 1));
    }
}

TEST_CASE("G29: the bound of a call is that of its gaps, its request and its response, to the microsecond") {
    tests::scripted_port port;
    scheduled_line<tests::scripted_port> wire{port, modbus::timing_at(9600)};
    const response_limits limits{.response = milliseconds(70)};
    const bus_gaps gaps{milliseconds(5), milliseconds(120)};
    // twice the quarantine and two frames; the request twice, with a pause and t3.5; the response byte by
    // byte
    const std::uint32_t busy = 240'000 + 512 * 1146;
    const std::uint32_t send = 16 * 1146 + 20'000 + 4011;
    CHECK(wire.bound(8, 7, limits, gaps).us == busy + send + 70'000 + 7 * (20'000 + 1146));
    const response_limits after_all{.response = milliseconds(1), .turnaround = milliseconds(90)};
    CHECK(wire.bound(8, 0, after_all, gaps).us == busy + send + 90'000);
    // A node's own gap may be the longest of all.
    CHECK(wire.bound(8, 0, after_all, bus_gaps{milliseconds(300), {}}).us ==
          600'000 + 512 * 1146 + send + 90'000);
}

TEST_CASE("G28: a silent node is not due twice in a window, however short a plan makes it") {
    for (const std::uint32_t window_ms : {1u, 50u, 130u, 500u}) {
        CAPTURE(window_ms);
        detail::other_requests others;
        REQUIRE(others.is_due(3, instant{10'000'000}, milliseconds(window_ms)));
        others.note(3, false);
        CHECK_FALSE(others.is_due(3, instant{10'000'100}, milliseconds(window_ms)));
    }
}

} // namespace figures_tests
