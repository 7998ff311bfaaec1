// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives on a port that opens itself again (`reconnecting`): the first frame after a loss is a stop, and nothing moves
// before the next consent. Judged by the frames on the wire and by the simulated motors.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/control/setpoint_loop.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/line/reconnecting.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_yako.hpp>

namespace port_reconnects_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

/// An adapter at the end of a virtual line: closed once it was unplugged, until it is opened again.
class adapter {
  public:
    struct endpoint {
        sim::virtual_line* wire = nullptr;
    };

    status open(const endpoint& at) {
        wire_ = at.wire;
        is_open_ = static_cast<bool>(wire_->receive(byte_buffer{}));
        return is_open_ ? errc::ok : errc::no_such_port;
    }
    void close() { is_open_ = false; }
    bool is_open() const { return is_open_; }
    transfer send(bytes out) { return seen(is_open_ ? wire_->send(out) : transfer{errc::port_lost}); }
    bool sent() { return wire_->sent(); }
    transfer receive(byte_buffer in) {
        return seen(is_open_ ? wire_->receive(in) : transfer{errc::port_lost});
    }
    instant now() { return wire_->now(); }
    void wait(duration d) {
        if (is_open_)
            wire_->wait(d);
        else
            wire_->pass(d);
    }

  private:
    transfer seen(const transfer& t) {
        is_open_ = is_open_ && (t || t.error() != errc::port_lost);
        return t;
    }

    sim::virtual_line* wire_ = nullptr;
    bool is_open_ = false;
};

using port_type = reconnecting<adapter>;
using line_type = line<port_type>;

template <class Model> struct plugged {
    Model model;
    sim::station<Model> station{model};
    sim::virtual_line wire{115200};
    port_type port{&wire};
    line_type on{port, modbus::timing_at(115200)};
    simulated::request_log log;

    plugged() {
        wire.attach(station);
        wire.set_hook(&simulated::request_log::note, &log);
    }
    plugged(const plugged&) = delete;

    template <class Step> void live(std::uint32_t ms, const Step& step) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) {
            const duration idle = step();
            port.wait(idle < microseconds(200) ? microseconds(50) : microseconds(200));
        }
    }
    void unplug() {
        wire.unplug();
        log.open.clear(); // a request that the loss has cut
    }
};

} // namespace

TEST_CASE("G45, G47: the first frame on a port that opened itself is a stop, of a drive without a watchdog "
          "that moves") {
    for (const std::uint32_t lost : {20u, 499u, 700u, 3000u}) {
        CAPTURE(lost);
        plugged<sim::yako_closed_loop> s;
        yako::closed_loop::drive<line_type> drive{s.on, 1, unsupervised};
        const auto step = [&] { return drive.step(); };
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable{}));
        REQUIRE(drive.run(velocity{60 * r_per_min}));
        s.live(400, step);
        REQUIRE(s.model.view().is_moving);
        (void)s.port.take_change();
        s.unplug();
        CHECK(drive.run(read_feedback{}) == errc::port_lost);
        CHECK(s.port.take_change());
        s.live(lost, step);
        REQUIRE(s.model.view().is_moving); // it runs on without the line
        s.wire.plug();
        const std::size_t before = s.log.frames.size();
        s.live(600, step);
        CHECK(s.port.is_open());
        CHECK(s.port.take_change());
        REQUIRE(s.log.frames.size() > before);
        CHECK(same_bytes(s.log.frames[before], enabled_yako::stop_frame));
        s.live(1500, step);
        CHECK_FALSE(s.model.view().is_moving);
        CHECK(drive.state() == drive_state::needs_init);
        CHECK_FALSE(drive.run(velocity{60 * r_per_min}));
        s.live(500, step);
        CHECK_FALSE(s.model.view().is_moving);
    }
}

TEST_CASE(
    "S3, G44, G47: wheels whose port opens itself are taken over, and turn only after another consent") {
    for (const std::uint32_t lost : {100u, 700u, 2000u}) {
        CAPTURE(lost);
        plugged<sim::zlac8015d> s;
        zlac8015d::drive<line_type> wheels{
            s.on, 1, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
        setpoint_loop loop{wheels, take_over{}, enable{}, setpoints<zlac8015d::clamped_velocity>{}};
        unsigned changes = 0;
        const auto step = [&] {
            loop.set({30 * r_per_min, 30 * r_per_min});
            const duration idle = loop.step();
            if (s.port.take_change()) ++changes;
            (void)loop.take_report();
            return idle;
        };
        const auto turns = [&] { return !simulated::are_slow(s.model); };
        s.live(1000, step);
        CHECK_FALSE(turns());
        loop.enable();
        s.live(2000, step);
        REQUIRE(turns());
        CHECK(changes == 1);
        s.unplug();
        s.live(lost, step);
        CHECK(changes == 2);
        CHECK_FALSE(s.port.is_open());
        s.wire.plug();
        const std::size_t before = s.log.frames.size();
        s.live(4000, step);
        CHECK(changes == 3);
        CHECK(s.port.is_open());
        REQUIRE(s.log.frames.size() > before);
        const simulated::frame& first = s.log.frames[before];
        CHECK(modbus::is_write(first[1]));
        for (std::size_t i = before; i < s.log.frames.size(); ++i)
            CHECK_FALSE(simulated::is_motion_or_enable(s.log.frames[i]));
        CHECK_FALSE(turns());
        CHECK(loop.is_taken_over());
        CHECK_FALSE(loop.is_motion_allowed());
        loop.enable();
        s.live(2000, step);
        CHECK(turns());
    }
}

} // namespace port_reconnects_tests
