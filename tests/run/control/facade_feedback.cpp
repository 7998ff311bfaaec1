// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a facade says of feedback that it has not read, or reads while it takes a drive over, stops it for a fault, or
// holds a position back.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include <doctest/doctest.h>

#include <tests/support/bare_rig.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/frame_port.hpp>

namespace facade_feedback_tests {

using namespace servobus;

namespace {

constexpr bare::command become_known{
    .steps = bare_rigs::set_steps, .then = command_kind::power, .makes_known = true};
constexpr bare::command refresh{.steps = bare_rigs::look_steps, .then = command_kind::refresh};

/// A C630S that is set up, and polled.
struct polled : simulated::simulated_c630s {
    c630s::drive<line_type> servo{line, 1};

    void set_up() {
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(c630s::set_up{}));
        model.power_cycle();
        REQUIRE(servo.run(init{}));
    }
    void turn() {
        const duration idle = servo.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    void loop(std::uint32_t us) {
        const std::uint64_t end = wire.time_us() + us;
        while (wire.time_us() < end) turn();
    }
};

/// A drive that is at the place that the test says.
struct placed : sim::c630s {
    std::int32_t place = 5000;

    explicit placed(const sim::c630s& drive) : sim::c630s{drive} {}
    std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = sim::c630s::read(address, to);
        if (address == servobus::c630s::absolute_position.address && to.size() == 2) {
            to[0] = static_cast<u16>(place);
            to[1] = static_cast<u16>(place >> 16);
        }
        return exception;
    }
};

struct placed_bench {
    simulated::driven_c630s made;
    simulated::frame_port<placed> port{placed{made.model}};
    line<simulated::frame_port<placed>> on{port, modbus::timing_at(port.baud)};
    c630s::drive<line<simulated::frame_port<placed>>> servo{on, 1};

    explicit placed_bench(bool is_set_up) {
        if (is_set_up) {
            REQUIRE(made.make_ready());
            port.model = placed{made.model};
        }
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.restart_visible() == is_set_up);
    }
    void loop(std::uint32_t us) {
        const std::uint64_t end = port.time_us() + us;
        while (port.time_us() < end) {
            const duration idle = servo.step();
            port.pass(idle.us == 0 ? microseconds(10) : shorter_of(idle, microseconds(1000)));
        }
    }
    void until_position_is_asked() {
        while (port.requests.empty() ||
               load_word(port.requests.back(), 2) != servobus::c630s::absolute_position.address)
            loop(10);
    }
    std::int32_t position() const {
        const result<c630s::feedback> now = servo.feedback(milliseconds(2000));
        REQUIRE(now);
        return now->position.count();
    }
};

} // namespace

TEST_CASE("G36: the feedback is busy while a drive is taken over again") {
    bare_rigs::rig r{milliseconds(20)};
    r.loop(50);
    REQUIRE(r.drive.check_feedback(milliseconds(30)) == errc::ok);
    REQUIRE(r.drive.begin(bare_rigs::taking_over) == errc::ok);
    while (!r.drive.is_idle()) {
        REQUIRE(r.drive.state() == drive_state::enabled); // as before
        REQUIRE(r.drive.check_feedback(milliseconds(30)) == errc::busy);
        r.turn();
    }
    REQUIRE(r.drive.last());
    r.loop(50);
    CHECK(r.drive.check_feedback(milliseconds(30)) == errc::ok);
}

TEST_CASE("G36: feedback that is exactly as old as asked holds, and older feedback does not") {
    bare_rigs::rig r{milliseconds(20)};
    r.loop(50);
    REQUIRE(r.drive.check_feedback(milliseconds(30)) == errc::ok);
    const instant taken = r.drive.machine().known().polling().image().taken;
    const instant first = r.on.now();
    const instant second = r.on.now();
    const duration look = since(first, second); // what a look at the clock takes here
    const duration age = since(taken, second);
    CHECK(r.drive.check_feedback(age + look) == errc::ok);
    CHECK(r.drive.check_feedback(age + look) == errc::timeout); // a look later
}

TEST_CASE("G36: a drive whose feedback was never read has none, however young the clock is") {
    bare_rigs::rig r;
    bare::drive<bare_rigs::rig::line_type> drive{r.on, node<bare_rigs::device>{1}, milliseconds(20)};
    REQUIRE(drive.run(become_known));
    REQUIRE(drive.state() == drive_state::enabled);
    CHECK(drive.check_feedback(milliseconds(60'000)) == errc::timeout);
    for (int i = 0; i < 100; ++i) {
        (void)drive.step();
        r.port.time += 100;
    }
    CHECK(drive.check_feedback(milliseconds(60'000)) == errc::ok);
}

TEST_CASE(
    "G35: while the stop for a fault is under way a motion is refused for the fault, a refresh is busy") {
    bare_rigs::rig r{milliseconds(20)};
    bare::model::judges = [](std::uint16_t) { return verdict::faulted; };
    while (r.drive.is_idle()) r.turn(); // until its stop begins
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
    REQUIRE(r.drive.cause() == stop_cause::fault);
    CHECK(r.drive.begin(bare_rigs::move) == errc::faulted);
    CHECK(r.drive.begin(bare_rigs::look) == errc::faulted);
    CHECK(r.drive.begin(refresh) == errc::busy);
    while (!r.drive.is_idle()) r.turn();
    CHECK(r.drive.run(refresh));
}

TEST_CASE("G36: a long response between a position and the status that confirms it leaves both right") {
    polled p;
    p.set_up();
    REQUIRE(p.servo.run(c630s::enable_in{c630s::control_mode::position}));
    const std::int32_t there = p.servo.feedback(milliseconds(2000))->position.count();
    unsigned read = 0;
    for (std::uint32_t phase = 0; phase < 200; ++phase) {
        CAPTURE(phase);
        p.loop(phase * 977 % 20'000);
        const auto record = p.servo.run(c630s::read_fault{1});
        REQUIRE(record);
        p.loop(150'000 + phase % 50 * 400);
        const result<c630s::feedback> now = p.servo.feedback(milliseconds(2000));
        if (!now) continue;
        ++read;
        REQUIRE(std::abs(now->position.count() - there) <= 60); // it stands
    }
    CHECK(read > 100);
}

TEST_CASE(
    "S5: a position that falls to zero asks for the marker, if there is one and the origin does not move") {
    enum class scene : std::uint8_t { is_marked, is_not_marked, is_restarted };
    for (const scene how : {scene::is_marked, scene::is_not_marked, scene::is_restarted}) {
        CAPTURE(static_cast<int>(how));
        placed_bench there{how != scene::is_not_marked};
        placed_bench fallen{how != scene::is_not_marked};
        for (placed_bench* b : {&there, &fallen}) {
            b->loop(1'000'000);
            REQUIRE(b->position() == 5000);
            if (b == &fallen) b->port.model.place = 3;
            b->port.requests.clear();
            b->until_position_is_asked();
            // Its response comes while the command is under way that puts the position to zero.
            if (how == scene::is_restarted) REQUIRE(b->servo.begin(c630s::restart{}) == errc::ok);
            do b->loop(100'000);
            while (!b->servo.is_idle());
        }
        // The frames are those of a drive whose position stays, but for the read of the marker.
        CHECK((fallen.port.requests != there.port.requests) == (how == scene::is_marked));
        if (how != scene::is_restarted) CHECK(fallen.position() == 3);
    }
}

TEST_CASE("G36: a position that falls counts with its own response where nothing can show a restart") {
    placed_bench b{false};
    b.loop(500'000);
    REQUIRE(b.position() == 5000);
    b.port.model.place = 3;
    b.until_position_is_asked();
    const std::size_t asked = b.port.requests.size();
    while (b.position() == 5000 && b.port.requests.size() == asked) b.loop(10);
    CHECK(b.position() == 3);
}

TEST_CASE("G36: a position that was held back when a take-over began is not delivered after it") {
    for (std::uint32_t later = 0; later < 20'000; later += 1000) {
        CAPTURE(later);
        placed_bench b{true};
        b.loop(1'000'000);
        REQUIRE(b.position() == 5000);
        b.port.model.place = 3; // as after a restart: it counts once the marker was read
        b.port.requests.clear();
        b.until_position_is_asked();
        b.loop(later);
        REQUIRE(b.servo.begin(init{}) == errc::ok);
        b.port.model.place = 7000;
        while (!b.servo.is_idle()) b.loop(100);
        REQUIRE(b.servo.last());
        for (int i = 0; i < 1000; ++i) {
            b.loop(1000);
            if (const result<c630s::feedback> now = b.servo.feedback(milliseconds(2000)))
                REQUIRE(now->position.count() == 7000);
        }
        CHECK(b.position() == 7000);
    }
}

} // namespace facade_feedback_tests
