// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Typed access to a node's registers over a scripted port: values and units, one transaction for 32 bits,
// several registers in one request, and what is refused before anything is sent.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace client_tests {

using namespace servobus;
using namespace tests::typed;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::operator+;

TEST_CASE("a register is read as its own type, with its unit") {
    rig r;
    r.file.words[0x0100] = 1234;
    r.file.words[0x0101] = 0xFF38;
    r.file.words[0x0104] = 155;
    r.file.words[0x0105] = 2;
    r.file.words[0x0106] = 0xF61E;
    const auto time = r.drive.read<fixture::time>();
    REQUIRE(time);
    CHECK(time->count() == 1234);
    CHECK(time->in(units::millisecond) == 1234);
    CHECK(r.last() == framed({1, 3, 0x01, 0x00, 0, 1}));
    CHECK(r.drive.read<fixture::speed>()->count() == -200);
    CHECK(r.drive.read<fixture::current>()->in(units::milliampere) == 15'500);
    CHECK(*r.drive.read<fixture::lamp>() == fixture::colour::green);
    CHECK(*r.drive.read<fixture::heat>() == left_right<std::int8_t>{-10, 30});
    CHECK(*r.drive.read<fixture::state>() == 0xBEEF);
    CHECK(r.port.frames.size() == 6);
}

TEST_CASE("a register is written by function 06 with the value it was given") {
    rig r;
    CHECK(r.drive.read<fixture::time>()); // G3: before this read an acknowledgement may be an echo
    CHECK(r.drive.write<fixture::time>(500).outcome() == outcome::done);
    CHECK(r.last() == framed({1, 6, 0x01, 0x00, 0x01, 0xF4}));
    CHECK(r.drive.write<fixture::speed>(-300));
    CHECK(r.last() == framed({1, 6, 0x01, 0x01, 0xFE, 0xD4}));
    CHECK(r.drive.write<fixture::current>(1500 * units::milliampere));
    CHECK(r.last() == framed({1, 6, 0x01, 0x04, 0x00, 0x0F}));
    CHECK(r.drive.write<fixture::lamp>(fixture::colour::green));
    CHECK(r.last() == framed({1, 6, 0x01, 0x05, 0x00, 0x02}));
    CHECK(r.drive.write<fixture::heat>(left_right<std::int8_t>{-1, 2}));
    CHECK(r.last() == framed({1, 6, 0x01, 0x06, 0xFF, 0x02}));
    CHECK(r.port.frames.size() == 6);
}

TEST_CASE("a value that does not fit is not sent") {
    rig r;
    for (const int v : {-301, 301, 32'768, -32'769, 65'535, 1 << 30}) {
        const status w = r.drive.write<fixture::speed>(checked(v));
        CHECK(w.outcome() == outcome::not_sent);
        CHECK(w.error() == errc::out_of_range);
    }
    const status w = r.drive.write<fixture::current>(checked(1550 * units::milliampere));
    CHECK(w.outcome() == outcome::not_sent);
    CHECK(w.error() == errc::inexact);
    CHECK(r.drive.write<fixture::steps>(0, checked(101)).error() == errc::out_of_range);
    CHECK(r.drive.broadcast<fixture::speed>(checked(301)).error() == errc::out_of_range);
    CHECK((r.drive.write<fixture::time, fixture::speed>(checked(1), checked(400)).error() ==
           errc::out_of_range));
    CHECK((r.drive.write<fixture::time, fixture::speed>(checked(9999), checked(4)).error() ==
           errc::out_of_range));
    CHECK(r.port.frames.empty());
    CHECK(r.drive.read<fixture::time>());
    int far = 1 << 30;
    CHECK(r.drive.write<fixture::speed>(clamped(far)));
    CHECK(r.last() == framed({1, 6, 0x01, 0x01, 0x01, 0x2C}));
}

TEST_CASE("G22, G23: a 32-bit value is one transaction in the node's word order, both ways") {
    for (const word_order order : {word_order::high_first, word_order::low_first}) {
        for (const i32 value :
             {0, 1, -1, 0x1234'5678, -0x1234'5678, 0x7FFF'FFFF, i32{-0x7FFF'FFFF} - 1, 0x8000, 0x10000}) {
            CAPTURE(value);
            rig<switchable> r;
            r.drive.node().word_order = order;
            const auto bits = static_cast<u32>(value);
            const unsigned high = bits >> 16;
            const unsigned low = bits & 0xFFFFu;
            const unsigned first = order == word_order::high_first ? high : low;
            const unsigned second = order == word_order::high_first ? low : high;
            using tests::high_byte, tests::low_byte;
            REQUIRE(r.drive.write<fixture::place>(checked(value)));
            CHECK(r.port.frames.size() == 1);
            CHECK(r.last() == framed({1, 0x10, 0x01, 0x02, 0, 2, 4, high_byte(first), low_byte(first),
                                      high_byte(second), low_byte(second)}));
            const auto back = r.drive.read<fixture::place>();
            REQUIRE(back);
            CHECK(back->count() == value);
            CHECK(r.port.frames.size() == 2);
            CHECK(r.last() == framed({1, 3, 0x01, 0x02, 0, 2}));
            const auto both = r.drive.read<fixture::word, fixture::place>();
            REQUIRE(both);
            CHECK(get<fixture::place>(*both).count() == value);
            CHECK(r.port.frames.size() == 3);
            REQUIRE(r.drive.write<fixture::places>(1, checked(value % 1000)));
            CHECK(r.drive.read<fixture::places>(1)->count() == value % 1000);
            CHECK(r.port.frames.size() == 5);
            REQUIRE((r.drive.write<fixture::place, fixture::word>(checked(value), 7)));
            CHECK(r.last() == framed({1, 0x10, 0x01, 0x02, 0, 3, 6, high_byte(first), low_byte(first),
                                      high_byte(second), low_byte(second), 0, 7}));
        }
    }
}

TEST_CASE("G22: while the word order is unknown, no frame with a 32-bit value is sent") {
    rig<switchable> r;
    REQUIRE(r.drive.node().word_order == word_order::unknown);
    CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.drive.read<fixture::places>(2).error() == errc::needs_word_order);
    CHECK((r.drive.read<fixture::word, fixture::place>().error() == errc::needs_word_order));
    for (const status w :
         {r.drive.write<fixture::place>(1), r.drive.write<fixture::places>(0, 1),
          r.drive.write<fixture::place, fixture::word>(1, 2), r.drive.broadcast<fixture::place>(1)}) {
        CHECK(w.error() == errc::needs_word_order);
        CHECK(w.outcome() == outcome::not_sent);
    }
    CHECK(r.port.frames.empty());
    CHECK(r.drive.read<fixture::word>()); // 16 bits need no word order
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("several registers are read in the fewest requests, and only what was asked for") {
    rig r;
    r.file.words[0x0100] = 100;
    r.file.words[0x0101] = 0xFFFF;
    r.file.words[0x0102] = 0x0001;
    r.file.words[0x0103] = 0x0002;
    r.file.words[0x0104] = 4;
    const auto v = r.drive.read<fixture::state, fixture::position, fixture::time, fixture::speed>();
    REQUIRE(v);
    CHECK(v->get<fixture::time>().count() == 100);
    CHECK(v->get<fixture::speed>().count() == -1);
    CHECK(v->get<fixture::position>().count() == 0x10002);
    CHECK(v->get<fixture::state>() == 0xBEEF);
    REQUIRE(r.port.frames.size() == 2);
    CHECK(r.port.frames[0].data == framed({1, 3, 0x01, 0x00, 0, 4}));
    CHECK(r.port.frames[1].data == framed({1, 3, 0x02, 0x00, 0, 1}));
    // Not across 0x0104, and not more than the device gives in one frame.
    r.port.frames.clear();
    CHECK((r.drive.read<fixture::lamp, fixture::speed, fixture::position>()));
    REQUIRE(r.port.frames.size() == 2);
    CHECK(r.port.frames[0].data == framed({1, 3, 0x01, 0x01, 0, 3}));
    CHECK(r.port.frames[1].data == framed({1, 3, 0x01, 0x05, 0, 1}));
    r.port.frames.clear();
    CHECK(
        (r.drive.read<fixture::time, fixture::speed, fixture::position, fixture::current, fixture::lamp>()));
    REQUIRE(r.port.frames.size() == 2);
    CHECK(r.port.frames[0].data == framed({1, 3, 0x01, 0x00, 0, 4}));
    CHECK(r.port.frames[1].data == framed({1, 3, 0x01, 0x04, 0, 2}));
}

TEST_CASE("if one of several requests fails there is no result, and no further request is sent") {
    rig r;
    r.file.words.erase(0x0100);
    const auto v = r.drive.read<fixture::state, fixture::time>();
    CHECK_FALSE(v);
    CHECK(v.error() == errc::exception);
    CHECK(v.exception() == 2);
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("several adjacent registers are written in one frame, all or nothing") {
    rig r;
    REQUIRE((r.drive.write<fixture::time, fixture::speed, fixture::position>(1000, -2, -3)));
    CHECK(r.port.frames.size() == 1);
    CHECK(r.last() == framed({1, 0x10, 0x01, 0x00, 0, 4, 8, 0x03, 0xE8, 0xFF, 0xFE, 0xFF, 0xFF, 0xFF, 0xFD}));
}

TEST_CASE("an element of an array of rows is read and written at its own address, and none beyond the last") {
    rig r;
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(r.drive.read<fixture::steps>(i)->count() == static_cast<i16>(6 * i));
        CHECK(r.drive.write<fixture::steps>(i, checked(static_cast<int>(i) - 50)));
        CHECK(r.file.words[static_cast<std::uint16_t>(0x0300 + 6 * i)] == static_cast<u16>(i - 50));
        CHECK(r.drive.read<fixture::steps>(i)->count() == static_cast<i16>(i) - 50);
    }
    CHECK(r.drive.read<at<fixture::steps, 2>>()->count() == -48);
    const std::size_t sent = r.port.frames.size();
    for (const std::size_t i : {std::size_t{4}, std::size_t{5}, std::size_t{10'923}, ~std::size_t{0}}) {
        CHECK(r.drive.read<fixture::steps>(i).error() == errc::bad_argument);
        CHECK(r.drive.write<fixture::steps>(i, 1).error() == errc::bad_argument);
    }
    CHECK(r.port.frames.size() == sent);
}

TEST_CASE("raw registers: the device's limits apply, and a failure leaves the caller's words as they were") {
    rig r;
    std::array<u16, 8> words{1, 2, 3, 4, 5, 6, 7, 8};
    const std::array<u16, 8> before = words;
    const std::span<u16> all{words};
    CHECK(r.drive.read_words(0x0300, all.first(0)).error() == errc::bad_argument);
    CHECK(r.drive.read_words(0x0300, all.first(5)).error() == errc::bad_argument);
    CHECK(r.drive.read_words(0xFFFF, all.first(2)).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0x0300, all.first(0)).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0x0300, all.first(7)).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0xFFFE, all.first(3)).error() == errc::bad_argument);
    CHECK(r.port.frames.empty());
    CHECK(r.drive.read_words(0x1000, all.first(4)) == status::sent(errc::exception, 2));
    CHECK(words == before);
    CHECK(r.drive.read_words(0x0300, all.first(4)).error() == errc::ok);
    CHECK(words == std::array<u16, 8>{0, 1, 2, 3, 5, 6, 7, 8});
    CHECK(r.drive.read_words(0x0304, all.first(1), modbus::function::read_input_registers).error() ==
          errc::ok);
    CHECK(r.last() == framed({1, 4, 0x03, 0x04, 0, 1}));
    CHECK(words[0] == 4);
    CHECK(r.drive.write_word(0x0300, 0xABCD));
    CHECK(r.last() == framed({1, 6, 0x03, 0x00, 0xAB, 0xCD}));
    CHECK(r.drive.write_words(0x0301, all.first(2)));
    CHECK(r.last() == framed({1, 0x10, 0x03, 0x01, 0, 2, 4, 0, 4, 0, 1}));
    CHECK(r.drive.write_words(0x0300, all.first(6))); // as many as the device takes
    CHECK(r.last().size() == 9 + 12);
    const std::size_t sent = r.port.frames.size();
    CHECK(
        r.drive.write_words(0xFFFE, all.first(2)).was_sent()); // the last addresses, which the device has not
    CHECK(r.drive.read_words(0xFFFC, all.first(4)).was_sent());
    CHECK(r.port.frames.size() >= sent + 2);
}

TEST_CASE("raw registers of an array of any kind, and of one that is longer than the device's limits") {
    rig r;
    u16 plain[3]{};
    std::array<u16, 3> array{};
    std::span<u16, 3> fixed{array};
    CHECK(r.drive.read_words(0x0300, plain));
    CHECK(plain[2] == 2);
    CHECK(r.drive.read_words(0x0301, array));
    CHECK(array == std::array<u16, 3>{1, 2, 3});
    CHECK(r.drive.read_words(0x0302, fixed));
    CHECK(array == std::array<u16, 3>{2, 3, 4});
    std::span<u16> any{array};
    CHECK(r.drive.read_words(0x0304, any, modbus::function::read_input_registers));
    CHECK(r.last() == framed({1, 4, 0x03, 0x04, 0, 3}));
    CHECK(array == std::array<u16, 3>{4, 5, 6});
    CHECK(r.drive.write_words(0x0300, plain));
    CHECK(r.last() == framed({1, 0x10, 0x03, 0x00, 0, 3, 6, 0, 0, 0, 1, 0, 2}));
    CHECK(r.drive.write_words(0x0300, array));
    CHECK(r.last() == framed({1, 0x10, 0x03, 0x00, 0, 3, 6, 0, 4, 0, 5, 0, 6}));
    CHECK(r.drive.write_words(0x0300, any));
    std::array<u16, 1> one{7};
    CHECK(r.drive.write_words(0x0300, one));
    CHECK(r.last() == framed({1, 0x10, 0x03, 0x00, 0, 1, 2, 0, 7}));
    CHECK(r.drive.read_words(0x0300, one));
    CHECK(one[0] == 7);
    const std::size_t sent = r.port.frames.size();
    std::array<u16, 0> none{};
    CHECK(r.drive.read_words(0x0300, none).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0x0300, none).error() == errc::bad_argument);
    std::array<u16, 7> too_many{};
    CHECK(r.drive.read_words(0x0300, too_many).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0x0300, too_many).error() == errc::bad_argument);
    CHECK(r.drive.write_words(0xFFFE, array).error() == errc::bad_argument);
    CHECK(r.drive.read_words(0xFFFE, array).error() == errc::bad_argument);
    CHECK(r.port.frames.size() == sent);
}

TEST_CASE("G32: a raw read by a function that writes is refused, on each line and stepped") {
    rig r;
    std::array<u16, 3> words{};
    constexpr modbus::function writes = modbus::function::write_single_register;
    SUBCASE("on a line") { CHECK(r.drive.read_words(0x0100, words, writes) == errc::bad_argument); }
    SUBCASE("on a blocking line") {
        blocking_line<tests::waiting_scripted_port, modbus::timing_at(115200)> on{r.port};
        client drive{on, node<fixture::device>{1}};
        CHECK(drive.read_words(0x0100, words, writes) == errc::bad_argument);
    }
    SUBCASE("stepped") {
        stepped_read_words<decltype(r.drive), 3> call{r.drive};
        CHECK(call.begin(0x0100, 3, writes) == errc::bad_argument);
        for (int i = 0; i < 1000; ++i, r.port.time += 100) call.step();
    }
    CHECK(r.port.frames.empty());
    CHECK(r.file.words[0x0100] == 0);
}

TEST_CASE("an address that this kind of device cannot have is refused before sending") {
    for (const unsigned node_address : {0u, 100u, 247u, 248u, 255u}) {
        rig r{static_cast<std::uint8_t>(node_address)};
        std::array<u16, 1> word{};
        CHECK(r.drive.read<fixture::time>().error() == errc::bad_argument);
        CHECK((r.drive.read<fixture::time, fixture::state>().error() == errc::bad_argument));
        CHECK(r.drive.read_words(1, word).error() == errc::bad_argument);
        CHECK(r.drive.write<fixture::time>(1).error() == errc::bad_argument);
        CHECK(r.drive.write<fixture::position>(1).error() == errc::bad_argument);
        CHECK(r.drive.write_word(1, 1).outcome() == outcome::not_sent);
        CHECK(r.drive.write_words(1, word).outcome() == outcome::not_sent);
        std::array<std::uint8_t, 4> response{};
        CHECK(r.drive.transact(byte_list{0x41}, response).outcome() == outcome::not_sent);
        CHECK(r.port.frames.empty());
    }
}

TEST_CASE("G30: a broadcast is one frame to address 0, done after the turnaround; a broadcast read does not "
          "exist") {
    rig r;
    const auto begun = r.port.time;
    CHECK(r.drive.broadcast<fixture::time>(77).outcome() == outcome::done);
    CHECK(r.last() == framed({0, 6, 0x01, 0x00, 0, 77}));
    CHECK(r.file.words[0x0100] == 77);
    CHECK(r.port.time >= r.port.frames[0].end + 10'000);
    CHECK(r.port.time - begun < 125'000);
    CHECK(r.drive.broadcast<fixture::position>(-1));
    CHECK(r.last() == framed({0, 0x10, 0x01, 0x02, 0, 2, 4, 0xFF, 0xFF, 0xFF, 0xFF}));
    CHECK(r.port.frames.size() == 2);
}

TEST_CASE("a byte count in place of the quantity is accepted only from a device whose limits allow it") {
    rig r;
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) {
        p.say(500, framed({1, 0x10, f.data[2], f.data[3], 0, 4}));
    };
    CHECK(r.drive.write<fixture::position>(1).error() == errc::wrong_quantity);
    r.drive.node().limits.echoes_byte_count = true;
    CHECK(r.drive.write<fixture::position>(1).outcome() == outcome::done);
}

TEST_CASE("every error and outcome has its own text") {
    std::vector<std::string> seen;
    for (unsigned e = 0; std::string{text(static_cast<errc>(e))} != "unknown error"; ++e) {
        const std::string words = text(static_cast<errc>(e));
        for (const std::string& other : seen) CHECK(words != other);
        seen.push_back(words);
    }
    CHECK(seen.size() > static_cast<unsigned>(errc::not_reached));
    for (auto e = static_cast<unsigned>(seen.size()); e < 256; ++e)
        CHECK(std::string{text(static_cast<errc>(e))} == "unknown error");
    for (unsigned e = 1; e < seen.size(); ++e) {
        const auto code = static_cast<errc>(e);
        const bool is_exception = code == errc::exception;
        CHECK(status{code}.outcome() == (is_exception ? outcome::refused : outcome::not_sent));
        CHECK(status::sent(code).outcome() == (is_exception ? outcome::refused : outcome::unknown));
    }
    CHECK(status{}.outcome() == outcome::done);
    CHECK(std::string{text(outcome::done)} == "done");
    CHECK(std::string{text(outcome::unknown)} == "unknown");
}

} // namespace client_tests
