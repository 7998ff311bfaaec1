// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Simulated YAKOTEC Modbus steppers, closed loop and open loop, for tests: the registers of each variant and
// the behaviour that a controlling program observes, under a virtual clock. Each is a register store for
// `modbus::server`: call `advance(now)` before each received byte and before each poll for the response. A
// `station` of sim/station.hpp does so on a virtual line.
//
//     servobus::sim::yako_closed_loop drive;
//     servobus::sim::station station{drive};
//     servobus::sim::virtual_line wire{drive.baud()};
//     wire.attach(station);
//
// From the manual V2.6.0: registers, ranges, defaults, exceptions, commands, homing steps, terminals,
// segments. Where the manual is silent, the model does one of the things that a drive may do, usually the
// worst for a careless program. These are assumptions, not facts about the drive. Square brackets name the
// switches of `yako_options` for what the facade depends on; where there is no switch they give the reason:
//
//  1  Exceptions are checked in this order: function, more than 16 registers read, addresses, access, values.
//     A request whose quantity and byte count do not agree is exception 5. A write is limited only by the
//     length of its frame. [answers_bad_crc; the facade sends no other wrong request]
//  2  A start that does not fit the state (released, in alarm, moving without bit 3, a stop input active) is
//     acknowledged and ignored. 0027h and 002Dh read back as 0. Of several bits in 0027h one is carried out,
//     the first of: emergency stop, stop, position, speed, homing. A code of 002Dh without a meaning is
//     ignored. [refuses_unfit, commands_read_back; the facade sends one bit of 0027h, apart from bits 2 and
//     3, and the printed codes of 002Dh]
//  3  An accepted start becomes a motion, and sets its status bit, `options::start_delay` later. Until then
//     the status is that of standstill, "in position" included, and further starts are ignored. [start_delay,
//     in_position]
//  4  The parameters of a motion are read when it is commanded. Values that are written afterwards apply to
//     the next motion. [none: section 4.6 states it of the deceleration time, and 4.1 starts with "the given
//     parameters"]
//  5  001Ah rescales every r/min register, 000Ch among them: the raw words and their ranges stay, so that
//     values that were written before change their meaning. [rescales_feedback_only]
//  6  The acceleration time leads from 0 to the speed, the deceleration time from the speed to 0. Only
//     position moves begin and end with a start speed. A speed segment begins at 0, whatever 0130h says.
//     [ramps_to_1000_r_per_min; start speeds do not change where a move ends]
//  7  A relative move counts from the position at its beginning, also when it interrupts another move. Bit 3
//     also interrupts a jog, a homing and a stop. 0010h and 0011h take effect at standstill; 000Ah keeps its
//     value. [interrupts_from_target; section 4.1 states bit 3 for positioning, and the facade refuses it for
//     all else; it writes neither 0010h nor 0011h]
//  8  "In position" means that an enabled motor has been at rest for 010Ch (in ms), near the commanded
//     position: also after a stop that ended a move early. [in_position]
//  9  With 0017h = 0 an overrun of a limit, switch or software limit, releases the motor: it coasts, and must
//     be enabled again. With 0017h = 1 it stops immediately. A start towards an active limit ends the same
//     way. [none: bit 4 is read and shows whether it is enabled afterwards; a coast between two reads is not
//     seen, nor is one by an input]
// 10  Software limits are inclusive and checked only while homed; their defaults of 0 forbid every motion.
//     Clearing the position (0031h) moves them, and the homed bit stays. A release does not clear the homed
//     bit. [homed; section 5.3 states that limits need a homing]
// 11  Home is the first pulse beyond the edge; the motor stops there without a ramp. The offset move runs
//     with 0032h. Methods 33 and 34 run at 0033h. The homed bit is cleared when homing begins and set after
//     the offset move. [homed, is_homed_before_offset; the facade waits for standstill and does not use the
//     speeds of homing]
// 12  Methods -1 and -3 run backward against the hard stop, -2 and -4 forward, with 0032h; -1 and -2 go back
//     to the first index pulse. The hard stop is detected once the following error exceeds 003Bh. [none:
//     these methods must be named explicitly, and nothing depends on their direction]
// 13  A following error above 010Ah, in pulses, is alarm 4. An alarm releases the motor. Clearing it (0021h)
//     has an effect only after its cause has ended, and does not enable. [alarm; the facade gives no error
//     code a meaning, and reads back whether the alarm is cleared]
// 14  An open loop counts what it commands: a shaft that is blocked, pushed or coasting loses steps without
//     notice. [none: stated of 000Ah]
// 15  An input with a level function starts one motion each time it becomes active, as soon as the state
//     allows. A PT trigger is ignored if its PIN inputs changed within 5 ms. After the MF input is inactive,
//     the motor has power again if it was enabled. A position input interrupts speed motions, as section 5.4
//     states; so does a PT trigger with 0051h = 1. Function 18 inverts the sign of a speed segment. [none:
//     levels, edges and 5 ms are stated, and 0007h shows what an input has started or released]
// 16  0008h and 0009h show what is active, after polarity. Output functions 9, 10, 11 show bits 0, 1, 2 of
//     004Fh. [none: the facade passes them on and decides nothing by them]
// 17  Saving keeps every register that can be written, RW and RW/S. 0041h restores all, in the EEPROM too.
//     Address and baud rate take effect at the next power cycle, the word order immediately. After power-on a
//     drive is at position 0 and not homed. [kept, saves_while_moving, restores_eeprom, restart_keeps_place,
//     restart_keeps_homed, is_enabled_at_power_on, moves_address_immediately; "after power is switched on
//     again" is printed at 0014h and 0015h alone, so 0019h and 001Ah act immediately]
// 18  Filters, currents, controller gains and the parity of 0015h have no effect. A register without a
//     default reads 0. [none: the facade writes none of them but 0015h, which takes effect at the next
//     power-on]
// 19  Bits 8 and 9 of 0027h end a homing as they end other motions. [stops_homing]
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/sim/yako/detail/core.hpp>

namespace servobus::sim {

/// The state of the motor, with a finer resolution than that of the registers.
struct yako_view {
    std::int64_t position = 0;  ///< pulses, as 000Ah, but not truncated to 32 bits
    std::int64_t speed = 0;     ///< 10^-6 r/min
    std::int64_t commanded = 0; ///< pulses from construction, positive as 0010h = 0 turns
    std::int64_t shaft = 0;     ///< the position of the shaft, counted as `commanded`
    std::int64_t home = 0;      ///< where the last homing found home, counted as `commanded`
    int home_direction = 0;     ///< 1 or -1: the motor's direction there, in the program's sense
    bool is_moving = false;
    bool is_homed = false;
};

/// A simulated drive of either variant. A `modbus::register_store`.
class yako_drive : private detail::yako_core {
    using core = detail::yako_core;

  public:
    using options = yako_options;
    using function = servobus::yako::input_function;
    using auxiliary = servobus::yako::auxiliary;
    using output_function = servobus::yako::output_function;

    // The register store

    /// Reads words. Returns 0, or exception 3, 4 or 5.
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        const std::uint8_t refusal = memory_.refuse_read(address, to.size());
        if (refusal != 0) return refusal;
        refresh();
        for (std::size_t i = 0; i < to.size(); ++i)
            to[i] = memory_.word_on_line(static_cast<std::uint16_t>(address + i));
        return 0;
    }

    /// Writes words in ascending order, all or none. Returns 0, or exception 3, 4, 6 or 7. A single word of a
    /// 32-bit value is accepted.
    constexpr std::uint8_t write(std::uint16_t address, words_view from) {
        const std::uint8_t refusal = memory_.refuse_write(address, from);
        if (refusal != 0) return refusal;
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (is_refused(static_cast<std::uint16_t>(address + i), from[i]))
                return detail::yako_memory::wrong_value;
        }
        for (std::size_t i = 0; i < from.size(); ++i)
            accept(static_cast<std::uint16_t>(address + i), from[i]);
        stir();
        adopt_settings();
        return 0;
    }

    /// The rules of its responses, for its server: limits and exception codes.
    constexpr modbus::server_rules rules() const {
        return {.max_read = 16,
                .illegal_function = 2,
                .illegal_address = 4,
                .illegal_value = 5,
                .bad_crc = options_.answers_bad_crc ? std::uint8_t{1} : std::uint8_t{0}};
    }

    // Time

    /// Advances the drive to `now` in ticks of 250 us. The first call sets the clock; so does a `now` that
    /// went back.
    constexpr void advance(instant now) {
        constexpr duration step = detail::wheel::tick;
        if (!has_clock_ || went_back(ticked_, now)) ticked_ = now;
        has_clock_ = true;
        for (; since(ticked_, now) >= step; ticked_ = ticked_ + step) {
            if (is_at_rest()) {
                const std::uint32_t idle = since(ticked_, now).us / step.us * step.us;
                rest(idle);
                ticked_ = ticked_ + duration{idle};
                return;
            }
            tick();
        }
    }

    // What a test or a simulated machine does to it

    /// Switches the power off and on: the registers get the saved values.
    constexpr void power_cycle() {
        memory_.power_on();
        switch_on();
    }
    /// Sets the switches SW1..SW7; the address changes with the next power cycle.
    constexpr void set_switches(std::uint8_t bits) { options_.switches = bits & 0x7F; }

    /// Raises an alarm, code 1..5; its cause lasts until `end_alarm`.
    constexpr void raise_alarm(std::uint16_t code) {
        cause_ = code;
        trip(code);
        stir();
    }
    /// Ends the alarm's cause; the alarm stays until it is cleared.
    constexpr void end_alarm() { cause_ = 0; }

    /// Sets the electrical level at a terminal, 0 for X0. No effect on a terminal that is wired to a switch
    /// of the machine.
    constexpr void set_input(unsigned input, bool level) {
        terminals_.set(input, level);
        stir();
    }
    /// Connects a machine to the shaft; its positions count from the shaft's position at construction.
    constexpr void attach(const yako_machine& machine) {
        axis_.attach(machine);
        stir();
    }
    /// Blocks the shaft or releases it. Closed loop then has a following error, open loop loses steps.
    constexpr void block_shaft(bool is_blocked) {
        axis_.block(is_blocked);
        stir();
    }
    /// Turns the shaft by external force, by a number of pulses in the direction of 0010h = 0. An enabled
    /// closed loop turns it back.
    constexpr void push_shaft(std::int64_t pulses) {
        axis_.push(pulses);
        stir();
    }

    // What a test reads

    constexpr yako_view view() const {
        return {axis_.position(), axis_.speed(), axis_.commanded(), axis_.shaft(), home_,
                home_direction_,  is_moving(),   is_homed_};
    }
    constexpr bool enabled() const { return !is_released(); }
    constexpr std::uint16_t alarm() const { return alarm_; }
    /// The electrical level of an output, 0 for Y0.
    constexpr bool output(unsigned output) const {
        const unsigned levels = outputs() ^ word_at(detail::yako_rows::output_polarity.address);
        return output < of_.outputs && (levels >> output & 1u) != 0;
    }
    /// Starts that were not ignored, by command or input.
    constexpr std::uint32_t starts() const { return starts_; }
    constexpr std::uint32_t writes_to(std::uint16_t address) const { return memory_.writes_to(address); }
    /// The total number of words written.
    constexpr std::uint32_t writes() const { return memory_.writes(); }
    /// The `back`-th last word written, 0 for the latest; the last 64 are kept.
    constexpr logged_write last_write(std::size_t back = 0) const { return memory_.write(back); }
    /// Registers written to the EEPROM since construction.
    constexpr std::uint32_t eeprom_writes() const { return memory_.eeprom_writes(); }
    /// Saves that were carried out.
    constexpr std::uint32_t saves() const { return memory_.saves(); }
    /// A register's word as a read returns it, without a request; 0 for an address that does not exist.
    constexpr std::uint16_t peek(std::uint16_t address) {
        refresh();
        return memory_.covers(address) ? memory_.word_on_line(address) : std::uint16_t{0};
    }

    /// Address and baud rate in effect since the last power-on.
    constexpr std::uint8_t address() const { return address_; }
    constexpr std::uint32_t baud() const { return baud_; }

  protected:
    constexpr yako_drive(const detail::yako_variant& of, options chosen) : core{of, chosen} {
        memory_.make_new();
        switch_on();
    }

  private:
    constexpr void switch_on() {
        constexpr std::array<std::uint32_t, 4> bauds{115200, 38400, 19200, 9600};
        take_address();
        baud_ = bauds[word_at(servobus::yako::rs485_baud_rate.address)];
        now_ = next_ = {};
        is_homed_ = is_homed_ && options_.restart_keeps_homed;
        has_positioned_ = has_reached_ = was_enabled_ = false;
        is_released_ = !options_.is_enabled_at_power_on;
        alarm_ = 0;
        wait_us_ = segment_wait_us_ = still_us_ = 0;
        spent_ = quiet_ticks_ = 0;
        adopt_settings();
        axis_.switch_on(options_.restart_keeps_place);
        terminals_.forget_edges();
        if (cause_ != 0) trip(cause_);
    }

    constexpr void take_address() {
        const unsigned set = options_.switches & 0x1Fu;
        address_ = static_cast<std::uint8_t>(set != 0 ? set : word_at(servobus::yako::node_address.address));
    }

    constexpr void accept(std::uint16_t address, std::uint16_t word) {
        namespace rows = servobus::yako;
        memory_.note(address, word);
        const bool is_command =
            address == rows::motion_command.address || address == rows::auxiliary_command.address;
        if (!is_command || options_.commands_read_back) memory_.set_word_on_line(address, word);
        if (address == rows::motion_command.address) return command(word);
        if (address == rows::auxiliary_command.address) return help(static_cast<auxiliary>(word));
        if (address == rows::node_address.address && options_.moves_address_immediately) take_address();
    }

    // True if a command is answered by an exception instead of an acknowledgement.
    constexpr bool is_refused(std::uint16_t address, std::uint16_t word) const {
        if (!options_.refuses_unfit) return false;
        if (address == servobus::yako::motion_command.address) {
            const auto wanted = servobus::yako::motion_code::from_word(word);
            return wanted.is_start() && !can_start((word & servobus::yako::motion_code::interrupt_bit) != 0);
        }
        if (address != servobus::yako::auxiliary_command.address) return false;
        const auto wanted = static_cast<auxiliary>(word);
        const bool is_unfit_while_moving =
            wanted == auxiliary::restore_parameters ||
            (wanted == auxiliary::save_parameters && !options_.saves_while_moving);
        return (is_unfit_while_moving && is_moving()) || (wanted == auxiliary::enable && has_alarm());
    }

    constexpr void help(auxiliary wanted) {
        switch (wanted) {
        case auxiliary::none: return;
        case auxiliary::release: return release();
        case auxiliary::enable: return enable();
        case auxiliary::clear_alarm: return clear_alarm();
        case auxiliary::clear_position: axis_.set_position(0); return lose_place();
        case auxiliary::restore_parameters:
            if (!is_moving()) memory_.restore(options_.restores_eeprom);
            return;
        case auxiliary::save_parameters:
            if (!is_moving() || options_.saves_while_moving) memory_.save();
            return;
        }
    }

    // Read-only registers

    constexpr std::uint16_t status() const {
        using bits = servobus::yako::motion_status;
        const auto bit_if = [](bool is_set, unsigned mask) { return is_set ? mask : 0u; };
        return static_cast<std::uint16_t>(
            bit_if(is_in_position(), bits::in_position_bit) | bit_if(is_homed_, bits::homed_bit) |
            bit_if(is_moving(), bits::moving_bit) | bit_if(has_alarm(), bits::alarm_bit) |
            bit_if(is_released(), bits::released_bit) |
            bit_if(software_limit() > 0, bits::positive_limit_bit) |
            bit_if(software_limit() < 0, bits::negative_limit_bit));
    }

    constexpr bool is_output_active(output_function f) const {
        const unsigned chosen = word_at(detail::yako_rows::user_outputs.address);
        switch (f) {
        case output_function::alarm: return has_alarm();
        case output_function::driver_status: return is_moving();
        case output_function::homing_complete: return is_homed_;
        case output_function::in_position: return is_in_position();
        case output_function::brake: return !is_released();
        case output_function::user_0: return (chosen & 1u) != 0;
        case output_function::user_1: return (chosen & 2u) != 0;
        case output_function::user_2: return (chosen & 4u) != 0;
        default: return false;
        }
    }
    constexpr unsigned outputs() const {
        unsigned active = 0;
        for (unsigned i = 0; i < of_.outputs; ++i) {
            const auto row = static_cast<std::uint16_t>(servobus::yako::y0_function.address + i);
            if (is_output_active(static_cast<output_function>(word_at(row)))) active |= 1u << i;
        }
        return active;
    }

    constexpr void refresh() {
        namespace rows = detail::yako_rows;
        const std::int64_t count = commands_.feedback_count();
        const std::int64_t turning = axis_.speed();
        const std::int64_t rounded = (turning < 0 ? turning - count / 2 : turning + count / 2) / count;
        memory_.set(rows::drive_model.address, of_.has_encoder ? 257 : 2505);
        memory_.set(rows::drive_version.address, 260);
        memory_.set(rows::actual_node_address.address, address_);
        memory_.set(rows::dip_switches.address, options_.switches);
        memory_.set(rows::error_code.address, alarm_);
        memory_.set(rows::status_word.address, status());
        memory_.set(rows::input_state.address, terminals_.active());
        memory_.set(rows::output_state.address, static_cast<std::uint16_t>(outputs()));
        memory_.set_pair(rows::actual_position.address, low_bits(axis_.position()));
        memory_.set(rows::actual_speed.address,
                    static_cast<std::uint16_t>(static_cast<std::uint64_t>(rounded)));
    }
    static constexpr std::int32_t low_bits(std::int64_t v) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(v)));
    }

    instant ticked_{};
    std::uint32_t baud_ = 0;
    std::uint8_t address_ = 0;
    bool has_clock_ = false;
};

/// A simulated closed-loop drive: ESS242-, ESS257-, ESS286-Rx1.
class yako_closed_loop : public yako_drive {
  public:
    constexpr explicit yako_closed_loop(options chosen = options{})
        : yako_drive{detail::yako_closed_loop_variant, chosen} {}
};

/// A simulated open-loop drive: ESD2205PR, ESD2505PR, YKE2405PR, YKE2608PR.
class yako_open_loop : public yako_drive {
  public:
    constexpr explicit yako_open_loop(options chosen = options{})
        : yako_drive{detail::yako_open_loop_variant, chosen} {}
};

} // namespace servobus::sim
