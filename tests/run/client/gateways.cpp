// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A gateway that responds in a node's place (0Ah, 0Bh), on Modbus TCP and on RTU, and devices that accept a request
// by exception 5: what a client makes of it. The simulated drive, seen from outside, says what was carried out.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <servobus/client/change_address.hpp>
#include <servobus/client/scan.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/blocking_line_rig.hpp>
#include <tests/support/client_rig.hpp>
#include <tests/support/gateway.hpp>

namespace gateways_tests {

using namespace servobus;
using tests::byte_list;
using tests::modbus_tcp_gateway;
using tests::rtu_gateway;
using tests::scripted_port;
using tests::sent_frame;

namespace {

/// One simulated drive, a gateway before it, and a client.
template <class Sim, class Device, class Port> struct bench {
    static constexpr std::uint32_t baud = Device::facts.baud;
    Sim drive;
    sim::station<Sim> station{drive};
    sim::virtual_line wire{baud};
    Port port{wire};
    line<Port> on{port, modbus::timing_at(baud)};
    client<line<Port>, Device> at;

    explicit bench(std::uint8_t number = 0x0B) : at{on, node_of(number)} { wire.attach(station); }
    bench(const bench&) = delete;

  private:
    node<Device> node_of(std::uint8_t number) {
        port.number = number;
        node<Device> n{1};
        n.limits.has_gateway = !Port::has_gateway;
        return n;
    }
};
template <class Port> using wheels_of = bench<sim::zlac8015d, zlac8015d::device, Port>;
template <class Port> using servo = bench<sim::c630s, c630s::device, Port>;

template <class Sim> std::uint16_t held(Sim& drive, std::uint16_t address) {
    std::uint16_t word = 0;
    REQUIRE(drive.read(address, slice<std::uint16_t>{&word, 1}) == 0);
    return word;
}

inline constexpr reg<u16, access::rw, tests::typed::device> own_address{
    0x0107, {1, 99}, no_unit, 1, communication};

struct tcp_port : tests::waiting_scripted_port {
    static constexpr bool has_gateway = true;
};

// Responds to each request with an exception of this number, as the address that was asked.
template <class Port> void respond(Port& port, std::uint8_t number) {
    port.device = [number](scripted_port& p, const sent_frame& f) {
        p.say(500, tests::exception_response(f.data[0], f.data[1], number));
    };
}

} // namespace

TEST_CASE_TEMPLATE(
    "G16, G38: a write whose response a gateway replaces by 0Ah or 0Bh is unknown, and is not repeated", Port,
    modbus_tcp_gateway, rtu_gateway) {
    for (const std::uint8_t number : {std::uint8_t{0x0A}, std::uint8_t{0x0B}}) {
        wheels_of<Port> b{number};
        std::uint16_t word[1]{};
        REQUIRE(b.at.read_words(0x2034, word)); // no echo is possible from now on
        const std::uint64_t before = b.wire.requests();
        b.port.loses_response = true;
        const status s = b.at.write_word(0x2034, 125);
        CHECK(b.port.exceptions == 1);
        CHECK(held(b.drive, 0x2034) == 125); // it was carried out
        CHECK(s.outcome() == outcome::unknown);
        CHECK(s == errc::gateway_exception);
        CHECK(s.exception() == number);
        CHECK(s.was_sent());
        CHECK_FALSE(s.has_response());
        CHECK(b.wire.requests() == before + 1);
    }
}

TEST_CASE_TEMPLATE("G38: a stepped write, a stepped read and any PDU end as the blocking calls", Port,
                   modbus_tcp_gateway, rtu_gateway) {
    using namespace zlac8015d;
    wheels_of<Port> b;
    using client_type = client<line<Port>, device>;
    stepped_write<client_type, left_acceleration_time> write{b.at};
    b.port.is_cut = true;
    REQUIRE(write.begin(100) == errc::ok);
    while (!write.done()) b.on.sleep(write.step());
    CHECK(write.status() == status::sent(errc::gateway_exception, 0x0B));

    stepped_read<client_type, bus_voltage> read{b.at};
    REQUIRE(read.begin() == errc::ok);
    while (!read.done()) b.on.sleep(read.step());
    CHECK(read.value().error() == errc::gateway_exception);
    CHECK(b.port.exceptions == 1 + 3); // the write once, the read with its two retries

    const std::uint8_t pdu[] = {0x11};
    std::uint8_t response[4]{};
    CHECK(b.at.transact(pdu, response) == status::sent(errc::gateway_exception, 0x0B));
}

TEST_CASE("G12, G38: other exceptions are the node's, and so are all of them without a gateway") {
    for (unsigned number = 0; number <= 255; ++number) {
        const auto byte = static_cast<std::uint8_t>(number);
        const bool is_of_gateway = number == 0x0A || number == 0x0B;
        const errc of_device = number == 5 ? errc::acknowledged : errc::exception;
        CAPTURE(number);
        tests::typed::rig<tests::typed::device, tcp_port> tcp;
        respond(tcp.port, byte);
        CHECK(tcp.drive.write_word(0x0100, 7) ==
              status::sent(is_of_gateway ? errc::gateway_exception : of_device, byte));
        tests::typed::rig<> rtu;
        respond(rtu.port, byte);
        CHECK(rtu.drive.write_word(0x0100, 7) == status::sent(of_device, byte));
        rtu.drive.node().limits.has_gateway = true;
        CHECK(rtu.drive.write_word(0x0100, 7) ==
              status::sent(is_of_gateway ? errc::gateway_exception : of_device, byte));
    }
}

TEST_CASE("G38: on a blocking line a gateway's exception is no response of the node either") {
    using namespace tests::blocking;
    for (const std::uint8_t number : {std::uint8_t{0x0A}, std::uint8_t{0x0B}}) {
        rig<setup<tcp_port>> tcp;
        respond(tcp.port, number);
        CHECK(tcp.fixed.write<ramp>(7) == status::sent(errc::gateway_exception, number));
        CHECK(tcp.fixed.read<ramp>().error() == errc::gateway_exception);
        CHECK(tcp.port.frames.size() == 1 + 3);
        rig<> rtu;
        respond(rtu.port, number);
        CHECK(rtu.open.write<ramp>(7) == status::sent(errc::exception, number));
        rtu.open.node().limits.has_gateway = true;
        CHECK(rtu.open.write<ramp>(7) == status::sent(errc::gateway_exception, number));
    }
}

TEST_CASE("G1, G38: a gateway's exception on an RTU line is followed by a quarantine") {
    const auto pause_after = [](std::uint8_t number) {
        tests::typed::rig<> r;
        r.drive.node().limits.has_gateway = true;
        respond(r.port, number);
        (void)r.drive.write_word(0x0100, 7);
        (void)r.drive.write_word(0x0100, 7);
        REQUIRE(r.port.frames.size() == 2);
        return r.port.frames[1].begin - r.port.frames[0].end;
    };
    CHECK(pause_after(0x0B) >= 100'000);
    CHECK(pause_after(0x02) < 10'000);
}

TEST_CASE("G3, G38: a gateway's exception does not rule out an echo") {
    tests::typed::rig<> r;
    r.drive.node().limits.has_gateway = true;
    r.port.device = [](scripted_port& p, const sent_frame& f) {
        if (f.data[1] == 0x06) // the adapter's echo, of a node that is not there
            p.say(500, f.data);
        else
            p.say(500, tests::exception_response(f.data[0], f.data[1], 0x0B));
    };
    const status s = r.drive.write_word(0x0100, 7);
    CHECK(s == status::sent(errc::own_echo));
    CHECK_FALSE(r.on.is_echo_ruled_out());

    using namespace tests::blocking;
    tests::scripted_port port;
    blocking_line<tests::scripted_port, timing_at(115200)> small{port};
    client c{small, node<tests::blocking::device>{1}};
    c.node().limits.has_gateway = true;
    port.device = r.port.device;
    CHECK(c.write<ramp>(7) == status::sent(errc::own_echo));
    CHECK_FALSE(small.is_echo_ruled_out());
}

TEST_CASE_TEMPLATE("G22, G38: a word order that was learned is stale after a gateway's exception", Port,
                   modbus_tcp_gateway, rtu_gateway) {
    bench<sim::yako_closed_loop, yako::closed_loop::device, Port> b;
    REQUIRE(b.at.learn_word_order());
    REQUIRE(b.at.node().word_order != word_order::unknown);
    b.port.loses_response = true;
    REQUIRE(b.at.write_word(0x0013, 1) == errc::gateway_exception);
    CHECK(b.at.node().word_order == word_order::unknown);
    CHECK(b.at.template read<yako::actual_position>().error() == errc::needs_word_order);
}

TEST_CASE_TEMPLATE("G18, G38: a ram_only token is void after a gateway's exception", Port, modbus_tcp_gateway,
                   rtu_gateway) {
    servo<Port> b;
    REQUIRE(b.at.template store<c630s::eeprom_update>(c630s::off_on::off));
    const result<ram_only> token = b.at.ram_only();
    REQUIRE(token);
    REQUIRE(b.at.template write<c630s::target_speed>(100 * units::r_per_min, *token));
    b.port.loses_response = true;
    REQUIRE(b.at.template write<c630s::target_speed>(200 * units::r_per_min, *token) ==
            errc::gateway_exception);
    CHECK(b.at.template write<c630s::target_speed>(300 * units::r_per_min, *token) == errc::needs_init);
}

TEST_CASE_TEMPLATE("G24, G27, G38: an address for which only a gateway responds is free", Port,
                   modbus_tcp_gateway, rtu_gateway) {
    servo<Port> b;
    const response_limits limits = b.at.node().limits;
    b.port.is_cut = true;
    const finding found = look_for(b.on, 9, limits);
    CHECK(found.what == presence::no_response);
    CHECK(found.why == status::sent(errc::gateway_exception, 0x0B));
    CHECK(b.port.exceptions == 1);
}

TEST_CASE("G24, G38: change_address takes an address for which only a gateway responds") {
    tests::typed::rig<tests::typed::device, tcp_port> r;
    std::uint8_t address = 1;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[0] != address) return p.say(500, tests::exception_response(f.data[0], f.data[1], 0x0B));
        byte_list response = r.file.response_to(f.data);
        if (f.data[1] == 0x06 && f.data[3] == 0x07) address = f.data[5];
        p.say(500, response);
    };
    r.file.words[0x0107] = 1;
    REQUIRE(change_address<own_address>(r.drive, 9));
    CHECK(r.drive.node().address == 9);
    CHECK(address == 9);
}

TEST_CASE("G30, G38: a broadcast that the gateway of Modbus TCP refuses is not done") {
    for (const std::uint8_t number :
         {std::uint8_t{0x0A}, std::uint8_t{0x0B}, std::uint8_t{0x01}, std::uint8_t{5}}) {
        CAPTURE(int{number});
        tests::typed::rig<tests::typed::device, tcp_port> r;
        respond(r.port, number);
        const status s = r.drive.broadcast<tests::typed::fixture::time>(7);
        CHECK(s == status::sent(errc::gateway_exception, number));
        CHECK(s.outcome() == outcome::unknown);
        CHECK(r.port.frames.size() == 1);

        tests::blocking::rig<tests::blocking::setup<tcp_port>> small;
        respond(small.port, number);
        CHECK(small.open.broadcast<tests::blocking::ramp>(7) ==
              status::sent(errc::gateway_exception, number));
    }
}

TEST_CASE(
    "G30: a broadcast over Modbus TCP is done without a response, after the response limit, or with one") {
    const auto broadcast = [](std::uint64_t after, bool has_response, status& end) {
        tests::typed::rig<tests::typed::device, tcp_port> r;
        r.port.device = [=](scripted_port& p, const sent_frame& f) {
            if (has_response) p.say(after, tests::acknowledgement(f.data));
        };
        end = r.drive.broadcast<tests::typed::fixture::time>(7);
        REQUIRE(r.port.frames.size() == 1);
        return r.port.time - r.port.frames[0].end;
    };
    status end{errc::busy};
    CHECK(broadcast(0, false, end) >= 100'000);
    CHECK(end == status::sent(errc::ok));
    CHECK(broadcast(5000, true, end) < 20'000);
    CHECK(end == status::sent(errc::ok));

    const auto broadcast_small = [](bool has_response, status& of) {
        tests::blocking::rig<tests::blocking::setup<tcp_port>> r;
        r.port.device = [=](scripted_port& p, const sent_frame& f) {
            if (has_response) p.say(5000, tests::acknowledgement(f.data));
        };
        of = r.open.broadcast<tests::blocking::ramp>(7);
        return r.port.time - r.port.frames.back().end;
    };
    CHECK(broadcast_small(false, end) >= 100'000);
    CHECK(end == status::sent(errc::ok));
    CHECK(broadcast_small(true, end) < 20'000);
    CHECK(end == status::sent(errc::ok));
}

TEST_CASE(
    "G30: a broadcast exchange without room for a refusal waits for its turnaround, on Modbus TCP too") {
    tcp_port port;
    line<tcp_port> on{port, modbus::timing_at(115200)};
    const byte_list request = tests::framed({0, 6, 1, 0, 0, 7});
    std::array<std::uint8_t, 4> room{0xA5, 0xA5, 0xA5, 0xA5};
    const response_limits limits{};
    respond(port, 0x0B);
    modbus::exchange x{request, room, on.timing(), limits};
    on.run(x, {});
    CHECK(x.status() == status::sent(errc::ok));
    CHECK(port.time - port.frames[0].end < 15'000);
    CHECK(room == std::array<std::uint8_t, 4>{0xA5, 0xA5, 0xA5, 0xA5});
}

TEST_CASE("G12, G16: exception 5 of a device that follows the standard is unknown, 6 is refused; neither is "
          "repeated") {
    tests::typed::rig<> r;
    respond(r.port, 5);
    const status accepted = r.drive.write<tests::typed::fixture::time>(7);
    CHECK(accepted == status::sent(errc::acknowledged, 5));
    CHECK(accepted.outcome() == outcome::unknown);
    CHECK(accepted.has_response());
    CHECK(r.drive.read<tests::typed::fixture::time>().error() == errc::acknowledged);
    CHECK(r.port.frames.size() == 2);
    respond(r.port, 6);
    const status busy = r.drive.write<tests::typed::fixture::time>(7);
    CHECK(busy == status::sent(errc::exception, 6));
    CHECK(busy.outcome() == outcome::refused);
    CHECK(r.drive.read<tests::typed::fixture::time>().error() == errc::exception);
    CHECK(r.port.frames.size() == 4);
    CHECK(r.on.observer().exceptions == 4);
}

TEST_CASE("G12, G16: exception 5 of a YAKO means too many registers, and is refused") {
    tests::typed::rig<yako::closed_loop::device> r;
    respond(r.port, 5);
    const status s = r.drive.write_word(0x0010, 1);
    CHECK(s == status::sent(errc::exception, 5));
    CHECK(s.outcome() == outcome::refused);
}

} // namespace gateways_tests
