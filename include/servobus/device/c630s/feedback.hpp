// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: what it reports, and the commands that read it: status and motion, positions of 64 bits,
// the fault history. c630s/drive.hpp includes it; programs get it from `read()` and `fault()` of a drive.
// Source: manual V24.111, sections 5.1.6 and 7.11; [errata Cn] are in device/errata_c630s.md.
//
//     const result<c630s::feedback> seen = servo.read();
//     if (seen && seen->alarm() != nullptr) std::puts(seen->alarm()->name);
//     const result<c630s::fault_entry> before = servo.fault(1); // the last one before the present
//     if (before && before->bus_voltage < 200 * volt) std::puts("the bus voltage was low");
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/alarms.hpp>
#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

/// What the drive reports, in several frames.
struct feedback {
    status_flags state{};          ///< nothing is set before the drive is set up
    reading<actual_speed> speed{}; ///< r/min
    reading<speed_command> commanded_speed{};
    reading<torque_command> torque{}; ///< 0.1 % of the rated torque
    inputs wired_inputs{};
    reading<absolute_position> position{};             ///< reference units
    reading<c630s::following_error> following_error{}; ///< reference units
    reading<fine_actual_speed> fine_speed{};           ///< 0.1 r/min
    u16 alarm_code = 0; ///< the present one, 0x101 for Er.101 [errata C17]; 0 if another record is chosen

    static constexpr std::size_t size = routines::record_place + 2u; ///< words

    constexpr bool has_fault() const { return state.has_fault(); }
    constexpr bool is_moving() const { return state.is_rotating(); }
    /// The output COIN: of a move the drive calls completed.
    constexpr bool is_in_position() const { return state.is_completed(); }
    /// The alarm by its name, null if there is none or the manual has none.
    constexpr const c630s::alarm* alarm() const { return find_alarm(alarm_code); }

    static constexpr feedback from_words(slice<const std::uint16_t> w, word_order order) {
        using namespace routines;
        using servobus::reading_of;
        const auto pair = [&](std::size_t i) { return join_words(w[i], w[i + 1], order); };
        feedback f;
        f.state = status_flags::from_word(w[status_place]);
        f.speed = reading_of<actual_speed>(w[speed_place]);
        f.commanded_speed = reading_of<speed_command>(w[speed_place + 1u]);
        f.torque = reading_of<torque_command>(w[speed_place + 2u]);
        f.wired_inputs = c630s::inputs::from_word(w[speed_place + 3u]);
        f.position = reading_of<absolute_position>(pair(position_place));
        f.following_error = reading_of<c630s::following_error>(pair(deviation_place));
        f.fine_speed = reading_of<fine_actual_speed>(pair(deviation_place + 2u));
        if (w[record_place] == detail::as_word(fault_record::current)) f.alarm_code = w[record_place + 1u];
        return f;
    }
};

/// Positions of 64 bits: encoder counts.
enum class wide_position : std::uint8_t {
    mechanical, ///< P0B-58, 60
    encoder,    ///< P0B-77, 79: the absolute encoder
    load,       ///< P0B-81, 83: a rotating load, within its turn
};

/// Reads both halves of a position in one frame.
struct read_wide_position {
    wide_position which;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const routine steps = which == wide_position::mechanical ? routine{routines::mechanical_position}
                              : which == wide_position::encoder  ? routine{routines::encoder_position}
                                                                 : routine{routines::load_position};
        return {.steps = steps,
                .arguments = {0, 0, 0, 0, 0, detail::word_order_value(cached)},
                .then = effect::position_read,
                .refusal = detail::needs_word_order(cached)};
    }
    /// The low 32 bits come first, each half in the drive's word order [errata C42].
    static constexpr std::int64_t from_words(slice<const std::uint16_t> w, word_order order) {
        const std::uint64_t low = join_words(w[0], w[1], order);
        const std::uint64_t high = join_words(w[2], w[3], order);
        return static_cast<std::int64_t>(high << 32 | low);
    }
};

/// A fault that the drive remembers, with what it saw at that moment.
struct fault_entry {
    u16 alarm_code = 0; ///< 0x101 for Er.101 [errata C17]; 0 presumably for none
    reading<recorded_time> time{};
    reading<recorded_speed> speed{};
    reading<recorded_u_current> u_current{};
    reading<recorded_v_current> v_current{};
    reading<recorded_bus_voltage> bus_voltage{};
    inputs wired_inputs{};
    outputs wired_outputs{};

    constexpr const c630s::alarm* alarm() const { return find_alarm(alarm_code); }

    static constexpr fault_entry from_words(slice<const std::uint16_t> w, word_order order) {
        using servobus::reading_of;
        fault_entry e;
        e.alarm_code = w[0];
        e.time = reading_of<recorded_time>(join_words(w[1], w[2], order));
        e.speed = reading_of<recorded_speed>(w[3]);
        e.u_current = reading_of<recorded_u_current>(w[4]);
        e.v_current = reading_of<recorded_v_current>(w[5]);
        e.bus_voltage = reading_of<recorded_bus_voltage>(w[6]);
        e.wired_inputs = c630s::inputs::from_word(w[7]);
        e.wired_outputs = c630s::outputs::from_word(w[8]);
        return e;
    }
};

/// Reads entry 0 (the present fault) to 9 of the fault history.
struct read_fault {
    unsigned entry;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_marked = cached.state == drive_state::needs_power_cycle;
        const fault_record after = is_marked ? fault_record::ninth_last : fault_record::current;
        return {.steps = routines::fault_history,
                .arguments = {detail::as_word(entry), detail::as_word(after), 0, 0, 0,
                              detail::word_order_value(cached)},
                .then = effect::record_read,
                .refusal = detail::first_error(detail::needs_word_order(cached),
                                               entry <= 9 ? errc::ok : errc::bad_argument)};
    }
};

} // namespace servobus::c630s
