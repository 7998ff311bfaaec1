// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Routines of steps over a scripted port, run by a facade: what is repeated if the drive refuses or does not
// respond, how a stop continues with the next one, and how a routine ends on a line where an echo is not ruled out.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/servobus.hpp>

#include <tests/support/bare_drive.hpp>
#include <tests/support/scripted_port.hpp>

namespace routine_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::sent_frame;

namespace {

namespace fixture {
using namespace servobus;

struct device {
    static constexpr profile facts{.name = "stepped"};
};
template <wire_value T> using rw = reg<T, access::rw, device>;

inline constexpr rw<u16> mode{0x0100, full<u16>, no_unit, 0};
inline constexpr rw<u16> command{0x0101, full<u16>, no_unit, 0};
inline constexpr rw<i16> speed{0x0102, full<i16>, no_unit, 0};
inline constexpr rw<i16> torque{0x0103, full<i16>, no_unit, 0};
inline constexpr reg<u16, access::ro, device> state{0x0110, full<u16>, no_unit, no_default};

inline constexpr step set_mode = steps::write<mode>(3);
inline constexpr step start = steps::write<command>(8);
inline constexpr step stop = steps::repeatable(steps::write<command>(7));
inline constexpr step zero = steps::repeatable(steps::write_zero<speed, torque>());
inline constexpr step look = steps::fetch<state>(2);
inline constexpr step check_mode = steps::expect<mode>(3, errc::wrong_state);
inline constexpr step until_ready = steps::until_bits<state>(0x0001, 0x0001, 50);
inline constexpr step until_ready_as_commanded =
    steps::until_bits<state>(0x0001, 0x0001, step::commanded_limit);
inline constexpr step until_still = steps::until_within<speed, torque>(20, 50);

inline constexpr step set_and_start[] = {set_mode, start};
inline constexpr step only_look[] = {look};
inline constexpr step checked_start[] = {check_mode, start};
inline constexpr step set_look_start[] = {set_mode, look, start};
inline constexpr step one_stop[] = {stop};
inline constexpr step two_stops[] = {zero, stop};
inline constexpr step stops_then_look[] = {zero, stop, look};
inline constexpr step stop_look_stop[] = {zero, stop, look, zero, stop, look};
inline constexpr step stop_then_start[] = {stop, start};
inline constexpr step wait_ready[] = {until_ready};
inline constexpr step wait_as_commanded[] = {until_ready_as_commanded};
inline constexpr step wait_still[] = {until_still};
inline constexpr step arguments[] = {steps::write_arguments<speed, torque>(1),
                                     steps::expect_arguments<speed, torque>(1)};
} // namespace fixture

struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    using line_type = line<tests::waiting_scripted_port>;
    line_type on{port, modbus::timing_at(115200)};
    bare::drive<line_type> drive;
    // How often a request to an address gets an exception, or no response, before it is executed.
    std::uint16_t refused_address = 0;
    std::uint8_t exception = 0;
    unsigned exceptions = 0;
    std::uint16_t mute_address = 0;
    unsigned silences_left = 0;

    static node<fixture::device> at(const response_limits& limits) {
        node<fixture::device> n{1};
        n.limits = limits;
        n.gaps = {{}, milliseconds(20)};
        return n;
    }
    explicit rig(const response_limits& limits = {}) : drive{on, at(limits)} {
        for (std::uint16_t a = 0x0100; a < 0x0120; ++a) file.words[a] = 0;
        port.device = [this](tests::scripted_port& at, const sent_frame& f) {
            const unsigned address = f.data[2] * 256u + f.data[3];
            if (address == mute_address && silences_left != 0) {
                --silences_left;
                return;
            }
            if (address == refused_address && exceptions != 0) {
                --exceptions;
                return at.say(500, tests::exception_response(1, f.data[1], exception));
            }
            file(at, f);
        };
    }
    rig(const rig&) = delete;

    void refuse(std::uint16_t address, std::uint8_t number, unsigned times) {
        refused_address = address;
        exception = number;
        exceptions = times;
    }
    void mute(std::uint16_t address, unsigned times) {
        mute_address = address;
        silences_left = times;
    }
    /// After a read nothing on this line can be an echo any more.
    void prove() {
        REQUIRE(run(fixture::only_look));
        port.frames.clear();
    }
    command_status run(const bare::command& c) {
        const command_status r = drive.run(c);
        REQUIRE(drive.is_idle());
        REQUIRE_FALSE(port.ran_away);
        return r;
    }
    command_status run(routine table) {
        // A routine that begins with a stop is a stop.
        const bool is_stop = table[0].is_repeatable;
        return run({.steps = table, .stop = is_stop ? stop_priority::halt : stop_priority::no_stop});
    }
    /// Frames that begin a request to this address.
    std::size_t asked(std::uint16_t address) const {
        std::size_t n = 0;
        for (const sent_frame& f : port.frames) n += f.data[2] * 256u + f.data[3] == address ? 1u : 0u;
        return n;
    }
};

constexpr std::uint16_t mode_at = 0x0100;
constexpr std::uint16_t command_at = 0x0101;
constexpr std::uint16_t speed_at = 0x0102;
constexpr std::uint16_t state_at = 0x0110;

response_limits with_damage() {
    response_limits p;
    p.corrupted_request = 9;
    return p;
}

} // namespace

static_assert(fixture::until_still.value == 20 && fixture::until_still.is_within);

// Steps are never left out by chance.
template <class R>
concept is_made_of_nothing = requires {
    R{};
}
|| requires { R{{}}; };
static_assert(!is_made_of_nothing<routine> && routine{no_steps}.empty());

TEST_CASE("a routine is a range of the steps of its table") {
    static constexpr std::array kept{fixture::zero, fixture::stop};
    const routine whole{fixture::two_stops};
    CHECK(routine{kept}.data() == kept.data());
    CHECK(routine{kept}.size() == 2);
    CHECK(routine{no_steps}.begin() == routine{no_steps}.end());
    std::size_t at = 0;
    for (const step& s : whole) CHECK(&s == &fixture::two_stops[at++]);
    CHECK(at == 2);
    CHECK(&whole[0] == &fixture::two_stops[0]);
}

TEST_CASE("G15: a step that the drive refuses is not repeated and ends its routine, and the report states "
          "what was done before") {
    rig r;
    r.prove();
    r.refuse(mode_at, 2, 1);
    const command_status first = r.run(fixture::set_and_start);
    CHECK(first.outcome() == outcome::refused);
    CHECK(first.exception() == 2);
    CHECK(first.step() == 0);
    CHECK_FALSE(first.has_changed());
    CHECK(r.port.frames.size() == 1);
    r.refuse(command_at, 3, 1);
    const command_status second = r.run(fixture::set_and_start);
    CHECK(second.outcome() == outcome::refused);
    CHECK(second.step() == 1);
    CHECK(second.has_changed());
    CHECK(r.port.frames.size() == 3);
}

TEST_CASE("G15: a step whose response is lost is sent once and ends unknown, and nothing after it is sent") {
    rig r;
    r.prove();
    r.mute(mode_at, 1);
    const command_status lost = r.run(fixture::set_and_start);
    CHECK(lost.outcome() == outcome::unknown);
    CHECK(lost.error() == errc::timeout);
    CHECK(lost.step() == 0);
    CHECK_FALSE(lost.has_changed());
    CHECK(r.port.frames.size() == 1);
}

TEST_CASE("a read is repeated after a timeout and after an exception that reports a damaged request, not "
          "after a refusal") {
    SUBCASE("as many timeouts as retries") {
        rig r;
        r.mute(state_at, 2);
        CHECK(r.run(fixture::only_look));
        CHECK(r.port.frames.size() == 3);
    }
    SUBCASE("one timeout more") {
        rig r;
        r.mute(state_at, 3);
        const command_status silent = r.run(fixture::only_look);
        CHECK(silent.outcome() == outcome::not_sent); // nothing that changes the drive was sent
        CHECK(silent.error() == errc::timeout);
        CHECK(r.port.frames.size() == 3);
    }
    SUBCASE("damaged") {
        rig r{with_damage()};
        r.refuse(state_at, 9, 2);
        CHECK(r.run(fixture::only_look));
        CHECK(r.port.frames.size() == 3);
    }
    SUBCASE("damaged, once more") {
        rig r{with_damage()};
        r.refuse(state_at, 9, 3);
        CHECK(r.run(fixture::only_look).exception() == 9);
        CHECK(r.port.frames.size() == 3);
    }
    SUBCASE("another exception of that drive") {
        rig r{with_damage()};
        r.refuse(state_at, 2, 1);
        CHECK(r.run(fixture::only_look).exception() == 2);
        CHECK(r.port.frames.size() == 1);
    }
    SUBCASE("the same number from a drive that means something else by it") {
        rig r;
        r.refuse(state_at, 9, 1);
        CHECK(r.run(fixture::only_look).exception() == 9);
        CHECK(r.port.frames.size() == 1);
    }
    SUBCASE("exception 0, where no number means that the request was damaged") {
        rig r;
        r.refuse(state_at, 0, 1);
        CHECK(r.run(fixture::only_look).error() == errc::exception);
        CHECK(r.port.frames.size() == 1);
    }
}

TEST_CASE("G15: a write that the drive reports as damaged is not repeated, unless it is a stop") {
    rig r{with_damage()};
    r.prove();
    r.refuse(mode_at, 9, 1);
    CHECK(r.run(fixture::set_and_start).outcome() == outcome::refused);
    CHECK(r.port.frames.size() == 1);
    r.refuse(command_at, 9, 1);
    CHECK(r.run(fixture::one_stop));
    CHECK(r.asked(command_at) == 2);
}

TEST_CASE("G3, G26: a stop is sent three times whatever the responses are, and ends with the first good one, "
          "which may be "
          "an echo after one that was lost") {
    for (unsigned bad = 0; bad <= 4; ++bad) {
        for (const bool is_refusal : {false, true}) {
            CAPTURE(bad);
            CAPTURE(is_refusal);
            rig r;
            r.prove();
            if (is_refusal) {
                r.refuse(command_at, 4, bad);
            } else {
                r.mute(command_at, bad);
            }
            const command_status stopped = r.run(fixture::one_stop);
            CHECK(r.asked(command_at) == (bad < 3 ? bad + 1 : 3));
            const bool may_be_echo = !is_refusal && bad != 0 && bad < 3; // nothing is read after it
            CHECK(static_cast<bool>(stopped) == (bad < 3 && !may_be_echo));
            if (may_be_echo) CHECK(stopped.error() == errc::own_echo);
            if (bad >= 3) {
                CHECK(stopped.outcome() == (is_refusal ? outcome::refused : outcome::unknown));
                CHECK(stopped.error() == (is_refusal ? errc::exception : errc::timeout));
                CHECK(stopped.step() == 0);
            }
        }
    }
}

TEST_CASE("after a stop that fails the next stop is sent, and the report states that one was missed") {
    for (const bool is_refusal : {false, true}) {
        CAPTURE(is_refusal);
        rig r;
        r.prove();
        if (is_refusal) {
            r.refuse(speed_at, 4, 3);
        } else {
            r.mute(speed_at, 3);
        }
        const command_status both = r.run(fixture::two_stops);
        CHECK(r.asked(speed_at) == 3);
        CHECK(r.asked(command_at) == 1);
        CHECK(r.file.words[command_at] == 7);
        CHECK_FALSE(both);
        CHECK(both.error() == (is_refusal ? errc::exception : errc::timeout));
        CHECK(both.outcome() == (is_refusal ? outcome::refused : outcome::unknown));
        CHECK(both.has_changed()); // the second one did
    }
    SUBCASE("both fail: the error of the last one") {
        rig r;
        r.prove();
        r.mute(speed_at, 3);
        r.refuse(command_at, 4, 3);
        const command_status none = r.run(fixture::two_stops);
        CHECK(r.port.frames.size() == 6);
        CHECK(none.error() == errc::exception);
        CHECK(none.step() == 1);
        CHECK(none.has_changed()); // perhaps
    }
    SUBCASE("what follows the stops is done as well, and the first error is kept") {
        rig r;
        r.prove();
        r.mute(speed_at, 3);
        const command_status looked = r.run(fixture::stops_then_look);
        CHECK(r.asked(state_at) == 1);
        CHECK(looked.error() == errc::timeout);
        CHECK(looked.outcome() == outcome::unknown);
    }
    SUBCASE("but no other write is sent after a stop that failed") {
        rig r;
        r.prove();
        r.mute(command_at, 3);
        CHECK(r.run(fixture::stop_then_start).outcome() == outcome::unknown);
        CHECK(r.port.frames.size() == 3);
        CHECK(r.file.words[command_at] == 0);
    }
}

TEST_CASE("a routine that missed stops in two places reports the first of them") {
    rig r;
    r.prove();
    r.mute(speed_at, 3);
    r.refuse(speed_at, 4, 3); // after the timeouts
    const command_status made = r.run(fixture::stop_look_stop);
    CHECK(made.error() == errc::timeout);
    CHECK(made.outcome() == outcome::unknown);
    CHECK(made.has_changed());
    CHECK(r.asked(speed_at) == 6);
    CHECK(r.asked(command_at) == 2);
    CHECK(r.asked(state_at) == 2);
}

TEST_CASE("a lost port is not called again, not even for a stop") {
    for (const bool is_stop : {false, true}) {
        CAPTURE(is_stop);
        rig r;
        r.prove();
        r.port.lost_from_call = r.port.calls + 1;
        const std::uint64_t calls = r.port.calls;
        const command_status lost =
            r.run(is_stop ? routine{fixture::two_stops} : routine{fixture::only_look});
        CHECK(lost.error() == errc::port_lost);
        CHECK(lost.outcome() == outcome::not_sent);
        CHECK(lost.step() == 0);
        CHECK(r.port.calls == calls + 1);
    }
}

TEST_CASE("G3: acknowledged single writes prove nothing on a line where only echoes were received") {
    rig r;
    r.port.device = [](tests::scripted_port& p, const sent_frame& f) { p.say(0, f.data); }; // an echo
    const command_status echoed = r.run(fixture::set_and_start);
    CHECK(echoed.outcome() == outcome::unknown);
    CHECK(echoed.error() == errc::own_echo);
    CHECK_FALSE(r.on.is_echo_ruled_out());
    rig other;
    other.prove();
    CHECK(other.run(fixture::set_and_start).outcome() == outcome::done);
    rig with_a_read; // in the routine itself
    CHECK(with_a_read.run(fixture::set_look_start).outcome() == outcome::done);
}

TEST_CASE("a register that holds another value ends the routine with the error of the step") {
    rig r;
    const command_status wrong = r.run(fixture::checked_start);
    CHECK(wrong.error() == errc::wrong_state);
    CHECK(wrong.outcome() == outcome::not_sent);
    CHECK(r.asked(command_at) == 0);
    r.file.words[mode_at] = 3;
    CHECK(r.run(fixture::checked_start));
    CHECK(r.asked(command_at) == 1);
}

TEST_CASE(
    "arguments are written and read back from their slot on, and fetched words are stored from theirs on") {
    rig r;
    CHECK(r.run({.steps = fixture::arguments, .arguments = {11, 22, 33, 44, 55, 66}}));
    CHECK(r.file.words[speed_at] == 22);
    CHECK(r.file.words[speed_at + 1] == 33);
    r.file.words[state_at] = 0xABCD;
    CHECK(r.run(fixture::only_look));
    CHECK(r.drive.words()[2] == 0xABCD);
    CHECK(r.drive.words()[1] == 0);
}

TEST_CASE("a state is awaited for the limit of its step, or for that of the command if the step has none") {
    for (const std::uint32_t limit : {10u, 50u, 200u}) {
        CAPTURE(limit);
        const bool is_commanded = limit != 50;
        rig r;
        r.prove();
        const std::uint64_t begun = r.port.time;
        const command_status never =
            r.run({.steps = is_commanded ? routine{fixture::wait_as_commanded} : routine{fixture::wait_ready},
                   .limit = milliseconds(limit)});
        CHECK(never.error() == errc::not_reached);
        CHECK(r.port.time - begun >= limit * 1000);
        CHECK(r.port.time - begun <= limit * 1000 + 25'000); // the feedback is read every 20 ms
        CHECK(r.port.frames.size() >= 2);
    }
    rig r;
    r.port.device = [&r](tests::scripted_port& p, const sent_frame& f) {
        if (r.port.frames.size() == 3) return; // a lost response meanwhile costs only a retry
        if (r.port.frames.size() == 8) r.file.words[state_at] = 1;
        r.file(p, f);
    };
    CHECK(r.run({.steps = fixture::wait_as_commanded, .limit = milliseconds(1000)}));
    CHECK(r.port.frames.size() == 8);
}

TEST_CASE("motors are at standstill when both speeds are near zero, in either direction") {
    struct scene {
        int left;
        int right;
        bool stands;
    };
    for (const scene s : {scene{0, 0, true}, scene{20, -20, true}, scene{21, 0, false}, scene{0, -21, false},
                          scene{-21, 0, false}, scene{0, 21, false}, scene{-32768, 0, false}}) {
        CAPTURE(s.left);
        CAPTURE(s.right);
        rig r;
        r.file.words[speed_at] = static_cast<u16>(s.left);
        r.file.words[speed_at + 1] = static_cast<u16>(s.right);
        CHECK(static_cast<bool>(r.run(fixture::wait_still)) == s.stands);
    }
}

TEST_CASE("G29: a clock that stops ends the routine, and what was sent is unknown") {
    for (const std::uint32_t after : {0u, 2000u, 3000u}) { // before, while sending, while waiting
        CAPTURE(after);
        rig r;
        r.prove();
        r.port.device = nullptr;
        const std::uint64_t at = r.port.time + after;
        r.port.clock = [at](std::uint64_t t) { return static_cast<std::uint32_t>(t < at ? t : at); };
        const command_status stopped = r.run(fixture::set_and_start);
        CHECK(stopped.error() == errc::clock_stopped);
        CHECK(r.port.frames.size() == (after == 0 ? 0 : 1));
        CHECK(stopped.outcome() == (after == 0 ? outcome::not_sent : outcome::unknown));
        CHECK(r.on.is_free()); // it was released
    }
}

TEST_CASE("G21: after a read without a response the witness is read before the routine goes on") {
    static constexpr step look_and_start[] = {fixture::look, fixture::start};
    for (const bool is_missing : {false, true}) {
        CAPTURE(is_missing);
        rig r;
        r.file.words[mode_at] = 3;
        REQUIRE(r.run({.steps = fixture::only_look,
                       .then = command_kind::take_over,
                       .witness = {&fixture::check_mode, {3, 0}}}));
        r.file.words[mode_at] = 4; // another mode since a restart
        if (is_missing) r.mute(state_at, 1);
        const command_status end = r.run(look_and_start);
        CHECK(end.error() == (is_missing ? errc::needs_init : errc::ok));
        CHECK(r.asked(command_at) == (is_missing ? 0u : 1u));
        CHECK(r.drive.state() == (is_missing ? drive_state::needs_init : drive_state::enabled));
    }
}

} // namespace routine_tests
