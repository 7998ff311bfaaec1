// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each block of the feedback that has come reaches the drive's model, also during a stop, with its words, when its
// request began to leave, and an epoch that changes where positions may be counted from elsewhere: after a restart, a
// lost port, a homing, a position that was cleared, and not otherwise.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/yako.hpp>
#include <tests/support/bare_rig.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/simulated_yako.hpp>

namespace noted_blocks_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

struct noted {
    std::uint8_t block;
    std::vector<std::uint16_t> words;
    instant taken;
    std::uint16_t epoch;
};
/// A drive's model that keeps what it is told.
template <class Model> struct following : Model {
    static inline std::vector<noted> told;

    void note(const block_feedback& r, typename Model::settings& known) {
        told.push_back({r.block, {r.words, r.words + Model::blocks[r.block].words}, r.taken, r.epoch});
        Model::note(r, known);
    }
};
using wheels_model = following<zlac8015d::model>;
struct wheels_rig : simulated::driven_zlac8015d {
    struct own_drive : facade<wheels_model, line_type> {
        explicit own_drive(line_type& on)
            : facade<wheels_model, line_type>{on, node<zlac8015d::device>{1}, milliseconds(20),
                                              no_command_timeout} {}
    };
    own_drive wheels{line};

    wheels_rig() { wheels_model::told.clear(); }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) {
            const duration idle = wheels.step();
            wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
    std::uint16_t epoch() const { return wheels_model::told.back().epoch; }
    /// The epochs that were seen since the `from`th block, each once.
    static std::size_t epochs_since(std::size_t from) {
        std::size_t n = 1;
        for (std::size_t i = from + 1; i < wheels_model::told.size(); ++i)
            n += wheels_model::told[i].epoch != wheels_model::told[i - 1].epoch ? 1u : 0u;
        return n;
    }
};

using servo_model = following<c630s::model>;
struct servo_rig : simulated::simulated_c630s {
    struct own_drive : facade<servo_model, line_type> {
        own_drive(line_type& on, duration feedback)
            : facade<servo_model, line_type>{on, node<c630s::device>{1}, feedback, no_command_timeout} {}
    };
    own_drive servo;

    explicit servo_rig(duration feedback = milliseconds(20)) : servo{line, feedback} {
        servo_model::told.clear();
        REQUIRE(servo.run(init{}));
        REQUIRE(servo.run(c630s::set_up{}));
        model.power_cycle();
        REQUIRE(servo.run(init{}));
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) {
            const duration idle = servo.step();
            wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
};

using axis_model = following<yako::model<yako::closed_loop::device>>;
struct axis_rig : simulated::simulated_closed_loop {
    struct own_drive : facade<axis_model, line_type> {
        explicit own_drive(line_type& on)
            : facade<axis_model, line_type>{on, node<yako::closed_loop::device>{1}, milliseconds(20),
                                            no_command_timeout} {}
    };
    own_drive axis{line};

    /// At 2000 pulses, which count as zero; its home is elsewhere. Responses are late.
    axis_rig() {
        axis_model::told.clear();
        REQUIRE(axis.run(init{}));
        model.attach(simulated::yako_slide());
        REQUIRE(axis.run(move_by{2000 * pulse}));
        loop(3'000'000);
        REQUIRE(axis.run(yako::clear_position{}));
        station.set_response_delay(milliseconds(8));
        loop(100'000);
    }
    void loop(std::uint64_t us) {
        const std::uint64_t end = wire.time_us() + us;
        while (wire.time_us() < end) {
            const duration idle = axis.step();
            wire.wait(idle.us == 0 || idle.us > 100 ? microseconds(100) : idle);
        }
    }
    static std::int32_t place_in(const noted& n) {
        return from_bits<i32>(join_words(n.words[4], n.words[5], word_order::high_first));
    }
};

/// No position of the time after the restart, which begins at zero, has the epoch of before.
void check_restart(wheels_rig& r, std::uint16_t was) {
    const std::size_t from = wheels_model::told.size();
    r.loop(3000);
    std::size_t at_zero = 0;
    for (std::size_t i = from; i < wheels_model::told.size(); ++i) {
        if (wheels_model::told[i].words[5] != 0 || wheels_model::told[i].words[6] > 50) continue;
        ++at_zero;
        CHECK(wheels_model::told[i].epoch != was);
    }
    CHECK(at_zero != 0);
}

} // namespace

TEST_CASE(
    "each image reaches the model, with the time at which its request began to leave, also during a stop") {
    wheels_rig r;
    REQUIRE(r.wheels.run(init{}));
    REQUIRE(r.wheels.run(enable{}));
    REQUIRE(r.wheels.run(velocity{100 * r_per_min, 100 * r_per_min}));
    const std::size_t before = wheels_model::told.size();
    const instant begun{static_cast<std::uint32_t>(r.wire.time_us())};
    r.loop(200);
    const std::size_t turning = wheels_model::told.size();
    CHECK(turning - before >= 9);
    REQUIRE(r.wheels.run(halt{}));
    CHECK(wheels_model::told.size() > turning); // the halt waits for standstill
    instant last = begun;
    for (std::size_t i = before; i < wheels_model::told.size(); ++i) {
        const noted& n = wheels_model::told[i];
        CHECK(n.block == 0);
        CHECK(n.words.size() == 11);
        CHECK_FALSE(since(last, n.taken) > milliseconds(60));
        last = n.taken;
    }
    const auto& words = wheels_model::told[turning].words;
    const auto place = static_cast<std::int32_t>(join_words(words[5], words[6], word_order::high_first));
    CHECK(place > 0);
    CHECK(place <= r.model.left().position);
}

TEST_CASE("the epoch of positions stays while a drive runs, is enabled, halted and set") {
    wheels_rig r;
    REQUIRE(r.wheels.run(init{}));
    r.loop(100);
    const std::size_t from = wheels_model::told.size() - 1;
    REQUIRE(r.wheels.run(enable{}));
    REQUIRE(r.wheels.run(velocity{100 * r_per_min, -100 * r_per_min}));
    r.loop(500);
    REQUIRE(r.wheels.run(quick_stop{}));
    REQUIRE(r.wheels.run(disable{}));
    REQUIRE(r.wheels.run(zlac8015d::watchdog{800 * millisecond}));
    r.loop(100);
    CHECK(r.epochs_since(from) == 1);
}

TEST_CASE("the epoch of positions changes after they were cleared, a restart and a lost port") {
    wheels_rig r;
    REQUIRE(r.wheels.run(init{}));
    r.loop(100);
    std::uint16_t was = r.epoch();
    const std::size_t seen = wheels_model::told.size();
    SUBCASE("cleared") {
        const std::size_t from = wheels_model::told.size();
        REQUIRE(r.wheels.run(zlac8015d::clear_position{}));
        r.loop(100);
        CHECK(r.epoch() != was);
        CHECK(wheels_model::told[from].epoch != was); // what is read while it may happen is neither
        was = r.epoch();
        r.loop(100);
        CHECK(r.epoch() == was);
    }
    SUBCASE("a restart that the image shows") {
        REQUIRE(r.wheels.run(enable{}));
        REQUIRE(r.wheels.run(velocity{100 * r_per_min, 100 * r_per_min}));
        r.loop(500);
        REQUIRE(r.wheels.run(halt{}));
        r.loop(100);
        r.model.power_cycle();
        check_restart(r, was);
    }
    SUBCASE("a restart that shows by the position alone, since the drive has no witness") {
        REQUIRE(r.wheels.run(enable{}));
        REQUIRE(r.wheels.run(velocity{100 * r_per_min, 100 * r_per_min}));
        r.loop(500);
        REQUIRE(r.wheels.run(disable{}));
        r.loop(100);
        was = r.epoch();
        r.model.power_cycle();
        check_restart(r, was);
    }
    SUBCASE("a lost port") {
        r.wire.unplug();
        r.loop(100);
        r.wire.plug();
        r.loop(2000);
        REQUIRE(r.wheels.state() == drive_state::needs_init);
        REQUIRE(r.wheels.run(init{}));
        for (std::size_t i = seen; i < wheels_model::told.size(); ++i)
            CHECK(wheels_model::told[i].epoch != was);
    }
}

TEST_CASE("each block of a servo's feedback reaches its model") {
    servo_rig r;
    const std::size_t from = servo_model::told.size();
    r.loop(1000);
    unsigned times[5]{};
    for (std::size_t i = from; i < servo_model::told.size(); ++i) {
        const noted& n = servo_model::told[i];
        ++times[n.block];
        CHECK(n.words.size() == c630s::model::blocks[n.block].words);
        CHECK(n.epoch == servo_model::told[from].epoch);
    }
    CHECK(times[0] >= 30);
    for (std::size_t b = 1; b < 5; ++b) CHECK(times[b] >= 3);
}

TEST_CASE("the epoch of positions changes while a servo is homed, and stays after it") {
    servo_rig r;
    r.model.attach(
        {.home_from = 200'000, .home_to = 260'000, .negative_limit = -900'000, .positive_limit = 900'000});
    REQUIRE(r.servo.run(c630s::homing_by{c630s::homing_mode::forward_home_switch, 300 * r_per_min,
                                         60 * r_per_min, 100 * millisecond, 30'000}));
    r.loop(300);
    REQUIRE(r.servo.run(c630s::enable_in{c630s::control_mode::position}));
    r.loop(100);
    const std::uint16_t was = servo_model::told.back().epoch;
    REQUIRE(r.servo.run(c630s::home{30 * second}));
    r.loop(100);
    const std::uint16_t homed = servo_model::told.back().epoch;
    CHECK(homed != was);
    r.loop(500);
    CHECK(servo_model::told.back().epoch == homed);
}

TEST_CASE("the epoch of positions changes where a servo's present position becomes its home, and no move "
          "counts any more") {
    servo_rig r;
    r.loop(300);
    REQUIRE(r.servo.run(c630s::segment{1, 300 * reference_unit, 60 * r_per_min}));
    REQUIRE(r.servo.run(c630s::enable_in{c630s::control_mode::position}));
    REQUIRE(r.servo.run(c630s::start_segment{1}));
    REQUIRE(r.servo.run(wait_standstill{}));
    r.loop(100);
    const std::size_t from = servo_model::told.size();
    const std::uint16_t was = servo_model::told.back().epoch;
    REQUIRE(r.servo.run(c630s::set_home{}));
    r.loop(500);
    std::size_t at_home = 0;
    for (std::size_t i = from; i < servo_model::told.size(); ++i) {
        const noted& n = servo_model::told[i];
        if (n.block != c630s::model::blocks.positions() || n.words[0] + n.words[1] != 0) continue;
        ++at_home;
        CHECK(n.epoch != was);
    }
    CHECK(at_home != 0);
    CHECK(r.servo.begin(wait_reached{}) == errc::wrong_state);
}

TEST_CASE("the epoch of positions changes with the gear of a servo, which says what a count is worth") {
    servo_rig r;
    r.loop(300);
    const std::uint16_t was = servo_model::told.back().epoch;
    REQUIRE(r.servo.run(c630s::set<c630s::gear_1_numerator>{20}));
    r.loop(300);
    CHECK(servo_model::told.back().epoch != was);
}

TEST_CASE("the epoch of positions changes with an init, also if nothing has shown that the drive restarted") {
    servo_rig r{{}};
    REQUIRE(r.servo.run(read_feedback{}));
    const std::uint16_t was = servo_model::told.back().epoch;
    REQUIRE(r.servo.run(read_feedback{}));
    CHECK(servo_model::told.back().epoch == was);
    r.model.power_cycle();
    REQUIRE(r.servo.run(init{}));
    REQUIRE(r.servo.run(read_feedback{}));
    CHECK(servo_model::told.back().epoch != was);
}

TEST_CASE("a homing that is stopped at its end changes the epoch of positions too, if it has set them") {
    std::uint64_t took = 0;
    {
        axis_rig r;
        const std::uint64_t begun = r.wire.time_us();
        REQUIRE(r.axis.run(yako::closed_loop::home{yako::homing::home_24}));
        took = r.wire.time_us() - begun;
    }
    unsigned stopped = 0;
    for (std::uint64_t at = took - 100'000; at < took; at += 2'500) {
        CAPTURE(at);
        axis_rig r;
        REQUIRE(r.axis.begin(yako::closed_loop::home{yako::homing::home_24}) == errc::ok);
        r.loop(at);
        if (r.axis.begin(halt{}) != errc::ok) continue;
        ++stopped;
        r.loop(500'000);
        const std::vector<noted>& all = axis_model::told;
        for (std::size_t i = 1; i < all.size(); ++i) {
            if (all[i].epoch != all[i - 1].epoch) continue;
            const std::int64_t way =
                std::int64_t{axis_rig::place_in(all[i])} - axis_rig::place_in(all[i - 1]);
            CHECK(std::llabs(way) <= 500); // the homing is slower
        }
    }
    CHECK(stopped > 30);
}

TEST_CASE("the epoch of positions changes with a take-over that reads no image") {
    using namespace bare_rigs;
    static constexpr step reads_elsewhere[] = {steps::fetch<setting>()};
    rig r{{}}; // nothing is polled
    REQUIRE(r.drive.run(look));
    const std::uint16_t was = r.drive.machine().known().feedback().epoch_of_positions();
    REQUIRE(r.drive.run(bare::command{.steps = reads_elsewhere, .then = command_kind::take_over}));
    REQUIRE(r.drive.run(look));
    CHECK(r.drive.machine().known().feedback().epoch_of_positions() != was);
}

} // namespace noted_blocks_tests
