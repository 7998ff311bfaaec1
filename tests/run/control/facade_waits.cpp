// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What all facades share, tested with one that knows next to nothing of its drive: how often a wait reads, what the
// feedback is worth meanwhile, and what supervisors do while a command is under way.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <functional>

#include <tests/support/bare_rig.hpp>
#include <tests/support/loop_bound.hpp>

namespace facade_waits_tests {

using namespace bare_rigs;

namespace {

constexpr step until_set[] = {steps::until_bits<setting>(0xFFFF, 2, 400)};
constexpr bare::command wait_for_setting{.steps = until_set};
constexpr step two_looks[] = {steps::fetch<state>(), steps::fetch<state>(1),
                              steps::expect_bits<state>(1, 1, errc::faulted)};
constexpr step with_witness[] = {steps::same_drive()};
constexpr step set_target[] = {steps::set_arguments<target>()};
constexpr steps::recheck same_target{.look = &halt_steps[1], .words = {0}};
constexpr bare::command take_over_witnessed{
    .steps = look_steps, .then = command_kind::take_over, .witness = same_target};

constexpr step long_wait[] = {steps::until_bits<setting>(0xFFFF, 2, 10'000)};
constexpr step long_question[] = {steps::confirm(10'000)};
/// Its question is answered by the feedback.
struct patient : bare::model {
    static errc confirm(const bare::command&, const situation& seen, const bare::settings&) {
        return seen.image[0] == 2 ? errc::ok : errc::busy;
    }
};
struct patient_drive : facade<patient, rig::line_type> {
    explicit patient_drive(rig::line_type& on)
        : facade<patient, rig::line_type>{on, node<device>{1}, {}, no_command_timeout} {}
};

std::size_t reads_of(const rig& r, unsigned address) {
    std::size_t n = 0;
    for (const sent_frame& f : r.port.frames)
        n += f.data[1] == 3 && f.data[2] * 256u + f.data[3] == address ? 1u : 0u;
    return n;
}

} // namespace

TEST_CASE("a wait for a register outside the feedback reads it every 20 ms, or once with each feedback") {
    for (const std::uint32_t period_ms : {0u, 50u}) {
        CAPTURE(period_ms);
        rig r{milliseconds(period_ms)};
        CHECK(r.drive.run(wait_for_setting).error() == errc::not_reached);
        const std::size_t expected = period_ms == 0 ? 400 / 20 : 400 / 50;
        CHECK(reads_of(r, 0x0102) >= expected - 1);
        CHECK(reads_of(r, 0x0102) <= expected + 1);
        if (period_ms != 0) CHECK(reads_of(r, 0x0110) + 1 >= reads_of(r, 0x0102));
        if (period_ms == 0) CHECK(reads_of(r, 0x0110) == 0);
    }
}

TEST_CASE("G36: the feedback is busy only while a command changes settings") {
    rig r{milliseconds(20)};
    r.loop(50);
    CHECK(r.drive.check_feedback(milliseconds(30)) == errc::ok);
    REQUIRE(r.drive.begin(look) == errc::ok);
    CHECK(r.drive.check_feedback(milliseconds(30)) == errc::ok);
    r.loop(50);
    REQUIRE(r.drive.begin(set) == errc::ok);
    CHECK(r.drive.check_feedback(milliseconds(30)) == errc::busy);
    r.loop(50);
    CHECK(r.drive.check_feedback(milliseconds(30)) == errc::ok);
}

TEST_CASE("S1: a drive that is to be checked, and of which nothing is known before that, is sent nothing") {
    rig r{milliseconds(20)};
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(take_over_witnessed));
    bare::model::judges = [](std::uint16_t) { return verdict::uncertain; };
    r.port.frames.clear();
    while (r.drive.check_feedback(milliseconds(10)) != errc::ok)
        r.turn(); // read just now: the witness is due
    r.port.lost_from_call = r.port.calls + 1;
    r.loop(100);
    r.port.lost_from_call = 0;
    r.port.frames.clear();
    r.loop(2000);
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
    CHECK(r.port.frames.empty());
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("a drive that is to be checked and has nothing that a restart would change is only polled") {
    rig r{milliseconds(20)};
    bare::model::judges = [](std::uint16_t) { return verdict::uncertain; };
    r.loop(500);
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
    CHECK(r.port.frames.size() == reads_of(r, 0x0110));
    CHECK(r.port.frames.size() >= 23);
    CHECK(r.port.frames.size() <= 26);
}

TEST_CASE(
    "G39: each refresh that raises a suspicion is followed by one read of the witness, which clears it") {
    rig r{milliseconds(20)};
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(take_over_witnessed));
    bare::model::judges = [](std::uint16_t) { return verdict::uncertain; };
    r.loop(100);
    r.port.frames.clear();
    r.loop(1000);
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
    const std::size_t refreshes = reads_of(r, 0x0110);
    CHECK(refreshes >= 40);
    CHECK(r.port.frames.size() - refreshes <= refreshes + 1);
    CHECK(r.port.frames.size() - refreshes + 1 >= refreshes);
    CHECK(r.drive.check_feedback(milliseconds(50)) == errc::ok);
}

TEST_CASE("a drive that is to be checked and does not respond is asked again with each feedback, not in each "
          "step") {
    rig r{milliseconds(1000)};
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(take_over_witnessed));
    bare::model::judges = [](std::uint16_t) { return verdict::uncertain; };
    while (r.drive.check_feedback(milliseconds(10)) != errc::ok)
        r.turn(); // read just now: the witness is due
    r.is_mute = true;
    r.port.frames.clear();
    r.loop(5100);
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
    CHECK(r.port.frames.size() >= 4);
    CHECK(r.port.frames.size() <= 7);
}

TEST_CASE("G25, G26: a take-over that replaces a supervisor's stop of which a frame was acknowledged is as "
          "urgent as what "
          "that has left, and the stop is repeated if it fails") {
    rig r;
    r.watched_stop_begins();
    while (r.port.frames.size() < 2) r.turn(); // its write is done, its read-back has been sent
    REQUIRE(r.drive.begin(taking_over) == errc::ok);
    r.is_mute = true;
    while (!r.drive.is_idle()) r.turn();
    CHECK_FALSE(r.drive.last());
    r.port.frames.clear();
    r.loop(1000);
    CHECK(r.halts() > 3);
    CHECK(r.hasty_frames() == 0); // a repetition waits like any other frame
}

TEST_CASE("G20: a take-over under way is not cut by the command timeout; the stop follows it if it fails") {
    for (const bool is_known : {false, true}) {
        CAPTURE(is_known);
        rig r;
        r.drive.set_command_timeout(milliseconds(100));
        REQUIRE(r.drive.run(move));
        r.is_mute = true;
        if (!is_known) CHECK_FALSE(r.drive.run(set));
        REQUIRE(r.drive.begin(taking_over) == errc::ok);
        r.port.frames.clear();
        while (!r.drive.is_idle()) r.turn(); // three tries of 100 ms
        CHECK(r.drive.last().error() == errc::timeout);
        CHECK(r.halts() == 0);
        r.loop(1000);
        CHECK(r.halts() > 0);
    }
}

TEST_CASE("G20, G21: a change of settings that the command timeout cuts leaves the state unknown, a motion "
          "does not") {
    for (const bool is_setting : {true, false}) {
        CAPTURE(is_setting);
        rig r;
        r.drive.set_command_timeout(milliseconds(100));
        REQUIRE(r.drive.run(move));
        r.loop(50);
        r.is_mute = true;
        REQUIRE(r.drive.begin(is_setting ? set : look) == errc::ok);
        r.port.frames.clear();
        while (r.halts() == 0) r.turn();
        CHECK(r.drive.last().error() == errc::command_timeout);
        CHECK((r.drive.state() == drive_state::needs_init) == is_setting);
    }
}

TEST_CASE("G20, G21: so does a change that was acknowledged and not read back yet") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    r.loop(50);
    REQUIRE(r.drive.begin(set) == errc::ok);
    while (r.file.words[setting.address] != 1) r.turn();
    r.loop(2);
    REQUIRE_FALSE(r.drive.is_idle());
    r.is_mute = true;
    r.loop(60);
    r.is_mute = false;
    r.loop(60);
    CHECK(r.halts() == 1);
    CHECK(r.drive.last().error() == errc::command_timeout);
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("G26: the command timeout's stop is no more urgent than a stop that is being repeated") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    r.drive.repeat_stops(milliseconds(60'000));
    REQUIRE(r.drive.run(move));
    r.is_mute = true;
    CHECK_FALSE(r.drive.run(halting));
    r.port.frames.clear();
    r.loop(1000);
    CHECK(r.halts() == 3);
    CHECK(r.hasty_frames() == 0);
}

TEST_CASE("a blocking call that another task's stop replaces says so") {
    // The port of a task switcher: while one task waits, others run.
    struct port_type : tests::scripted_port {
        std::function<void()> others;
        void wait(duration longest) {
            time += longest.us == 0 ? 1 : longest.us;
            if (others) others();
        }
    };
    port_type port;
    tests::register_file file;
    for (const unsigned a : {0x0100u, 0x0101u, 0x0102u, 0x0110u}) file.words[static_cast<u16>(a)] = 0x55;
    port.device = [&](tests::scripted_port& p, const sent_frame& f) { file(p, f); };
    line on{port, modbus::timing_at(115200)};
    bare::drive<line<port_type>> drive{on, node<device>{1}};
    REQUIRE(drive.run(taking_over));
    bool has_stopped = false;
    port.others = [&] {
        if (!has_stopped && !drive.is_idle()) has_stopped = drive.begin(halting) == errc::ok;
    };
    const command_status got = drive.run(wait_for_setting);
    CHECK(has_stopped);
    CHECK(got.error() == errc::preempted);
    CHECK(drive.last()); // the stop's
    CHECK(file.words[0x0100] == 0);
}

TEST_CASE("adjacent steps that read from the feedback take one frame together") {
    rig r;
    REQUIRE(r.drive.run(bare::command{.steps = two_looks}));
    CHECK(r.port.frames.size() == 1);
    CHECK(r.drive.words()[0] == 0x55);
    CHECK(r.drive.words()[1] == 0x55);
}

TEST_CASE("G20: a new command timeout counts from when it is set, not from a command long before") {
    rig r;
    REQUIRE(r.drive.run(move));
    r.loop(500);
    r.drive.set_command_timeout(milliseconds(100));
    r.loop(80);
    CHECK(r.halts() == 0);
    r.loop(60);
    CHECK(r.halts() > 0);
}

TEST_CASE("G20: a drive that was enabled again is not stopped by the command timeout until it is commanded "
          "to move") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    REQUIRE(r.drive.run(halting));
    REQUIRE(r.drive.run(bare::command{.steps = look_steps, .then = command_kind::power}));
    r.port.frames.clear();
    r.loop(500);
    CHECK(r.halts() == 0);
    REQUIRE(r.drive.run(move));
    r.loop(150);
    CHECK(r.halts() > 0);
}

TEST_CASE("G20: a drive that was halted is still energised and halted once more by the command timeout, a "
          "disabled one not") {
    for (const bool is_disabled : {false, true}) {
        CAPTURE(is_disabled);
        rig r;
        r.drive.set_command_timeout(milliseconds(100));
        REQUIRE(r.drive.run(move));
        REQUIRE(r.drive.run(is_disabled ? disabling : halting));
        r.port.frames.clear();
        r.loop(500);
        CHECK(r.halts() == (is_disabled ? 0 : 1));
    }
}

TEST_CASE("G20: a move ends by itself, and ends the watch over an endless motion before it") {
    rig r;
    r.drive.set_command_timeout(milliseconds(100));
    REQUIRE(r.drive.run(move));
    REQUIRE(r.drive.run(bare::command{.steps = move_steps, .arguments = {50}, .then = command_kind::move}));
    r.port.frames.clear();
    r.loop(500);
    CHECK(r.halts() == 0);
}

TEST_CASE("the cause of a stop counts until the next motion") {
    rig r;
    REQUIRE(r.drive.run(move));
    REQUIRE(r.drive.run(halting));
    CHECK(r.drive.cause() == stop_cause::command);
    REQUIRE(r.drive.run(look));
    CHECK(r.drive.cause() == stop_cause::command);
    REQUIRE(r.drive.run(move));
    CHECK(r.drive.cause() == stop_cause::unknown);
}

TEST_CASE("a stop of the program is the cause though its response is lost: it may have arrived") {
    rig r;
    REQUIRE(r.drive.run(move));
    r.is_mute = true;
    REQUIRE(r.drive.run(halting).outcome() == outcome::unknown);
    CHECK(r.drive.cause() == stop_cause::command);
}

TEST_CASE("G21: a command that asks for the witness of a drive of which nothing is known ends with its first "
          "response") {
    rig r;
    r.is_mute = true;
    CHECK_FALSE(r.drive.run(set)); // nothing is known of the drive any more
    r.is_mute = false;
    r.port.frames.clear();
    REQUIRE(r.drive.begin(bare::command{.steps = with_witness}) == errc::ok);
    r.loop(500);
    CHECK(r.drive.is_idle());
    CHECK(r.drive.last().error() == errc::needs_init);
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("G16, G21: a setpoint without a response that reads back as neither the old nor the new value is "
          "unknown") {
    struct scene {
        u16 found;
        bool is_enabled_anew;
    };
    for (const scene& s :
         {scene{300, false}, {100, false}, {77, false}, {0, false}, {300, true}, {100, true}, {0, true}}) {
        const u16 found = s.found;
        const bool is_enabled_anew = s.is_enabled_anew;
        CAPTURE(found);
        CAPTURE(is_enabled_anew);
        rig r;
        r.file.words[0x0100] = 0;
        REQUIRE(r.drive.run(take_over_witnessed));
        REQUIRE(r.drive.run(bare::command{.steps = set_target, .arguments = {100}}));
        if (is_enabled_anew)
            REQUIRE(r.drive.run(bare::command{.steps = look_steps, .then = command_kind::power}));
        const u16 old = is_enabled_anew ? u16{0} : u16{100}; // an enable has the target zero
        r.file.words[0x0100] = 0;                            // the witness
        bool is_lost = false;
        auto answers = r.port.device;
        r.port.device = [&](tests::scripted_port& p, const sent_frame& f) {
            const bool is_write = f.data[1] == 0x06;
            if (is_write) is_lost = true;
            if (is_write) return;
            const bool is_read_back = is_lost && f.data[3] == 0x00;
            if (is_read_back) {
                is_lost = false;
                return p.say(500, tests::read_response(1, {found}));
            }
            answers(p, f);
        };
        const command_status got = r.drive.run(bare::command{.steps = set_target, .arguments = {300}});
        CHECK(static_cast<bool>(got) == (found == 300));
        if (found == old) CHECK(got.error() == errc::not_executed);
        if (found != old && found != 300) CHECK(got.error() == errc::timeout);
        if (found != 300) CHECK(got.has_changed()); // the write before the read-back
        if (found != 300) CHECK(got.outcome() == outcome::unknown);
    }
}

TEST_CASE("a drive is absent after three reads of its feedback without a response, not after three writes") {
    rig r{milliseconds(20)};
    r.loop(50);
    r.is_mute = true;
    r.port.frames.clear();
    REQUIRE_FALSE(r.drive.run(halting));
    REQUIRE(r.halts() == 3);
    CHECK_FALSE(r.drive.is_absent());
    r.is_mute = false;
    REQUIRE(r.drive.run(taking_over));
    r.is_mute = true;
    r.port.frames.clear();
    for (std::size_t reads = 1; reads <= 3; ++reads) {
        CAPTURE(reads);
        for (tests::loop_bound left{"a read"}; r.port.frames.size() < reads; left.use()) r.turn();
        CHECK_FALSE(r.drive.is_absent());
        for (tests::loop_bound left{"its end"}; r.drive.machine().is_on_the_wire(); left.use()) r.turn();
        CHECK(r.drive.is_absent() == (reads == 3));
    }
    CHECK(reads_of(r, 0x0110) == 3);
    r.loop(2000);
    CHECK(r.drive.is_absent());
    r.is_mute = false;
    r.loop(1100);
    CHECK_FALSE(r.drive.is_absent());
}

TEST_CASE("G28: reads of its feedback that are lost now and then make no drive absent: three in a row do") {
    rig r{milliseconds(20)};
    REQUIRE(r.drive.run(taking_over));
    r.loop(50);
    for (int round = 0; round < 6; ++round) {
        CAPTURE(round);
        for (int lost = 0; lost < 2; ++lost) {
            r.port.frames.clear();
            r.is_mute = true;
            while (r.port.frames.empty()) r.turn();
            r.is_mute = false;
            while (r.drive.machine().is_on_the_wire()) r.turn();
            CHECK_FALSE(r.drive.is_absent());
        }
        r.loop(500);
        REQUIRE_FALSE(r.drive.is_absent());
    }
}

TEST_CASE("G16: a setpoint that cannot be read back ends as its write: what it has done is not known") {
    rig r;
    REQUIRE(r.drive.run(take_over_witnessed));
    r.port.device = [](tests::scripted_port& p, const sent_frame& f) {
        if (f.data[1] == 0x03) p.say(500, tests::exception_response(1, 0x03, 4));
    };
    const command_status how = r.drive.run(
        bare::command{.steps = set_target, .arguments = {300}, .then = command_kind::endless_motion});
    CHECK(how.error() == errc::timeout);
    CHECK(how.outcome() == outcome::unknown);
}

TEST_CASE("G16: of a setpoint of two words that reads back as before, each word is compared with its own") {
    constexpr static step set_both[] = {steps::set_arguments<target, command>()};
    struct scene {
        u16 first, second;
        errc ends;
    };
    for (const scene& s : {scene{100, 50, errc::not_executed},
                           {100, 100, errc::timeout},
                           {50, 50, errc::timeout},
                           {300, 50, errc::timeout},
                           {100, 70, errc::timeout},
                           {300, 70, errc::ok}}) {
        CAPTURE(s.first);
        CAPTURE(s.second);
        rig r;
        REQUIRE(r.drive.run(bare::command{.steps = set_both, .arguments = {100, 50}}));
        auto answers = r.port.device;
        r.port.device = [&](tests::scripted_port& p, const sent_frame& f) {
            if (f.data[1] == 0x10) return;
            if (f.data[1] == 0x03 && f.data[3] == 0x00)
                return p.say(500, tests::read_response(1, {s.first, s.second}));
            answers(p, f);
        };
        CHECK(r.drive.run(bare::command{.steps = set_both, .arguments = {300, 70}}).error() == s.ends);
    }
}

TEST_CASE("G29: a command ends although the drive responds to the witness and never to what a step reads") {
    rig r;
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(take_over_witnessed));
    r.port.frames.clear();
    r.port.device = [&r](tests::scripted_port& p, const tests::sent_frame& f) {
        if (f.data[3] == (state.address & 0xFFu)) return; // of that register it says nothing
        r.file(p, f);
    };
    REQUIRE(r.drive.begin(look) == errc::ok);
    for (int i = 0; i < 100'000 && !r.drive.is_idle(); ++i) r.turn();
    REQUIRE(r.drive.is_idle());
    CHECK(r.drive.last().error() == errc::timeout);
    CHECK(reads_of(r, state.address) == 3);
    CHECK(reads_of(r, 0x0100) >= 1);
}

TEST_CASE(
    "a step that waits for a state goes on while now and then reads are lost: too many in a row end it") {
    for (const bool is_question : {false, true}) {
        CAPTURE(is_question);
        for (const bool loses_one_more : {false, true}) {
            CAPTURE(loses_one_more);
            rig r;
            patient_drive drive{r.on};
            const u16 awaited = is_question ? state.address : setting.address;
            constexpr unsigned rounds = 5;
            constexpr unsigned retries = node<device>{1}.read_retries;
            unsigned lost = 0, seen = 0;
            r.port.device = [&](tests::scripted_port& p, const sent_frame& f) {
                const unsigned losses = retries + (loses_one_more && seen == 2 ? 1 : 0);
                if (lost++ < losses) return;
                lost = 0;
                if (++seen == rounds) r.file.words[awaited] = 2;
                r.file(p, f);
            };
            const errc ends =
                drive.run(bare::command{.steps = is_question ? routine{long_question} : routine{long_wait}})
                    .error();
            CHECK(ends == (loses_one_more ? errc::timeout : errc::ok));
            CHECK(seen == (loses_one_more ? 2 : rounds));
        }
    }
}

TEST_CASE("G36: an image that waits for the witness is never used if that got no response") {
    rig r{milliseconds(20)};
    r.file.words[0x0100] = 0;
    REQUIRE(r.drive.run(take_over_witnessed));
    r.loop(50);
    bare::model::judges = [](std::uint16_t word) {
        return word == 7 ? verdict::uncertain : verdict::as_expected;
    };
    const auto image = [&r] { return r.drive.machine().known().polling().image().words[0]; };
    for (const bool is_lost : {false, true}) {
        CAPTURE(is_lost);
        bool is_asked = false;
        r.file.words[0x0110] = 7;
        r.port.device = [&](tests::scripted_port& p, const sent_frame& f) {
            const unsigned address = f.data[2] * 256u + f.data[3];
            const bool is_first = address == 0x0100 && !is_asked;
            is_asked = is_asked || is_first;
            if (is_first && is_lost) return;
            r.file(p, f);
            if (address == 0x0110) r.file.words[0x0110] = 9;
        };
        bool was_used = false;
        for (const std::uint64_t end = r.port.time + 1'500'000; r.port.time < end;) {
            r.turn();
            was_used = was_used || image() == 7;
        }
        CHECK(is_asked);
        CHECK(was_used == !is_lost);
        CHECK(image() == 9);
    }
    bare::model::judges = [](std::uint16_t) { return verdict::as_expected; };
}

TEST_CASE("G28: an absent drive is asked once a second, however long it is absent") {
    rig r{milliseconds(20)};
    REQUIRE(r.drive.run(taking_over));
    r.is_mute = true;
    r.loop(2000);
    for (int i = 0; i < 300; ++i) {
        CAPTURE(i);
        r.port.frames.clear();
        r.loop(1100);
        CHECK(r.drive.is_absent());
        CHECK(r.port.frames.size() <= 2);
    }
}

} // namespace facade_waits_tests
