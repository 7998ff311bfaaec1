// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interpretations of the manuals that the drives of a run follow, drawn from the seed: a table of the switches
// of each simulated drive. A new member of a drive's options, or a new enumerator, must be added here, or
// this file does not compile.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/sim/c630s/options.hpp>
#include <servobus/sim/faults.hpp>
#include <servobus/sim/yako/options.hpp>
#include <servobus/sim/zlac8015d/options.hpp>

#include "drive_kind.hpp"

namespace trial {

// The names of the positions of each switch. There is no `default`, so the compiler warns of a missing
// enumerator.

constexpr const char* position(servobus::sim::zlac8015d_options::kept p) {
    using enum servobus::sim::zlac8015d_options::kept;
    switch (p) {
    case marked: return "RW/S";
    case all: return "RW";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::zero p) {
    using enum servobus::sim::zlac8015d_options::zero;
    switch (p) {
    case off: return "off";
    case stops: return "stops";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::shaft p) {
    using enum servobus::sim::zlac8015d_options::shaft;
    switch (p) {
    case locked: return "locked";
    case released: return "released";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::stopped p) {
    using enum servobus::sim::zlac8015d_options::stopped;
    switch (p) {
    case emergency: return "emergency";
    case locked: return "locked";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::idle p) {
    using enum servobus::sim::zlac8015d_options::idle;
    switch (p) {
    case released: return "released";
    case emergency: return "emergency";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::start p) {
    using enum servobus::sim::zlac8015d_options::start;
    switch (p) {
    case any: return "any";
    case by_200F: return "by 200Fh";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::ramp p) {
    using enum servobus::sim::zlac8015d_options::ramp;
    switch (p) {
    case linear: return "linear";
    case begins_anew: return "begins anew";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::running p) {
    using enum servobus::sim::zlac8015d_options::running;
    switch (p) {
    case turns: return "turns";
    case driven: return "driven";
    case enabled: return "enabled";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::fault_code p) {
    using enum servobus::sim::zlac8015d_options::fault_code;
    switch (p) {
    case until_reset: return "until reset";
    case until_restart: return "until restart";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::switched_off p) {
    using enum servobus::sim::zlac8015d_options::switched_off;
    switch (p) {
    case both_wheels: return "both wheels";
    case its_wheel: return "its wheel";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::zlac8015d_options::brake p) {
    using enum servobus::sim::zlac8015d_options::brake;
    switch (p) {
    case engages: return "engages";
    case releases: return "releases";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::yako_kept p) {
    using enum servobus::sim::yako_kept;
    switch (p) {
    case saved: return "saved";
    case marked: return "marked";
    case line_settings: return "line settings";
    case written: return "written";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::yako_in_position p) {
    using enum servobus::sim::yako_in_position;
    switch (p) {
    case at_rest: return "at rest";
    case until_commanded: return "until commanded";
    case after_first_move: return "after first move";
    case at_target: return "at target";
    case until_next_move: return "until next move";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::yako_homed p) {
    using enum servobus::sim::yako_homed;
    switch (p) {
    case until_homing: return "until homing";
    case until_place_lost: return "until place lost";
    case always: return "always";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::yako_alarm p) {
    using enum servobus::sim::yako_alarm;
    switch (p) {
    case releases: return "releases";
    case clearing_enables: return "clearing enables";
    case holds: return "holds";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::c630s_restart p) {
    using enum servobus::sim::c630s_restart;
    switch (p) {
    case parameters: return "parameters";
    case levels: return "levels";
    case homing_command: return "homing command";
    case alarms_and_position: return "alarms and position";
    case everything: return "everything";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::c630s_brake p) {
    using enum servobus::sim::c630s_brake;
    switch (p) {
    case follows_servo: return "follows servo";
    case wired_only: return "wired only";
    case always_released: return "always released";
    }
    return nullptr;
}
constexpr const char* position(servobus::sim::c630s_bus_stop p) {
    using enum servobus::sim::c630s_bus_stop;
    switch (p) {
    case lasts: return "lasts";
    case resets: return "resets";
    case frees_shaft: return "frees shaft";
    }
    return nullptr;
}

/// One switch: a member of `Options`. Position 0 is the default.
template <class Options> struct drive_switch {
    const char* name;
    unsigned positions; ///< 1: the switch is never changed
    const char* (*text)(unsigned position);
    void (*set)(Options&, unsigned position);
    unsigned (*position)(const Options&);
};

namespace detail {

template <class Options, class Value> Value value_type_of(Value Options::*);
template <class Options, class Value> Options options_type_of(Value Options::*);
template <auto Member> using value_of = decltype(value_type_of(Member));
template <auto Member> using options_of = decltype(options_type_of(Member));

/// A switch of two or more interpretations.
template <auto Member> constexpr drive_switch<options_of<Member>> row(const char* name) {
    using options = options_of<Member>;
    using value = value_of<Member>;
    drive_switch<options> r{};
    r.name = name;
    if constexpr (std::is_same_v<value, bool>) {
        r.positions = 2;
        r.text = [](unsigned p) { return (p != 0) != (options{}.*Member) ? "true" : "false"; };
        r.set = [](options& of, unsigned p) { of.*Member = (p != 0) != (options{}.*Member); };
        r.position = [](const options& of) { return of.*Member == options{}.*Member ? 0u : 1u; };
    } else {
        static_assert(std::is_enum_v<value> && options{}.*Member == value{});
        r.text = [](unsigned p) { return trial::position(static_cast<value>(p)); };
        while (r.text(r.positions) != nullptr) ++r.positions;
        r.set = [](options& of, unsigned p) { of.*Member = static_cast<value>(p); };
        r.position = [](const options& of) { return static_cast<unsigned>(of.*Member); };
    }
    return r;
}
template <unsigned... Numbers> inline constexpr unsigned listed[sizeof...(Numbers)] = {Numbers...};
/// A time that no manual states, drawn from some numbers of milliseconds.
template <auto Member, unsigned... Milliseconds>
constexpr drive_switch<options_of<Member>> times(const char* name, const char* (*text)(unsigned)) {
    using options = options_of<Member>;
    drive_switch<options> r{};
    static_assert(options{}.*Member == servobus::milliseconds(listed<Milliseconds...>[0]));
    r.name = name;
    r.positions = sizeof...(Milliseconds);
    r.text = text;
    r.set = [](options& of, unsigned p) { of.*Member = servobus::milliseconds(listed<Milliseconds...>[p]); };
    r.position = [](const options& of) {
        unsigned p = 0;
        while (of.*Member != servobus::milliseconds(listed<Milliseconds...>[p])) ++p;
        return p;
    };
    return r;
}
/// A setting of a drive that is no interpretation of a manual.
template <auto Member> constexpr drive_switch<options_of<Member>> fixed(const char* name) {
    using options = options_of<Member>;
    drive_switch<options> r{};
    r.name = name;
    r.positions = 1;
    r.text = [](unsigned) { return "as it is"; };
    r.set = [](options& of, unsigned) { of.*Member = options{}.*Member; };
    r.position = [](const options&) { return 0u; };
    return r;
}

struct anything {
    template <class T> constexpr operator T() const;
};
template <class Aggregate, class... Values> consteval std::size_t count_members() {
    if constexpr (requires { Aggregate{Values{}..., anything{}}; }) {
        return count_members<Aggregate, Values..., anything>();
    } else {
        return sizeof...(Values);
    }
}
/// Each member has a row, and each row changes a different member.
template <class Options, std::size_t Size>
consteval bool is_complete(const std::array<drive_switch<Options>, Size>& rows) {
    for (std::size_t i = 0; i < Size; ++i) {
        Options moved;
        rows[i].set(moved, rows[i].positions - 1);
        for (std::size_t j = 0; j < Size; ++j) {
            if (rows[j].position(moved) != (i == j ? rows[i].positions - 1 : 0)) return false;
        }
    }
    return Size == count_members<Options>();
}

} // namespace detail

/// The switches of a simulated drive, by the type of its options.
template <class Options> struct switches_of;

template <> struct switches_of<servobus::sim::zlac8015d_options> {
    using options = servobus::sim::zlac8015d_options;
    static constexpr drive_kind kind = drive_kind::zlac8015d;
    static constexpr std::array rows{
        detail::row<&options::resumes_after_watchdog>("resumes after watchdog"),
        detail::row<&options::save>("save keeps"),
        detail::row<&options::host_timeout>("2000h = 0"),
        detail::row<&options::while_turning>("shaft while turning"),
        detail::row<&options::in_torque_mode>("shaft in torque mode"),
        detail::row<&options::after_quick_stop>("shaft after quick stop"),
        detail::row<&options::bit>("running bit"),
        detail::row<&options::code>("fault code"),
        detail::row<&options::by_fault>("a fault switches off"),
        detail::row<&options::code_1>("brake code 1"),
        detail::row<&options::idle_shaft>("shaft without power"),
        detail::row<&options::shows_speed_of_moves>("shows speed of moves"),
        detail::row<&options::position_start>("position start"),
        detail::row<&options::enables_without_mode>("enables without mode"),
        detail::row<&options::speed_ramp>("speed ramp"),
        detail::row<&options::checks_option_codes>("checks option codes"),
        detail::row<&options::rescales_immediately>("rescales immediately"),
    };
};

template <> struct switches_of<servobus::sim::yako_options> {
    using options = servobus::sim::yako_options;
    static constexpr drive_kind kind = drive_kind::yako;
    static constexpr const char* delay(unsigned p) {
        constexpr const char* names[] = {"2 ms", "0 ms", "15 ms"};
        return names[p];
    }
    static constexpr std::array rows{
        detail::times<&options::start_delay, 2, 0, 15>("start delay", delay),
        detail::row<&options::is_enabled_at_power_on>("is enabled at power-on"),
        detail::row<&options::answers_bad_crc>("answers bad CRC"),
        detail::fixed<&options::switches>("switches"),
        detail::row<&options::kept>("kept"),
        detail::row<&options::restart_keeps_place>("restart keeps place"),
        detail::row<&options::restart_keeps_homed>("restart keeps homed"),
        detail::row<&options::in_position>("in position"),
        detail::row<&options::homed>("homed"),
        detail::row<&options::is_homed_before_offset>("is homed before offset"),
        detail::row<&options::alarm>("alarm"),
        detail::row<&options::refuses_unfit>("refuses unfit"),
        detail::row<&options::saves_while_moving>("saves while moving"),
        detail::row<&options::commands_read_back>("commands read back"),
        detail::row<&options::stops_homing>("stops homing"),
        detail::row<&options::interrupts_from_target>("interrupts from target"),
        detail::row<&options::ramps_to_1000_r_per_min>("ramps to 1000 r/min"),
        detail::row<&options::rescales_feedback_only>("rescales feedback only"),
        detail::row<&options::restores_eeprom>("restores EEPROM"),
        detail::row<&options::moves_address_immediately>("moves address immediately"),
    };
};

template <> struct switches_of<servobus::sim::c630s_options> {
    using options = servobus::sim::c630s_options;
    static constexpr drive_kind kind = drive_kind::c630s;
    static constexpr const char* window(unsigned p) {
        constexpr const char* names[] = {"10 s", "60 s"};
        return names[p];
    }
    static constexpr std::array rows{
        detail::times<&options::many_writes_within, 10'000, 60'000>("many writes within", window),
        detail::row<&options::stores_eeprom_off>("stores EEPROM off"),
        detail::row<&options::resets_while_enabled>("resets while enabled"),
        detail::row<&options::virtual_brake_delays>("virtual brake delays"),
        detail::row<&options::echoes_byte_count>("echoes byte count"),
        detail::row<&options::home_output_falls>("home output falls"),
        detail::row<&options::restart_keeps>("restart keeps"),
        detail::row<&options::software_reset_is_power_on>("software reset is power-on"),
        detail::row<&options::brake>("brake"),
        detail::row<&options::bus_stop>("bus stop"),
        detail::row<&options::commands_end>("commands end"),
        detail::row<&options::homing_command_ends>("homing command ends"),
        detail::row<&options::segment_start_is_level>("segment start is level"),
        detail::row<&options::jog_follows_command>("jog follows command"),
        detail::row<&options::shows_last_alarm>("shows last alarm"),
        detail::row<&options::bus_voltage_in_volts>("bus voltage in volts"),
        detail::row<&options::delay_is_additional>("delay is additional"),
        detail::row<&options::disabled_inputs_count>("disabled inputs count"),
        detail::row<&options::first_output_shows>("first output shows"),
        detail::row<&options::servo_on_waits_for_power_on>("servo-on waits for power-on"),
        detail::row<&options::gear_keeps_rest>("gear keeps rest"),
    };
};

static_assert(detail::is_complete(switches_of<servobus::sim::zlac8015d_options>::rows));
static_assert(detail::is_complete(switches_of<servobus::sim::yako_options>::rows));
static_assert(detail::is_complete(switches_of<servobus::sim::c630s_options>::rows));

/// The position of each switch of one drive, in the order of its table; 0 beyond the end of the table.
inline constexpr std::size_t most_switches = 21;
using switch_positions = std::array<std::uint8_t, most_switches>;

constexpr switch_positions positions_of() { return {}; }
template <class Options> constexpr switch_positions positions_of(const Options& chosen) {
    const auto& rows = switches_of<Options>::rows;
    static_assert(switches_of<Options>::rows.size() <= most_switches);
    switch_positions found{};
    for (std::size_t i = 0; i < rows.size(); ++i)
        found[i] = static_cast<std::uint8_t>(rows[i].position(chosen));
    return found;
}

/// The options that have these positions.
template <class Options> Options options_at(const switch_positions& at) {
    Options chosen;
    for (std::size_t i = 0; i < switches_of<Options>::rows.size(); ++i)
        switches_of<Options>::rows[i].set(chosen, at[i]);
    return chosen;
}

/// The interpretations of a run, drawn independently of its traffic. In half of the runs each drive has its
/// defaults; in the others each switch of each drive has a random position.
class interpretations {
  public:
    explicit interpretations(std::uint64_t seed)
        : random_{seed * 0xC2B2'AE35u + 17}, are_default_{random_.below(2) == 0} {}

    template <class Options> Options draw() {
        Options drawn;
        if (are_default_) return drawn;
        for (const auto& row : switches_of<Options>::rows) row.set(drawn, random_.below(row.positions));
        leave_out_unknowable(drawn);
        return drawn;
    }

  private:
    template <class Options> static void leave_out_unknowable(Options&) {}
    // A wheel that turns after a stop shows in no register then [B31].
    static void leave_out_unknowable(servobus::sim::zlac8015d_options& drawn) {
        if (drawn.bit != servobus::sim::zlac8015d_options::running::turns) drawn.shows_speed_of_moves = true;
    }
    servobus::sim::dice random_;
    bool are_default_;
};

/// How many transactions met each position of each switch.
class switch_count {
  public:
    void note(drive_kind k, const switch_positions& at) {
        auto& of_drive = met_[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < at.size(); ++i) ++of_drive[i][at[i]];
    }

    /// `say(drive, switch, position, count)` for each position that can be drawn.
    template <class Say> void each(const Say& say) const {
        each_of<servobus::sim::zlac8015d_options>(say);
        each_of<servobus::sim::yako_options>(say);
        each_of<servobus::sim::c630s_options>(say);
    }

  private:
    static constexpr std::size_t most_positions = 5;
    using met_by_drive = std::array<std::array<std::uint64_t, most_positions>, most_switches>;

    template <class Options, class Say> void each_of(const Say& say) const {
        constexpr drive_kind kind = switches_of<Options>::kind;
        const auto& rows = switches_of<Options>::rows;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (rows[i].positions == 1) continue;
            for (unsigned p = 0; p < rows[i].positions; ++p)
                say(kind, rows[i].name, rows[i].text(p), met_[static_cast<std::size_t>(kind)][i][p]);
        }
    }

    std::array<met_by_drive, static_cast<std::size_t>(drive_kind::count_)> met_{};
};

} // namespace trial
