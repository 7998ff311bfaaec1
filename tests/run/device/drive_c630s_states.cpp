// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S facade in rare states: an interrupted command after which the state is certain, a fault, a lost
// port or a stopped clock during an enable, a drive that waits for its power cycle, and one that responds
// with values that it cannot have.
#include <doctest/doctest.h>

#include <tests/support/driven_c630s.hpp>
#include <tests/support/frame_port.hpp>

namespace drive_c630s_states_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;

namespace {

constexpr u16 p31 = virtual_input_levels.address;

void be_enabled_in(rig& r, control_mode mode) {
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(enable_in{mode}));
    REQUIRE(r.model.enabled());
}
void finish(rig& r) {
    while (!r.drive.is_idle()) r.turn();
}
/// Begins a command and immediately replaces it by disable.
template <class Command> void cut_by_servo_off(rig& r, const Command& wanted) {
    REQUIRE(r.drive.begin(wanted) == errc::ok);
    r.turn();
    REQUIRE_FALSE(r.drive.is_idle());
    REQUIRE(r.drive.begin(disable{}) == errc::ok);
    finish(r);
    REQUIRE(r.drive.last());
    CHECK_FALSE(r.model.enabled());
}

/// A drive of which one register reads as a value that it cannot have.
struct odd_drive : sim::c630s {
    u16 odd_address = 0;
    u16 odd_word = 0;

    constexpr std::uint8_t read(u16 address, std::span<u16> to) {
        const std::uint8_t exception = sim::c630s::read(address, to);
        if (odd_address >= address && odd_address < address + to.size()) to[odd_address - address] = odd_word;
        return exception;
    }
};
/// A port whose clock stops at servo-on.
struct stopping_port : simulated::frame_port<sim::c630s> {
    using simulated::frame_port<sim::c630s>::frame_port;
    instant now() {
        if (!model.enabled()) shown_ = simulated::frame_port<sim::c630s>::now();
        return shown_;
    }

  private:
    instant shown_{};
};

sim::c630s ready_drive() {
    rig r;
    REQUIRE(r.make_ready());
    return r.model;
}

} // namespace

// Interrupted commands

TEST_CASE("G21: a disable that replaces a command without lasting effects keeps the cached state valid") {
    rig r;
    SUBCASE("ramps") {
        be_enabled_in(r, control_mode::speed);
        cut_by_servo_off(r, ramps{100 * millisecond, 100 * millisecond});
    }
    SUBCASE("feedback") {
        be_enabled_in(r, control_mode::speed);
        cut_by_servo_off(r, read_feedback{});
    }
    SUBCASE("a position of 64 bits") {
        be_enabled_in(r, control_mode::speed);
        cut_by_servo_off(r, read_wide_position{wide_position::mechanical});
    }
    SUBCASE("a speed") {
        be_enabled_in(r, control_mode::speed);
        cut_by_servo_off(r, velocity{100 * r_per_min});
    }
    SUBCASE("a halt") {
        be_enabled_in(r, control_mode::speed);
        cut_by_servo_off(r, halt{});
    }
    SUBCASE("a homing that has not begun") {
        be_enabled_in(r, control_mode::position);
        cut_by_servo_off(r, home{10 * second});
        CHECK(r.model.homings() == 0);
    }
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable{})); // no init is needed
}

TEST_CASE("any stop may replace a disable that waits for the brake") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(keep<brake_off_to_power_off_delay>{500}));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable{}));
    REQUIRE(r.drive.begin(disable{}) == errc::ok);
    while (r.model.enabled()) r.turn();
    REQUIRE_FALSE(r.drive.is_idle()); // 500 ms until the power is off
    REQUIRE(r.drive.begin(quick_stop{}) == errc::ok);
    finish(r);
    CHECK(r.drive.last());
    CHECK(r.drive.state() == drive_state::quick_stopped); // a disable is to be confirmed again
    CHECK_FALSE(r.model.enabled());
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.state() == drive_state::disabled);
}

TEST_CASE("G21: a disable that replaces a setting that has begun invalidates the cached state") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    SUBCASE("nothing was written") {
        cut_by_servo_off(r, set<max_speed>{1000});
        CHECK(r.drive.state() == drive_state::disabled);
        return;
    }
    const std::size_t before = r.written_to(max_speed.address).size();
    REQUIRE(r.drive.begin(set<max_speed>{1000}) == errc::ok);
    while (r.written_to(max_speed.address).size() == before) r.turn();
    REQUIRE(r.drive.begin(disable{}) == errc::ok);
    finish(r);
    CHECK(r.drive.last());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("on a disabled drive a quick stop is a servo-off without an emergency stop") {
    rig r;
    REQUIRE(r.make_ready());
    r.requests.clear();
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.drive.state() == drive_state::disabled);
    CHECK(r.written_to(emergency_stop.address).empty());
    REQUIRE(r.drive.run(enable{})); // no emergency stop is left to be reset
}

// Faults during an enable or a homing

TEST_CASE("a fault while an enable waits for the brake switches the servo off and is reported") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(keep<brake_on_to_command_delay>{400}));
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.begin(enable{}) == errc::ok);
    while (!r.model.enabled()) r.turn();
    r.loop(60); // it waits for the brake
    REQUIRE_FALSE(r.drive.is_idle());
    r.model.raise(0x620);
    finish(r);
    CHECK(r.drive.last().error() == errc::faulted);
    CHECK((r.model.peek(p31) & ~terminal::marker) == 0);
    CHECK(r.drive.state() == drive_state::faulted);
    REQUIRE(r.drive.run(fault_reset{}));
    r.wire.pass(milliseconds(500));
    CHECK(r.model.enables() == 1);
}

TEST_CASE("G21: after the port is lost during an enable or a homing nothing more is sent") {
    rig r;
    REQUIRE(r.make_ready());
    SUBCASE("enable") {
        REQUIRE(r.drive.run(keep<brake_on_to_command_delay>{400}));
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.begin(enable{}) == errc::ok);
        while (!r.model.enabled()) r.turn();
        r.loop(60); // it waits for the brake
    }
    SUBCASE("homing") {
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        REQUIRE(r.drive.begin(home{10 * second}) == errc::ok);
        while (!r.model.is_homing()) r.turn();
    }
    REQUIRE_FALSE(r.drive.is_idle());
    r.wire.unplug();
    while (r.drive.state() != drive_state::needs_init) r.turn();
    CHECK(r.drive.is_idle()); // no stop is begun, since it could not be sent
    CHECK(r.drive.last().error() == errc::port_lost);
    CHECK(r.drive.state() == drive_state::needs_init);
    r.wire.plug();
    REQUIRE(r.drive.run(init{}));
    CHECK_FALSE(r.model.enabled());
    CHECK(r.model.stands_still());
}

TEST_CASE("G16: a set-up that a lost port cuts is unknown once one of its parts has written") {
    unsigned unknown = 0, clean = 0;
    for (std::size_t n = 1; n <= 120; ++n) {
        CAPTURE(n);
        rig r;
        REQUIRE(r.drive.run(init{}));
        const std::size_t before = r.requests.size();
        REQUIRE(r.drive.begin(set_up{}) == errc::ok);
        while (!r.drive.is_idle() &&
               (r.requests.size() < before + n || r.wire.responses() < r.wire.requests()))
            r.turn();
        if (r.drive.is_idle()) break;
        r.wire.unplug();
        finish(r);
        bool has_written = false;
        for (std::size_t i = before; i < r.requests.size(); ++i)
            has_written = has_written || modbus::is_write(r.requests[i][1]);
        const outcome ended = r.drive.last().outcome();
        CHECK((ended == outcome::unknown) == has_written);
        (has_written ? unknown : clean) += 1;
    }
    CHECK(unknown > 30);
    CHECK(clean > 0);
}

TEST_CASE("G29: an enable during which the clock stops returns, and the cached state is invalid") {
    stopping_port port{ready_drive()};
    servobus::line line{port, modbus::timing_at(port.baud)};
    c630s::drive drive{line, 1};
    REQUIRE(drive.run(init{}));
    REQUIRE_FALSE(port.model.enabled());
    const command_status got = drive.run(enable{});
    CHECK(got.error() == errc::clock_stopped);
    CHECK(got.outcome() == outcome::unknown);
    CHECK(drive.is_idle()); // nothing waits for the clock to go on
    CHECK(drive.state() == drive_state::needs_init);
}

// Set-up

TEST_CASE("G18: a set-up that the drive refuses half-way leaves P0C-13 at 0") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.begin(set_up{}) == errc::ok);
    while (r.model.peek(eeprom_update.address) == 0) r.turn();
    while (r.model.peek(di1_function.address) == 1) r.turn(); // the first wired input has lost servo-on
    // it remains in effect until the power is switched off
    r.model.set_input(1, true);
    finish(r);
    CHECK(r.drive.last().error() == errc::exception);
    CHECK(r.drive.last().has_changed());
    CHECK(r.model.peek(eeprom_update.address) == 0);
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("G18: another set_up of a drive that is set up only reads") {
    rig r;
    REQUIRE(r.make_ready());
    r.requests.clear();
    REQUIRE(r.drive.run(set_up{}));
    CHECK(r.requests.size() == c630s::detail::set_up_block_count);
    for (const auto& frame : r.requests) CHECK_FALSE(modbus::is_write(frame[1]));
    CHECK(r.drive.state() == drive_state::disabled);
}

TEST_CASE("S1: set_up switches off homing by a wired input, as every enable does") {
    for (const homing how : {homing::by_input, homing::electrical_by_input, homing::set_home_by_input}) {
        CAPTURE(static_cast<int>(how));
        rig r;
        client direct{r.line, node<device>{1}};
        REQUIRE(direct.store<homing_control>(checked(how)));
        REQUIRE(r.make_ready());
        CHECK(r.model.stored(homing_control.address) == 0);
    }
}

TEST_CASE("set_up of a drive that another program has set up meanwhile writes nothing and requires init") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.state() == drive_state::needs_set_up);
    rig::drive_type other{r.line, 1, unsupervised};
    REQUIRE(other.run(init{}));
    REQUIRE(other.run(set_up{}));
    const std::uint32_t before = r.model.eeprom_writes();
    REQUIRE(r.drive.run(set_up{}));
    CHECK(r.model.eeprom_writes() == before);
    CHECK(r.drive.state() == drive_state::needs_init);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.needs_power_cycle());
}

TEST_CASE("set_up does not change registers that do not concern it") {
    for (const u16 address : {drive_number.address, max_speed.address, virtual_input_levels.address}) {
        CAPTURE(address);
        CHECK(c630s::detail::set_up_word(address, 1) == 1);
    }
}

TEST_CASE("set_up reads back each word that it writes: one that the drive does not hold ends it") {
    unsigned judged = 0;
    for (const u16 block : c630s::detail::set_up_blocks) {
        for (u16 i = 0; i < c630s::detail::block_size; ++i) {
            const auto address = static_cast<u16>(block + i);
            for (const u16 held : {u16{1}, u16{0}, u16{2}}) {
                if (c630s::detail::set_up_word(address, held) == held) continue;
                CAPTURE(address);
                CAPTURE(held);
                odd_drive model{};
                model.odd_address = address;
                model.odd_word = held;
                simulated::frame_port<odd_drive> port{model};
                servobus::line line{port, modbus::timing_at(port.baud)};
                c630s::drive drive{line, 1};
                REQUIRE(drive.run(init{}));
                CHECK(drive.run(set_up{}).error() == errc::unexpected_value);
                CHECK(drive.state() == drive_state::needs_init);
                ++judged;
                break;
            }
        }
    }
    CHECK(judged > 70);
}

TEST_CASE("may_have_written covers the writes of a routine up to the reported step, and no others") {
    const routine table{routines::velocity};
    const auto ended = [](unsigned step) {
        return command_status{status::sent(errc::timeout), static_cast<std::uint8_t>(step), false};
    };
    const auto last = static_cast<unsigned>(table.size()) - 1;
    CHECK_FALSE(c630s::detail::may_have_written<target_speed>(table, ended(last - 1)));
    CHECK(c630s::detail::may_have_written<target_speed>(table, ended(last)));
    // A report with a higher step, of a longer table, is checked only up to the end of this table.
    CHECK_FALSE(c630s::detail::may_have_written<virtual_input_levels>(table, ended(200)));
}

TEST_CASE(
    "while a power cycle is pending, no fault is reset, and reading the fault history keeps the pending "
    "mark") {
    rig r;
    r.model.raise(0x400);
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(set_up{}));
    REQUIRE(r.drive.needs_power_cycle());
    CHECK(r.drive.run(fault_reset{}).error() == errc::wrong_state);
    CHECK(r.drive.run(reset_encoder{}).error() == errc::wrong_state);
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->alarm_code == 0); // another record is selected
    CHECK(seen->alarm() == nullptr);
    const auto entry = r.drive.fault(0);
    REQUIRE(entry);
    CHECK(entry->alarm_code == 0x400);
    REQUIRE(entry->alarm() != nullptr);
    CHECK(entry->alarm()->code == 0x400);
    c630s::drive other{r.line, 1};
    REQUIRE(other.run(init{}));
    CHECK(other.needs_power_cycle());
}

TEST_CASE("init refuses a drive whose word order reads as neither of the two values") {
    odd_drive model{};
    model.odd_address = pair_word_order.address;
    model.odd_word = 2;
    simulated::frame_port<odd_drive> port{model};
    servobus::line line{port, modbus::timing_at(port.baud)};
    c630s::drive drive{line, 1};
    const command_status got = drive.run(init{});
    CHECK(got.error() == errc::unexpected_value);
    CHECK(drive.state() == drive_state::needs_init);
}

TEST_CASE("S6: commands with 32-bit values are refused while the word order is unknown") {
    const cached_settings known{.state = drive_state::disabled};
    CHECK(segment{1, 1 * reference_unit, 1 * r_per_min}.prepare(known).refusal == errc::needs_word_order);
    CHECK(prepare(read_feedback{}, known).refusal == errc::needs_word_order);
    CHECK(read_wide_position{wide_position::load}.prepare(known).refusal == errc::needs_word_order);
    CHECK(prepare(set<home_offset>{1}, known).refusal == errc::needs_word_order);
}

// Disabled and stopped drives

TEST_CASE("reading a disabled drive with a fault sends no stop") {
    rig r;
    REQUIRE(r.make_ready());
    r.model.raise(0x620);
    r.requests.clear();
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->alarm_code == 0x620);
    CHECK(r.drive.state() == drive_state::faulted);
    for (const auto& f : r.requests) CHECK_FALSE(modbus::is_write(f[1]));
}

TEST_CASE("after a quick stop, settings that need the servo off are refused") {
    rig r;
    be_enabled_in(r, control_mode::speed);
    REQUIRE(r.drive.run(quick_stop{}));
    REQUIRE(r.drive.state() == drive_state::quick_stopped);
    const std::size_t sent = r.requests.size();
    CHECK(r.drive.run(step_size{10 * reference_unit}).error() == errc::wrong_state);
    CHECK(r.drive.run(restart{}).error() == errc::wrong_state);
    CHECK(r.requests.size() == sent);
}

TEST_CASE("a restart is refused while the motor turns by a wired servo-on, and the drive needs init") {
    rig r;
    client direct{r.line, node<device>{1}};
    REQUIRE(direct.store<mode_of_operation>(control_mode::speed));
    r.model.set_input(1, true); // servo-on from the factory
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.state() == drive_state::needs_set_up);
    const auto token = direct.ram_only();
    REQUIRE(token);
    REQUIRE(direct.write<target_speed>(100, *token));
    r.wire.pass(milliseconds(500));
    REQUIRE_FALSE(r.model.stands_still());
    CHECK(r.drive.run(restart{}).error() == errc::busy);
    CHECK(r.drive.state() == drive_state::needs_init);
    CHECK(r.written_to(software_reset.address).empty());
}

TEST_CASE("wait_standstill also works on a disabled motor; a homing is refused above 2000 s or below 0") {
    rig r;
    REQUIRE(r.make_ready());
    CHECK(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(enable_in{control_mode::position}));
    CHECK(r.drive.run(home{2'000'001 * millisecond}).error() == errc::out_of_range);
    CHECK(r.drive.run(home{-1 * millisecond}).error() == errc::out_of_range);
    CHECK(r.model.homings() == 0);
}

// Limits

TEST_CASE("a limit that set or keep changes applies to the commands after it") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(set<max_forward_speed>{400}));
    REQUIRE(r.drive.run(keep<max_reverse_speed>{300}));
    REQUIRE(r.drive.run(set<positive_internal_torque_limit>{200 * part<10>(percent)}));
    REQUIRE(r.drive.run(keep<negative_internal_torque_limit>{100 * part<10>(percent)}));
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.drive.run(velocity{401 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{400 * r_per_min}));
    CHECK(r.drive.run(velocity{-301 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{-300 * r_per_min}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(set<max_speed>{200})); // below both: it limits both directions
    REQUIRE(r.drive.run(enable_in{control_mode::speed}));
    CHECK(r.drive.run(velocity{201 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{-201 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{-200 * r_per_min}));
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(enable_in{control_mode::torque}));
    CHECK(r.drive.run(torque{201 * part<10>(percent)}).error() == errc::out_of_range);
    CHECK(r.drive.run(torque{-101 * part<10>(percent)}).error() == errc::out_of_range);
    CHECK(r.drive.run(torque{-100 * part<10>(percent)}));
}

TEST_CASE("speed segments that run cyclically return to the first one") {
    rig r;
    REQUIRE(r.make_ready());
    REQUIRE(r.drive.run(speed_segment{1, 60 * r_per_min, 1 * second}));
    REQUIRE(r.drive.run(speed_segment{2, -60 * r_per_min, 1 * second}));
    REQUIRE(r.drive.run(speed_segment{3, 500 * r_per_min, 1 * second})); // not part of the run
    REQUIRE(r.drive.run(run_speed_segments{segment_mode::cyclic, 1, 2}));
    unsigned turns = 0;
    bool was_forward = false;
    for (int i = 0; i < 100; ++i) {
        r.wire.pass(milliseconds(50));
        const bool is_forward = r.r_per_min() > 0;
        turns += is_forward && !was_forward ? 1u : 0u;
        was_forward = is_forward;
        CHECK(r.r_per_min() <= 60);
    }
    CHECK(turns >= 2);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.run(segment_ramp_times{static_cast<segment_ramp>(5), 1 * millisecond, 1 * millisecond})
              .error() == errc::bad_argument);
}

TEST_CASE("S4: after a start without a response, motion is seen also in reverse and if the move is already "
          "over") {
    for (const bool is_short : {false, true}) {
        CAPTURE(is_short);
        rig r;
        be_enabled_in(r, control_mode::position);
        const distance way = (is_short ? -300 : -80'000) * reference_unit;
        REQUIRE(r.drive.run(segment{1, way, 600 * r_per_min, 10 * millisecond}));
        const std::size_t start = r.wire.requests();
        REQUIRE(r.drive.begin(start_segment{1}) == errc::ok);
        while (!r.drive.is_idle()) {
            const std::size_t done = r.wire.requests() - start;
            r.wire.faults().lost_response = done == 12 ? 1000 : 0; // the start
            r.turn();
        }
        CHECK(r.wire.struck() != 0);
        r.wire.faults() = {};
        CHECK(r.drive.last().outcome() == outcome::unknown);
        CHECK(r.model.starts() == 1);
        CHECK(r.drive.motion() == motion_check::seen);
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("G26: a command that a fault has ended stays failed, however many responses are lost to its stop") {
    for (const std::uint32_t lost : {1u, 5u, 10u, 15u, 20u, 25u, 30u, 35u, 40u, 50u, 59u}) {
        CAPTURE(lost);
        rig r;
        REQUIRE(r.make_ready());
        REQUIRE(r.drive.run(enable_in{control_mode::position}));
        REQUIRE(r.drive.run(segment{1, 50'000 * reference_unit, 600 * r_per_min}));
        REQUIRE(r.drive.run(start_segment{1}));
        REQUIRE(r.drive.begin(wait_reached{}) == errc::ok);
        r.loop(200);
        r.model.raise(0x620);
        while (r.drive.state() != drive_state::faulted && !r.drive.is_idle()) r.turn();
        const std::uint32_t first = r.wire.requests();
        while (!r.drive.is_idle()) {
            r.wire.faults().lost_response = r.wire.requests() - first < lost ? 1000 : 0;
            r.turn();
        }
        CHECK_FALSE(r.drive.last());
    }
}

TEST_CASE(
    "an enable that the drive refuses is followed by a servo-off only if it may have switched the servo on") {
    unsigned played = 0, stopped = 0;
    for (unsigned n = 0; n < 40; ++n) {
        CAPTURE(n);
        rig r;
        REQUIRE(r.make_ready());
        r.requests.clear();
        REQUIRE(r.drive.begin(enable_in{control_mode::speed}) == errc::ok);
        while (!r.drive.is_idle() && r.model.refused == 0) {
            r.model.refuses = r.requests.size() >= n;
            r.turn();
        }
        r.model.refuses = false;
        if (r.model.refused == 0) break;
        ++played;
        const std::size_t until = r.requests.size();
        const auto writes_servo_on = [&](std::size_t from, std::size_t to) {
            bool is = false;
            for (std::size_t i = from; i < to; ++i)
                is = is || (modbus::is_write(r.requests[i][1]) && load_word(r.requests[i], 2) == p31);
            return is;
        };
        const bool was_written = writes_servo_on(0, until);
        r.loop(500);
        CHECK(r.drive.last().error() == errc::exception);
        CHECK(writes_servo_on(until, r.requests.size()) == was_written);
        CHECK_FALSE(r.model.enabled());
        if (was_written) ++stopped;
    }
    CHECK(played > 3);
    CHECK(stopped > 0);
    CHECK(stopped < played);
}

} // namespace drive_c630s_states_tests
