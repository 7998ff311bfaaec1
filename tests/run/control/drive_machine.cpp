// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's machine moved by hand: no line, no port, no simulated drive. The compiler runs it.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/device/zlac8015d.hpp>

namespace drive_machine_tests {

using namespace servobus;
using namespace servobus::units;
namespace zlac = servobus::zlac8015d;

// Answers each read with words of zero and each write with its acknowledgement, or is silent.
struct hand {
    drive_machine<zlac::model, modbus::exchange> drive{node<zlac::device>{1}, duration{}, no_command_timeout};
    instant now{1000};
    servobus::epoch in{};
    std::uint8_t changed = 0; // the node whose settings another client has written last
    modbus::rtu_timing at_115200 = modbus::timing_at(115200);
    std::uint16_t first_written = 0; // register
    unsigned writes = 0;
    unsigned frames = 0;
    unsigned announced = 0;
    unsigned abandoned = 0;

    // The five calls that a machine makes on its line.
    constexpr servobus::epoch epoch(std::uint8_t) const { return in; }
    constexpr std::uint8_t changed_node() const { return changed; }
    constexpr const modbus::rtu_timing& timing() const { return at_115200; }
    constexpr void abandon(modbus::exchange& x) {
        x.abort(errc::busy, false);
        ++abandoned;
    }
    constexpr void announce_stop() { ++announced; }

    template <class Wanted> constexpr errc begin(const Wanted& wanted) {
        auto next = commands::prepared(wanted, drive.valid_settings(now, *this));
        const errc refusal = drive.accept(next, now);
        drive.notify(*this);
        return refusal;
    }
    // Loads the frame that is due. False if there is none.
    constexpr bool load() {
        if (drive.pass(now, *this)) drive.notify(*this);
        const flight next = drive.next(now, *this);
        if (next != drive.purpose()) drive.load(next, now, *this);
        return next != flight::none;
    }
    constexpr void exchange(bool is_answered) {
        auto& x = drive.exchange();
        const instant began = now;
        x.begin_leaving();
        now.us += 700;
        x.sent(now);
        note(x.request());
        if (is_answered) answer(x);
        while (!x.done()) now.us += x.elapse(now).us;
        if (!is_answered) ++in.misses;
        drive.conclude(now, began, false);
        drive.notify(*this);
    }
    constexpr bool turn(bool is_answered) {
        if (!load()) {
            now.us += 1000;
            return false;
        }
        exchange(is_answered);
        return true;
    }
    constexpr command_status run(bool is_answered) {
        for (unsigned i = 0; i < 1000 && !drive.slot().is_idle(); ++i) (void)turn(is_answered);
        return drive.slot().report();
    }

  private:
    constexpr void note(bytes request) {
        ++frames;
        if (modbus::is_read(request[1])) return;
        if (writes++ == 0) first_written = static_cast<std::uint16_t>(request[2] << 8 | request[3]);
    }
    static constexpr void answer_with(modbus::exchange& x, byte_buffer response, instant now) {
        (void)modbus::close_frame<modbus::default_crc>(response, response.size() - 3);
        (void)x.feed(bytes{response.data(), response.size()}, now);
    }
    constexpr void answer(modbus::exchange& x) const {
        std::uint8_t response[64]{};
        const std::size_t size = x.response_size();
        const bool is_read = modbus::is_read(x.request()[1]);
        for (std::size_t i = 0; i < (is_read ? 2u : 6u); ++i) response[i] = x.request()[i];
        if (is_read) response[2] = static_cast<std::uint8_t>(size - 5);
        answer_with(x, byte_buffer{response, size}, now);
    }
};

constexpr bool begins_with_a_stop() {
    hand h;
    if (h.begin(init{}) != errc::ok) return false;
    while (h.writes == 0) {
        if (!h.turn(true)) return false;
    }
    return h.first_written == zlac::left_target_speed.address;
}
static_assert(begins_with_a_stop());

// Nothing is known of the drive: all that stops it is sent, and nothing is believed of a silent drive.
constexpr bool is_disabled(bool is_answered) {
    hand h;
    if (h.begin(disable{}) != errc::ok) return false;
    return bool{h.run(is_answered)} == is_answered && h.announced != 0;
}
static_assert(is_disabled(true) && is_disabled(false));

// Until the first byte leaves, a stop takes the place of what waits; then that is received, and not used.
constexpr bool a_stop_takes_the_place(bool has_left) {
    hand h;
    if (h.begin(init{}) != errc::ok || !h.load()) return false;
    if (has_left) h.drive.exchange().begin_leaving();
    if (h.begin(quick_stop{}) != errc::ok) return false;
    if (has_left) return h.drive.is_on_the_wire() && h.drive.purpose() == flight::drained && h.abandoned == 0;
    return h.abandoned == 1 && h.drive.wants_stop() && h.drive.next(h.now, h) == flight::step;
}
static_assert(a_stop_takes_the_place(true) && a_stop_takes_the_place(false));

// A lost port ends the command at once, and nothing is known any more.
constexpr bool a_lost_port_ends_it() {
    hand h;
    if (h.begin(read_feedback{}) != errc::needs_init) return false;
    if (h.begin(init{}) != errc::ok || !h.load()) return false;
    ++h.in.events.losses;
    h.in.misses += 0x100; // a miss of all nodes
    if (!h.drive.pass(h.now, h)) return false;
    h.drive.notify(h);
    return h.drive.slot().is_idle() && h.drive.slot().report().error() == errc::port_lost &&
           h.abandoned == 1 && h.drive.next(h.now, h) == flight::none;
}
static_assert(a_lost_port_ends_it());

// How a take-over has ended after another client's writes, the last one of node `changed`.
constexpr errc after_changes(unsigned changes, std::uint8_t changed, unsigned losses = 0) {
    hand h;
    if (h.begin(init{}) != errc::ok || !h.load()) return errc::bad_argument;
    h.in.events.losses = static_cast<std::uint8_t>(h.in.events.losses + losses);
    h.in.events.changes = static_cast<std::uint8_t>(h.in.events.changes + changes);
    h.changed = changed;
    const bool has_ended = h.drive.pass(h.now, h);
    h.drive.notify(h);
    if (has_ended != h.drive.slot().is_idle()) return errc::bad_argument;
    return has_ended ? h.drive.slot().report().error() : errc::ok;
}
static_assert(after_changes(0, 0) == errc::ok);
static_assert(after_changes(1, 1) == errc::needs_init); // of this drive
static_assert(after_changes(2, 0) == errc::needs_init); // of all drives
static_assert(after_changes(1, 2) == errc::ok);         // of another one
static_assert(after_changes(2, 2) == errc::needs_init); // which the first was of is not known
static_assert(after_changes(0, 2, 1) == errc::port_lost);
static_assert(after_changes(1, 2, 2) == errc::port_lost);
static_assert(after_changes(0, 1, 4) == errc::port_lost); // several losses are no change
static_assert(after_changes(0, 2, 8) == errc::port_lost);

TEST_CASE("G19: a drive's machine is moved by hand, without a line") {
    hand h;
    CHECK(h.begin(disable{}) == errc::ok);
    CHECK(h.drive.wants_stop());
    CHECK_FALSE(h.run(false));
    const unsigned silent = h.frames;
    CHECK(h.begin(disable{}) == errc::ok);
    CHECK(h.run(true));
    CHECK(h.frames - silent < silent); // nothing is repeated
    CHECK_FALSE(h.turn(true));         // and nothing is polled
}

} // namespace drive_machine_tests
