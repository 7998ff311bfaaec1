// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line tells a port that can be awake when the last byte of a response comes: how many bytes are missing, each
// time before it waits, once the response has begun.
#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/line/line.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace expecting_port_tests {

using namespace servobus;

namespace {

struct plain_device {
    static constexpr profile facts{.name = "plain", .exceptions = standard_exceptions};
};
struct few_words {
    static std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = address;
        return address == 0x100 ? 2 : 0;
    }
    static std::uint8_t write(std::uint16_t, words_view) { return 0; }
};

// Keeps what it was told, and a zero for each wait without it.
class told_port {
  public:
    explicit told_port(sim::virtual_line& wire) : wire_{&wire} {}
    transfer send(bytes out) { return wire_->send(out); }
    bool sent() { return has_left = wire_->sent(); }
    transfer receive(byte_buffer in) { return wire_->receive(in); }
    instant now() { return wire_->now(); }
    void wait(duration longest) {
        if (has_left) told.push_back(expected_);
        expected_ = 0;
        wire_->wait(longest);
    }
    void expect(std::uint16_t missing) { expected_ = missing; }

    std::vector<std::uint16_t> told{};
    bool has_left = false;

  private:
    sim::virtual_line* wire_;
    std::uint16_t expected_ = 0;
};
static_assert(expecting_port<told_port>);
static_assert(!expecting_port<sim::virtual_line>);

constexpr auto timing = modbus::timing_at(115200);

template <class Line> void check_what_is_told() {
    few_words registers;
    sim::station<few_words> station{registers, 1, 115200, milliseconds(2)};
    sim::virtual_line wire{115200};
    wire.attach(station);
    told_port port{wire};
    const auto told_while = [&](auto call) {
        port.told.clear();
        port.has_left = false;
        call();
        return port.told;
    };
    const auto make = [&] {
        if constexpr (requires { Line{port, timing}; })
            return Line{port, timing};
        else
            return Line{port};
    };
    Line on = make();
    client<Line, plain_device> drive{on, node<plain_device>{1}};
    u16 words[2]{};
    CHECK(drive.read_words(0x10, words)); // the quarantine of a new line
    using list = std::vector<std::uint16_t>;
    CHECK(told_while([&] { CHECK(drive.read_words(0x10, words)); }) == list{0, 8, 7, 6, 5, 4, 3, 2, 1});
    CHECK(told_while([&] { CHECK(drive.write_word(0x10, 5)); }) == list{0, 7, 6, 5, 4, 3, 2, 1});
    // The second byte of an exception shows that there are five.
    CHECK(told_while([&] { CHECK(drive.read_words(0x100, words).error() == errc::exception); }) ==
          list{0, 8, 3, 2, 1});
    // Without a response there is nothing to say.
    wire.set_connected(0, false);
    for (const std::uint16_t missing : told_while([&] { CHECK_FALSE(drive.read_words(0x10, words)); }))
        CHECK(missing == 0);
}

} // namespace

TEST_CASE("a line tells its port how many bytes of a response are missing") {
    check_what_is_told<line<told_port>>();
}

TEST_CASE("a blocking line tells its port the same") {
    check_what_is_told<blocking_line<told_port, timing>>();
}

} // namespace expecting_port_tests
