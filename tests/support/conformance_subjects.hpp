// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drives of the library for the judges of sim/conformance.hpp: how each is seen from outside, what may happen to
// it, and its commands. `Interpretations` numbers the interpretations of a manual; number 0 is the simulator's default.
#pragma once

#include <cstdint>
#include <string_view>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/conformance.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/seen_machines.hpp>

namespace subjects {

using namespace servobus;
using namespace servobus::units;

/// Only the interpretation that the simulated drive has by default.
template <class Options> struct default_interpretation {
    static constexpr unsigned count = 1;
    static Options options(unsigned) { return {}; }
};

template <class Machine> void write_by_hand(Machine& m, std::uint16_t address, std::uint16_t value) {
    const std::uint8_t word[2]{static_cast<std::uint8_t>(value >> 8),
                               static_cast<std::uint8_t>(value & 0xFFu)};
    (void)m.write(address, words_view{word});
}

template <class Interpretations = default_interpretation<sim::zlac8015d_options>>
struct wheels : seen::wheels {
    using options = sim::zlac8015d_options;
    struct machine : sim::zlac8015d {
        explicit machine(const options& read) : sim::zlac8015d{read}, read_as{read} {}
        options read_as;
    };
    template <class Line> using drive = zlac8015d::drive<Line>;

    static constexpr std::uint8_t address = 1;
    static constexpr std::uint32_t baud = 115200;
    static constexpr unsigned interpretations = Interpretations::count;
    static constexpr std::int64_t tolerance = 20;
    static constexpr bool energises_by_reset = false;
    static constexpr bool energises_by_level = false;
    static sim::what_shows shows(unsigned interpretation) {
        const bool is_hidden =
            Interpretations::options(interpretation).after_quick_stop == options::stopped::locked;
        return {.restart = sim::restart_shows::while_enabled, .wired_stop = !is_hidden};
    }
    /// Errata B30 to B32.
    static bool can_be_done(unsigned interpretation, std::string_view command) {
        const options read = Interpretations::options(interpretation);
        const bool is_move = command.substr(0, 5) == "move_" || command == "a second move";
        if (command == "torque") return read.in_torque_mode == options::shaft::locked;
        if (command.substr(0, 10) == "quick_stop")
            return read.after_quick_stop == options::stopped::emergency;
        if (command == "halt, turning" || is_move) return read.bit != options::running::enabled;
        if (command == "fault_reset") return read.code == options::fault_code::until_reset;
        return true;
    }

    static machine make(unsigned interpretation) { return machine{Interpretations::options(interpretation)}; }
    template <class Drive> static bool take_over(Drive& d, machine& m) {
        write_by_hand(m, 0x2086, 10'000); // a torque soon turns the wheels
        write_by_hand(m, 0x2087, 10'000);
        if (m.read_as.code_1 == options::brake::releases) {
            write_by_hand(m, 0x201A, 1);
            write_by_hand(m, 0x201B, 1);
        }
        return static_cast<bool>(d.run(init{}));
    }
    static void write_by_another(machine& m) { write_by_hand(m, 0x2080, 700); }

    template <class Each> static void commands(const Each& each) {
        using zlac8015d::enable_in, zlac8015d::operating_mode, zlac8015d::synchronisation;
        const enable_in torque{operating_mode::torque};
        const enable_in relative{operating_mode::relative_position};
        const enable_in absolute{operating_mode::absolute_position};
        const enable_in single{operating_mode::relative_position, synchronisation::asynchronous};
        each("velocity", enable{}, velocity{30 * r_per_min, 30 * r_per_min}, sim::turns());
        each("hold", enable{}, hold{30 * r_per_min, 30 * r_per_min}, sim::turns());
        each("left_velocity", enable{}, zlac8015d::left_velocity{30 * r_per_min}, sim::turns());
        each("torque", torque, zlac8015d::torque{3000 * milliampere, 3000 * milliampere}, sim::turns());
        each("move_by", relative, move_by{2000 * pulse, 2000 * pulse}, sim::moves_by(2000));
        each("move_left_by", single, zlac8015d::move_left_by{-1500 * pulse}, sim::moves_by(-1500));
        each("move_to", absolute, move_to{2000 * pulse, 2000 * pulse}, sim::moves_to(2000));
        each("ramps", disable{}, zlac8015d::ramps{200 * millisecond, 200 * millisecond},
             sim::changes_nothing());
        each("clear_position", disable{}, zlac8015d::clear_position{}, sim::changes_nothing());
        each("watchdog", disable{}, zlac8015d::watchdog{2'000 * millisecond}, sim::changes_nothing());
        each("save", disable{}, zlac8015d::save{}, sim::changes_nothing());
    }
};

/// `Machine` is the simulated drive of one of the two variants, `Drive` its facade, `Homing` its command.
template <class Machine, template <class> class Drive, class Homing,
          class Interpretations = default_interpretation<sim::yako_options>>
struct axis : seen::stepper {
    using homing = Homing;
    using machine = Machine;
    template <class Line> using drive = Drive<Line>;

    static constexpr std::uint8_t address = 1;
    static constexpr std::uint32_t baud = 115200;
    static constexpr unsigned interpretations = Interpretations::count;
    static constexpr std::int64_t tolerance = 4;
    static constexpr bool energises_by_reset = true;
    static constexpr bool energises_by_level = false;
    // In thousandths of a turn, which are pulses by the factory's resolution.
    static constexpr std::int64_t home = 6'000;

    static sim::what_shows shows(unsigned interpretation) {
        const sim::yako_options read = Interpretations::options(interpretation);
        const bool is_hidden = read.kept == sim::yako_kept::written;
        return {.restart = is_hidden ? sim::restart_shows::never : sim::restart_shows::always,
                .every_stop = read.stops_homing};
    }
    static bool can_be_done(unsigned, const char*) { return true; }

    static machine make(unsigned interpretation) { return machine{Interpretations::options(interpretation)}; }
    template <class D> static bool take_over(D& d, machine& m) {
        m.attach({.home_from = home, .home_to = 2 * home});
        write_by_hand(m, 0x0044, static_cast<std::uint16_t>(yako::input_function::stop));
        return d.run(init{}) && d.run(yako::set_homing_profile{120 * r_per_min, 30 * r_per_min});
    }
    static void write_by_another(machine& m) { write_by_hand(m, 0x0021, 300); }

    template <class Each> static void commands(const Each& each) {
        const yako::motion_profile brisk{10 * r_per_min, 50 * millisecond, 50 * millisecond, 600 * r_per_min};
        each("velocity", enable{}, velocity{60 * r_per_min}, sim::turns());
        each("move_by", enable{}, move_by{3000 * pulse, brisk}, sim::moves_by(3000));
        each("bounded_jog", enable{}, yako::bounded_jog{-2000 * pulse, brisk}, sim::moves_by(-2000));
        const yako::held_velocity down{-60 * r_per_min, milliseconds(50), yako::time{100}, yako::time{100}};
        each("hold", enable{}, down, sim::moves_by(yako::reach(down, {.microsteps = 1000}).count()));
        each("home", enable{}, homing{yako::homing::home_24}, sim::homes_at(home));
        each("set_profile", enable{}, yako::set_profile{brisk}, sim::changes_nothing());
        each("declare_position", enable{}, declare_position{500 * pulse}, sim::hides_a_restart());
        each("clear_position", disable{}, yako::clear_position{}, sim::changes_nothing());
        // The marker is not saved, and so is written anew.
        each("save", disable{}, yako::save{}, sim::hides_a_restart());
    }
};
template <class Interpretations = default_interpretation<sim::yako_options>>
using closed_axis =
    axis<sim::yako_closed_loop, yako::closed_loop::drive, yako::closed_loop::home, Interpretations>;
template <class Interpretations = default_interpretation<sim::yako_options>>
using open_axis = axis<sim::yako_open_loop, yako::open_loop::drive, yako::open_loop::home, Interpretations>;

template <class Interpretations = default_interpretation<sim::c630s_options>> struct servo : seen::servo {
    struct machine : sim::c630s {
        explicit machine(const sim::c630s_options& read) : sim::c630s{read}, read_as{read} {}
        sim::c630s_options read_as;
    };
    template <class Line> using drive = c630s::drive<Line>;

    static constexpr std::uint8_t address = 1;
    static constexpr std::uint32_t baud = 57600;
    static constexpr unsigned interpretations = Interpretations::count;
    static constexpr std::int64_t tolerance = 20;
    static constexpr bool energises_by_reset = false;
    static constexpr bool energises_by_level = true;
    /// A stop reads the marker and sets it again (promise G35).
    static sim::what_shows shows(unsigned) { return {.restart_in_a_change = false}; }
    /// Erratum C77: the brake's output confirms an enable. Errata C23, C83: a start may be acknowledged and not move.
    static bool can_be_done(unsigned interpretation, std::string_view command) {
        const sim::c630s_options read = Interpretations::options(interpretation);
        if (command == "jog") return !read.jog_follows_command;
        if (command == "start_segment" || command == "a second move") return !read.segment_start_is_level;
        const bool is_wired = read.brake == sim::c630s_brake::wired_only && !read.first_output_shows;
        return command != "enable" || read.brake == sim::c630s_brake::follows_servo || is_wired;
    }

    static machine make(unsigned interpretation) { return machine{Interpretations::options(interpretation)}; }
    template <class Drive> static bool take_over(Drive& d, machine& m) {
        using c630s::keep, c630s::output_function;
        if (!d.run(init{}) || !d.run(c630s::set_up{})) return false;
        if (m.read_as.first_output_shows && !(d.run(keep<c630s::do1_function>{output_function::none}) &&
                                              d.run(keep<c630s::do2_function>{output_function::none}) &&
                                              d.run(keep<c630s::do3_function>{output_function::none}) &&
                                              d.run(keep<c630s::do4_function>{output_function::none}) &&
                                              d.run(keep<c630s::do5_function>{output_function::none})))
            return false;
        if (m.read_as.brake == sim::c630s_brake::wired_only &&
            !d.run(keep<c630s::do2_function>{output_function::brake}))
            return false;
        m.attach({.home_from = 15 * 131'072,
                  .home_to = 16 * 131'072,
                  .negative_limit = -9'000'000,
                  .positive_limit = 9'000'000});
        m.power_cycle();
        if (!d.run(init{})) return false;
        if (d.state() == drive_state::faulted && !d.run(fault_reset{})) return false; // a restart may keep it
        return d.state() == drive_state::disabled &&
               d.run(c630s::homing_by{c630s::homing_mode::forward_home_switch, 300 * r_per_min,
                                      60 * r_per_min, 100 * millisecond, 30'000}) &&
               d.run(c630s::segment{1, 3000 * c630s::reference_unit, 300 * r_per_min});
    }
    static void write_by_another(machine& m) { write_by_hand(m, 0x0605, 700); }

    template <class Each> static void commands(const Each& each) {
        using c630s::control_mode, c630s::enable_in, c630s::torque_share;
        const enable_in positions{control_mode::position};
        const enable_in torque{control_mode::torque};
        each("velocity", enable{}, velocity{60 * r_per_min}, sim::turns());
        each("hold", enable{}, hold{60 * r_per_min, c630s::runs_on_without_line{}}, sim::turns());
        each("jog", enable{}, c630s::jog{-60 * r_per_min}, sim::turns());
        each("torque", torque, c630s::torque{10 * percent}, sim::turns());
        each("start_segment", positions, c630s::start_segment{1}, sim::moves_by(3000));
        each("home", positions, c630s::home{30 * second}, sim::homes_at(150'000));
        each("ramps", disable{}, c630s::ramps{200 * millisecond, 200 * millisecond}, sim::changes_nothing());
        each("set_home", disable{}, c630s::set_home{}, sim::changes_nothing());
    }
};

} // namespace subjects
