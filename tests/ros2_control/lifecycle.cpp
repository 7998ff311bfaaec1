// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The transitions: what a wrong description, a port that is not there, an absent drive and a contradiction do, and that
// the wheels stand after each way out.
#include "robot.hpp"

#include <memory>

namespace robots::lifecycle {

/// The interface refuses a description, with one sentence and without opening the port.
template <class Change> void is_refused(const char* sentence, Change change) {
    world w;
    auto info = description();
    change(info);
    w.begin(info);
    CAPTURE(sentence);
    CHECK(w.component.state() == primary::PRIMARY_STATE_FINALIZED);
    CHECK(virtual_port::opened == 0);
    REQUIRE(w.errors().size() == 1);
    CHECK(w.errors()[0] == std::string{"base: "} + sentence);
}
void parameter_is_refused(const char* name, const char* value, const char* sentence) {
    is_refused(sentence, [&](auto& info) { info.hardware_parameters[name] = value; });
}

TEST_CASE("wrong parameters are refused with one sentence, and nothing is opened") {
    is_refused("parameter 'port' is missing", [](auto& i) { i.hardware_parameters.erase("port"); });
    is_refused("parameter 'left_counts_per_turn' is missing",
               [](auto& i) { i.hardware_parameters.erase("left_counts_per_turn"); });
    is_refused("parameter 'right_counts_per_turn' is missing",
               [](auto& i) { i.hardware_parameters.erase("right_counts_per_turn"); });
    parameter_is_refused("prot", "x", "unknown parameter 'prot'");
    for (const char* wrong : {"0", "-4096", "4096.0", "", "nan", "16388", " 4096", "99999999999999999999"}) {
        const std::string sentence = "parameter 'left_counts_per_turn': '" + std::string{wrong} +
                                     "' is no whole number from 4 to 16384";
        parameter_is_refused("left_counts_per_turn", wrong, sentence.c_str());
    }
    parameter_is_refused("left_counts_per_turn", "4098",
                         "counts per turn are 4 times the encoder's lines: a multiple of 4");
    parameter_is_refused("node", "0", "parameter 'node': '0' is no whole number from 1 to 127");
    parameter_is_refused("node", "128", "parameter 'node': '128' is no whole number from 1 to 127");
    parameter_is_refused("baud", "100000", "parameter 'baud': the drive has no rate of 100000");
    parameter_is_refused("right_mirrored", "yes",
                         "parameter 'right_mirrored': 'yes' is neither true nor false");
    parameter_is_refused("watchdog_ms", "0",
                         "parameter 'watchdog_ms': '0' is no whole number from 1 to 32767");
}

TEST_CASE("wrong joints and sensors are refused likewise") {
    is_refused("two joints are needed, the left wheel and then the right one; there are 1",
               [](auto& i) { i.joints.pop_back(); });
    is_refused("two joints are needed, the left wheel and then the right one; there are 3",
               [](auto& i) { i.joints.push_back(i.joints[0]); });
    is_refused("both joints are called 'left_wheel_joint'",
               [](auto& i) { i.joints[1].name = i.joints[0].name; });
    is_refused("joint 'left_wheel_joint' needs one command interface, velocity",
               [](auto& i) { i.joints[0].command_interfaces[0].name = "position"; });
    is_refused("joint 'right_wheel_joint' needs one command interface, velocity",
               [](auto& i) { i.joints[1].command_interfaces.push_back(i.joints[1].command_interfaces[0]); });
    is_refused("joint 'left_wheel_joint' needs two state interfaces, position and velocity",
               [](auto& i) { i.joints[0].state_interfaces.pop_back(); });
    is_refused("joint 'left_wheel_joint' needs two state interfaces, position and velocity",
               [](auto& i) { i.joints[0].state_interfaces[1].name = "effort"; });
    is_refused("sensor 'drive' has no interface 'voltage'",
               [](auto& i) { i.sensors[0].state_interfaces[0].name = "voltage"; });
    is_refused("there is at most one sensor", [](auto& i) { i.sensors.push_back(i.sensors[0]); });
    is_refused("there are no GPIOs", [](auto& i) { i.gpios.push_back(i.sensors[0]); });
    is_refused("transmissions are not applied: state the wheel's own counts per turn",
               [](auto& i) { i.transmissions.emplace_back(); });
}

TEST_CASE("a description without a sensor, and in another order, is accepted") {
    world w;
    auto info = description();
    info.sensors.clear();
    std::swap(info.joints[0].state_interfaces[0], info.joints[0].state_interfaces[1]);
    info.hardware_parameters["right_mirrored"] = "True"; // as xacro writes it
    w.begin(info);
    CHECK(w.component.is_active());
    CHECK(w.component.names().size() == 6);
}

TEST_CASE("a port that is not there leaves the component unconfigured") {
    world w;
    auto info = description();
    info.hardware_parameters["port"] = "/dev/nothing";
    w.begin(info);
    CHECK(w.component.state() == primary::PRIMARY_STATE_UNCONFIGURED);
    REQUIRE(w.errors().size() == 1);
    CHECK(w.errors()[0] == "base: cannot open /dev/nothing: there is no such port");
}

TEST_CASE(
    "configuring sends nothing; an absent drive leaves the component inactive, and it is activated later") {
    world w;
    w.wire.set_connected(0, false);
    w.component.initialise(description());
    w.component.configure();
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.wire.requests() == 0);
    const std::uint64_t began = w.wire.time_us();
    w.component.activate();
    CHECK(w.wire.time_us() - began < 5'000'000);
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    REQUIRE(w.errors().size() == 1);
    CHECK(w.errors()[0] == "base: the drive is not taken over: init: no response");
    w.wire.set_connected(0, true);
    w.component.activate();
    CHECK(w.component.is_active());
}

TEST_CASE("a port that was lost while the component was inactive is opened again by the activation") {
    world w;
    w.begin();
    w.component.deactivate();
    w.wire.unplug();
    REQUIRE(w.run(1000) == return_type::OK);
    w.component.activate();
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    CHECK(w.errors().size() == 1);
    w.wire.plug();
    w.component.activate();
    CHECK(w.component.is_active());
    CHECK(virtual_port::opened == 3);
}

TEST_CASE("counts that contradict the drive's encoder lines fail the activation, and the drive stays without "
          "power") {
    for (const bool is_left : {true, false}) {
        world w;
        auto info = description();
        info.hardware_parameters[is_left ? "left_counts_per_turn" : "right_counts_per_turn"] = "16384";
        w.begin(info);
        CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
        CHECK(!w.drive.enabled());
        REQUIRE(w.errors().size() == 1);
        CHECK(w.errors()[0] ==
              std::string{"base: "} + (is_left ? "left" : "right") +
                  "_counts_per_turn is 16384, but the drive counts 4096: its encoder lines, " +
                  (is_left ? "2030h" : "2060h") + ", are 1024");
    }
}

TEST_CASE("a new drive is activated once it was switched off and on") {
    world w;
    w.drive.store(servobus::zlac8015d::speed_resolution.address, 1);
    w.drive.power_cycle();
    w.begin();
    for (int i = 0; i < 3; ++i) {
        CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
        CHECK(w.drive.enables() == 0);
        REQUIRE(!w.errors().empty());
        CHECK(w.errors().back() == "base: the drive has a new resolution of speeds (2022h): switch it off "
                                   "and on, then activate again");
        w.component.activate();
    }
    CHECK(w.drive.saves() == 1);
    w.drive.power_cycle();
    w.component.activate();
    CHECK(w.component.is_active());
}

TEST_CASE("a watchdog that a lost frame would exceed is refused by the activation") {
    world w;
    auto info = description();
    info.hardware_parameters["watchdog_ms"] = "100";
    w.begin(info);
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    REQUIRE(w.errors().size() == 1);
    CHECK(w.errors()[0] ==
          "base: the drive is not taken over: setting (watchdog_ms): value outside the register's range");
}

TEST_CASE("a drive that another program has left moving is stopped by the activation") {
    world w;
    const auto set = [&](std::uint16_t address, std::uint16_t value) {
        const std::uint8_t word[]{static_cast<std::uint8_t>(value >> 8),
                                  static_cast<std::uint8_t>(value & 0xFFu)};
        (void)w.drive.write(address, words_view{word});
    };
    set(0x200D, 3);
    set(0x2088, 20);
    set(0x200E, 8);
    set(0x2000, 0);
    w.wire.pass(milliseconds(2000));
    REQUIRE(!w.drive.stands_still());
    w.begin();
    CHECK(w.component.is_active());
    CHECK(w.drive.stands_still());
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.drive.stands_still());
}

TEST_CASE("each way out stops wheels that turn: they stand and have no power") {
    for (int way = 0; way < 4; ++way) {
        auto w = std::make_unique<world>();
        auto hardware = std::make_unique<system>();
        manager::component component{*hardware};
        component.initialise(description());
        component.configure();
        component.activate();
        REQUIRE(component.is_active());
        component.command(8, 8);
        for (int i = 0; i < 200; ++i) {
            (void)component.read();
            (void)component.write();
            w->wire.pass(milliseconds(10));
        }
        REQUIRE(!w->drive.stands_still());
        CAPTURE(way);
        switch (way) {
        case 0: component.deactivate(); break;
        case 1: component.shut_down(); break;
        case 2: hardware.reset(); break; // as Humble does on Ctrl-C
        default: (void)hardware->on_error({primary::PRIMARY_STATE_ACTIVE, "active"}); break;
        }
        CHECK(w->drive.stands_still());
        CHECK(!w->drive.enabled());
        CHECK(world::errors().empty());
    }
}

TEST_CASE("a stop that is not confirmed is tried again by on_error") {
    unsigned second = 0;
    for (std::uint32_t ms = 100; ms <= 3000; ms += 100) {
        world w;
        w.begin();
        w.component.command(5, 5);
        REQUIRE(w.run(1500) == return_type::OK);
        w.wire.cut_for(milliseconds(ms));
        w.component.deactivate();
        if (w.component.state() == primary::PRIMARY_STATE_INACTIVE) CHECK(!w.drive.enabled()); // confirmed
        second += w.component.state() == primary::PRIMARY_STATE_UNCONFIGURED && !w.drive.enabled() ? 1u : 0u;
        CHECK(w.run(2500) == return_type::OK);
        CHECK(w.drive.stands_still());
    }
    MESSAGE(second, " of 30 by the second attempt");
    CHECK(second > 0);
}

TEST_CASE("positions are followed while the component is inactive, and go on over each transition") {
    world w;
    w.begin();
    w.component.command(3, 3);
    REQUIRE(w.run(2000) == return_type::OK);
    w.component.deactivate();
    const double there = w.position("left");
    CHECK(there == doctest::Approx(w.left()).epsilon(1e-9));
    REQUIRE(w.run(1000) == return_type::OK);
    w.component.clean_up();
    w.component.configure();
    w.component.activate();
    REQUIRE(w.component.is_active());
    CHECK(w.run(200) == return_type::OK);
    CHECK(w.position("left") == doctest::Approx(there));
    CHECK(w.component.value("drive/position_gaps") == 1);
    CHECK(w.errors().empty());
}

} // namespace robots::lifecycle
