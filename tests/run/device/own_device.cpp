// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A user's own device, outside the library's namespace: the example's header over a scripted port.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include <servobus/servobus.hpp>

#include <examples/own_device/own_device.hpp>
#include <tests/support/scripted_port.hpp>

namespace own_device_tests {

using tests::framed;

namespace {

using line_type = servobus::line<tests::waiting_scripted_port>;

struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    line_type line{port, servobus::modbus::timing_at(winch::device::facts.baud)};
    servobus::client<line_type, winch::device> drum{line, servobus::node<winch::device>{1}};

    rig() {
        port.character_us = 573;
        for (std::uint16_t a = 0; a < 0x0140; ++a) file.words[a] = 0;
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) { file(p, f); };
    }
    rig(const rig&) = delete;
    const tests::byte_list& last() const { return port.frames.back().data; }
};

static_assert(servobus::device_class<winch::device>);
static_assert(winch::device::facts.word_order == servobus::word_order::low_first);
static_assert(servobus::read_plan<winch::position, winch::load>.count == 1);
static_assert(servobus::at<winch::stops, 7>.address == 0x011C);

} // namespace

TEST_CASE("own device: constants and run-time values are written in the counts of its manual") {
    rig r;
    CHECK(r.drum.write<winch::control_word>(winch::control_code::turn));
    CHECK(r.port.frames.front().data == framed({1, 6, 0, 1, 0, 2}));
    CHECK(r.drum.write<winch::speed>(12 * winch::r_per_min));
    CHECK(r.last() == framed({1, 6, 0, 2, 0, 120}));
    int wanted = 9999;
    CHECK(r.drum.write<winch::speed>(servobus::clamped(wanted * winch::r_per_min)));
    CHECK(r.last() == framed({1, 6, 0, 2, 0x02, 0x58}));
    CHECK(r.drum.write<winch::limit>(servobus::checked(1500 * winch::milliampere)));
    CHECK(r.last() == framed({1, 6, 0, 4, 0, 15}));
    CHECK(r.drum.write<winch::ramp>(700));
    CHECK(r.last() == framed({1, 6, 0, 3, 0x02, 0xBC}));
    const std::size_t sent = r.port.frames.size();
    CHECK(r.drum.write<winch::ramp>(servobus::checked(9)).error() == servobus::errc::out_of_range);
    CHECK(r.drum.write<winch::limit>(servobus::checked(1550 * winch::milliampere)).error() ==
          servobus::errc::inexact);
    CHECK(r.port.frames.size() == sent);
}

TEST_CASE("own device: 32-bit values are sent low word first in one frame, also in arrays") {
    rig r;
    r.file.words[0x0011] = 0x5678;
    r.file.words[0x0012] = 0x1234;
    r.file.words[0x0010] = 42;
    const auto place = r.drum.read<winch::position>();
    REQUIRE(place);
    CHECK(place->count() == 0x1234'5678);
    const auto both = r.drum.read<winch::position, winch::load>();
    REQUIRE(both);
    CHECK(servobus::get<winch::load>(*both).in(winch::milliampere) == 4200);
    CHECK(servobus::get<winch::position>(*both).count() == 0x1234'5678);
    CHECK(r.port.frames.size() == 2);
    CHECK(r.last() == framed({1, 3, 0, 0x10, 0, 3}));
    CHECK(r.drum.write<winch::stops>(3, -100'000));
    CHECK(r.last() == framed({1, 0x10, 0x01, 0x0C, 0, 2, 4, 0x79, 0x60, 0xFF, 0xFE}));
    CHECK(r.drum.read<winch::stops>(3)->count() == -100'000);
    CHECK(r.drum.read<servobus::at<winch::stops, 3>>()->count() == -100'000);
    CHECK(r.drum.write<winch::stops>(8, 0).error() == servobus::errc::bad_argument);
}

TEST_CASE("own device: an exception has the words of its profile") {
    rig r;
    r.port.device = [](tests::scripted_port& p, const tests::sent_frame& f) {
        p.say(4000, tests::exception_response(1, f.data[1], 9));
    };
    const servobus::status w = r.drum.write<winch::control_word>(winch::control_code::turn);
    CHECK(w.outcome() == servobus::outcome::refused);
    CHECK(std::string{winch::device::facts.meaning(w.exception())} == "rope is slack");
}

TEST_CASE("own device: a node address that it cannot have is refused") {
    rig r;
    servobus::client<line_type, winch::device> other{r.line, servobus::node<winch::device>{32}};
    CHECK(other.read<winch::load>().error() == servobus::errc::bad_argument);
    CHECK(r.port.frames.empty());
}

} // namespace own_device_tests
