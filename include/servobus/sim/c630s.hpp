// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated Coolmay C630S for tests: its 463 parameters and the behaviour that a controlling program
// observes, under a virtual clock. The model is a register store for `modbus::server`: call `advance(now)`
// before each received byte and before each poll for the response. A `station` of sim/station.hpp does so on
// a virtual line.
//
//     servobus::sim::c630s drive;
//     servobus::sim::station station{drive};
//     servobus::sim::virtual_line wire{drive.baud()};
//     wire.attach(station);
//
// From the manual V24.111: parameters, ranges, defaults, when they may be written and take effect, functions
// of the terminals, control modes, homing modes, alarms. sim/c630s/options.hpp lists what the model does
// where the manual is silent, with the switches for other interpretations.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/sim/c630s/detail/core.hpp>

namespace servobus::sim {

/// The simulated drive. A `modbus::register_store`.
class c630s : private detail::c630s_core {
    using core = detail::c630s_core;

  public:
    using options = c630s_options;
    using machine = c630s_machine;
    using record = c630s_record;
    using core::state;

    /// A new drive with factory settings, switched on, with all inputs open.
    constexpr c630s() : c630s{options{}} {}
    constexpr explicit c630s(options chosen) : core{chosen} {
        memory_.make_new();
        switch_on();
    }

    // The register store

    /// Reads words. Returns 0, or exception 2 if one of the addresses does not exist.
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        refresh();
        return answer(memory_.read(address, to));
    }

    /// Writes words in ascending order, all or none. Returns 0, or exception 2, 3 or 4.
    constexpr std::uint8_t write(std::uint16_t address, words_view from) {
        const std::uint8_t refusal = memory_.refuse_write(address, from, is_stopped_for(address));
        if (refusal != 0) return answer(refusal);
        is_idle_ = false;
        (void)memory_.each(address, from, [this](std::size_t n, u32 bits, std::size_t words) {
            accept(n, bits, words);
            return std::uint8_t{0};
        });
        apply_at_stop();
        if (restarts_) begin(!options_.software_reset_is_power_on);
        return answer(0);
    }

    // Time

    /// Advances the drive to `now` in steps of 1 ms. The first call sets the clock; so does a `now` that went
    /// back.
    constexpr void advance(instant now) {
        if (!has_clock_ || went_back(ticked_, now)) {
            has_clock_ = true;
            ticked_ = now;
        }
        constexpr duration tick_time = detail::c630s_shaft::tick;
        while (since(ticked_, now) >= tick_time) {
            if (is_idle_) {
                const std::uint32_t ticks = since(ticked_, now).us / tick_time.us;
                ms_ += ticks;
                ticked_ = ticked_ + tick_time * ticks;
                return;
            }
            tick();
            ticked_ = ticked_ + tick_time;
        }
    }

    // What a test or a simulated machine does to it

    /// Switches the power off and on: parameters are read from the EEPROM, changes that waited for power-on
    /// take effect, and alarms whose cause has ended are cleared. A turning motor continues to roll.
    constexpr void power_cycle() { begin(false); }

    /// Raises an alarm, 0x620 for Er.620. With `lasts` its cause stays until `end_causes`; the causes of
    /// Er.731, Er.733 and Er.735 stay until P0D-20 is written.
    constexpr void raise(std::uint16_t code, bool lasts = false) {
        if (lasts || code == 0x731 || code == 0x733 || code == 0x735) lasting_ |= bit_of(code);
        core::raise(code);
    }
    /// Ends the causes of raised alarms; the alarms stay until they are reset.
    constexpr void end_causes() { lasting_ &= bit_of(0x731) | bit_of(0x733) | bit_of(0x735); }

    /// Switches the current through DI `number`, 1..8. A terminal that conducts is low, which with logic 0 is
    /// active; otherwise it is high.
    constexpr void set_input(unsigned number, bool conducts) {
        inputs_.set_conduction(number, conducts, memory_);
        is_idle_ = false;
    }
    /// Connects a machine, which controls the inputs with the functions FunIN.31, 14 and 15.
    constexpr void attach(const machine& what) {
        machine_ = what;
        has_machine_ = true;
        is_idle_ = false;
        move_machine();
    }
    /// Blocks the shaft or releases it.
    constexpr void block_shaft(bool is_blocked) { motor_.block(is_blocked); }
    /// Sends pulses to the pulse input, in reference units. They count in position control with P05-00 = 0.
    constexpr void send_pulses(std::int32_t count) {
        if (state_ == state::on && control() == coolmay::control_mode::position &&
            memory_.get(coolmay::position_command_source) == coolmay::position_source::pulses)
            take_pulses(count);
    }
    /// The voltages at AI1 and AI2 in mV, -12000..12000.
    constexpr void set_analogue(std::int32_t ai1, std::int32_t ai2) {
        analogue_ = {ai1, ai2};
        is_idle_ = false;
    }
    /// In 0.1 V; 310 V after construction. Below 200 V is Er.410, above 420 V Er.400.
    constexpr void set_bus_voltage(std::uint16_t tenths) {
        bus_voltage_ = tenths;
        is_idle_ = false;
    }
    /// In degC.
    constexpr void set_module_temperature(std::int16_t degrees) { temperature_ = degrees; }

    // What a test reads

    constexpr bool enabled() const { return state_ == state::on; }
    constexpr state current_state() const { return state_; }
    constexpr bool stands_still() const { return motor_.stands(); }
    /// The motor's position in encoder counts from where it was at construction; neither homing nor a power
    /// cycle changes it.
    constexpr std::int64_t position() const { return motor_.position(); }
    /// In 10^-6 r/min.
    constexpr std::int64_t speed() const { return motor_.speed(); }
    /// In 0.1 % of the rated torque.
    constexpr std::int64_t torque() const { return motor_.torque(); }
    using core::is_homing;
    using core::is_positioning;
    /// Position commands that were started: steps, and starts of segments.
    constexpr std::uint32_t starts() const { return starts_; }
    /// Homings that were started.
    using core::homings;
    /// How often S-ON enabled the drive.
    constexpr std::uint32_t enables() const { return enables_; }
    constexpr bool is_active(coolmay::output_function f) const { return is_out(f); }
    constexpr bool is_active(coolmay::input_function f) const { return given(f); }
    /// True if DO `number`, 1..6, conducts.
    constexpr bool output(unsigned number) const {
        return number >= 1 && number <= 6 && (outputs() >> (number - 1) & 1) != 0;
    }
    constexpr bool has_fault() const { return alarms_.has_fault(); }
    constexpr bool has_warning() const { return alarms_.has_warning(); }
    constexpr bool has_alarm(std::uint16_t code) const { return alarms_.is_present(code); }
    /// The newest fault that is present, else the newest warning; 0 for none.
    constexpr std::uint16_t alarm() const { return alarms_.current(); }
    /// Registers written to the EEPROM since construction.
    constexpr std::uint32_t eeprom_writes() const { return memory_.eeprom_writes(); }
    /// A parameter's value in the EEPROM; 0 for an address that does not exist.
    constexpr std::int64_t stored(std::uint16_t address) const {
        return covers(address) ? memory_.stored(address) : 0;
    }
    /// A parameter as a read returns it, without a request; 0 for an address that does not exist.
    constexpr std::int64_t peek(std::uint16_t address) {
        refresh();
        return covers(address) ? memory_.shown(address) : 0;
    }
    /// A parameter's value that is in effect; 0 for an address that does not exist.
    constexpr std::int64_t in_force(std::uint16_t address) const {
        return covers(address) ? memory_[address] : 0;
    }
    /// The total number of parameters written.
    constexpr std::uint32_t writes() const { return memory_.writes(); }
    /// The `back`-th last parameter written, 0 for the latest; the last 64 are kept.
    constexpr c630s_write last_write(std::size_t back = 0) const { return memory_.write(back); }

    /// Address and baud rate that are in effect.
    constexpr std::uint8_t address() const {
        return static_cast<std::uint8_t>(memory_[coolmay::node_address.address]);
    }
    constexpr std::uint32_t baud() const {
        constexpr std::array<std::uint32_t, 6> bauds{2400, 4800, 9600, 19200, 38400, 57600};
        return bauds[static_cast<std::size_t>(memory_[coolmay::rs485_baud_rate.address])];
    }
    /// The rules of its responses, for its server.
    constexpr modbus::server_rules rules() const { return {.echoes_byte_count = options_.echoes_byte_count}; }
    /// By how much the caller delays each response: P0C-25, with `options::delay_is_additional` 40 ms more.
    constexpr duration response_delay() const {
        const std::uint32_t own_ms = options_.delay_is_additional ? 40 : 0;
        return milliseconds(static_cast<std::uint32_t>(memory_[coolmay::response_delay.address]) + own_ms);
    }

  private:
    static constexpr bool covers(std::uint16_t address) { return detail::c630s_memory::covers(address); }

    constexpr std::uint8_t answer(std::uint8_t exception) {
        if (exception != 0) last_error_ = exception;
        return exception;
    }
    constexpr bool is_stopped_for(std::uint16_t address) const {
        return is_stopped() || (options_.resets_while_enabled && address == coolmay::alarm_reset.address);
    }

    // Power on, or a software restart (`is_reset`), after which changes that wait for power-on still wait.
    constexpr void begin(bool is_reset) {
        restarts_ = false;
        memory_.power_on(keeps(c630s_restart::levels), is_reset);
        last_error_ = 0;
        switch_on();
        if (is_reset && memory_.has_waiting()) core::raise(0x941);
    }

    // A write

    constexpr void accept(std::size_t n, u32 bits, std::size_t words) {
        const entry& e = detail::c630s_memory::rows[n];
        const std::int64_t value = e.number(bits);
        if (has(e.flags, after_power_cycle) && memory_.shown(e.address) != value) core::raise(0x941);
        const std::int64_t before = memory_.shown(e.address);
        const bool switches_off = e.address == coolmay::eeprom_update.address && bits == 0;
        if (memory_.wears_eeprom(n) && (options_.stores_eeprom_off || !switches_off)) {
            memory_.store(n, bits, words);
            note_storing();
        }
        memory_.put(n, bits);
        if (value != before || !keeps_command(e.address)) act(e.address, value);
    }
    // A command that keeps its value once it is carried out: the same value is none again.
    constexpr bool keeps_command(std::uint16_t address) const {
        if (address == coolmay::homing_control.address) return !options_.homing_command_ends;
        return !options_.commands_end && (address == coolmay::alarm_reset.address ||
                                          address == coolmay::reset_absolute_encoder.address ||
                                          address == coolmay::initialise_parameters.address);
    }
    constexpr void end_command(std::uint16_t address) {
        if (options_.commands_end) memory_.set(address, 0);
    }

    // Er.942: more than 200 within `many_writes_within`.
    constexpr void note_storing() {
        std::int64_t& oldest = stored_at_[next_stored_ % stored_at_.size()];
        const std::int64_t window = options_.many_writes_within.us / 1000;
        if (next_stored_ >= stored_at_.size() && ms_ - oldest < window) core::raise(0x942);
        oldest = ms_;
        ++next_stored_;
    }

    constexpr void act(std::uint16_t address, std::int64_t value) {
        switch (address) {
        case coolmay::virtual_input_levels.address:
            return inputs_.set_virtual(static_cast<std::uint16_t>(value), memory_);
        case coolmay::virtual_inputs_enable.address: inputs_.refresh(memory_); return check_assignments();
        case coolmay::terminal_forcing.address:
        case coolmay::forced_inputs.address: return inputs_.refresh(memory_);
        case coolmay::homing_control.address: return command_homing(static_cast<coolmay::homing>(value));
        case coolmay::initialise_parameters.address:
            end_command(address);
            if (value == 1) memory_.restore_factory();
            if (value == 2) alarms_.clear_records();
            return;
        case coolmay::software_reset.address:
            memory_.set(address, 0);
            restarts_ = value == 1;
            return;
        case coolmay::alarm_reset.address:
            end_command(address);
            if (value == 1) reset_alarms();
            return;
        case coolmay::reset_absolute_encoder.address:
            end_command(address);
            if (value != 0) lasting_ &= ~(bit_of(0x731) | bit_of(0x733) | bit_of(0x735));
            if (value == 2) lose_turns();
            return;
        default: return;
        }
    }
    // Sets the encoder's turn count to 0; P0B-07 changes with it.
    constexpr void lose_turns() {
        const std::int64_t turn = detail::c630s_shaft::counts_per_turn;
        const std::int64_t before = turn_origin_;
        const std::int64_t at = motor_.position();
        turn_origin_ = at - ((at % turn) + turn) % turn;
        zero_ += turn_origin_ - before;
    }

    // Read-only parameters

    constexpr void set_wide(std::uint16_t low, std::uint16_t high, std::int64_t v) {
        const auto bits = static_cast<std::uint64_t>(v);
        memory_.set(low, static_cast<std::int64_t>(bits & 0xFFFF'FFFFu));
        memory_.set(high, static_cast<std::int64_t>(bits >> 32));
    }
    template <class Row> constexpr void show(const Row& row, std::int64_t v) { memory_.set(row.address, v); }

    constexpr void refresh() {
        show_motion();
        show_positions();
        show_record();
        show(coolmay::last_bus_error, last_error_);
        const bool is_off = state_ == state::off;
        show(coolmay::servo_status, alarms_.has_fault() ? 3 : is_off ? 1 : 2);
        show(coolmay::active_functions_1_to_16, functions() & 0xFFFFu);
        show(coolmay::active_functions_17_to_32, functions() >> 16);
        show(coolmay::virtual_output_levels, virtual_outputs());
    }
    constexpr void show_motion() {
        const std::int64_t torque = motor_.torque();
        show(coolmay::actual_speed, motor_.speed() / 1'000'000);
        show(coolmay::fine_actual_speed, motor_.speed() / 100'000);
        show(coolmay::speed_command, wanted_speed_ / 1'000'000);
        show(coolmay::torque_command, torque);
        show(coolmay::position_command_speed, command_.speed() / 1'000'000);
        show(coolmay::average_load, (torque < 0 ? -torque : torque) / 10);
        show(coolmay::phase_current, current());
        show(coolmay::ai1_voltage, analogue_[0] / 10);
        show(coolmay::ai2_voltage, analogue_[1] / 10);
        show(coolmay::bus_voltage, bus_voltage_);
        show(coolmay::module_temperature, temperature_);
        show(coolmay::power_on_time, seconds());
        const std::uint16_t levels = inputs_.levels(memory_);
        show(coolmay::input_state, levels);
        show(coolmay::input_conduction, ~levels & 0xFF);
        show(coolmay::output_state, outputs());
    }
    constexpr void show_positions() {
        const std::int64_t turn = detail::c630s_shaft::counts_per_turn;
        const std::int64_t at = motor_.position();
        const std::int64_t in_turn = ((at % turn) + turn) % turn;
        const std::int64_t absolute = memory_.is_on(coolmay::encoder_type) ? at - turn_origin_ : in_turn;
        const std::int64_t load = ((at - zero_) % turn + turn) % turn;
        show(coolmay::absolute_position, to_reference(at - zero_));
        show(coolmay::mechanical_angle, in_turn / 2);
        show(coolmay::electrical_angle, in_turn % (turn / 5) * 360 / (turn / 5));
        show(coolmay::command_pulses, to_reference(command_.position() - powered_at_));
        show(coolmay::input_position_command, to_reference(command_.position() - powered_at_));
        show(coolmay::encoder_following_error, deviation());
        show(coolmay::following_error, to_reference(deviation()));
        show(coolmay::feedback_pulses, at - powered_at_);
        show(coolmay::encoder_revolutions, (absolute - in_turn) / turn);
        show(coolmay::encoder_position_in_revolution, in_turn);
        set_wide(coolmay::mechanical_position_low.address, coolmay::mechanical_position_high.address,
                 at - zero_);
        set_wide(coolmay::encoder_position_low.address, coolmay::encoder_position_high.address, absolute);
        set_wide(coolmay::load_position_low.address, coolmay::load_position_high.address, load);
        show(coolmay::load_position, to_reference(load));
    }
    constexpr void show_record() {
        const record r =
            alarms_.record(static_cast<std::size_t>(memory_[coolmay::selected_fault_record.address]),
                           options_.shows_last_alarm);
        show(coolmay::recorded_alarm, r.code);
        show(coolmay::recorded_time, r.time);
        show(coolmay::recorded_speed, r.speed);
        show(coolmay::recorded_u_current, r.u_current);
        show(coolmay::recorded_v_current, r.v_current);
        show(coolmay::recorded_bus_voltage,
             options_.bus_voltage_in_volts ? r.bus_voltage / 10 : r.bus_voltage);
        show(coolmay::recorded_inputs, r.inputs);
        show(coolmay::recorded_outputs, r.outputs);
    }

    std::array<std::int64_t, 200> stored_at_{}; // ms
    std::size_t next_stored_ = 0;
    std::int64_t turn_origin_ = 0; // encoder counts at which the turn count is 0
    instant ticked_{};
    std::int16_t temperature_ = 35;
    std::uint8_t last_error_ = 0;
    bool has_clock_ = false;
    bool restarts_ = false;
};

} // namespace servobus::sim
