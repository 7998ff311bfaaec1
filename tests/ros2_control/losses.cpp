// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive that faults, is stopped by its wiring, restarts or is lost deactivates the interface once, with one sentence
// in the log, and never moves again by itself.
#include "robot.hpp"

#include <servobus/sim/faults.hpp>

namespace robots::losses {

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// Drives forward until `happens` has been called, then until the error and through the stop for it. Returns the log's
/// first error. A drive that cannot be reached is stopped by its watchdog and stays enabled.
template <class Happens>
std::string error_after(world& w, Happens happens, std::uint32_t within_ms, bool is_reachable = true) {
    w.begin();
    REQUIRE(w.component.is_active());
    w.component.command(5, 5);
    REQUIRE(w.run(1500) == return_type::OK);
    happens();
    const std::uint64_t began = w.wire.time_us();
    CHECK(w.run(5000) == return_type::ERROR);
    CHECK((w.wire.time_us() - began) / 1000 < within_ms);
    CHECK(w.component.state() == primary::PRIMARY_STATE_UNCONFIGURED);
    CHECK(w.component.errors() == 1);
    // The framework's loop goes on with its other components.
    CHECK(w.run(3000) == return_type::OK);
    CHECK(w.drive.stands_still());
    if (is_reachable) CHECK(!w.drive.enabled());
    const auto all = w.errors();
    CAPTURE(all.size());
    REQUIRE(!all.empty());
    MESSAGE(all[0]);
    return all[0];
}

TEST_CASE("a fault of one wheel deactivates, and the log names it") {
    world w;
    using servobus::zlac8015d::fault;
    const std::string error = error_after(
        w, [&] { w.drive.raise(fault::overcurrent, fault::none); }, 400);
    CHECK(has(error, "base: the drive has a fault: left overcurrent; right none"));
    CHECK(w.errors().size() == 1);

    SUBCASE("its cause is still there: no activation") {
        w.component.configure();
        w.component.activate();
        CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
        CHECK(has(w.errors().back(),
                  "left overcurrent; right none; parameter reset_faults lets an activation reset them"));
        CHECK(w.component.value("drive/is_faulted") == 1);
    }
    SUBCASE("its cause has ended: the fault stays without the parameter") {
        w.drive.end_faults();
        w.component.configure();
        w.component.activate();
        CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    }
}
TEST_CASE("an error is logged once, and stays an error until the framework handles it") {
    world w;
    w.begin();
    w.component.command(5, 5);
    REQUIRE(w.run(1000) == return_type::OK);
    using servobus::zlac8015d::fault;
    w.drive.raise(fault::none, fault::overvoltage);
    w.wire.pass(milliseconds(10));
    unsigned wrong = 0;
    for (int i = 0; i < 50; ++i) { // a manager that goes on without on_error
        const rclcpp::Duration period{std::chrono::milliseconds{10}};
        wrong += w.hardware.read(rclcpp::Time{}, period) == return_type::ERROR ? 1u : 0u;
        wrong += w.hardware.write(rclcpp::Time{}, period) == return_type::ERROR ? 1u : 0u;
        w.wire.pass(milliseconds(10));
    }
    CHECK(wrong > 80);
    CHECK(w.errors().size() == 1);
    CHECK(!w.drive.enabled());
}
TEST_CASE("reset_faults lets an activation reset a fault whose cause has ended") {
    world w;
    auto info = description();
    info.hardware_parameters["reset_faults"] = "true";
    using servobus::zlac8015d::fault;
    w.drive.raise(fault::none, fault::hall);
    w.begin(info);
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    CHECK(has(w.errors().back(), "right hall"));
    w.drive.end_faults();
    w.component.activate();
    CHECK(w.component.is_active());
    w.component.command(2, 2);
    CHECK(w.run(1000) == return_type::OK);
}

TEST_CASE("a wired stop deactivates; its end moves nothing") {
    world w;
    const std::string error = error_after(
        w, [&] { w.drive.set_input(true, false); }, 800);
    CHECK(has(error, "a wired stop, or another program, has stopped the drive [state: quick-stopped"));
    CHECK(w.errors().size() == 1);
    w.component.configure();
    w.component.activate();
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    CHECK(has(w.errors().back(), "is a wired stop active?"));
    w.drive.set_input(false, false);
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.drive.stands_still());
    w.component.activate();
    CHECK(w.component.is_active());
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.drive.stands_still());
}

TEST_CASE("a restart is reported; the positions go on from their last value") {
    world w;
    double before = 0;
    const std::string error = error_after(
        w,
        [&] {
            before = w.position("left");
            w.drive.power_cycle();
        },
        800);
    CHECK(has(error, "the drive has restarted, or was switched off [state: needs init, cause: restart]"));
    CHECK(w.errors().size() == 1);
    CHECK(w.position("left") >= before);
    CHECK(w.position("left") - before < 0.5);
    const double there = w.position("left");
    w.component.configure();
    w.component.activate();
    REQUIRE(w.component.is_active());
    CHECK(w.position("left") == doctest::Approx(there));
    CHECK(w.component.value("drive/position_gaps") == 1);
    const double real = w.left();
    w.component.command(5, 5);
    REQUIRE(w.run(2000) == return_type::OK);
    w.component.command(0, 0);
    REQUIRE(w.run(1500) == return_type::OK);
    CHECK(w.position("left") - there == doctest::Approx(w.left() - real).epsilon(1e-6));
}

TEST_CASE("no cycle publishes a position of after a restart as one of before it") {
    unsigned restarts = 0;
    for (std::uint32_t ms = 200; ms < 3000; ms += 97) { // at any place: near zero too
        world w;
        w.begin();
        w.component.command(2, -2);
        (void)w.run(ms);
        w.drive.power_cycle();
        ++restarts;
        double last = w.position("left");
        bool is_ended = false;
        for (int i = 0; i < 300 && !is_ended; ++i) {
            is_ended = w.cycle() != return_type::OK;
            CHECK(std::abs(w.position("left") - last) < 0.2);
            last = w.position("left");
        }
        CHECK(is_ended);
        CHECK(w.component.errors() == 1);
    }
    MESSAGE(restarts, " restarts");
}

TEST_CASE("single lost frames are survived, and cost no count") {
    unsigned frames = 0, runs = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        world w{{}, seed};
        w.begin();
        REQUIRE(w.component.is_active());
        w.wire.faults().lost_request = 10; // of 1000
        w.wire.faults().lost_response = 10;
        w.wire.faults().corrupted_response = 10;
        w.component.command(4, -3);
        const return_type how = w.run(10'000);
        frames += w.wire.struck();
        if (how != return_type::OK) continue;
        ++runs;
        w.wire.faults() = {};
        w.component.command(0, 0);
        REQUIRE(w.run(2000) == return_type::OK);
        CHECK(w.position("left") == doctest::Approx(w.left()).epsilon(1e-9));
        CHECK(w.position("right") == doctest::Approx(w.right()).epsilon(1e-9));
        CHECK(w.errors().empty());
    }
    MESSAGE(runs, " of 20 runs of 10 s to their end, ", frames, " frames struck");
    CHECK(runs == 20);
}

TEST_CASE("a line that is cut for less than the watchdog is survived") {
    world w;
    w.begin();
    w.component.command(5, 5);
    REQUIRE(w.run(1500) == return_type::OK);
    w.wire.cut_for(milliseconds(150));
    REQUIRE(w.run(2000) == return_type::OK);
    CHECK(w.velocity("left") == doctest::Approx(5).epsilon(0.01));
}

TEST_CASE("a line that is cut for longer than the watchdog deactivates") {
    world w;
    const std::string error = error_after(
        w, [&] { w.wire.cut_for(milliseconds(3000)); }, 1500, false);
    CHECK(has(error, "the drive did not respond for the time of its watchdog, 500 ms"));
    CHECK(w.errors().size() == 2); // and that the stop is not confirmed
}

TEST_CASE("a port that is unplugged deactivates at once, and configures again when it is back") {
    world w;
    const std::string error = error_after(
        w, [&] { w.wire.unplug(); }, 100, false);
    CHECK(has(error, "the port is gone (Input/output error)"));
    CHECK(w.errors().size() == 2);
    w.wire.plug();
    w.component.configure();
    w.component.activate();
    CHECK(w.component.is_active());
    const double real = w.left();
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.left() == real);
    w.component.command(2, 2);
    CHECK(w.run(1000) == return_type::OK);
    CHECK(w.velocity("left") == doctest::Approx(2).epsilon(0.01));
}

TEST_CASE("an inactive drive that is lost is a warning, no error") {
    world w;
    w.begin();
    w.component.deactivate();
    REQUIRE(w.run(500) == return_type::OK);
    w.wire.set_connected(0, false);
    CHECK(w.run(5000) == return_type::OK);
    CHECK(w.component.state() == primary::PRIMARY_STATE_INACTIVE);
    CHECK(w.errors().empty());
    CHECK(has(stand_in::logged().back(), "WARN base: the inactive drive has restarted or does not respond"));
}

} // namespace robots::losses
