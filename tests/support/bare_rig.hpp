// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program, a facade that knows next to nothing of its drive (bare_drive.hpp), and registers that stand in for it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/servobus.hpp>

#include <tests/support/bare_drive.hpp>
#include <tests/support/scripted_port.hpp>

namespace bare_rigs {

using namespace servobus;
using tests::sent_frame;

struct device {
    static constexpr profile facts{.name = "plain"};
};
inline constexpr reg<i16, access::rw, device> target{0x0100, full<i16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> command{0x0101, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> setting{0x0102, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::ro, device> state{0x0110, full<u16>, no_unit, no_default};

inline constexpr step halt_steps[] = {steps::repeatable(steps::write<target>(0)),
                                      steps::expect_zero<target>()};
inline constexpr step disable_steps[] = {steps::repeatable(steps::write<command>(7)),
                                         steps::expect<command>(7)};
inline constexpr step quick_stop_steps[] = {steps::repeatable(steps::write<command>(5)),
                                            steps::expect<command>(5)};
inline constexpr step move_steps[] = {steps::write_arguments<target>()};
inline constexpr step set_steps[] = {steps::write<setting>(1), steps::expect<setting>(1)};
inline constexpr step look_steps[] = {steps::fetch<state>()};

constexpr bare::command look{.steps = look_steps};
constexpr bare::command move{.steps = move_steps, .arguments = {100}, .then = command_kind::endless_motion};
constexpr bare::command set{.steps = set_steps, .then = command_kind::setting};
constexpr bare::command halting{.steps = halt_steps, .stop = stop_priority::halt};
constexpr bare::command disabling{.steps = disable_steps, .stop = stop_priority::disable};
constexpr bare::command quick_stopping{.steps = quick_stop_steps, .stop = stop_priority::quick_stop};
constexpr bare::command taking_over{.steps = look_steps, .then = command_kind::take_over};

struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    using line_type = line<tests::waiting_scripted_port>;
    line_type on{port, modbus::timing_at(115200)};
    bare::drive<line_type> drive;
    bool is_mute = false;
    unsigned ignores = 0; ///< so many writes are acknowledged and not carried out

    /// `feedback`: the period in which the facade polls; 0: never.
    explicit rig(duration feedback = {}) : drive{on, node<device>{1}, feedback} {
        bare::model::stops_by = halting;
        for (const unsigned a : {0x0100u, 0x0101u, 0x0102u, 0x0110u}) file.words[static_cast<u16>(a)] = 0x55;
        port.device = [this](tests::scripted_port& p, const sent_frame& f) {
            if (is_mute) return;
            if (f.data[1] == 0x06 && ignores != 0) {
                --ignores;
                return p.say(500, tests::acknowledgement(f.data));
            }
            file(p, f);
        };
        REQUIRE(drive.run(taking_over));
        port.frames.clear();
    }
    rig(const rig&) = delete;

    void turn() {
        const duration idle = drive.step();
        port.wait(idle.us == 0 ? microseconds(10) : idle);
        port.time += 10;
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = port.time + std::uint64_t{ms} * 1000u;
        while (port.time < end) turn();
    }
    /// Runs until the stop of the command timeout has been sent; its response is still to come.
    void watched_stop_begins() {
        drive.set_command_timeout(milliseconds(100));
        REQUIRE(drive.run(move));
        port.frames.clear();
        const std::uint64_t end = port.time + 1'000'000;
        while (port.frames.empty() && port.time < end) turn();
        REQUIRE(port.frames.size() == 1);
        REQUIRE_FALSE(drive.is_idle());
    }
    std::size_t writes_to(unsigned address, unsigned value) const {
        std::size_t n = 0;
        for (const sent_frame& f : port.frames)
            n += f.data[1] == 6 && f.data[2] * 256u + f.data[3] == address &&
                         f.data[4] * 256u + f.data[5] == value
                     ? 1u
                     : 0u;
        return n;
    }
    std::size_t halts() const { return writes_to(0x0100, 0); }
    /// While the drive is mute: frames that did not wait for the quarantine of the frame before.
    std::size_t hasty_frames() const {
        const node<device> n{1};
        std::size_t count = 0;
        for (std::size_t i = 1; i < port.frames.size(); ++i) {
            const std::uint64_t pause = port.frames[i].begin - port.frames[i - 1].begin;
            count += pause < (n.limits.response + n.gaps.quarantine).us ? 1u : 0u;
        }
        return count;
    }
};

} // namespace bare_rigs
