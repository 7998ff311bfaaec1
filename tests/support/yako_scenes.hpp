// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every command of the YAKOTEC facades, for tests that play it with an event at each of its frames: the states in which
// commands begin, how the drive is when they are done, and what a command may have done that failed. All scenes run
// under the interpretations of the manual (tests/support/yako_interpretations.hpp).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/yako_interpretations.hpp>

namespace yako_scenes {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;

constexpr auto stop_frame = modbus::write_frame(1, 0x0027, 0x0100);
constexpr auto quick_stop_frame = modbus::write_frame(1, 0x0027, 0x0200);
constexpr auto release_frame = modbus::write_frame(1, 0x002D, 0x0011);

const motion_profile gentle{10 * r_per_min, 50 * millisecond, 50 * millisecond, 60 * r_per_min};
const motion_profile brisk{10 * r_per_min, 20 * millisecond, 20 * millisecond, 300 * r_per_min};

constexpr yako::held_velocity fast{600 * r_per_min, milliseconds(1), 10 * millisecond, 10 * millisecond};

inline bool is_write(bytes f) { return modbus::is_write(f[1]); }
inline bool is_stop(bytes f) {
    return same_bytes(f, stop_frame) || same_bytes(f, quick_stop_frame) || same_bytes(f, release_frame);
}

// The states in which commands begin. The axis is not at zero, where a restart would put it.

template <class A, class... Commands> void take(A& a, const Commands&... then) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(move_by{30 * pulse, brisk}));
    a.run(30);
    REQUIRE(a.place() == 30);
    CHECK((static_cast<bool>(a.drive.run(then)) && ...));
}
template <class A, class... Commands> void take_homed(A& a, const Commands&... then) {
    take(a, declare_position{30 * pulse}, then...);
}
template <class A> void take_low_first(A& a) { take(a, set_word_order{word_order_setting::low_first}); }
template <class A> void take_limited(A& a) { take(a, limit_travel{-5000 * pulse, 5000 * pulse}); }
template <class A> void take_over_homed(A& a) { take_homed(a, init{}); }
template <class A> void be_released(A& a) { take(a, disable{}); }
template <class A> void run(A& a) { take(a, velocity{60 * r_per_min, 30 * millisecond, 30 * millisecond}); }
template <class A> void move_shortly(A& a) { take(a, move_by{20 * pulse, gentle}); }
template <class A> void move_on(A& a) { take(a, move_by{3000 * pulse, gentle}); }
template <class A> void keep_on(A& a) { take(a, fast); }
template <class A> void move_on_homed(A& a) { take_homed(a, move_by{3000 * pulse, gentle}); }
template <class A> void have_an_alarm(A& a) {
    take(a);
    a.model.raise_alarm(1);
    a.model.end_alarm();
}
template <class A, class... Commands> void take_at_home(A& a, const Commands&... then) {
    sim::yako_machine m;
    m.home_from = 20;
    m.home_to = 40;
    a.model.attach(m);
    take(a, set_homing_profile{300 * r_per_min, 150 * r_per_min, 30 * millisecond}, then...);
}
template <class A> void take_at_home_low_first(A& a) {
    take_at_home(a, set_word_order{word_order_setting::low_first});
}

// Checks of the drive for when a command is done.

template <class A> bool always(A&) { return true; }
template <class A> bool stands(A& a) { return !a.is_moving(); }
// 30 pulses by the preparation, then 20.
template <class A> bool has_arrived(A& a) { return !a.is_moving() && a.model.view().shaft == 50; }
template <class A> bool runs(A& a) { return a.is_moving(); }
template <class A> bool is_on(A& a) { return a.model.enabled(); }
template <class A> bool is_off(A& a) { return !a.model.enabled() && !a.is_moving(); }
template <class A> bool is_healthy(A& a) { return a.model.alarm() == 0; }
template <class A> bool is_homed(A& a) { return a.model.view().is_homed; }
template <class A> bool is_kept(A& a) { return a.model.saves() == 1; }
template <class A, u16 Address, u16 Value> bool has(A& a) { return a.model.peek(Address) == Value; }
template <class A, u16 Address, u16 First, u16 Second> bool has_pair(A& a) {
    return has<A, Address, First>(a) && has<A, Address + 1, Second>(a);
}

constexpr std::int64_t any_way = -1;

template <class A> struct row {
    std::string name;
    void (*prepare)(A&);
    std::function<command_status(A&)> begin;
    bool (*is_done)(A&);
    std::int64_t way = any_way; // by which the shaft turns; 0 for commands that do not move it
};
template <class A> using rows = std::vector<row<A>>;

template <class Command> auto command_to(Command wanted) {
    return [wanted](auto& a) { return a.drive.begin(wanted); };
}

// clang-format off
template <class A> rows<A> commands_alike() {
    const sole_drive_on_the_line alone{};
    constexpr auto absolute = positioning::absolute;
    constexpr auto interrupt = while_moving::interrupt;
    return {
        {"init",                  run<A>,            command_to(init{}),                                     stands<A>},
        {"enable",                be_released<A>,    command_to(enable{}),                                   is_on<A>},
        {"release",               run<A>,            command_to(disable{}),                                  is_off<A>},
        {"stop",                  run<A>,            command_to(halt{}),                                     stands<A>},
        {"quick_stop",            run<A>,            command_to(quick_stop{}),                               stands<A>},
        {"fault_reset",           have_an_alarm<A>,  command_to(fault_reset{}),                              is_healthy<A>},
        {"move_by",               take<A>,           command_to(move_by{100 * pulse, brisk}),                always<A>, 100},
        {"move_by, to zero",      take<A>,           command_to(move_by{-30 * pulse, brisk}),                always<A>, -30},
        {"move_by, low first",    take_low_first<A>, command_to(move_by{100 * pulse, brisk}),                always<A>, 100},
        {"move_by, limited",      take_limited<A>,   command_to(move_by{100 * pulse, brisk}),                always<A>, 100},
        {"move_by, stored",       take<A>,           command_to(move_by{100 * pulse}),                       always<A>, 100},
        {"move_by, both",         take_low_first<A>, command_to(move_by{100 * pulse}),                       always<A>, 100},
        {"move_by, interrupting", move_on<A>,        command_to(move_by{100 * pulse, gentle, interrupt}),    always<A>},
        {"the same, stored",      move_on<A>,        command_to(move_by{100 * pulse, {}, interrupt}),        always<A>},
        {"move_to",               take_homed<A>,     command_to(move_to{130 * pulse, brisk}),                always<A>, 100},
        {"move_to, stored",       take_homed<A>,     command_to(move_to{130 * pulse}),                       always<A>, 100},
        {"move_to, interrupting", move_on_homed<A>,     command_to(move_to{900 * pulse, gentle, interrupt}),    always<A>},
        {"the same, stored",      move_on_homed<A>,  command_to(move_to{900 * pulse, {}, interrupt}),        always<A>},
        {"jog",                   take<A>,           command_to(velocity{60 * r_per_min}),                        runs<A>},
        {"bounded_jog",           take<A>,           command_to(bounded_jog{100 * pulse, brisk}),                  always<A>, 100},
        {"bounded_jog, stored",   take<A>,           command_to(bounded_jog{100 * pulse}),                         always<A>, 100},
        {"hold",                  take<A>,           command_to(fast),                                       always<A>, yako::reach(fast, {.microsteps = 1000}).count()},
        {"hold, going on",        keep_on<A>,        command_to(fast),                                       always<A>},
        {"declare_position",      take<A>,           command_to(declare_position{70'000 * pulse}),           is_homed<A>, 0},
        {"the same, low first",   take_low_first<A>, command_to(declare_position{70'000 * pulse}),           has_pair<A, 0x000A, 0x1170, 1>, 0},
        {"accept_position",        take_over_homed<A>, command_to(accept_position{}),                          is_homed<A>, 0},
        {"clear_position",        take_homed<A>,     command_to(clear_position{}),                           has_pair<A, 0x000A, 0, 0>, 0},
        {"wait_standstill",       move_shortly<A>,   command_to(wait_standstill{}),                                    stands<A>},
        {"wait_reached",         move_shortly<A>,   command_to(wait_reached{}),                            has_arrived<A>},
        {"read_feedback",         take<A>,           command_to(read_feedback{}),                            always<A>, 0},
        {"set_profile",           take<A>,           command_to(set_profile{gentle}),                        has<A, 0x0023, 60>, 0},
        {"set_homing_profile",    take<A>,           command_to(set_homing_profile{90 * r_per_min, 30 * r_per_min}), has_pair<A, 0x0032, 90, 30>, 0},
        {"set_position_segment",  take<A>,           command_to(set_position_segment{3, 70'000 * pulse, 90 * r_per_min}), has_pair<A, 0x006C, 1, 0x1170>, 0},
        {"set_speed_segment",     take<A>,           command_to(set_speed_segment{3, 90 * r_per_min}),       has<A, 0x00C6, 90>, 0},
        {"set_pv_trigger",        take<A>,           command_to(set_pv_trigger{pv_trigger::rising_edge}),    has<A, 0x0051, 1>, 0},
        {"set_input_move",        take<A>,           command_to(set_input_move{70'000 * pulse, gentle}),     has_pair<A, 0x0024, 1, 0x1170>, 0},
        {"the same, absolute",    take_homed<A>,     command_to(set_input_move{70'000 * pulse, gentle, absolute}), has<A, 0x0050, 1>, 0},
        {"set_input",             be_released<A>,    command_to(set_input{input_terminal::x3, input_function::stop}), has<A, 0x0044, 5>, 0},
        {"set_output",            take<A>,           command_to(set_output{output_terminal::y1, output_function::user_0}), has<A, 0x004D, 9>, 0},
        {"limit_travel",          take<A>,           command_to(limit_travel{-1 * pulse, 7000 * pulse}),     has_pair<A, 0x0037, 0, 7000>, 0},
        {"unlimit_travel",        take_limited<A>,   command_to(unlimit_travel{}),                           has<A, 0x0018, 0>, 0},
        {"set_over_travel_stop",  take<A>,           command_to(set_over_travel_stop{static_cast<over_travel_stop>(1)}), has<A, 0x0017, 1>, 0},
        {"set_word_order",        take<A>,           command_to(set_word_order{word_order_setting::low_first}),      has<A, 0x0019, 1>, 0},
        {"save",                  take<A>,           command_to(save{}),                                     is_kept<A>, 0},
        {"factory_reset",         take<A>,           command_to(factory_reset{alone}),                       has<A, 0x0023, 60>, 0},
        {"set_node_address",      take<A>,           command_to(set_node_address{9, alone}),                 has<A, 0x0013, 9>, 0},
        {"set_baud_rate",         take<A>,           command_to(set_baud_rate{static_cast<baud_rate>(2)}),   has<A, 0x0014, 2>, 0},
        {"set_serial_format",     take<A>,           command_to(set_serial_format{static_cast<serial_format>(2)}), has<A, 0x0015, 2>, 0},
    };
}
rows<closed_axis> commands_of(const closed_axis*) {
    using A = closed_axis;
    rows<A> all = commands_alike<A>();
    all.insert(all.end(), {
        {"home",                  take_at_home<A>,   command_to(closed_loop::home{homing::home_24}),         is_homed<A>},
        {"home, low first",       take_at_home_low_first<A>, command_to(closed_loop::home{homing::home_24, 70 * pulse}), is_homed<A>},
        {"set_input_polarity",    be_released<A>,    command_to(closed_loop::set_input_polarity{{.x3 = true}}),  has<A, 0x0040, 8>, 0},
        {"set_output_polarity",   take<A>,           command_to(closed_loop::set_output_polarity{{.y1 = true}}), has<A, 0x004B, 2>, 0},
        {"set_outputs",           take<A>,           command_to(closed_loop::set_outputs{{.y1 = true}}),         has<A, 0x004F, 2>, 0},
        {"set_speed_resolution",  take<A>,           command_to(set_speed_resolution{speed_count::tenth_r_per_min}), has<A, 0x001A, 1>, 0},
    });
    return all;
}
rows<open_axis> commands_of(const open_axis*) {
    using A = open_axis;
    rows<A> all = commands_alike<A>();
    all.insert(all.end(), {
        {"home",                  take_at_home<A>,   command_to(open_loop::home{homing::home_24}),           is_homed<A>},
        {"set_input_polarity",    be_released<A>,    command_to(open_loop::set_input_polarity{{.x6 = true}}),  has<A, 0x0040, 64>, 0},
        {"set_output_polarity",   take<A>,           command_to(open_loop::set_output_polarity{{.y2 = true}}), has<A, 0x004B, 4>, 0},
        {"set_outputs",           take<A>,           command_to(open_loop::set_outputs{{.y2 = true}}),         has<A, 0x004F, 4>, 0},
    });
    return all;
}
// clang-format on

/// A command in progress.
template <class A> struct scene : A {
    const row<A>& of;
    std::size_t first; // frame of the command
    std::uint32_t asked;
    std::uint32_t starts;
    std::int64_t place;

    explicit scene(const row<A>& wanted, sim::yako_options options = {}) : A{options}, of{wanted} {
        of.prepare(*this);
        first = this->requests.size();
        asked = this->wire.requests();
        starts = this->model.starts();
        place = this->model.view().shaft;
        REQUIRE(of.begin(*this) == errc::ok);
    }

    std::size_t frames() const { return this->requests.size() - first; }
    /// The number of frames of which the first byte has been sent.
    std::size_t begun() const { return this->wire.requests() - asked; }
    bool is_ok() const { return static_cast<bool>(this->drive.last()); }
    bool moves() const { return of.way != any_way && of.way != 0; }
    std::int64_t way() const { return this->model.view().shaft - place; }
    /// The longest time that the call may take after the line is lost: a read of three tries and a stop of
    /// three, or the read after a start.
    std::uint64_t longest_end_us() const {
        return 7u * this->line.bound(24, 64, {}, {{}, milliseconds(100)}).us;
    }

    template <class Before> void play(Before before_each_turn) {
        const std::uint64_t end = this->wire.time_us() + 8'000'000;
        for (tests::loop_bound left{"the end of a command"}; !this->drive.is_idle(); left.use()) {
            before_each_turn();
            this->turn();
            if (this->wire.time_us() > end) FAIL("it does not end");
        }
    }
    void reconnect() {
        this->wire.set_connected(0, true);
        this->wire.faults() = {};
    }

    void check_done() {
        this->run(120);
        CHECK(of.is_done(*this));
        if (of.way != any_way) CHECK(way() == of.way);
    }
    /// The command ended before the event: it is done.
    bool is_over() {
        CHECK(is_ok());
        check_done();
        return false;
    }
    /// Checks that the motion is the commanded one or a part of it.
    void check_way() {
        if (of.way == any_way) return;
        CHECK((of.way < 0 ? way() <= 0 : way() >= 0));
        CHECK((of.way < 0 ? way() >= of.way : way() <= of.way));
    }
    /// G15: no write but a stop was sent twice.
    void check_once() {
        for (std::size_t i = first; i < this->requests.size(); ++i) {
            const auto& f = this->requests[i];
            if (!is_write(f) || is_stop(f)) continue;
            for (std::size_t j = first; j < i; ++j) CHECK_FALSE(f == this->requests[j]);
        }
        CHECK(this->model.starts() <= starts + 1);
    }
    /// G16, G21: a command that was not sent wrote nothing, and an unknown outcome invalidates the cached
    /// state.
    void check_failure() {
        const command_status r = this->drive.last();
        CHECK((r.outcome() == outcome::not_sent || r.outcome() == outcome::unknown ||
               this->model.refused != 0));
        if (r.outcome() == outcome::unknown) CHECK(this->drive.state() == drive_state::needs_init);
        if (moves() && this->model.starts() == starts) CHECK(this->drive.motion() != motion_check::seen);
        if (r.outcome() != outcome::not_sent) return;
        for (std::size_t i = first; i < this->requests.size(); ++i) CHECK_FALSE(is_write(this->requests[i]));
    }
    /// Checks that the cached settings are those of the drive.
    void check_beliefs() {
        const cached_settings& known = this->drive.cached();
        if (known.state == drive_state::needs_init) return;
        if (of.prepare != have_an_alarm<A> || is_ok()) // which only a response shows
            CHECK((known.state == drive_state::enabled) == this->model.enabled());
        CHECK((known.word_order == word_order::low_first) == (this->model.peek(0x0019) == 1));
        CHECK(static_cast<u16>(known.limits) == this->model.peek(0x0018));
        if (known.is_homed) CHECK(is_homed<A>(*this));
    }
};

/// Plays `scene_at(row, n, variant, options)` for n = 0, 1, 2 .. as long as it returns that its event has occurred.
/// Under the manual's first interpretation it plays all variants, under the others one after another. In the whole
/// product each choice plays one scene, the next one of the next row.
template <class A, class Scene> void at_every_frame(std::size_t variants, Scene scene_at) {
    const rows<A> all = commands_of(static_cast<const A*>(nullptr));
    std::vector<std::size_t> next(variants * all.size(), 0);
    ::interpretations::under_yako([&](const sim::yako_options& by, std::size_t number, bool is_whole) {
        std::size_t played = 0;
        for (std::size_t i = 0; i < next.size(); ++i) {
            const std::size_t variant = i / all.size();
            const std::size_t k = i % all.size();
            const bool is_due =
                is_whole ? i == number % next.size() : number == 0 || variant == number % variants;
            if (!is_due) continue;
            CAPTURE(all[k].name);
            CAPTURE(variant);
            std::size_t n = is_whole ? next[i] : 0;
            bool goes_on = true;
            do {
                CAPTURE(n);
                goes_on = scene_at(all[k], n, variant, by);
                n = goes_on ? n + 1 : 0;
                ++played;
            } while (goes_on && !is_whole);
            next[i] = n;
        }
        return played;
    });
}
/// With two variants.
template <class A, class Scene> void at_every_frame(Scene scene_at) {
    at_every_frame<A>(2, [&](const row<A>& o, std::size_t n, std::size_t variant,
                             const sim::yako_options& by) { return scene_at(o, n, variant != 0, by); });
}

} // namespace yako_scenes
