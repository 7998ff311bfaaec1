// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Adapters that receive what they send, also those that do so only while no drive responds. G3: a line that only echoes
// never reports a success, whatever the echo setting. G4: a line with echo handling removes exactly what it sent, and
// reports what is wrong with an echo.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/client/client.hpp>
#include <servobus/device/c630s/drive.hpp>
#include <servobus/device/yako/drive.hpp>
#include <servobus/device/zlac8015d/drive.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/scripted_port.hpp>

namespace echo_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;

namespace {

struct device {
    static constexpr profile facts{.name = "any", .word_order = word_order::high_first, .read_retries = 0};
};
inline constexpr reg<u16, access::rw, device> speed{0x0100, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> other_speed{0x0101, full<u16>, no_unit, 0};

enum class adapter { silent, clean, late };

template <class Echo = unechoed, class Port = waiting_scripted_port> struct rig {
    Port port;
    tests::register_file file;
    line<Port, counters, Echo> on{port, modbus::timing_at(115200)};
    client<line<Port, counters, Echo>, device> drive{on, node<device>{1}};

    /// `late`: the port did not keep its contract, or could not, and the echo arrives after `sent()`.
    explicit rig(adapter a) {
        port.echoes = a != adapter::silent;
        port.keeps_echo = has_local_echo<Echo> || a == adapter::late;
        port.echo_late_us = a == adapter::late ? 3000 : 0;
    }
    rig(const rig&) = delete;
    void connect() {
        file.words[0x0100] = file.words[0x0101] = 0;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) { file(p, f); };
    }
};

// An adapter that returns each request that no node responds to, and two nodes.
template <class Line> struct returning_rig {
    waiting_scripted_port port;
    tests::register_file file;
    bool is_1_there = true;
    bool is_2_there = true;
    Line on;
    client<Line, device> drive{on, node<device>{1}};
    client<Line, device> other{on, node<device>{2}};

    returning_rig() requires(Line::is_small) : on{port} { begin(); }
    returning_rig() requires(!Line::is_small) : on{port, modbus::timing_at(115200)} { begin(); }
    returning_rig(const returning_rig&) = delete;
    void begin() {
        for (const u16 a : {u16{0x0100}, u16{0x0101}}) file.words[a] = 0;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) {
            const std::uint8_t to = f.data[0];
            const bool is_there = (to == 1 && is_1_there) || (to == 2 && is_2_there);
            p.say(500, is_there ? file.response_to(f.data) : f.data);
        };
    }
    /// The functions of the frames that were sent since the last call.
    byte_list sent() {
        byte_list all;
        for (const tests::sent_frame& f : port.frames) all.push_back(f.data[1]);
        port.frames.clear();
        return all;
    }
};
using returning_line = line<waiting_scripted_port>;
using returning_blocking_line = blocking_line<waiting_scripted_port, modbus::timing_at(115200)>;

// The reads of one register whose own echo, without its last byte, is a well-formed response.
template <class Found> int echoes_that_look_like_answers(Found&& found) {
    int count = 0;
    for (unsigned node_address = 1; node_address <= 247; ++node_address) {
        for (unsigned low = 0; low <= 0xFF; ++low) {
            const byte_list request =
                framed({tests::low_byte(node_address), 0x03, 0x02, tests::low_byte(low), 0x00, 0x01});
            if (tests::crc_of(bytes{request}.first(7)) != 0) continue;
            ++count;
            found(request);
        }
    }
    return count;
}

} // namespace

TEST_CASE("G3: an echo that is a well-formed response is distinguished from a response by what follows it") {
    const modbus::rtu_timing timing = modbus::timing_at(115200);
    const response_limits limits;
    const int found = echoes_that_look_like_answers([&](const byte_list& request) {
        for (const std::size_t piece : {1u, 3u, 7u, 8u}) {
            std::array<std::uint8_t, 7> room{};
            modbus::exchange x{request, room, timing, limits};
            x.sent({});
            for (std::size_t at = 0; at < request.size(); at += piece)
                x.feed(bytes{request}.subspan(at, std::min(piece, request.size() - at)), {1000});
            CHECK(x.status().error() == errc::own_echo);
        }
        // A device that sends these seven bytes and no more has responded.
        std::array<std::uint8_t, 7> room{};
        modbus::exchange x{request, room, timing, limits};
        x.sent({});
        CHECK(x.feed(bytes{request}.first(7), {1000}) == 7);
        CHECK_FALSE(x.done());
        x.elapse({1000 + timing.longest_gap(1).us + timing.wire_time(1).us});
        CHECK(x.done());
        CHECK(x.status().error() == errc::ok);
        CHECK(x.words()[0] == (request[3] << 8));
    });
    CHECK(found == 248);
}

TEST_CASE("G3, G6: an echo followed by zeros is no response, although its CRC still fits") {
    const modbus::rtu_timing timing = modbus::timing_at(115200);
    const response_limits limits;
    for (unsigned words = 2; words <= 125; ++words) {
        const byte_list request = framed({1, 3, tests::low_byte(2 * words), 0x10, 0, tests::low_byte(words)});
        byte_list said = request;
        said.resize(5 + 2 * words, 0x00);
        REQUIRE(tests::crc_of(said) == 0);
        for (const std::size_t piece : {std::size_t{1}, said.size()}) {
            byte_list room(said.size());
            modbus::exchange x{request, room, timing, limits};
            x.sent({});
            for (std::size_t at = 0; at < said.size(); at += piece)
                x.feed(bytes{said}.subspan(at, piece), {1000});
            CHECK(x.status().error() == errc::own_echo);
        }
        said[3] ^= 0xFFu; // any other data, also with a CRC that ends with a zero, is a response
        said = framed({said.begin(), said.end() - 2});
        byte_list room(said.size());
        modbus::exchange x{request, room, timing, limits};
        x.sent({});
        x.feed(said, {1000});
        CHECK(x.status().error() == errc::ok);
    }
}

TEST_CASE("G3, G6: an echo followed by zeros is no response to any other function either") {
    const modbus::rtu_timing timing = modbus::timing_at(115200);
    const response_limits limits;
    for (const byte_list& request : {framed({0x17, 0x2B, 0, 0, 0, 0}), framed({0x17, 0x41}),
                                     framed({0x17, 0x08, 0, 1, 2, 3, 4, 5, 6, 7, 8})}) {
        for (std::size_t size = request.size() + 1; size <= modbus::max_frame; ++size) {
            byte_list said = request;
            said.resize(size, 0x00);
            for (const std::size_t piece : {std::size_t{1}, size}) {
                byte_list room(size);
                modbus::exchange x{request, room, timing, limits};
                x.sent({});
                for (std::size_t at = 0; at < size; at += piece)
                    x.feed(bytes{said}.subspan(at, piece), {1000});
                REQUIRE(x.status().error() == errc::own_echo);
            }
        }
    }
}

TEST_CASE("G3: the echo of a multiple write is recognised, also in memory that the response shares with the "
          "request") {
    const modbus::rtu_timing timing = modbus::timing_at(115200);
    const response_limits limits;
    int found = 0;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const byte_list begin{0x01, 0x10, tests::high_byte(address), tests::low_byte(address), 0x00, 0x02};
        const std::uint16_t crc = tests::crc_of(begin);
        if ((crc & 0xFF) != 4) continue; // its byte count
        byte_list request = begin;
        request.insert(request.end(), {0x04, tests::high_byte(crc), 0x11, 0x22, 0x33});
        request = framed(request);
        ++found;
        byte_list shared = request;
        modbus::exchange x{shared, shared, timing, limits};
        x.sent({});
        for (const std::uint8_t b : request) x.feed(b, {1000});
        CHECK(x.status().error() == errc::own_echo);
        modbus::exchange answered{request, shared, timing, limits};
        answered.sent({});
        answered.feed(bytes{tests::acknowledgement(request)}, {1000});
        answered.elapse({100'000});
        CHECK(answered.status().error() == errc::ok);
    }
    CHECK(found > 100);
}

TEST_CASE_TEMPLATE("G3: on a line without a device no call ever succeeds", Echo, unechoed, echoed) {
    for (const adapter a : {adapter::silent, adapter::clean, adapter::late}) {
        CAPTURE(static_cast<int>(a));
        rig<Echo> r{a};
        for (int i = 0; i < 3; ++i) {
            CHECK_FALSE(r.drive.template read<speed>());
            const status one = r.drive.template write<speed>(5);
            CHECK(one.outcome() == outcome::unknown);
            CHECK_FALSE(r.drive.template write<speed, other_speed>(5, 6));
            CHECK_FALSE(r.drive.write_word(0x200E, 8));
            CHECK_FALSE(r.drive.template write_if_different<speed>(5));
            const std::array<std::uint8_t, 5> query_data{0x08, 0x00, 0x00, 0x12, 0x34};
            std::array<std::uint8_t, 5> response{};
            CHECK_FALSE(r.drive.transact(query_data, response));
        }
        CHECK_FALSE(r.on.is_echo_ruled_out());
    }
}

TEST_CASE("G3: a broadcast is no sign that anything answers") {
    rig<> r{adapter::late};
    const auto all = modbus::write_frame(modbus::broadcast, 0x2088, {0, 0});
    modbus::exchange x{all, {}, r.on.timing(), r.drive.node().limits};
    r.on.run(x, r.drive.node().gaps);
    REQUIRE(x.status() == errc::ok);
    CHECK_FALSE(r.on.is_echo_ruled_out());
    CHECK_FALSE(r.drive.write<speed>(5)); // its late echo is a well-formed response
}

TEST_CASE_TEMPLATE("G3: a broadcast does not make an echo possible again", Line, returning_line,
                   returning_blocking_line) {
    returning_rig<Line> r;
    REQUIRE(r.drive.template read<speed>());
    REQUIRE(r.on.is_echo_ruled_out());
    r.port.device = {};
    CHECK(r.drive.template broadcast<speed>(5));
    CHECK(r.on.is_echo_ruled_out());
}

TEST_CASE("G3: a facade does not take an echo for its drive") {
    for (const bool keeps : {false, true}) {
        sim::line_settings settings;
        settings.echoes = true;
        settings.keeps_echo = keeps;
        sim::virtual_line wire{settings};
        line on{wire, modbus::timing_at(115200)};
        zlac8015d::drive wheels{on, node<zlac8015d::device>{1}, unsupervised};
        CHECK_FALSE(wheels.run(init{}));
        CHECK_FALSE(wheels.run(quick_stop{}));
        yako::closed_loop::drive axis{on, node<yako::closed_loop::device>{1}};
        CHECK_FALSE(axis.run(init{}));
        c630s::drive servo{on, node<c630s::device>{1}};
        CHECK_FALSE(servo.run(init{}));
    }
}

TEST_CASE("G3: the first single write on a line is followed by a read, the others are not") {
    rig<> r{adapter::silent};
    r.connect();
    CHECK(r.drive.write<speed>(5));
    REQUIRE(r.port.frames.size() == 2);
    CHECK(r.port.frames[0].data[1] == 0x06); // immediately: it may be a stop
    CHECK(r.port.frames[1].data[1] == 0x03);
    CHECK(r.on.is_echo_ruled_out());
    CHECK(r.drive.write<speed>(6));
    CHECK(r.port.frames.size() == 3);
}

TEST_CASE_TEMPLATE(
    "G3: after a request without a response a single write counts only after a read, since the adapter may "
    "return it",
    Line, returning_line, returning_blocking_line) {
    returning_rig<Line> r;
    REQUIRE(r.drive.template read<speed>());
    REQUIRE(r.drive.template write<speed>(5));
    CHECK(r.sent() == byte_list{0x03, 0x06});
    r.is_1_there = r.is_2_there = false;
    SUBCASE("a read fails") { CHECK_FALSE(r.drive.template read<speed>()); }
    SUBCASE("a multiple write fails") {
        const status both = r.drive.template write<speed, other_speed>(5, 6);
        CHECK(both.outcome() == outcome::unknown);
    }
    (void)r.sent();
    for (int i = 0; i < 2; ++i) {
        const status stop = r.drive.template write<speed>(0);
        CHECK(stop.error() == errc::own_echo);
        CHECK(stop.outcome() == outcome::unknown);
        CHECK(r.sent() == byte_list{0x06, 0x03}); // the write first: it may be a stop
    }
    const std::array<std::uint8_t, 5> query_data{0x08, 0x00, 0x00, 0x12, 0x34};
    std::array<std::uint8_t, 5> response{};
    if constexpr (!Line::is_small) CHECK(r.drive.transact(query_data, response).error() == errc::own_echo);
    (void)r.sent();
    r.is_1_there = r.is_2_there = true;
    CHECK(r.drive.template write<speed>(7));
    CHECK(r.sent() == byte_list{0x06, 0x03});
    CHECK(r.file.words[0x0100] == 7);
    CHECK(r.drive.template write<speed>(8));
    CHECK(r.drive.template write<speed>(9));
    CHECK(r.sent() == byte_list{0x06, 0x06}); // as on any line
}

TEST_CASE("G3: a node that responds proves nothing of another one that did not, and has no frame more") {
    returning_rig<returning_line> r;
    REQUIRE(r.drive.read<speed>());
    REQUIRE(r.other.read<speed>());
    r.is_1_there = false;
    CHECK_FALSE(r.drive.read<speed>());
    REQUIRE(r.other.read<speed>());
    (void)r.sent();
    CHECK(r.other.write<speed>(3));
    CHECK(r.sent() == byte_list{0x06});
    CHECK(r.drive.write<speed>(0).error() == errc::own_echo);
    CHECK(r.sent() == byte_list{0x06, 0x03});
    CHECK(r.other.write<speed>(4));
    CHECK(r.sent() == byte_list{0x06});
}

TEST_CASE("G3: a node that did not respond before another one did is not proved by it") {
    returning_rig<returning_line> r;
    r.is_1_there = false;
    CHECK_FALSE(r.drive.read<speed>());
    REQUIRE(r.other.read<speed>());
    CHECK(r.drive.write<speed>(0).error() == errc::own_echo);
}

TEST_CASE(
    "G3: of nodes that all respond no single write but the first one on the line is followed by a read") {
    returning_rig<returning_line> r;
    CHECK(r.drive.write<speed>(1));
    CHECK(r.other.write<speed>(1));
    r.on.begin_epoch(1); // as the write of a switch of the drive does: what was learned of it is stale
    CHECK(r.drive.write<speed>(2));
    CHECK(r.other.write<speed>(2));
    CHECK(r.sent() == byte_list{0x06, 0x03, 0x06, 0x06, 0x06});
}

TEST_CASE(
    "G3: a facade does not take returned requests for a stop of its drive, nor does a client beside it") {
    sim::zlac8015d machine;
    sim::station station{machine, 1, 115200, milliseconds(1)};
    sim::line_settings settings;
    settings.unanswered_return = milliseconds(5);
    sim::virtual_line wire{settings};
    wire.attach(station);
    line on{wire, modbus::timing_at(115200)};
    zlac8015d::drive wheels{on, node<zlac8015d::device>{1}, unsupervised};
    client registers{on, node<zlac8015d::device>{1}};
    REQUIRE(wheels.run(init{}));
    REQUIRE(wheels.run(enable{}));
    REQUIRE(wheels.run(velocity{30 * units::r_per_min, 30 * units::r_per_min}));
    CHECK(wire.returned() == 0);
    wire.set_connected(0, false);
    CHECK_FALSE(wheels.run(quick_stop{}));
    CHECK(registers.write<zlac8015d::control_word>(zlac8015d::control_code::stop).error() == errc::own_echo);
    CHECK_FALSE(wheels.run(zlac8015d::left_velocity{0 * units::r_per_min}));
    CHECK_FALSE(wheels.run(halt{}));
    CHECK(registers.write<zlac8015d::control_word>(zlac8015d::control_code::quick_stop).error() ==
          errc::own_echo);
    CHECK_FALSE(wheels.run(disable{}));
    CHECK(wire.returned() > 8);
    wire.set_connected(0, true);
    CHECK(wheels.run(init{}));
    CHECK(registers.write<zlac8015d::control_word>(zlac8015d::control_code::stop));
}

TEST_CASE("G4: the echo is removed and nothing else, however it arrives") {
    for (const adapter a : {adapter::clean, adapter::late}) {
        for (const std::size_t piece : {1u, 5u, 1000u}) {
            for (const std::uint32_t delay : {0u, 1u, 500u, 20'000u}) {
                rig<echoed> r{a};
                r.connect();
                r.port.gives_at_most = piece;
                r.file.delay = delay + r.port.echo_late_us;
                r.file.words[0x0100] = 77;
                CHECK(*r.drive.read<speed>() == 77);
                CHECK(r.drive.write<speed>(78).outcome() == outcome::done);
                CHECK(r.drive.write<speed, other_speed>(79, 80).outcome() == outcome::done);
                CHECK(r.file.words[0x0101] == 80);
                CHECK(r.on.observer().unexpected_bytes == 0);
                CHECK(r.on.observer().requests == 3);
            }
        }
    }
}

TEST_CASE("G4: an echo that differs is a collision") {
    rig<echoed> r{adapter::clean};
    r.connect();
    r.port.corrupts_echo = true;
    const status w = r.drive.write<speed>(5);
    CHECK(w.error() == errc::collision);
    CHECK(w.outcome() == outcome::unknown);
    r.port.corrupts_echo = false;
    CHECK(r.drive.read<speed>());
}

TEST_CASE("G4: an echo that does not arrive is reported, within the frame's own time") {
    rig<echoed> r{adapter::silent};
    r.connect();
    const auto begin = r.port.time;
    const status w = r.drive.write<speed, other_speed>(5, 6);
    CHECK(w.error() == errc::no_echo);
    CHECK(w.outcome() == outcome::unknown);
    // The gap before it, the frame twice, and what a USB adapter may hold back.
    const auto& t = r.on.timing();
    CHECK(r.port.time - begin < 100'000 + t.wire_time(2 * 13 + 4).us + t.inter_byte.us + 2 * t.t3_5);
    SUBCASE("unless it is switched off") {
        r.on.echo().is_on = false;
        CHECK(r.drive.read<speed>());
    }
}

TEST_CASE("G4: a response that follows the echo directly, in one piece with it, is the response") {
    for (const std::uint32_t late : {0u, 3000u}) {
        for (const std::uint32_t turn : {0u, 700u, 2000u, 5000u, 9000u}) { // of a superloop
            for (const std::size_t trailing : {0u, 2u}) {
                CAPTURE(late);
                CAPTURE(turn);
                CAPTURE(trailing);
                rig<echoed, scripted_port> r{adapter::clean};
                r.port.echo_late_us = late;
                byte_list said = tests::read_response(1, {77});
                said.insert(said.end(), trailing, 0x55);
                r.port.device = [&](scripted_port& p, const tests::sent_frame&) { p.say(late, said); };
                const modbus::frame<8> request = modbus::read_frame(1, 0x0100, 1);
                const response_limits limits;
                for (int i = 0; i < 3; ++i) {
                    std::array<std::uint8_t, 7> room{};
                    modbus::exchange x{request, room, r.on.timing(), limits};
                    while (!x.done()) {
                        r.on.step(x, {});
                        r.port.time += turn;
                    }
                    REQUIRE(x.status() == errc::ok);
                    CHECK(x.words()[0] == 77);
                    CHECK(r.on.is_free());
                    CHECK(r.on.is_echo_ruled_out());
                    r.port.time += 20'000;
                }
                CHECK(r.on.observer().requests == 3);
                CHECK(r.on.observer().responses == 3);
                CHECK(r.on.observer().unexpected_bytes <= 3 * trailing);
                CHECK(r.on.observer().unexpected_bytes >= 2 * trailing); // the last may still be in the port
            }
        }
    }
}

TEST_CASE("G4: an echo that is complete before the port reports that all has left is not awaited again") {
    rig<echoed> r{adapter::clean};
    r.connect();
    r.port.says_sent_late = 2000;
    r.file.delay = 4000;
    r.file.words[0x0100] = 77;
    CHECK(r.drive.read<speed>().value_or({}) == 77);
    CHECK(r.drive.write<speed>(78).outcome() == outcome::done);
    CHECK(r.on.observer().unexpected_bytes == 0);
}

TEST_CASE_TEMPLATE(
    "G16, G29: a port that is lost at any call, also while the rest of the echo is awaited, gives no success",
    Port, scripted_port, waiting_scripted_port) {
    for (const adapter a : {adapter::clean, adapter::late}) {
        bool was_whole = false;
        int unknown = 0;
        for (std::uint64_t n = 1; !was_whole && n < 10'000; ++n) {
            CAPTURE(n);
            rig<echoed, Port> r{a};
            r.connect();
            r.file.delay = 500 + r.port.echo_late_us;
            r.port.call_us = 20;
            CHECK(r.drive.template read<speed>());
            const std::size_t before = r.port.frames.size();
            r.port.lost_from_call = r.port.calls + n;
            const status w = r.drive.template write<speed>(5);
            was_whole = !r.port.has_failed;
            REQUIRE_FALSE(r.port.ran_away);
            if (was_whole) {
                REQUIRE(w.outcome() == outcome::done);
                break;
            }
            const bool has_left = r.port.frames.size() != before;
            REQUIRE(w.outcome() == (has_left ? outcome::unknown : outcome::not_sent));
            if (w.error() != errc::partial_send) {
                REQUIRE(w.error() == errc::port_lost);
                REQUIRE_FALSE(r.on.is_echo_ruled_out());
            }
            unknown += has_left ? 1 : 0;
        }
        CHECK(was_whole);
        CHECK(unknown > 20);
    }
}

namespace {
/// A UART that loses a garbled character, and reports it.
struct garbling_port : waiting_scripted_port {
    std::uint64_t bad_byte = 0; ///< counted from the first one received; 0: none
    std::uint64_t heard = 0;

    transfer receive(byte_buffer in) {
        std::array<std::uint8_t, 1> byte{};
        std::uint16_t n = 0;
        while (n < in.size()) {
            const transfer came = waiting_scripted_port::receive(byte);
            if (!came) return came.status();
            if (*came == 0) break;
            if (++heard == bad_byte) return errc::receive_failed;
            in[n++] = byte[0];
        }
        return n;
    }
};
} // namespace

TEST_CASE("G4, G16: an echo with a garbled character is no success, whenever it arrives") {
    for (const std::uint32_t late : {0u, 3000u}) {
        for (std::uint64_t bad = 1; bad <= 8; ++bad) {
            for (const bool is_there : {false, true}) {
                CAPTURE(late);
                CAPTURE(bad);
                CAPTURE(is_there);
                rig<echoed, garbling_port> r{adapter::clean};
                r.connect();
                r.port.echo_late_us = late;
                r.file.delay = 500 + late;
                CHECK(r.drive.read<speed>());
                if (!is_there) r.port.device = nullptr;
                r.port.heard = 0;
                r.port.bad_byte = bad;
                const status w = r.drive.write<speed>(5);
                CHECK(w.outcome() == outcome::unknown);
                CHECK((w.error() == errc::no_echo || w.error() == errc::collision ||
                       w.error() == errc::receive_failed));
                CHECK(r.port.frames.size() == 2);
                r.port.bad_byte = 0;
                r.connect();
                CHECK(r.drive.read<speed>());
            }
        }
    }
}

TEST_CASE("a garbled character while the request leaves does not matter where no echo is compared") {
    for (std::uint64_t bad = 1; bad <= 7; ++bad) {
        CAPTURE(bad);
        rig<echoed, garbling_port> r{adapter::clean};
        r.connect();
        r.port.keeps_echo = false;
        r.on.echo().is_on = false;
        CHECK(r.drive.read<speed>());
        r.port.heard = 0;
        r.port.bad_byte = bad;
        CHECK(r.drive.write<speed>(5).outcome() == outcome::done);
        CHECK(r.port.frames.size() == 2);
    }
}

TEST_CASE("G4: a port that miscounts what it received does not disturb the echo") {
    for (const std::uint32_t turn : {0u, 3500u, 9000u}) {
        CAPTURE(turn);
        rig<echoed, scripted_port> r{adapter::clean};
        r.connect();
        r.port.lies_about_counts = true;
        for (std::uint16_t a = 0x0100; a < 0x0130; ++a) r.file.words[a] = 0;
        byte_list body{1, 0x10, 0x01, 0x00, 0, 30, 60};
        body.resize(7 + 60);
        body.back() = 77;
        const byte_list request = framed(body);
        std::array<std::uint8_t, 8> room{};
        const response_limits limits;
        modbus::exchange x{request, room, r.on.timing(), limits};
        while (!x.done()) {
            r.on.step(x, {});
            r.port.time += turn;
        }
        CHECK(x.status() == errc::ok);
        CHECK(r.file.words[0x0100 + 29] == 77);
    }
}

} // namespace echo_tests
