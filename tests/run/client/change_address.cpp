// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client follows its drive to a new address, whenever the drive takes it and whichever frame is lost.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/client/change_address.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/line_setting.hpp>
#include <tests/support/scripted_port.hpp>
#include <tests/support/simulated_c630s.hpp>

namespace change_address_tests {

using namespace servobus;

namespace {

struct mover {
    static constexpr profile facts{.name = "mover", .lowest_address = 1, .highest_address = 40};
};
inline constexpr reg<u16, access::rw, mover> own_address{0x0010, {1, 40}, no_unit, 1, communication};

struct address_setting {
    static constexpr std::uint16_t at = own_address.address;
    static constexpr std::uint16_t initial = 1;
    static std::uint8_t address(std::uint16_t value) { return static_cast<std::uint8_t>(value); }
    static constexpr std::uint32_t baud(std::uint16_t) { return 115200; }
};
using movable = tests::settable<address_setting>;

// Another node on a bad line: some requests do not reach it, or its responses are lost or late.
struct hard_to_hear final : sim::line_device {
    movable device;
    sim::station<movable> station{device};
    unsigned lost_requests = 0;
    unsigned lost_responses = 0;
    unsigned late_responses = 0;
    duration late_by{};

    void receive(std::uint8_t byte, bool is_readable, instant now) override {
        const bool is_new = since(last_, now) > milliseconds(2);
        last_ = now;
        if (is_new && is_deaf_) is_deaf_ = false;
        if (is_new && byte == device.in_force && lost_requests != 0) {
            --lost_requests;
            is_deaf_ = true;
        }
        if (!is_deaf_) station.receive(byte, is_readable, now);
    }
    duration run(instant now) override {
        const duration idle = station.run(now);
        if (held_ == 0) return idle;
        const duration left = went_back(due_, now) ? since(now, due_) : microseconds(1);
        return left < idle ? left : idle;
    }
    bytes send(instant now) override {
        if (held_ != 0 && !went_back(due_, now)) {
            const bytes response{response_.data(), held_};
            held_ = 0;
            return response;
        }
        const bytes response = station.send(now);
        if (response.empty()) return response;
        if (lost_responses != 0) {
            --lost_responses;
            return {};
        }
        if (late_responses == 0) return response;
        --late_responses;
        for (const std::uint8_t byte : response) response_[held_++] = byte;
        due_ = now + late_by;
        return {};
    }
    std::uint32_t baud() const override { return 115200; }

  private:
    instant last_{};
    instant due_{};
    std::array<std::uint8_t, 256> response_{};
    std::size_t held_ = 0;
    bool is_deaf_ = false;
};

struct rig : tests::line_setting_rig<address_setting, mover> {
    static constexpr const auto& row = own_address;
    static constexpr std::uint8_t wanted = 7;

    status change() { return change_address<own_address>(at, wanted); }
    bool is_changed() const { return at.node().address == wanted; }
    bool is_unchanged() const { return at.node().address == 1; }
    void follow() { at.node().address = wanted; }
};

} // namespace

TEST_CASE("G24: the client follows its drive, whether the old address responds, the new one, or neither") {
    tests::play_a_change_in_operation<rig>();
}

TEST_CASE("G24: a drive that is slow to take its new address is found when it is read there again") {
    for (const unsigned unanswered : {0u, 1u, 2u, 3u}) { // requests without a response while the drive moves
        CAPTURE(unanswered);
        tests::scripted_port port;
        servobus::line<tests::scripted_port> on{port, modbus::timing_at(115200)};
        client<servobus::line<tests::scripted_port>, mover> at{on, node<mover>{1}};
        bool is_written = false;
        std::vector<std::uint8_t> asked{};
        port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
            const std::uint8_t node_address = f.data[0];
            if (is_written) asked.push_back(node_address);
            if (!is_written && node_address == 1 && f.data[1] == 0x06)
                p.say(500, tests::acknowledgement(f.data));
            if (!is_written && node_address == 1 && f.data[1] == 0x03)
                p.say(500, tests::read_response(1, {1}));
            if (is_written && node_address == 7 && asked.size() > unanswered)
                p.say(500, tests::read_response(7, {7}));
            is_written = is_written || f.data[1] == 0x06;
        };
        REQUIRE(at.read<own_address>()); // so that an echo is ruled out on this line
        const status w = change_address<own_address>(at, 7);
        const bool is_found = unanswered < 3;
        CHECK(w.error() == (is_found ? errc::ok : errc::timeout));
        CHECK(at.node().address == (is_found ? 7 : 1));
        const std::vector<std::uint8_t> looks{7, 1, 7};
        CHECK(asked == (unanswered == 0 ? std::vector<std::uint8_t>{7} : looks));
    }
}

TEST_CASE("G24: a drive that takes its new address when it starts again is reported as not reached yet") {
    tests::play_a_change_at_power_on<rig>();
}

TEST_CASE("S6: an address is not changed to one that is taken, or that the device cannot have") {
    rig r;
    movable neighbour;
    neighbour.in_force = neighbour.held = 7;
    sim::station at_seven{neighbour};
    r.wire.attach(at_seven);
    CHECK(r.change().error() == errc::busy);
    CHECK(change_address<own_address>(r.at, 0).error() == errc::bad_argument);
    CHECK(change_address<own_address>(r.at, 1).error() == errc::bad_argument);
    CHECK(change_address<own_address>(r.at, 41).error() == errc::bad_argument);
    CHECK(r.device.writes == 0);
    CHECK(neighbour.writes == 0);
    CHECK(r.at.node().address == 1);
}

TEST_CASE("S6, G27: an address is taken if two drives respond there at once, so that no response is valid") {
    rig r;
    movable first;
    movable second;
    first.in_force = first.held = second.in_force = 7;
    second.held = 0x5A; // its response differs
    sim::station one{first};
    sim::station other{second};
    r.wire.attach(one);
    r.wire.attach(other);
    REQUIRE(look_for(r.line, 7, r.at.node().limits, own_address.address).what == presence::garbled);
    CHECK(r.change().error() == errc::busy);
    CHECK(r.device.writes == 0);
    CHECK(r.at.node().address == 1);
}

TEST_CASE("S6: an address is taken if any of several reads gets a response there, even a late one") {
    rig r;
    hard_to_hear neighbour;
    neighbour.device.in_force = neighbour.device.held = 7;
    r.wire.attach(neighbour);
    auto& at = r.at.node();
    at.limits.response = milliseconds(20);
    at.gaps.quarantine = milliseconds(50);
    SUBCASE("a request is lost") { neighbour.lost_requests = 1; }
    SUBCASE("a response is lost") { neighbour.lost_responses = 1; }
    SUBCASE("one is lost, and no read is retried") {
        neighbour.lost_responses = 1;
        at.read_retries = 0;
    }
    SUBCASE("all retries but one are lost") { neighbour.lost_responses = at.read_retries; }
    SUBCASE("a request and a response are lost") { neighbour.lost_requests = neighbour.lost_responses = 1; }
    SUBCASE("a response is later than the limit") {
        neighbour.late_responses = 1;
        SUBCASE("shortly") { neighbour.late_by = milliseconds(20); }
        SUBCASE("nearly by the quarantine") { neighbour.late_by = milliseconds(68); }
        SUBCASE("and the others are lost") {
            neighbour.late_by = milliseconds(30);
            at.read_retries = 0;
        }
    }
    SUBCASE("each response is later than the limit") {
        neighbour.late_responses = 1000;
        std::uint32_t late = 0;
        SUBCASE("shortly") { late = 20; }
        SUBCASE("by half the quarantine") { late = 45; }
        SUBCASE("nearly by the quarantine") { late = 68; }
        neighbour.late_by = milliseconds(late);
    }
    CHECK(r.change().error() == errc::busy);
    CHECK(r.device.writes == 0);
    CHECK(neighbour.device.writes == 0);
    CHECK(at.address == 1);
}

TEST_CASE("S6, G29: before the write the new address is read as often as the node's reads are tried, within "
          "the stated time") {
    for (const std::uint8_t retries : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{5}}) {
        CAPTURE(retries);
        rig r;
        REQUIRE(r.at.read<own_address>());
        auto& at = r.at.node();
        at.read_retries = retries;
        at.limits.response = milliseconds(20);
        at.gaps.quarantine = milliseconds(50);
        unsigned asked = 0;
        r.wire.set_hook(
            [](void* to, const sim::wire_byte& b) {
                *static_cast<unsigned*>(to) += b.is_from_client ? 1u : 0u;
            },
            &asked);
        r.device.refuses = true;
        const instant start = r.line.now();
        CHECK(r.change().exception() == 4);
        const unsigned looks = retries == 0 ? 2u : retries + 1u;
        CHECK(asked == 8 * (looks + 1));
        response_limits longer = at.limits;
        longer.response = longer.response + at.gaps.quarantine;
        CHECK(since(start, r.line.now()) >= longer.response * looks);
        CHECK(since(start, r.line.now()) <=
              r.line.bound(8, 7, longer, {}) * (2 * looks) + r.line.bound(8, 8, at.limits, at.gaps));
    }
}

TEST_CASE("G24: a refusal by the drive or the line leaves the client at its old address") {
    rig r;
    SUBCASE("an exception") {
        r.device.refuses = true;
        const status w = r.change();
        CHECK(w.outcome() == outcome::refused);
        CHECK(w.exception() == 4);
    }
    SUBCASE("no drive at either address") {
        REQUIRE(r.at.read<own_address>());
        r.wire.set_connected(0, false);
        const status w = r.change();
        CHECK(w.outcome() == outcome::unknown);
        CHECK(w.error() == errc::timeout);
    }
    SUBCASE("a lost port") {
        r.wire.unplug();
        const status w = r.change();
        CHECK(w.outcome() == outcome::not_sent);
        CHECK(w.error() == errc::port_lost);
    }
    SUBCASE("no drive has responded on this line yet") {
        r.wire.set_connected(0, false);
        CHECK(r.change().outcome() == outcome::not_sent);
    }
    CHECK(r.at.node().address == 1);
}

TEST_CASE("G24: a C630S takes a new address immediately, a ZLAC8015D when it starts again") {
    simulated::simulated_c630s servo;
    client axis{servo.line, node<c630s::device>{1}};
    CHECK(change_address<c630s::node_address>(axis, 9));
    CHECK(axis.node().address == 9);
    CHECK(axis.read<c630s::software_version>());

    simulated::simulated_model<sim::zlac8015d, sim::zlac8015d_options, 115200> wheels;
    client both{wheels.line, node<zlac8015d::device>{1}};
    CHECK(change_address<zlac8015d::node_address>(both, 9).error() == errc::not_reached);
    CHECK(both.write<zlac8015d::save_parameters>(zlac8015d::parameter_save::save_all));
    wheels.model.power_cycle();
    CHECK_FALSE(both.read<zlac8015d::bus_voltage>());
    client there{wheels.line, node<zlac8015d::device>{9}};
    CHECK(there.read<zlac8015d::bus_voltage>());
}

} // namespace change_address_tests
