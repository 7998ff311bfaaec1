// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLTECH ZLAC8015D for tests: its 116 registers and the behaviour that a controlling program
// observes, under a virtual clock. The model is a register store for `modbus::server`: call `advance(now)`
// before each received byte and before each poll for the response. A `station` of sim/station.hpp does so on
// a virtual line.
//
//     servobus::sim::zlac8015d drive;
//     servobus::sim::station station{drive};
//     servobus::sim::virtual_line wire{drive.baud()};
//     wire.attach(station);
//
// From the RS485 manual V1.07: registers, ranges, defaults, exceptions, control word, modes, status word,
// faults, the stop by an input. Where the manual is silent, the model does one of the things that a drive may
// do, usually the worst for a careless program. These are assumptions, not facts about the drive. Where
// another interpretation matters, `options` has a switch for it; "no switch" gives the reason where it does not:
//
//  1  Writing a read-only register is exception 2; a value outside its range or code list is exception 3.
//     Either way the host learns that nothing was written: no switch, but `options::checks_option_codes` for
//     codes that no order uses.
//  2  A command that does not fit the state is acknowledged and ignored: a mode while a wheel turns, enable with
//     a fault or an active stop input, a start in the wrong mode, factory reset while enabled. Only the
//     registers show it: 200Dh keeps its old value. A drive that refuses instead is the easier one: no switch.
//     An enable without a mode: `options::enables_without_mode`; a start that 200Fh does not name:
//     `options::position_start`.
//  3  Mode 0 disables. With any other mode, enable moves a wheel immediately if its target is not zero. A
//     program that zeroes the targets first, and writes a mode at standstill only, meets neither: no switch.
//  4  Ramps to a speed: `options::speed_ramp`. In position modes both times refer to 208Eh/208Fh, and the ramps
//     are linear. The library waits for standstill as long as the longest ramp takes.
//  5  Stop (07h) slows down by 2082h/2083h and releases the shaft, or with 2013h = 0 releases it immediately.
//     The factory setting is 1; with 0 either behaviour shows in the speeds, which are read: no switch.
//  6  Quick stop (05h) of an enabled drive holds the shaft afterwards until 08h, or until 07h, which releases
//     it; a drive that is not enabled ignores it. Option 7 stops within a tick. What 20A2h shows:
//     `options::after_quick_stop`.
//  7  The stop input does what 05h does; with 2021h = 1 the shaft is released at standstill, with option 7
//     immediately. Enable is ignored while the input is active. Sections 3.4 and 3.7: no switch.
//  8  A relative start during a move adds to the present target; an absolute one replaces it. A quick stop, a
//     stop or a change of mode discards the move. An absolute target beyond +-3FFFFFFFh is not started. A
//     program that starts moves at standstill only, and zeroes targets, meets neither: no switch.
//  9  2005h sets the feedback 20A7h..20AAh to zero, 2006h the origin of absolute moves: two separate zeros.
//     The triggers 2005h, 2006h, 2009h and 2010h read back as 0, and a restart sets the feedback to zero. The
//     library compares positions within one run of the drive only, and only while the mode is unchanged: no
//     switch.
// 10  An enabled drive that receives no request for longer than 2000h stops by 2011h. Every request to it
//     that reaches the registers counts, also one that they refuse; a request to another address does not.
//     What ends the stop: `options::resumes_after_watchdog`; the time 0: `options::host_timeout`.
// 11  A fault switches off what `options::by_fault` says; with 201Fh = 1 the phases are shorted and brake.
//     06h clears the faults whose cause has ended (and their code: `options::code`); the drive is disabled
//     then. A commanded speed above 2008h in velocity mode is the fault 2000h, enabled or not.
// 12  2010h saves `options::save`, in any state. 2009h restores all rows, in the EEPROM too. Node address and
//     baud rate take effect at the next power cycle, and so does 2022h: `options::rescales_immediately`.
// 13  An engaged brake (201Ah/201Bh; the code: `options::code_1`) blocks its wheel; a wheel that is driven
//     against it for 2035h/2065h has the fault overload. Parking mode (200Ch) brakes the wheels of a drive
//     that is not enabled. 2019h, which inverts B0 and B1, is not modelled: `options::code_1` has the same
//     effect.
// 14  0 encoder lines count as 1024. This is a scale of positions, on which no guarantee depends: no switch.
// 15  20A2h: `options::while_turning`, `in_torque_mode`, `idle_shaft` and `bit`. The speeds of a move:
//     `options::shows_speed_of_moves`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/sim/detail/wheel.hpp>
#include <servobus/sim/zlac8015d/detail/axis.hpp>
#include <servobus/sim/zlac8015d/detail/core.hpp>
#include <servobus/sim/zlac8015d/detail/memory.hpp>
#include <servobus/sim/zlac8015d/options.hpp>

namespace servobus::sim {

namespace zlac = servobus::zlac8015d; // the class sim::zlac8015d hides the device's namespace

/// The state of one wheel, with a finer resolution than that of its registers.
struct wheel_view {
    std::int64_t position = 0; ///< counts from construction; neither clearing nor a power cycle changes it
    std::int64_t speed = 0;    ///< 10^-6 r/min
    std::int64_t current = 0;  ///< uA
    std::int64_t target = 0;   ///< counts, as `position`; where the present or last move ends
    bool is_moving = false;    ///< a move of a position mode is under way
    std::uint32_t starts = 0;  ///< moves that were carried out
    bool is_brake_engaged = false; ///< by B0 or B1
};

/// The simulated drive. A `modbus::register_store`.
class zlac8015d : private detail::zlac8015d_core {
    using core = detail::zlac8015d_core;

  public:
    using options = zlac8015d_options;
    using core::control_code;
    using fault = zlac::fault;
    using faults = zlac::faults;
    using core::operating_mode;
    using core::state;
    using status = zlac::status_flags;

    /// A new drive with factory settings, switched on.
    constexpr zlac8015d() : zlac8015d{options{}} {}
    constexpr explicit zlac8015d(options chosen) : core{chosen} {
        memory_.make_new();
        switch_on();
    }

    // The register store

    /// Reads words. Returns 0, or exception 2 if one of the addresses does not exist. Either way the read
    /// restarts the watchdog time.
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        note_request();
        const std::uint8_t refusal = memory::refuse_read(address, to.size());
        if (refusal != 0) return refusal;
        refresh();
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = memory_[static_cast<std::uint16_t>(address + i)];
        return 0;
    }

    /// Writes words in ascending order, all or none. Returns 0, or exception 2 or 3. A single word of a
    /// 32-bit value is accepted without a range check.
    constexpr std::uint8_t write(std::uint16_t address, words_view from) {
        note_request();
        const std::uint8_t refusal = memory_.refuse_write(address, from);
        if (refusal != 0) return refusal;
        for (std::size_t i = 0; i < from.size(); ++i)
            accept(static_cast<std::uint16_t>(address + i), from[i]);
        look_for_faults();
        return 0;
    }

    // Time

    /// Advances the drive to `now` in ticks of 250 us. The first call sets the clock; so does a `now` that
    /// went back.
    constexpr void advance(instant now) {
        if (!has_clock_ || went_back(now_, now)) {
            has_clock_ = true;
            ticked_ = now;
        }
        now_ = now;
        while (since(ticked_, now) >= detail::wheel::tick) {
            if (is_at_rest()) {
                const std::uint32_t idle =
                    since(ticked_, now).us / detail::wheel::tick.us * detail::wheel::tick.us;
                since_request_ += idle;
                ticked_ = ticked_ + duration{idle};
                return;
            }
            tick();
            ticked_ = ticked_ + detail::wheel::tick;
        }
    }

    /// Records a valid request at `now`, which restarts the watchdog time, as `read` and `write` do.
    constexpr void on_request(instant now) {
        advance(now);
        note_request();
    }

    // What a test or a simulated machine does to it

    /// Switches the power off and on: volatile registers get their defaults, the feedback is 0, saved
    /// registers are read from the EEPROM. A moving wheel continues to roll. A fault whose cause persists is
    /// present again immediately.
    constexpr void power_cycle() {
        memory_.power_on();
        switch_on();
    }

    /// Puts a word into the EEPROM, as if a program had saved it long ago. It holds from the next `power_cycle()`.
    constexpr void store(std::uint16_t address, std::uint16_t word) { memory_.store(address, word); }

    /// Raises faults of each wheel, as a set or as one `fault`; their causes last until `end_faults`.
    constexpr void raise(faults left, faults right) {
        left_.raise(left.bits);
        right_.raise(right.bits);
        look_for_faults();
    }
    constexpr void raise(fault left, fault right) {
        raise(faults{static_cast<std::uint16_t>(left)}, faults{static_cast<std::uint16_t>(right)});
    }
    /// Ends the causes of raised faults; the faults stay until 06h.
    constexpr void end_faults() {
        left_.end_causes();
        right_.end_causes();
    }

    /// Sets the levels at the terminals X0 and X1.
    constexpr void set_input(bool x0, bool x1) { inputs_ = {x0, x1}; }
    /// In 0.01 V; 24 V after construction.
    constexpr void set_bus_voltage(std::uint16_t centivolt) { bus_voltage_ = centivolt; }
    /// In degC, -55..120. Above 2046h/2076h the wheel has the fault motor_overtemperature.
    constexpr void set_motor_temperature(std::int8_t left, std::int8_t right) {
        motor_temperature_ = {left, right};
        look_for_faults();
    }
    /// In 0.1 degC.
    constexpr void set_driver_temperature(std::int16_t tenths) { driver_temperature_ = tenths; }

    // What a test reads

    constexpr bool enabled() const { return state_ == state::operating; }
    constexpr state current_state() const { return state_; }
    using core::mode;
    using core::stands_still;
    constexpr bool in_watchdog_stop() const { return in_watchdog_stop_; }
    constexpr wheel_view left() const { return view(left_); }
    constexpr wheel_view right() const { return view(right_); }

    /// Starts (10h, 11h, 12h) that were carried out; ignored ones do not count.
    constexpr std::uint32_t starts() const { return starts_; }
    /// Enables (08h) that were carried out.
    constexpr std::uint32_t enables() const { return enables_; }
    /// How often this control word was written, including ignored writes.
    constexpr std::uint32_t commands(control_code c) const { return commands_[static_cast<std::size_t>(c)]; }
    constexpr std::uint32_t writes_to(std::uint16_t address) const { return memory_.writes_to(address); }
    /// The total number of words written.
    constexpr std::uint32_t writes() const { return memory_.writes(); }
    /// The `back`-th last word written, 0 for the latest; the last 64 are kept.
    constexpr logged_write last_write(std::size_t back = 0) const { return memory_.write(back); }
    /// Registers written to the EEPROM since construction.
    constexpr std::uint32_t eeprom_writes() const { return memory_.eeprom_writes(); }
    /// Saves (2010h) that were carried out.
    constexpr std::uint32_t saves() const { return memory_.saves(); }
    /// A register's word as a read returns it, without a request; 0 for an address that does not exist.
    constexpr std::uint16_t peek(std::uint16_t address) {
        refresh();
        return memory::covers(address) ? memory_[address] : std::uint16_t{0};
    }

    /// The counts of a commanded speed in 1 r/min, as they are in force: 2022h may be another value already.
    constexpr std::uint16_t resolution() const { return memory_.resolution(); }
    /// Address and baud rate in effect since the last power-on.
    constexpr std::uint8_t address() const { return address_; }
    constexpr std::uint32_t baud() const { return baud_; }

  private:
    constexpr wheel_view view(const axis& a) const {
        const detail::wheel& w = a.motor();
        return {w.position(),
                w.speed(),
                w.current(),
                w.target(),
                w.is_moving_to_target(),
                a.starts(),
                a.is_brake_engaged(memory_)};
    }

    constexpr void switch_on() {
        constexpr std::array<std::uint32_t, 7> bauds{0, 128000, 115200, 57600, 38400, 19200, 9600};
        address_ = static_cast<std::uint8_t>(memory_[zlac::node_address.address]);
        baud_ = bauds[memory_[zlac::rs485_baud_rate.address]];
        core::switch_on();
    }

    constexpr void note_request() {
        since_request_ = -std::int64_t{since(ticked_, now_).us};
        const bool is_always_over =
            memory_[zlac::host_timeout.address] == 0 && options_.host_timeout == options::zero::stops;
        if (state_ == state::operating && !is_always_over) in_watchdog_stop_ = false;
    }

    // Read-only registers

    constexpr zlac::shaft_state shaft_of(const axis& a) const {
        using zlac::shaft_state;
        if (a.faults() != 0) return shaft_state::alarm;
        if (state_ == state::quick_stop || in_watchdog_stop_) {
            return options_.after_quick_stop == options::stopped::emergency ? shaft_state::emergency_stop
                                                                            : shaft_state::locked;
        }
        if (state_ == state::idle) {
            return is_locked_                                       ? shaft_state::locked
                   : options_.idle_shaft == options::idle::released ? shaft_state::released
                                                                    : shaft_state::emergency_stop;
        }
        const bool is_released =
            (options_.while_turning == options::shaft::released && !a.stands()) ||
            (options_.in_torque_mode == options::shaft::released && mode() == operating_mode::torque);
        return is_released ? shaft_state::released : shaft_state::locked;
    }

    constexpr bool running_bit_of(const axis& a) const {
        const bool turns = !a.stands() || a.motor().is_moving_to_target();
        switch (options_.bit) {
        case options::running::enabled: return state_ == state::operating && a.faults() == 0;
        case options::running::driven:
            return turns && state_ != state::idle && !is_released_ && a.faults() == 0;
        default: return turns;
        }
    }

    constexpr std::uint16_t speed_word_of(const axis& a) const {
        return is_positioning() && !options_.shows_speed_of_moves
                   ? std::uint16_t{0}
                   : static_cast<std::uint16_t>(a.speed_word());
    }

    constexpr zlac::axis_status status_of(const axis& a) const { return {shaft_of(a), running_bit_of(a)}; }

    constexpr bool output(std::uint16_t function) const {
        switch (static_cast<zlac::output_function>(function)) {
        case zlac::output_function::alarm: return has_fault();
        case zlac::output_function::driver_status: return enabled();
        case zlac::output_function::in_position:
            return !left_.motor().is_moving_to_target() && !right_.motor().is_moving_to_target();
        default: return false;
        }
    }

    constexpr void refresh() {
        const zlac::outputs outputs{output(memory_[zlac::y0_function.address]),
                                    output(memory_[zlac::y1_function.address])};
        const unsigned inverted = memory_[zlac::output_polarities.address] & 3u;
        memory_.set(zlac::input_state.address, inputs_.to_word());
        memory_.set(zlac::output_state.address, static_cast<std::uint16_t>(outputs.to_word() ^ inverted));
        memory_.set(zlac::software_version.address, 107);
        memory_.set(zlac::bus_voltage.address, bus_voltage_);
        memory_.set(zlac::status_word.address, status{status_of(left_), status_of(right_)}.to_word());
        memory_.set(zlac::hall_state.address,
                    zlac::hall_inputs{left_.hall(memory_), right_.hall(memory_)}.to_word());
        memory_.set(zlac::motor_temperature.address, motor_temperature_.to_word());
        memory_.set(zlac::left_faults.address, left_.fault_code());
        memory_.set(zlac::right_faults.address, right_.fault_code());
        memory_.set_pair(zlac::left_actual_position.address, left_.feedback());
        memory_.set_pair(zlac::right_actual_position.address, right_.feedback());
        memory_.set(zlac::left_actual_speed.address, speed_word_of(left_));
        memory_.set(zlac::right_actual_speed.address, speed_word_of(right_));
        memory_.set(zlac::left_actual_torque.address, static_cast<std::uint16_t>(left_.current_word()));
        memory_.set(zlac::right_actual_torque.address, static_cast<std::uint16_t>(right_.current_word()));
        memory_.set(zlac::host_connected.address, 1);
        memory_.set(zlac::driver_temperature.address, static_cast<std::uint16_t>(driver_temperature_));
    }

    instant now_{};
    instant ticked_{};
    std::uint32_t baud_ = 0;
    std::uint16_t bus_voltage_ = 2400;
    std::int16_t driver_temperature_ = 350;
    std::uint8_t address_ = 0;
    bool has_clock_ = false;
};

} // namespace servobus::sim
