// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated ZLTECH ZLAC8015D: its 116 registers with the behaviour that a controlling program sees, under a
// virtual clock. It is a register store for `modbus::server`; who runs it calls `advance(now)` before each
// byte and each look at the reply.
//
// From the RS485 manual V1.07: registers, ranges, defaults, exceptions, control word, modes, status word,
// faults, the input's stop. Where the manual is silent the model does one of the things a drive may do, as a
// rule the worst for a careless program. These are assumptions, not facts about the drive:
//
//  1  Writing a read-only register is exception 2; a value outside its range or code list is exception 3.
//  2  An order that does not fit the state is acknowledged and ignored: a mode while a wheel turns, enable
//     without a mode, with a fault or an active stop input, a start in the wrong mode or with the wrong
//     200Fh, factory reset while enabled. Only the registers tell: 200Dh keeps its old value.
//  3  Mode 0 disables. With any other, enable moves a wheel at once if its target is not zero.
//  4  The acceleration time leads from 0 to the target, the deceleration time from the speed at which slowing
//     began to 0; in position modes both refer to 208Eh/208Fh. Ramps are linear.
//  5  Stop (07h) slows down by 2082h/2083h and releases the shaft, or with 2013h = 0 releases it at once.
//  6  Quick stop (05h) of an enabled drive holds the shaft afterwards until 08h, or 07h, which releases it;
//     a drive that is not enabled ignores it. Option 7 stands still within a tick.
//  7  The stop input does what 05h does; with 2021h = 1 the shaft is released at standstill, with option 7 at
//     once. Enable is ignored while the input is active.
//  8  A relative start while moving adds to the present target; an absolute one replaces it. A quick stop, a
//     stop or a change of mode drops the move. An absolute target beyond +-3FFFFFFFh is not started.
//  9  2005h sets the feedback 20A7h..20AAh to zero, 2006h the origin of absolute moves: two separate zeros.
//     The triggers 2005h, 2006h, 2009h and 2010h read back as 0.
// 10  2000h = 0 switches the watchdog off. Otherwise an enabled drive that hears no request for longer stops by
//     2011h; `options::resumes_after_watchdog` says what the next request does. Every request that the server
//     carries out or refuses for its address or value counts.
// 11  A fault of one wheel cuts the power of both; with 201Fh = 1 the phases are shorted and brake. 06h clears
//     the faults of which the cause is gone; the drive is disabled then. A commanded speed above 2008h in
//     velocity mode is the fault 2000h, whether enabled or not.
// 12  2010h saves the rows marked RW/S. 2009h restores all rows, in the EEPROM too. Node address and baud rate
//     come into force with the next power cycle.
// 13  A closed brake (201Ah/201Bh = 1) blocks its wheel; driven against it for 2035h/2065h, the wheel's fault
//     is overload. Parking mode (200Ch) brakes the wheels of a drive that is not enabled.
// 14  0 encoder lines count as 1024.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/bytes.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/sim/zlac8015d/memory.hpp>
#include <servobus/sim/zlac8015d/wheel.hpp>
#include <servobus/time.hpp>

namespace servobus::sim {

/// What a test may choose of the simulated drive.
struct zlac8015d_options {
    /// What ends a watchdog stop. True: the next valid request, and the wheels go on to the targets that still
    /// stand: the worst case for a controller. False: the drive stays in quick stop until it is enabled again.
    bool resumes_after_watchdog = true;
};

/// What one wheel does, finer than its registers tell.
struct wheel_view {
    std::int64_t position = 0;    ///< counts since the model was made; no clear and no power cycle changes it
    std::int64_t speed = 0;       ///< 10^-6 r/min
    std::int64_t current = 0;     ///< uA
    std::int64_t target = 0;      ///< counts, as `position`; where the present or last move ends
    bool is_moving = false;       ///< a move of a position mode is under way
    std::uint32_t starts = 0;     ///< moves that were carried out
    bool is_brake_closed = false; ///< B0 or B1
};

/// The simulated drive. A `modbus::register_store`.
class zlac8015d {
  public:
    using options = zlac8015d_options;
    using command = servobus::zlac8015d::command;
    using fault = servobus::zlac8015d::fault;
    using faults = servobus::zlac8015d::faults;
    using operating_mode = servobus::zlac8015d::operating_mode;
    using status = servobus::zlac8015d::status;

    enum class state : std::uint8_t {
        idle,       ///< no power in the motors, or only the power-on lock of 2007h
        operating,  ///< enabled
        stopping,   ///< 07h: slowing down, then idle
        quick_stop, ///< slowing down or held until enabled again
    };

    /// A new drive with factory settings, switched on.
    constexpr explicit zlac8015d(options chosen = {}) : options_{chosen} {
        memory_.make_new();
        switch_on();
    }

    // The register store

    /// Reads words. Returns 0, or exception 2 if one of the addresses does not exist. Either way the host was
    /// heard.
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        on_request(now_);
        const std::uint8_t refusal = memory::refuse_read(address, to.size());
        if (refusal != 0) return refusal;
        refresh();
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = memory_[static_cast<std::uint16_t>(address + i)];
        return 0;
    }

    /// Writes words in ascending order, all or none. Returns 0, or exception 2 or 3. One word of a 32-bit
    /// value is taken as it is.
    constexpr std::uint8_t write(std::uint16_t address, words_view from) {
        on_request(now_);
        const std::uint8_t refusal = memory::refuse_write(address, from);
        if (refusal != 0) return refusal;
        for (std::size_t i = 0; i < from.size(); ++i)
            accept(static_cast<std::uint16_t>(address + i), from[i]);
        check_commanded_speeds();
        return 0;
    }

    // Time

    /// Lets the drive run up to `now`, tick by tick. The first call sets the clock; a clock that went back sets
    /// it anew.
    constexpr void advance(instant now) {
        if (!has_clock_ || went_back(now_, now)) {
            has_clock_ = true;
            ticked_ = now;
        }
        now_ = now;
        while (since(ticked_, now) >= detail::wheel::tick) {
            if (is_at_rest()) {
                const std::uint32_t idle = since(ticked_, now).us / detail::wheel::tick.us * detail::wheel::tick.us;
                silence_ += idle;
                ticked_ = ticked_ + duration{idle};
                return;
            }
            tick();
            ticked_ = ticked_ + detail::wheel::tick;
        }
    }

    /// The drive has heard a valid request. `read` and `write` call it.
    constexpr void on_request(instant now) {
        advance(now);
        silence_ = -std::int64_t{since(ticked_, now_).us};
        if (in_watchdog_stop_ && options_.resumes_after_watchdog) in_watchdog_stop_ = false;
    }

    // What a test or a simulated machine does to it

    /// Switches off and on again: volatile registers and feedback fall back, saved ones come from the EEPROM,
    /// a moving wheel rolls on. A fault whose cause persists is there again at once.
    constexpr void power_cycle() {
        memory_.power_on();
        switch_on();
    }

    /// Faults set in, each wheel's as a set or as one `fault`; their causes last until `end_faults`.
    constexpr void raise(faults left, faults right) {
        wheels_[0].cause |= left.bits;
        wheels_[1].cause |= right.bits;
        latch_faults();
    }
    constexpr void raise(fault left, fault right) { raise(as_set(left), as_set(right)); }
    /// The causes of raised faults are gone; the faults stay until 06h.
    constexpr void end_faults() { wheels_[0].cause = wheels_[1].cause = 0; }

    /// The levels at the terminals X0 and X1.
    constexpr void set_input(bool x0, bool x1) { inputs_ = {x0, x1}; }
    /// 0.01 V; 24 V after construction.
    constexpr void set_bus_voltage(std::uint16_t centivolt) { bus_voltage_ = centivolt; }
    /// degC, -55..120. Above 2046h/2076h the wheel has the fault motor_overtemperature.
    constexpr void set_motor_temperature(std::int8_t left, std::int8_t right) {
        motor_temperature_ = {left, right};
    }
    /// 0.1 degC
    constexpr void set_driver_temperature(std::int16_t tenths) { driver_temperature_ = tenths; }

    // What a test asks

    constexpr bool enabled() const { return state_ == state::operating; }
    constexpr state current_state() const { return state_; }
    constexpr operating_mode mode() const { return static_cast<operating_mode>(memory_[map::mode_of_operation.address]); }
    constexpr bool in_watchdog_stop() const { return in_watchdog_stop_; }
    constexpr wheel_view left() const { return view(wheels_[0], map::left_brake.address); }
    constexpr wheel_view right() const { return view(wheels_[1], map::right_brake.address); }
    constexpr bool stands_still() const { return wheels_[0].motor.stands() && wheels_[1].motor.stands(); }

    /// Starts (10h, 11h, 12h) that were carried out; ignored ones do not count.
    constexpr std::uint32_t starts() const { return starts_; }
    /// Enables (08h) that were carried out.
    constexpr std::uint32_t enables() const { return enables_; }
    /// How often this control word was written, obeyed or not.
    constexpr std::uint32_t orders(command c) const { return orders_[static_cast<std::size_t>(c)]; }
    constexpr std::uint32_t writes_to(std::uint16_t address) const { return memory_.writes_to(address); }
    /// Words written in all.
    constexpr std::uint32_t writes() const { return memory_.writes(); }
    /// The `back`-th last word written, 0 the latest; the last 64 are known.
    constexpr logged_write last_write(std::size_t back = 0) const { return memory_.write(back); }
    /// Words written to the EEPROM since the model was made.
    constexpr std::uint32_t eeprom_writes() const { return memory_.eeprom_writes(); }
    /// Orders to save (2010h) that were carried out.
    constexpr std::uint32_t saves() const { return memory_.saves(); }
    /// A register's word as a read gives it, without being a request; 0 for an address that does not exist.
    constexpr std::uint16_t peek(std::uint16_t address) {
        refresh();
        return memory::covers(address) ? memory_[address] : std::uint16_t{0};
    }

    /// Node address and baud rate in force since the last power-on.
    constexpr std::uint8_t unit() const { return unit_; }
    constexpr std::uint32_t baud() const { return baud_; }

  private:
    using memory = detail::zlac8015d_memory;
    // The rows by name; a type, since a namespace cannot be renamed inside a class.
    struct map;

    struct axis {
        detail::wheel motor{};
        std::int64_t feedback_zero = 0;
        std::int64_t origin = 0;
        std::int64_t blocked_us = 0;
        std::uint32_t starts = 0;
        std::uint16_t cause = 0;   // raised by the test
        std::uint16_t latched = 0; // what 20A5h, 20A6h show
    };
};

} // namespace servobus::sim
