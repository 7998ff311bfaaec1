// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The Arduino port over a fake core.
#include <array>

#include "contract.hpp"

#include "fakes/arduino.hpp"

#include "examples/ports/arduino_stream.hpp"

using servobus::ports::arduino_stream;

namespace {

struct rig {
    using port_type = arduino_stream;
    static constexpr bool tells_errors = false;
    static constexpr bool drives_by_itself = false;
    static constexpr bool can_refuse = false;

    rig() { it.start(); }
    ~rig() {
        CHECK(serial1.blocked == 0);
        CHECK(serial1.longest_flush <= 2 * fake::wire::character);
    }
    arduino_stream& port() { return it; }

    fake::arduino::serial serial1;
    arduino_stream it{serial1, fake::arduino::driver_pin, 115200};
};

} // namespace

TEST_CASE("Arduino Stream") { contract::all<rig>(); }

TEST_CASE("Arduino Stream: a response that came while the loop was late is not lost") {
    fake::line() = {};
    fake::arduino::serial serial1;
    arduino_stream port{serial1, -1, 115200}; // the transceiver switches by itself
    port.start();
    REQUIRE(*port.send(contract::request) == 8);
    fake::line().advance(8 * fake::wire::character + 2000);
    fake::line().arrive({1, 2, 3});
    fake::line().advance(5000);
    CHECK(port.sent());
    std::array<std::uint8_t, 8> in{};
    CHECK(*port.receive(in) == 3);
}

TEST_CASE("Arduino Stream: on a core that never reports free space a send fails and nothing blocks") {
    struct roomless final : Stream {
        std::size_t write(std::uint8_t) override { return 0; }
        std::size_t write(const std::uint8_t*, std::size_t) override { return 0; }
        int available() override { return 0; }
        int read() override { return -1; }
        int peek() override { return -1; }
    } stream;
    fake::line() = {};
    arduino_stream port{stream, fake::arduino::driver_pin, 115200};
    port.start();
    servobus::line wire{port, servobus::modbus::timing_at(115200)};
    servobus::client<decltype(wire), contract::device> client{wire, servobus::node<contract::device>{1}};
    CHECK(client.write<contract::level>(7).error() == servobus::errc::send_failed);
    CHECK_FALSE(fake::line().driver);
}
