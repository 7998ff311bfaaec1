// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated winch, for tests of programs and of own_drive.hpp: a register store for `servobus::modbus::server`
// that moves with the time of a virtual line. On a host; connect it by a station:
//
//     winch::simulated machine;
//     servobus::sim::station station{machine, 5, 19200, servobus::milliseconds(1)};
//     servobus::sim::virtual_line wire{19200};
//     wire.attach(station);
//
// What its manual would not say, and is assumed here: it has no ramps; a start that does not fit its state is
// acknowledged and ignored; a fault takes its power away; registers that are not saved are 0 after power-on.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

#include "own_device.hpp"

namespace winch {

class simulated {
  public:
    simulated() {
        words_[ramp.address] = static_cast<std::uint16_t>(ramp.initial);
        words_[limit.address] = static_cast<std::uint16_t>(limit.initial);
    }

    // The register store: 0, or an exception of the device, and then nothing has changed.

    std::uint8_t read(std::uint16_t address, servobus::slice<std::uint16_t> to) {
        if (address + to.size() > size) return 1;
        show();
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words_[address + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, servobus::words_view from) {
        if (address == 0 || address + from.size() > load.address) return 1;
        for (std::size_t i = 0; i < from.size(); ++i) words_[address + i] = from[i];
        if (address == control_word.address) command(static_cast<control_code>(from[0]));
        return 0;
    }

    /// Moves on; the station calls it.
    void advance(servobus::instant now) {
        const std::uint32_t passed = servobus::since(now_, now).us;
        now_ = now;
        if (!is_turning()) return;
        if (control_ == control_code::turn) {
            travelled_ += std::int64_t{turn_pace()} * passed;
            return;
        }
        const std::int64_t missing = std::int64_t{goal()} * unit - travelled_;
        const std::int64_t way = std::int64_t{move_pace} * passed;
        if (missing <= way && missing >= -way) {
            travelled_ += missing;
            control_ = control_code::hold;
        } else {
            travelled_ += missing < 0 ? -way : way;
        }
    }

    // What a test does to it, and sees

    void raise_fault(std::uint16_t code) {
        fault_ = code;
        has_cause_ = true;
        control_ = control_code::off;
    }
    void end_fault_cause() { has_cause_ = false; }
    void power_cycle() {
        const std::uint16_t kept[] = {words_[ramp.address], words_[limit.address]};
        for (std::uint16_t& w : words_) w = 0;
        words_[ramp.address] = kept[0];
        words_[limit.address] = kept[1];
        control_ = control_code::off;
    }
    /// It stops, and stays energised without a fault, as if an input had stopped it.
    void interrupt() {
        if (is_turning()) control_ = control_code::hold;
    }
    std::int32_t place() const { return static_cast<std::int32_t>(travelled_ / unit); }
    bool is_energised() const { return control_ != control_code::off; }
    bool is_turning() const {
        return (control_ == control_code::turn && turn_pace() != 0) || control_ == control_code::move;
    }
    /// Starts that were not ignored.
    std::uint32_t starts() const { return starts_; }

  private:
    static constexpr std::size_t size = 0x20;
    static constexpr std::int64_t unit = 1'000'000;
    static constexpr std::int32_t move_pace = 10'000; // pulses a second

    std::int32_t turn_pace() const { return static_cast<std::int16_t>(words_[speed.address]) * 10; }
    std::int32_t goal() const {
        return static_cast<std::int32_t>(servobus::join_words(
            words_[target.address], words_[target.address + 1u], device::facts.word_order));
    }
    void command(control_code c) {
        if (c == control_code::clear_fault) {
            if (!has_cause_) fault_ = 0;
            return;
        }
        const bool is_start = c == control_code::turn || c == control_code::move;
        if (fault_ != 0 && c != control_code::off) return;
        if (is_start && !is_energised()) return;
        if (is_start) ++starts_;
        control_ = c;
    }
    void show() {
        const auto words =
            servobus::split_words(static_cast<std::uint32_t>(place()), device::facts.word_order);
        words_[load.address] = is_turning() ? 42 : 0;
        words_[position.address] = words.first;
        words_[position.address + 1u] = words.second;
        words_[status_word.address] = static_cast<std::uint16_t>(
            (is_energised() ? status_bits::energised : 0) | (is_turning() ? status_bits::turning : 0));
        words_[fault.address] = fault_;
    }

    std::uint16_t words_[size]{};
    servobus::instant now_{};
    std::int64_t travelled_ = 0; // 10^-6 pulses
    control_code control_ = control_code::off;
    std::uint16_t fault_ = 0;
    std::uint32_t starts_ = 0;
    bool has_cause_ = false;
};

} // namespace winch
