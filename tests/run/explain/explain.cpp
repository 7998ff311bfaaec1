// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames in words: every kind of frame, every way in which it can be invalid, and text that does not fit.
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/explain/explain.hpp>

namespace explain_tests {

using namespace servobus;
using enum direction;

namespace {

struct said {
    std::string text;
    explanation what;
};

said say(direction way, bytes frame, bytes before = {}, const catalogue& map = zlac8015d::catalogue,
         word_order order = word_order::unknown) {
    char room[4096];
    const explanation e = explain(map, way, frame, before, room, order);
    return {std::string{room, e.size}, e};
}

// A frame around a PDU, with the right CRC.
template <std::size_t N>
std::array<std::uint8_t, N + 3> framed(std::uint8_t node_address, const std::uint8_t (&pdu)[N]) {
    std::array<std::uint8_t, N + 3> frame{node_address};
    for (std::size_t i = 0; i < N; ++i) frame[i + 1] = pdu[i];
    CHECK(modbus::close_frame(frame, N) == N + 3);
    return frame;
}

constexpr profile low_first_device{.name = "low", .word_order = word_order::low_first};
constexpr profile open_word_order_device{.name = "open", .word_order = word_order::unknown};
constexpr profile counting_device{.name = "counting", .limits = {.echoes_byte_count = true}};
constexpr catalogue low_first{&low_first_device, zlac8015d::catalogue.entries};
constexpr catalogue open_word_order{&open_word_order_device, zlac8015d::catalogue.entries};
constexpr catalogue counting{&counting_device, zlac8015d::catalogue.entries};

constexpr auto read_speeds = hex("01 03 20 AB 00 02 BE 2B");
constexpr auto speeds = hex("01 03 04 00 64 00 64 BA 07");

} // namespace

// These frames need no entry of a catalogue: with sanitizers, g++ does not accept the address of an array's
// element as a constant.
TEST_CASE("explain can be evaluated at compile time") {
    constexpr auto is_as_expected = [] {
        std::array<char, 128> room{};
        const explanation e = explain(zlac8015d::catalogue, response, speeds, std::span<char>{room});
        constexpr std::string_view expected = "node 1: response, 2 words 0x0064 0x0064";
        return e.is_valid() && std::string_view{room.data(), e.size} == expected;
    };
    static_assert(is_as_expected());
    CHECK(is_as_expected());
}

TEST_CASE("requests are explained with their registers and values") {
    CHECK(say(request, read_speeds).text ==
          "node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)");
    CHECK(say(request, modbus::write_frame(1, 0x2080, 500)).text ==
          "node 1: write left_acceleration_time (0x2080) = 500 ms");
    CHECK(say(request, hex("01 06 20 88 00 64 03 CB")).text ==
          "node 1: write left_target_speed (0x2088) = 100 r/min (at the factory's scale)");
    CHECK(say(request, hex("01 10 20 88 00 02 04 FF 9C FF 9C D2 0B")).text ==
          "node 1: write left_target_speed (0x2088) = -100 r/min, right_target_speed (0x2089) = -100 r/min "
          "(at the "
          "factory's scale)");
    CHECK(say(request, modbus::read_frame(1, 0x20A1, 1, modbus::function::read_input_registers)).text ==
          "node 1: read bus_voltage (0x20A1) as input registers");
}

TEST_CASE("values are written as decimal fractions, names, bits or halves") {
    CHECK(say(request, modbus::write_frame(1, 0x2034, 125)).text ==
          "node 1: write left_max_current (0x2034) = 12.5 A");
    CHECK(say(request, modbus::write_frame(1, 0x200E, 0x13)).text ==
          "node 1: write control_word (0x200E) = 0x0013 (outside 0..18)");
    CHECK(say(request, modbus::write_frame(1, 0x2016, 3)).text ==
          "node 1: write input_polarity (0x2016) = x0 + x1 (0x0003)");
    CHECK(say(request, modbus::write_frame(1, 0x2016, 0)).text ==
          "node 1: write input_polarity (0x2016) = 0x0000");
    const auto said = [](std::uint16_t address, std::uint8_t high, std::uint8_t low) {
        return say(response, framed(1, {0x03, 0x02, high, low}), modbus::read_frame(1, address, 1)).text;
    };
    CHECK(said(0x20A1, 0x09, 0x60) == "node 1: response, bus_voltage = 24.00 V");
    CHECK(said(0x20A4, 0xF6, 0x24) == "node 1: response, motor_temperature = left -10 degC / right 36 degC");
    CHECK(said(0x20A3, 0x05, 0x03) == "node 1: response, hall_state = left 5 / right 3");
    CHECK(said(0x20B0, 0xFF, 0xFB) == "node 1: response, driver_temperature = -0.5 degC");
    CHECK(said(0x20A5, 0x02, 0x01) == "node 1: response, left_faults = overvoltage + hall (0x0201)");
    CHECK(said(0x20A5, 0x10, 0x01) == "node 1: response, left_faults = overvoltage + 0x1000 (0x1001)");
    CHECK(said(0x20A5, 0x00, 0x00) == "node 1: response, left_faults = none (0x0000)");
    CHECK(said(0x20A2, 0x41, 0x80) ==
          "node 1: response, status_word = left locked + left running + right emergency stop (0x4180)");
}

TEST_CASE("32-bit values are read in the device's word order, or in the one that is given") {
    constexpr auto frame = hex("01 10 20 8A 00 02 04 FF FF B0 00 97 95");
    CHECK(say(request, frame).text == "node 1: write left_target_position (0x208A) = -20480 pulse");
    CHECK(say(request, frame, {}, low_first).text ==
          "node 1: write left_target_position (0x208A) = -1342111745 pulse");
    CHECK(say(request, frame, {}, open_word_order).text ==
          "node 1: write left_target_position (0x208A) = 0xFFFF 0xB000 (word order unknown)");
    CHECK(say(request, frame, {}, open_word_order, word_order::high_first).text ==
          "node 1: write left_target_position (0x208A) = -20480 pulse");
}

TEST_CASE("half of a 32-bit value is named as half of it") {
    CHECK(say(request, modbus::write_frame(1, 0x208A, 1)).text ==
          "node 1: write high word of left_target_position (0x208A) = 0x0001");
    CHECK(say(request, modbus::read_frame(1, 0x208B, 2)).text ==
          "node 1: read low word of left_target_position (0x208B), high word of right_target_position "
          "(0x208C)");
    CHECK(say(request, modbus::read_frame(1, 0x208A, 1), {}, low_first).text ==
          "node 1: read low word of left_target_position (0x208A)");
    CHECK(say(request, modbus::read_frame(1, 0x208B, 1), {}, open_word_order).text ==
          "node 1: read second word of left_target_position (0x208B)");
}

TEST_CASE("where the word order can be switched, a 32-bit value is read in the factory's, if the catalogue "
          "states it") {
    static constexpr profile switched{
        .name = "switched", .word_order = word_order::unknown, .word_order_register = 5};
    const auto speed_of = [](std::int64_t initial) {
        entry order{};
        order.address = 5;
        order.initial = initial;
        entry pair{};
        pair.address = 7;
        pair.name = "place";
        pair.kind = value_kind::unsigned_pair;
        pair.rights = access::rw;
        pair.limits = full<u32>;
        const std::array<entry, 2> entries{order, pair};
        const catalogue map{&switched, entries};
        const std::array<std::uint16_t, 2> words{0x0001, 0x0002};
        return say(request, modbus::write_frame(1, 7, words), {}, map).text + "; " +
               say(request, modbus::read_frame(1, 7, 1), {}, map).text + "; " +
               say(request, modbus::read_frame(1, 8, 1), {}, map).text;
    };
    const std::string halves = "; node 1: read first word of place (0x0007); node 1: read second word of "
                               "place (0x0008)";
    CHECK(speed_of(0) == "node 1: write place (0x0007) = 65538 (in the factory's word order)" + halves);
    CHECK(speed_of(1) == "node 1: write place (0x0007) = 131073 (in the factory's word order)" + halves);
    const std::string unknown_word_order =
        "node 1: write place (0x0007) = 0x0001 0x0002 (word order unknown)";
    for (const std::int64_t initial : {std::int64_t{-1}, std::int64_t{2}, no_default})
        CHECK(speed_of(initial) == unknown_word_order + halves);
}

TEST_CASE("a pair with a word order of its own is read in that one") {
    static constexpr profile mixed{
        .name = "mixed", .word_order = word_order::unknown, .word_order_register = 5};
    const auto said_with = [](word_order own) {
        entry order{};
        order.address = 5;
        order.initial = 0;
        entry pair{};
        pair.address = 7;
        pair.name = "place";
        pair.kind = value_kind::unsigned_pair;
        pair.limits = full<u32>;
        pair.own_word_order = own;
        const std::array<entry, 2> entries{order, pair};
        const catalogue map{&mixed, entries};
        const std::array<std::uint16_t, 2> words{0x0001, 0x0002};
        return say(request, modbus::write_frame(1, 7, words), {}, map).text + "; " +
               say(request, modbus::read_frame(1, 7, 1), {}, map).text;
    };
    CHECK(said_with(word_order::low_first) ==
          "node 1: write place (0x0007) = 131073 (read-only); node 1: read low word of place (0x0007)");
    CHECK(said_with(word_order::high_first) ==
          "node 1: write place (0x0007) = 65538 (read-only); node 1: read high word of place (0x0007)");
}

TEST_CASE("addresses that are not in the catalogue are explained as unknown registers") {
    CHECK(say(request, modbus::read_frame(1, 0x3000, 1)).text == "node 1: read unknown register (0x3000)");
    CHECK(say(request, modbus::read_frame(1, 0x20AF, 4)).text ==
          "node 1: read host_connected (0x20AF), driver_temperature (0x20B0), unknown registers "
          "(0x20B1..0x20B2)");
    CHECK(say(request, modbus::write_frame(1, 0x3000, std::array<std::uint16_t, 2>{1, 0xABCD})).text ==
          "node 1: write unknown registers (0x3000..0x3001) = 0x0001 0xABCD");
    CHECK(say(request, modbus::write_frame(1, 0x1FFF, std::array<std::uint16_t, 2>{7, 100})).text ==
          "node 1: write unknown register (0x1FFF) = 0x0007, host_timeout (0x2000) = 100 ms");
    CHECK(say(request, modbus::read_frame(1, 0xFFFF, 1)).what.is_valid());
}

TEST_CASE("a write that the device would refuse is explained with the reason") {
    CHECK(say(request, modbus::write_frame(1, 0x2034, 999)).text ==
          "node 1: write left_max_current (0x2034) = 99.9 A (outside 0.0..30.0)");
    CHECK(say(request, modbus::write_frame(1, 0x20A1, 1)).text ==
          "node 1: write bus_voltage (0x20A1) = 0.01 V (read-only)");
}

TEST_CASE("the explanation names the node that is addressed") {
    CHECK(say(request, modbus::write_frame(0, 0x200E, 7)).text ==
          "all nodes: write control_word (0x200E) = stop (0x0007)");
    CHECK(say(request, modbus::write_frame(250, 0x200E, 7)).text ==
          "node 250 (reserved): write control_word (0x200E) = stop (0x0007)");
    const said broadcast_read = say(request, framed(0, {0x03, 0x20, 0xA1, 0x00, 0x01}));
    CHECK(broadcast_read.text ==
          "all nodes: read bus_voltage (0x20A1) (invalid: a broadcast read gets no response)");
    CHECK(broadcast_read.what.why.error() == errc::bad_argument);
    CHECK(say(response, framed(0, {0x06, 0x20, 0x0E, 0x00, 0x07})).what.why.error() == errc::wrong_node);
}

TEST_CASE("responses are explained with and without their request") {
    CHECK(say(response, speeds).text == "node 1: response, 2 words 0x0064 0x0064");
    CHECK(say(response, speeds, read_speeds).text ==
          "node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min");
    CHECK(say(response, hex("01 10 20 88 00 02 CA 22")).text ==
          "node 1: response, left_target_speed (0x2088), right_target_speed (0x2089) written");
    CHECK(say(response, modbus::write_frame(1, 0x200D, 3)).text ==
          "node 1: response, mode_of_operation (0x200D) = velocity (0x0003) written");
}

TEST_CASE("exceptions are explained in the device's words") {
    const auto refused = framed(1, {0x83, 0x02});
    const said alone = say(unknown, refused);
    CHECK(alone.text == "node 1: response, exception 2 (illegal data address) to function 03");
    CHECK(alone.what.is_valid());
    CHECK(alone.what.why.exception() == 2);
    CHECK(alone.what.way == response);
    CHECK(say(response, refused, modbus::read_frame(1, 0x3000, 1)).text ==
          "node 1: response, exception 2 (illegal data address) to read unknown register (0x3000)");
    CHECK(say(response, framed(1, {0x90, 0x63})).text ==
          "node 1: response, exception 99 (unknown exception) to function 10h");
}

TEST_CASE("a response that does not match its request is reported") {
    const auto check = [](bytes frame, bytes before, errc expected,
                          const catalogue& map = zlac8015d::catalogue) {
        const said s = say(response, frame, before, map);
        CHECK(s.what.is_valid()); // the frame itself is sound
        CHECK(s.what.mismatch == expected);
        const bool says_so = s.text.find("no response to the request before it") != std::string::npos;
        CHECK(says_so == (expected != errc::ok));
    };
    constexpr auto write_one = modbus::write_frame(1, 0x200E, 8);
    constexpr auto write_two = hex("01 10 20 88 00 02 04 00 64 00 64 23 9C");
    check(speeds, read_speeds, errc::ok);
    check(speeds, modbus::read_frame(2, 0x20AB, 2), errc::wrong_node);
    check(speeds, write_one, errc::wrong_function);
    check(speeds, modbus::read_frame(1, 0x20AB, 3), errc::wrong_byte_count);
    check(modbus::write_frame(1, 0x200D, 8), write_one, errc::wrong_address);
    check(modbus::write_frame(1, 0x200E, 7), write_one, errc::wrong_value);
    check(framed(1, {0x10, 0x20, 0x88, 0x00, 0x03}), write_two, errc::wrong_quantity);
    check(framed(1, {0x10, 0x20, 0x88, 0x00, 0x04}), write_two, errc::wrong_quantity);
    check(framed(1, {0x10, 0x20, 0x88, 0x00, 0x04}), write_two, errc::ok, counting); // the device's deviation
    check(framed(1, {0x10, 0x20, 0x88, 0x00, 0x02}), write_two, errc::ok, counting);
    check(framed(1, {0x10, 0x20, 0x88, 0x00, 0x03}), write_two, errc::wrong_quantity, counting);
    check(speeds, hex("01 03 FF"), errc::ok); // an invalid request is not used
    CHECK(say(response, speeds, modbus::read_frame(1, 0x20AB, 3)).text ==
          "node 1: response, 2 words 0x0064 0x0064 (no response to the request before it: wrong byte count)");
}

TEST_CASE("without a direction both are tried") {
    CHECK(say(unknown, read_speeds).what.way == request);
    CHECK(say(unknown, speeds).what.way == response);
    CHECK(say(unknown, speeds, read_speeds).text ==
          "node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min");
    CHECK(say(unknown, hex("01 10 20 88 00 02 CA 22")).what.way == response);
    CHECK(say(unknown, hex("01 10 20 88 00 02 04 00 64 00 64 23 9C")).what.way == request);
    constexpr auto write_one = modbus::write_frame(1, 0x200E, 8);
    const said echo = say(unknown, write_one);
    CHECK(echo.text ==
          "node 1: write control_word (0x200E) = enable (0x0008) (request, or the response that echoes it)");
    CHECK(echo.what.way == unknown);
    CHECK(say(unknown, write_one, write_one).text == "node 1: write control_word (0x200E) = enable (0x0008) "
                                                     "(the request again, or the response that echoes it)");
    // A broadcast has no response, so it can only be a request.
    CHECK(say(unknown, modbus::write_frame(0, 0x200E, 8)).what.way == request);
}

TEST_CASE("a valid frame whose content is not known is said to be one, with its bytes") {
    const auto check = [](bytes frame, std::string_view text) {
        for (const direction way : {unknown, request, response}) {
            const said s = say(way, frame, read_speeds);
            CHECK(s.what.why.error() == errc::ok);
            CHECK(s.what.way == way);
            CHECK(s.what.mismatch == errc::ok);
            CHECK(s.text == text);
        }
    };
    check(framed(1, {0x14, 0x07, 0x06, 0x00, 0x04, 0x00, 0x01, 0x00, 0x02}),
          "node 1: valid frame of function 14h (read file record), data 07 06 00 04 00 01 00 02");
    check(framed(1, {0x15, 0x01, 0xFF}),
          "node 1: valid frame of function 15h (write file record), data 01 FF");
    check(framed(1, {0x2B, 0x0D, 0x01, 0x00}),
          "node 1: valid frame of function 2Bh (encapsulated interface), data 0D 01 00");
    check(framed(1, {0x08, 0x00, 0x05, 0x00, 0x00}),
          "node 1: valid frame of function 08 (diagnostics), data 00 05 00 00");
    check(framed(0, {0x65, 0x01}), "all nodes: valid frame of function 65h (user-defined), data 01");
    check(framed(1, {0x48}), "node 1: valid frame of function 48h (user-defined), no data");
    check(framed(1, {0x49}), "node 1: valid frame of function 49h (not in the standard), no data");
}

TEST_CASE("bytes that are no frame are reported as invalid") {
    const auto check = [](bytes frame, errc why, std::string_view text) {
        const said s = say(unknown, frame);
        CHECK(s.what.why.error() == why);
        CHECK_FALSE(s.what.is_valid());
        CHECK(s.text == text);
    };
    check({}, errc::too_short, "invalid: frame too short, 0 bytes");
    check(hex("01"), errc::too_short, "invalid: frame too short, 1 byte");
    check(hex("01 06 20 0E 00 08 E2 0E"), errc::bad_crc,
          "invalid: wrong CRC, ends in E2 0E, should be E2 0F");
    std::array<std::uint8_t, 257> long_one{};
    check(long_one, errc::too_long, "invalid: frame too long, 257 bytes");
}

TEST_CASE("a frame with a correct CRC may be invalid all the same") {
    const auto check = [](direction way, bytes frame, errc why, std::string_view text) {
        const said s = say(way, frame);
        CHECK(s.what.why.error() == why);
        CHECK(s.what.way == unknown);
        CHECK(s.text == text);
    };
    check(unknown, framed(1, {0x00, 0x0E, 0x01}), errc::wrong_function,
          "node 1: invalid: function 00, which does not exist");
    check(unknown, framed(1, {0x82, 0x02, 0x00}), errc::too_long,
          "node 1: invalid response to function 02 (read discrete inputs): frame too long");
    check(request, framed(1, {0x82, 0x02}), errc::wrong_function,
          "node 1: invalid request of function 02 (read discrete inputs): an exception is no request");
    check(request, framed(1, {0x83, 0x02}), errc::wrong_function,
          "node 1: invalid request of function 03: an exception is no request");
    check(unknown, framed(1, {0x03, 0x20, 0xA1, 0x00, 0x7E}), errc::wrong_quantity,
          "node 1: invalid request of function 03: wrong quantity 126");
    check(unknown, framed(1, {0x03, 0xFF, 0xFF, 0x00, 0x02}), errc::wrong_address,
          "node 1: invalid request of function 03: registers beyond 0xFFFF");
    check(unknown, framed(1, {0x10, 0xFF, 0xFF, 0x00, 0x02}), errc::wrong_address,
          "node 1: invalid response to function 10h: registers beyond 0xFFFF");
    check(unknown, framed(1, {0x03, 0x03, 0x00, 0x01, 0x02, 0x03}), errc::wrong_byte_count,
          "node 1: invalid response to function 03: wrong byte count 3 with 4 data bytes");
    check(request, hex("01 10 20 88 00 02 CA 22"), errc::too_short,
          "node 1: invalid request of function 10h: frame too short");
    check(response, read_speeds, errc::wrong_byte_count,
          "node 1: invalid response to function 03: wrong byte count 32 with 3 data bytes");
    check(request, framed(1, {0x06, 0x20, 0x0E, 0x00, 0x08, 0x00}), errc::too_long,
          "node 1: invalid request of function 06: frame too long");
    // A manual prints such a frame: 5 registers, byte count 12, 13 bytes.
    check(unknown, framed(1, {0x10, 0x20, 0x30, 0x00, 0x05, 0x0C, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}),
          errc::wrong_byte_count,
          "node 1: invalid request of function 10h: wrong byte count 12 with 13 data bytes for 5 registers");
}

TEST_CASE("an explanation that does not fit is cut and ends in dots") {
    const std::string whole = say(request, read_speeds).text;
    for (std::size_t size = 0; size <= whole.size() + 1; ++size) {
        std::string room(size + 4, '#');
        const explanation e =
            explain(zlac8015d::catalogue, request, read_speeds, std::span<char>{room.data(), size});
        CHECK(e.is_valid());
        CHECK(e.size == (size < whole.size() ? size : whole.size()));
        CHECK(room.substr(e.size, 1) == "#"); // nothing after the end
        if (size >= whole.size()) {
            CHECK(room.substr(0, e.size) == whole);
        } else if (size >= 3) {
            CHECK(room.substr(0, e.size) == whole.substr(0, size - 3) + "...");
        }
    }
}

TEST_CASE("whatever the bytes are, there is an explanation, and it fits") {
    std::uint32_t state = 1;
    const auto roll = [&state] {
        state = state * 1664525u + 1013904223u;
        return state >> 16;
    };
    constexpr std::uint8_t codes[] = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x0B, 0x0C, 0x0F,
                                      0x10, 0x11, 0x16, 0x17, 0x18, 0x2B, 0x83, 0x90, 0x41, 0x00};
    for (int i = 0; i < 20'000; ++i) {
        std::array<std::uint8_t, 260> frame{};
        for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(roll() & 0xFFu);
        frame[1] = codes[roll() % std::size(codes)];
        std::size_t size = roll() % 32 == 0 ? roll() % 257 : 2 + roll() % 16;
        if (roll() % 8 != 0 && size > 1) size = modbus::close_frame(frame, size - 1);
        const bytes all = bytes{frame}.first(size);
        char room[200];
        const auto way = static_cast<direction>(roll() % 3);
        const explanation e = explain(zlac8015d::catalogue, way, all, roll() % 2 == 0 ? all : bytes{}, room);
        CHECK(e.size > 0);
        CHECK(e.size <= sizeof room);
    }
}

TEST_CASE("numbers and quantities are written exactly") {
    const auto written = [](auto put) {
        char room[40];
        text_writer out{room};
        put(out);
        return std::string{room, out.size()};
    };
    CHECK(written([](text_writer& w) { w.scaled(-5, 1); }) == "-0.5");
    CHECK(written([](text_writer& w) { w.scaled(0, 2); }) == "0.00");
    CHECK(written([](text_writer& w) { w.scaled(12345, 2); }) == "123.45");
    CHECK(written([](text_writer& w) { w.number((std::numeric_limits<std::int64_t>::min)()); }) ==
          "-9223372036854775808");
    CHECK(written([](text_writer& w) { w.hex_word(0x0AF0); }) == "0x0AF0");
    const auto quantity = [&](unit u, std::int64_t count) {
        return written([&](text_writer& w) { put_count(w, count, u); });
    };
    CHECK(quantity(unit{measure::ampere, 1, 4}, 3) == "0.75");
    CHECK(quantity(unit{measure::ampere, 25, 1}, -3) == "-75");
    CHECK(quantity(unit{measure::ampere, 2, 20}, 7) == "0.7");
    CHECK(quantity(unit{measure::r_per_min, 1, 3}, 7) == "7/3"); // as a fraction if there is no exact decimal
}

} // namespace explain_tests
