// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs of any function, on a line and on a blocking line, to a node whose figures can be changed and to one
// whose figures are constants.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace transact_tests {

using namespace servobus;
using namespace tests::typed;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct many_exchanges {
    using line = servobus::line<tests::waiting_scripted_port>;
    using node = servobus::node<device>;
    static line on(tests::waiting_scripted_port& port) { return line{port, timing}; }
};
template <class Node> struct blocking {
    using line = blocking_line<tests::waiting_scripted_port, timing>;
    using node = Node;
    static line on(tests::waiting_scripted_port& port) { return line{port}; }
};
using blocking_calls = blocking<servobus::node<device>>;
using constants = blocking<fixed_node<device, 1>>;

template <class Kind> struct setup {
    tests::waiting_scripted_port port;
    tests::register_file file;
    typename Kind::line on = Kind::on(port);
    client<typename Kind::line, device, typename Kind::node> drive{on, typename Kind::node{}};

    setup() {
        for (std::uint16_t a = 0x0100; a < 0x0110; ++a) file.words[a] = 0;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) { file(p, f); };
    }
    setup(const setup&) = delete;
    byte_list last() const { return port.frames.back().data; }
    void answer(const byte_list& frame) {
        port.device = [frame](scripted_port& p, const tests::sent_frame&) { p.say(500, frame); };
    }
};
} // namespace

#define TRANSACT_ON_EACH_LINE many_exchanges, blocking_calls, constants

TEST_CASE_TEMPLATE(
    "any PDU may be sent; its response fills the buffer exactly, or is refused before anything is sent", Kind,
    TRANSACT_ON_EACH_LINE) {
    setup<Kind> r;
    r.answer(framed({1, 0x41, 9, 8, 7}));
    std::array<std::uint8_t, 16> room{};
    room.fill(0xA5);
    CHECK(r.drive.transact(byte_list{0x41, 1, 2}, byte_buffer{room}.first(4)));
    CHECK(r.last() == framed({1, 0x41, 1, 2}));
    CHECK(room[0] == 0x41);
    CHECK(room[3] == 7);
    CHECK(room[4] == 0xA5);
    r.answer(tests::exception_response(1, 0x41, 77));
    const status refused = r.drive.transact(byte_list{0x41}, byte_buffer{room}.first(4));
    CHECK(refused.outcome() == outcome::refused);
    CHECK(refused.exception() == 77);
    CHECK(room[3] == 7);
    const std::size_t sent = r.port.frames.size();
    for (const byte_list& pdu :
         {byte_list{}, byte_list(254, 0x41), byte_list{0x80}, byte_list{0x83, 1}, byte_list{0, 1}})
        CHECK(r.drive.transact(pdu, byte_buffer{room}.first(4)).outcome() == outcome::not_sent);
    CHECK(r.drive.transact(byte_list{0x41}, byte_buffer{}).outcome() == outcome::not_sent);
    byte_list large(254);
    CHECK(r.drive.transact(byte_list{0x41}, large).outcome() == outcome::not_sent);
    CHECK(r.port.frames.size() == sent);
}

TEST_CASE_TEMPLATE("a PDU and its response fill the longest frame of the line, and no more", Kind,
                   TRANSACT_ON_EACH_LINE) {
    constexpr std::size_t longest = Kind::line::longest_frame - 3;
    static_assert(longest == (Kind::line::is_small ? 252 : 253));
    setup<Kind> r;
    byte_list pdu(longest, 0x5A);
    pdu[0] = 0x41;
    byte_list room(longest + 1);
    REQUIRE(r.drive.template read<fixture::time>()); // something that is no echo has arrived
    r.answer(framed(byte_list{1} + byte_list{0x41} + byte_list(longest - 1, 0x77)));
    CHECK(r.drive.transact(pdu, byte_buffer{room}.first(longest)));
    CHECK(r.last().size() == longest + 3);
    CHECK(room[longest - 1] == 0x77);
    CHECK(r.drive.transact(pdu, room) == errc::bad_argument);
    pdu.push_back(1);
    CHECK(r.drive.transact(pdu, byte_buffer{room}.first(longest)) == errc::bad_argument);
}

TEST_CASE_TEMPLATE(
    "a PDU of function 03, 06 or 10h has a response of its own length, and the buffer must have it", Kind,
    TRANSACT_ON_EACH_LINE) {
    setup<Kind> r;
    r.file.words[0x0101] = 0x1234;
    const byte_list read{0x03, 0x01, 0x01, 0, 1};
    const byte_list write{0x06, 0x01, 0x01, 0, 5};
    const byte_list write_two{0x10, 0x01, 0x01, 0, 1, 2, 0, 6};
    for (std::size_t size = 2; size <= 16; ++size) {
        CAPTURE(size);
        byte_list room(size, 0xA5);
        const std::size_t before = r.port.frames.size();
        const status a = r.drive.transact(read, room);
        CHECK(a.outcome() == (size == 4 ? outcome::done : outcome::not_sent));
        if (size == 4) CHECK(room == byte_list{0x03, 2, 0x12, 0x34});
        room.assign(size, 0xA5);
        CHECK(r.drive.transact(write, room).outcome() == (size == 5 ? outcome::done : outcome::not_sent));
        if (size == 5) CHECK(room == write);
        CHECK(r.drive.transact(write_two, room).outcome() == (size == 5 ? outcome::done : outcome::not_sent));
        CHECK(r.port.frames.size() == before + (size == 4 ? 1 : size == 5 ? 2 : 0));
        r.file.words[0x0101] = 0x1234;
    }
}

TEST_CASE_TEMPLATE("G2, G3, G10: what is no valid response to another function ends in its error, and the "
                   "buffer is as it was",
                   Kind, TRANSACT_ON_EACH_LINE) {
    const byte_list pdu{0x41, 0x12, 0x34};
    const byte_list good = framed({1, 0x41, 9, 8, 7});
    byte_list cut = good, spoilt = good;
    cut.pop_back();
    spoilt[3] ^= 1;
    struct wrong {
        byte_list answer;
        errc error;
    };
    const std::vector<wrong> wrongs{{{}, errc::timeout},
                                    {spoilt, errc::bad_crc},
                                    {cut, errc::truncated_response},
                                    {framed({1, 0x42, 9, 8, 7}), errc::wrong_function},
                                    {framed({2, 0x41, 9, 8, 7}), errc::timeout},
                                    {framed({1, 0x41, 0x12, 0x34}) + byte_list{0, 0}, errc::own_echo}};
    for (const wrong& w : wrongs) {
        CAPTURE(static_cast<int>(w.error));
        setup<Kind> r;
        r.answer(w.answer);
        byte_list room(w.error == errc::own_echo ? 5 : 4, 0xA5);
        const status is = r.drive.transact(pdu, room);
        CHECK(is.error() == w.error);
        CHECK(is.outcome() == outcome::unknown);
        CHECK(room == byte_list(room.size(), 0xA5));
        CHECK(r.port.frames.size() == 1); // never repeated
    }
    setup<Kind> r;
    r.answer(framed({1, 0x41, 0x12, 0x34})); // as Return Query Data is answered, or as the echo of an adapter
    byte_list room(3);
    CHECK(r.drive.transact(pdu, room) == errc::own_echo);
    r.port.device = [&r](scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    REQUIRE(r.drive.template read<fixture::time>());
    r.answer(framed({1, 0x41, 0x12, 0x34}));
    CHECK(r.drive.transact(pdu, room));
    CHECK(room == pdu);
}

} // namespace transact_tests
