// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A restart in the middle of a move, a homing or a refresh: no wait takes it for an arrival, and no position of the
// restarted drive is delivered as that of the one before. The simulated shaft, which no restart resets, says where the
// motor is.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <servobus/servobus.hpp>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/driven_machine.hpp>

namespace lives_tests {

using namespace servobus;
using namespace servobus::units;
namespace y = servobus::yako;
namespace z = servobus::zlac8015d;
namespace c = servobus::c630s;

namespace {

using tests::on_wire;
template <class Sim, class Drive> using bench = tests::driven_machine<Sim, Drive>;

struct closed {
    using sim = servobus::sim::yako_closed_loop;
    using drive = y::closed_loop::drive<on_wire>;
};
struct open {
    using sim = servobus::sim::yako_open_loop;
    using drive = y::open_loop::drive<on_wire>;
};
template <class Axis> using stepper = bench<typename Axis::sim, typename Axis::drive>;
using wheels_bench = bench<sim::zlac8015d, z::drive<on_wire>>;

} // namespace

TEST_CASE_TEMPLATE("G34, G39: a YAKO that restarts on its way to zero is not taken for one that arrived",
                   Axis, closed, open) {
    unsigned judged = 0;
    for (const bool waits_for_standstill : {false, true}) {
        for (const std::uint32_t feedback : {20u, 100u, 250u}) {
            for (const std::uint32_t boot_ms : {0u, 150u}) {
                for (std::uint32_t at = 3'000; at < 600'000; at += 37'000) {
                    CAPTURE(feedback);
                    CAPTURE(at);
                    stepper<Axis> b{115200, sim::yako_options{},
                                    supervision{milliseconds(feedback), no_command_timeout}};
                    REQUIRE(b.drive.run(init{}));
                    REQUIRE(b.drive.run(enable{}));
                    REQUIRE(b.drive.run(move_by{1500 * pulse}, wait_reached{}).how == arrival_state::reached);
                    REQUIRE(b.drive.restart_visible());
                    const long long before = b.machine.view().shaft;
                    REQUIRE(b.drive.run(move_by{-1500 * pulse}));
                    REQUIRE((waits_for_standstill ? b.drive.begin(wait_standstill{})
                                                  : b.drive.begin(wait_reached{})) == errc::ok);
                    b.pass(at);
                    if (b.drive.is_idle()) continue; // it had arrived
                    ++judged;
                    b.machine.power_cycle();
                    b.wire.set_connected(0, boot_ms == 0);
                    b.pass(boot_ms * 1000u);
                    b.wire.set_connected(0, true);
                    b.pass(2'000'000);
                    REQUIRE(b.drive.is_idle());
                    const bool has_arrived = b.machine.view().shaft - before < -1500 + 5;
                    if (has_arrived) continue;
                    CHECK_FALSE(b.drive.last());
                    CHECK(b.drive.arrival().how != arrival_state::reached);
                }
            }
        }
    }
    CHECK(judged > 100);
}

TEST_CASE("G34, G37: a homing that a restart cuts short is not done, also where the homed bit survives") {
    unsigned judged = 0;
    for (const bool keeps_homed : {false, true}) {
        for (std::uint32_t at = 1'000; at < 900'000; at += 41'000) {
            sim::yako_options options{};
            options.restart_keeps_homed = keeps_homed;
            stepper<closed> b{115200, options, without_watchdog};
            REQUIRE(b.drive.run(init{}));
            REQUIRE(b.drive.run(enable{}));
            REQUIRE(b.drive.run(declare_position{0 * pulse}));
            REQUIRE(b.drive.run(move_by{800 * pulse}, wait_reached{}).how == arrival_state::reached);
            if (b.drive.begin(y::closed_loop::home{y::homing::negative_limit}) != errc::ok) FAIL("no homing");
            b.pass(at);
            if (b.drive.is_idle()) continue;
            ++judged;
            b.machine.power_cycle();
            b.pass(3'000'000);
            if (!b.drive.is_idle()) b.pass(120'000'000);
            CHECK_FALSE(b.drive.last());
        }
    }
    CHECK(judged > 20);
}

TEST_CASE("G36, G39: no position of a restarted ZLAC8015D is given as that of the one before") {
    unsigned judged = 0;
    for (const auto shaft :
         {sim::zlac8015d_options::shaft::locked, sim::zlac8015d_options::shaft::released}) {
        for (std::uint32_t phase = 0; phase < 60; ++phase) {
            sim::zlac8015d_options options{};
            options.while_turning = shaft;
            wheels_bench b{115200, options, supervision{milliseconds(20), milliseconds(500)}};
            REQUIRE(b.drive.run(init{}));
            REQUIRE(b.drive.run(enable{}));
            REQUIRE(b.drive.run(velocity{60 * r_per_min, 60 * r_per_min}));
            for (int i = 0; i < 20; ++i) {
                b.pass(100'000);
                REQUIRE(b.drive.run(velocity{60 * r_per_min, 60 * r_per_min}));
            }
            b.pass(50'000 + phase * 371);
            const auto last = b.drive.feedback(milliseconds(60));
            REQUIRE(last);
            b.machine.power_cycle();
            for (int i = 0; i < 1000 && b.drive.state() != z::drive_state::needs_init; ++i) {
                b.pass(500);
                const auto now = b.drive.feedback(milliseconds(60));
                if (!now) continue;
                ++judged;
                REQUIRE(now->left_position.count() > last->left_position.count() - 200);
            }
            CHECK(b.drive.state() == z::drive_state::needs_init);
        }
    }
    CHECK(judged > 60);
}

TEST_CASE(
    "G37, G39: on an undisturbed line no refresh of a turning ZLAC8015D fails, whatever its shafts read as") {
    for (const auto shaft :
         {sim::zlac8015d_options::shaft::locked, sim::zlac8015d_options::shaft::released}) {
        sim::zlac8015d_options options{};
        options.while_turning = shaft;
        wheels_bench b{115200, options, supervision{milliseconds(20), no_command_timeout}};
        REQUIRE(b.drive.run(init{}));
        REQUIRE(b.drive.run(enable{}));
        REQUIRE(b.drive.run(velocity{60 * r_per_min, -60 * r_per_min}));
        b.pass(200'000);
        for (int i = 0; i < 100; ++i) {
            b.pass(3'000);
            REQUIRE(b.drive.feedback(milliseconds(60)));
            if (i % 10 == 0) REQUIRE(b.drive.read());
        }
    }
}

TEST_CASE_TEMPLATE(
    "G36, G39: no position of a restarted YAKO that was not homed is given as that of the one before", Axis,
    closed, open) {
    unsigned judged = 0;
    for (const bool jogs : {false, true}) {
        for (std::uint32_t phase = 0; phase < 40; ++phase) {
            stepper<Axis> b{115200, sim::yako_options{}, without_watchdog};
            REQUIRE(b.drive.run(init{}));
            REQUIRE(b.drive.run(enable{}));
            REQUIRE((jogs ? b.drive.run(velocity{300 * r_per_min})
                          : b.drive.run(move_by{100'000 * pulse,
                                                y::motion_profile{0 * r_per_min, 100 * millisecond,
                                                                  100 * millisecond, 300 * r_per_min}})));
            b.pass(1'000'000 + phase * 1977);
            const auto last = b.drive.feedback(milliseconds(60));
            REQUIRE(last);
            b.machine.power_cycle();
            for (int i = 0; i < 2000 && b.drive.state() == y::drive_state::enabled; ++i) {
                b.pass(500);
                const auto now = b.drive.feedback(milliseconds(60));
                if (!now) continue;
                ++judged;
                REQUIRE(now->position.count() > last->position.count() - 10);
            }
            CHECK(b.drive.state() == y::drive_state::needs_init);
        }
    }
    CHECK(judged > 40);
}

TEST_CASE("G39: after a declared position, a clearing or a homing a lower position raises no suspicion") {
    stepper<closed> b{115200, sim::yako_options{}, without_watchdog};
    REQUIRE(b.drive.run(init{}));
    REQUIRE(b.drive.run(enable{}));
    REQUIRE(b.drive.run(move_by{20'000 * pulse}, wait_reached{}).how == arrival_state::reached);
    b.pass(30'000);
    REQUIRE(b.drive.run(declare_position{0 * pulse}));
    for (int i = 0; i < 100; ++i) {
        b.pass(1'000);
        REQUIRE(b.drive.feedback(milliseconds(60)));
    }
    CHECK(b.drive.feedback(milliseconds(60))->position.count() == 0);
}

TEST_CASE("G36, G39: no position of a restarted C630S is given as that of the one before") {
    unsigned judged = 0, anew = 0;
    for (std::uint32_t phase = 0; phase < 120; ++phase) {
        bench<sim::c630s, c::drive<on_wire>> b{57600, sim::c630s_options{}, without_watchdog};
        REQUIRE(b.drive.run(init{}));
        REQUIRE(b.drive.run(c::set_up{}));
        b.machine.power_cycle();
        REQUIRE(b.drive.run(init{}));
        REQUIRE(b.drive.run(c::enable_in{c::control_mode::speed}));
        REQUIRE(b.drive.run(velocity{300 * r_per_min}));
        b.pass(2'000'000 + phase * 1400);
        const auto last = b.drive.feedback(milliseconds(400));
        REQUIRE(last);
        b.machine.power_cycle();
        for (int i = 0; i < 2000 && b.drive.state() == c::drive_state::enabled; ++i) {
            b.pass(500);
            const auto now = b.drive.feedback(milliseconds(400));
            if (!now) continue;
            ++judged;
            REQUIRE(now->position.count() >= last->position.count());
        }
        CHECK(b.drive.state() == c::drive_state::needs_init);
        REQUIRE(b.drive.run(init{}));
        for (int i = 0; i < 400; ++i) {
            b.pass(500);
            const auto now = b.drive.feedback(milliseconds(20'000));
            if (!now) continue;
            ++anew;
            const auto shown = static_cast<std::int32_t>(b.machine.peek(c::absolute_position.address));
            REQUIRE(std::abs(now->position.count() - shown) < 60);
        }
    }
    CHECK(judged > 120);
    CHECK(anew > 120);
}

TEST_CASE(
    "G36, G39: after a homing no position of a C630S is given that counts from where it counted before") {
    bench<sim::c630s, c::drive<on_wire>> b{57600, sim::c630s_options{}, without_watchdog};
    REQUIRE(b.drive.run(init{}));
    REQUIRE(b.drive.run(c::set_up{}));
    b.machine.power_cycle();
    REQUIRE(b.drive.run(init{}));
    b.machine.attach({.home_from = 600'000,
                      .home_to = 660'000,
                      .negative_limit = -90'000'000,
                      .positive_limit = 90'000'000});
    REQUIRE(b.drive.run(c::homing_by{c::homing_mode::forward_home_switch, 300 * r_per_min, 60 * r_per_min,
                                     100 * millisecond, 30'000}));
    REQUIRE(b.drive.run(c::enable_in{c::control_mode::position}));
    const auto shown = [&] {
        return static_cast<std::int32_t>(b.machine.peek(c::absolute_position.address));
    };
    for (int round = 0; round < 3; ++round) {
        const command_status homed = b.drive.run(c::home{30 * second});
        CAPTURE(round);
        REQUIRE(homed);
        unsigned given = 0;
        for (int i = 0; i < 1500; ++i) {
            if (const auto now = b.drive.feedback(milliseconds(5'000))) {
                ++given;
                REQUIRE(std::abs(now->position.count() - shown()) < 60);
            }
            b.pass(1'000);
        }
        CHECK(given > 500);
        REQUIRE(b.drive.run(c::segment{1, -5000 * reference_unit, 300 * r_per_min}));
        REQUIRE(b.drive.run(c::start_segment{1}, wait_reached{}).how == arrival_state::reached);
        b.pass(1'000'000);
    }
}

TEST_CASE(
    "G35, G39: what a C630S's start writes is the frame after the read that shows its inputs, also when "
    "feedback is due") {
    // A restart between the two would be hidden, since the write sets the servo on and the marker.
    static std::vector<std::array<std::uint8_t, 8>> seen;
    seen.clear();
    bench<sim::c630s, c::drive<on_wire>> b{57600, sim::c630s_options{},
                                           supervision{milliseconds(20), no_command_timeout}};
    REQUIRE(b.drive.run(init{}));
    REQUIRE(b.drive.run(c::set_up{}));
    b.machine.power_cycle();
    REQUIRE(b.drive.run(init{}));
    REQUIRE(b.drive.run(c::segment{1, 500 * reference_unit, 300 * r_per_min}));
    REQUIRE(b.drive.run(c::enable_in{c::control_mode::position}));
    struct open_frame {
        std::array<std::uint8_t, 8> data{};
        std::size_t size = 0;
    } open;
    b.wire.set_hook(
        [](void* to, const sim::wire_byte& byte) {
            auto& f = *static_cast<open_frame*>(to);
            if (!byte.is_from_client) return void(f.size = 0);
            if (f.size < f.data.size()) f.data[f.size++] = byte.value;
            if (f.size == f.data.size()) seen.push_back(f.data);
        },
        &open);
    for (std::uint32_t k = 0; k < 40; ++k) {
        b.pass(60'000 + k * 1'300);
        REQUIRE(b.drive.run(c::start_segment{1}, wait_reached{}).how == arrival_state::reached);
    }
    const auto is_of_inputs = [](const std::array<std::uint8_t, 8>& f, std::uint8_t code) {
        return f[1] == code && f[2] == 0x31 && f[3] == 0x00;
    };
    unsigned writes = 0;
    for (std::size_t i = 1; i < seen.size(); ++i) {
        if (!is_of_inputs(seen[i], 6)) continue;
        ++writes;
        REQUIRE(is_of_inputs(seen[i - 1], 3));
    }
    CHECK(writes == 3 * 40);
}

TEST_CASE(
    "G39: a YAKO that restarts before the first refresh after a setting gives no position of its new life") {
    for (const bool is_init : {false, true}) {
        for (std::uint32_t after = 5'000; after < 490'000; after += 40'000) {
            CAPTURE(is_init);
            CAPTURE(after);
            stepper<closed> b{115200, sim::yako_options{},
                              supervision{milliseconds(250), no_command_timeout}};
            REQUIRE(b.drive.run(init{}));
            REQUIRE(b.drive.run(enable{}));
            REQUIRE(b.drive.run(move_by{3000 * pulse}, wait_reached{}).how == arrival_state::reached);
            if (is_init) REQUIRE(b.drive.run(init{}));
            if (!is_init)
                REQUIRE(
                    b.drive.run(y::set_homing_profile{200 * r_per_min, 120 * r_per_min, 50 * millisecond}));
            b.wire.pass(duration{after}); // the program does not step it
            b.machine.power_cycle();
            for (int i = 0; i < 3000 && b.drive.state() == y::drive_state::enabled; ++i) {
                const auto now = b.drive.feedback(milliseconds(750));
                if (now) REQUIRE(now->position.count() > 2900);
                b.pass(500);
            }
            CHECK(b.drive.state() == y::drive_state::needs_init);
        }
    }
}

TEST_CASE(
    "G34, G39: a move to where a restart begins to count is not said to have reached it after a restart") {
    unsigned judged = 0;
    for (std::uint32_t at = 3'000; at < 400'000; at += 7'000) {
        CAPTURE(at);
        stepper<closed> b{115200, sim::yako_options{}, supervision{milliseconds(100), no_command_timeout}};
        REQUIRE(b.drive.run(init{}));
        REQUIRE(b.drive.run(enable{}));
        REQUIRE(b.drive.run(move_by{700 * pulse}, wait_reached{}).how == arrival_state::reached);
        REQUIRE(b.drive.run(
            move_by{-697 * pulse, {0 * r_per_min, 50 * millisecond, 50 * millisecond, 240 * r_per_min}}));
        b.pass(at);
        if (!b.machine.view().is_moving || std::abs(b.machine.view().position) < 20) continue;
        ++judged;
        b.machine.power_cycle();
        for (int i = 0; i < 2000; ++i) {
            REQUIRE(b.drive.arrival().how != arrival_state::reached);
            b.pass(500);
        }
    }
    CHECK(judged > 5);
}

TEST_CASE_TEMPLATE(
    "G34, G37: a YAKO whose counter wraps is at its target beyond 2^31 pulses; at its end nothing is said",
    Axis, closed, open) {
    using device =
        std::conditional_t<std::is_same_v<Axis, closed>, y::closed_loop::device, y::open_loop::device>;
    using motion = y::motion_under_way<device>;
    y::cached_settings known{};
    known.state = y::drive_state::enabled;
    known.word_order = word_order::high_first;
    const auto words = [&](std::int64_t position, bool is_moving) {
        struct image {
            std::uint16_t w[7];
        } i{};
        const auto bits = static_cast<std::uint32_t>(position & 0xFFFF'FFFF);
        i.w[1] = is_moving ? y::motion_status::moving_bit : std::uint16_t{0};
        i.w[4] = static_cast<std::uint16_t>(bits >> 16);
        i.w[5] = static_cast<std::uint16_t>(bits & 0xFFFF);
        return i;
    };
    const std::int64_t start = 2'147'483'000;
    y::prepared_command move{.steps = no_steps};
    move.then = y::effect::moved;
    move.has_target = true;
    move.target = 2'000;
    motion m{};
    m.begin(move, words(start, false).w, known);
    m.keep_goal(move);
    const auto how = [&](std::int64_t at) {
        return m.arrival_of(words(at, false).w, milliseconds(5000), known).how;
    };
    CHECK(how(start + 2'000) == arrival_state::reached); // 2^31 + 1352, as a counter that wraps has it
    CHECK(how(start + 1'100) == arrival_state::stopped_short);
    CHECK(how(start + 300) == arrival_state::stopped_short);
    CHECK(how(2'147'483'647) == arrival_state::none);
    CHECK(m.arrival_of(words(2'147'483'647, true).w, milliseconds(5000), known).how ==
          arrival_state::under_way);
}

} // namespace lives_tests
