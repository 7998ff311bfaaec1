// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The identification of a device over both lines: in one part and in several, with parts that are lost, of a device
// that refuses, that begins again, or that has more than there is room for.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include <servobus/client/identification.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace identification_tests {

using namespace servobus;
using namespace tests::typed;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(19200);

struct any_line {
    using type = servobus::line<tests::waiting_scripted_port, counters, unechoed, modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port, timing}; }
};
struct small_line {
    using type = blocking_line<tests::waiting_scripted_port, timing, milliseconds(100), modbus::default_crc,
                               modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port}; }
};

byte_list text(std::uint8_t id, const std::string& words) {
    byte_list object{id, static_cast<std::uint8_t>(words.size())};
    object.insert(object.end(), words.begin(), words.end());
    return object;
}
byte_list part(std::uint8_t more, std::uint8_t next, std::uint8_t count, const byte_list& objects) {
    return framed(byte_list{1, 0x2B, 0x0E, 2, 0x82, more, next, count} + objects);
}

template <class Kind> struct setup {
    tests::waiting_scripted_port port;
    typename Kind::type on = Kind::on(port);
    client<typename Kind::type, device> drive{on, node<device>{1}};
    std::vector<byte_list> script; ///< the responses, in turn; an empty one is lost
    std::vector<std::string> seen;
    std::vector<unsigned> asked; ///< objects

    setup() {
        port.device = [this](scripted_port& p, const sent_frame& f) {
            REQUIRE(f.data.size() == 7);
            asked.push_back(f.data[4]);
            const std::size_t number = p.frames.size() - 1;
            if (number < script.size() && !script[number].empty()) p.say(500, script[number]);
        };
    }
    setup(const setup&) = delete;
    status read() {
        return read_identification(
            drive, modbus::identification::regular, [this](const modbus::identification_object& o) {
                seen.push_back(std::to_string(o.id) + " " + std::string{o.value.begin(), o.value.end()});
            });
    }
};
} // namespace

TEST_CASE_TEMPLATE("an identification is read part by part, and a lost part is asked for again", Kind,
                   any_line, small_line) {
    setup<Kind> r;
    r.script = {part(0xFF, 2, 2, text(0, "Acme") + text(1, "P-1")),
                {},
                part(0, 0, 2, text(2, "V2") + text(4, "pump"))};
    CHECK(r.read());
    CHECK(r.seen == std::vector<std::string>{"0 Acme", "1 P-1", "2 V2", "4 pump"});
    CHECK(r.asked == std::vector<unsigned>{0, 2, 2});
}

TEST_CASE_TEMPLATE("each part of an identification may be asked for three times", Kind, any_line,
                   small_line) {
    setup<Kind> r;
    r.script = {{}, {}, part(0xFF, 1, 1, text(0, "Acme")), {}, {}, part(0, 0, 1, text(1, "P-1"))};
    CHECK(r.read());
    CHECK(r.seen == std::vector<std::string>{"0 Acme", "1 P-1"});
    CHECK(r.asked == std::vector<unsigned>{0, 0, 0, 1, 1, 1});
    setup<Kind> lost;
    lost.script = {{}, part(0xFF, 1, 1, text(0, "Acme"))};
    CHECK(lost.read().error() == errc::timeout);
    CHECK(lost.asked == std::vector<unsigned>{0, 0, 1, 1, 1});
}

TEST_CASE_TEMPLATE("a device that refuses, or is not there, has no identification", Kind, any_line,
                   small_line) {
    setup<Kind> r;
    r.script = {framed({1, 0xAB, 1})};
    const status refused = r.read();
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 1);
    CHECK(r.asked.size() == 1);
    setup<Kind> absent;
    CHECK(absent.read().error() == errc::timeout);
    CHECK(absent.asked.size() == 3);
    CHECK((r.seen.empty() && absent.seen.empty()));
}

TEST_CASE_TEMPLATE("an identification that begins again ends with an error", Kind, any_line, small_line) {
    setup<Kind> r;
    r.script = {part(0xFF, 2, 1, text(0, "Acme")), part(0xFF, 1, 1, text(0, "Acme"))};
    CHECK(r.read().error() == errc::unexpected_value);
    CHECK(r.asked.size() == 2);
    CHECK(r.seen.size() == 1);
}

TEST_CASE(
    "the longest part fits a line; a blocking line, whose frames have 255 bytes, says that it is too long") {
    const byte_list longest = part(0, 0, 1, text(0, std::string(244, 'x')));
    REQUIRE(longest.size() == 256);
    setup<any_line> r;
    r.script = {longest};
    CHECK(r.read());
    CHECK(r.seen.at(0).size() == 246);
    setup<small_line> s;
    s.script = {longest, longest, longest};
    CHECK(s.read().error() == errc::too_long);
    CHECK(s.seen.empty());
}

} // namespace identification_tests
