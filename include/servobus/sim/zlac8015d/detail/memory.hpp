// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the register memory of the simulated ZLAC8015D. It decides what may be written and what the
// EEPROM keeps. Ranges, defaults and access rights are those of the device's catalogue.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/sim/memory.hpp>
#include <servobus/sim/zlac8015d/options.hpp>

namespace servobus::sim::detail {

class zlac8015d_memory : public register_memory<0x2000, 0xB1> { // 2000h .. 20B0h
  public:
    constexpr explicit zlac8015d_memory(const zlac8015d_options& chosen)
        : register_memory{index}, is_kept_{chosen.save == zlac8015d_options::kept::all ? &can_be_written
                                                                                       : &is_marked},
          checks_option_codes_{chosen.checks_option_codes}, rescales_immediately_{
                                                                chosen.rescales_immediately} {}

    static constexpr bool covers(std::uint16_t address) { return index.covers(address); }

    /// The exception of a read of these registers; 0 if it is allowed.
    static constexpr std::uint8_t refuse_read(std::uint16_t address, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            if (!covers(static_cast<std::uint16_t>(address + i))) return illegal_address;
        }
        return 0;
    }

    /// The exception of a write; 0 if it is allowed. Addresses are checked before values.
    constexpr std::uint8_t refuse_write(std::uint16_t address, words_view from) const {
        for (std::size_t i = 0; i < from.size(); ++i) {
            const auto at = static_cast<std::uint16_t>(address + i);
            if (!covers(at) || index.row(at).rights == access::ro) return illegal_address;
        }
        for (std::size_t i = 0; i < from.size(); ++i) {
            const entry& e = index.row(static_cast<std::uint16_t>(address + i));
            if (e.words() == 1) {
                if (!accepts(e, from[i])) return illegal_value;
            } else if (e.address == address + i && i + 1 < from.size()) {
                if (!accepts(e, join_words(from[i], from[i + 1], word_order::high_first)))
                    return illegal_value;
            }
        }
        return 0;
    }

    /// Power on: saved registers are read from the EEPROM, the others get their defaults.
    constexpr void power_on() {
        clear();
        fill([](const entry&) { return true; });
        recall(is_kept_);
        resolution_ = (*this)[resolution_address];
    }
    /// Fills the EEPROM as in a new drive, then switches on.
    constexpr void make_new() {
        fill_eeprom(is_kept_);
        power_on();
    }
    /// Restores the factory defaults, in the EEPROM too; mode and control word keep their values.
    constexpr void restore() {
        wear(fill_eeprom(is_kept_));
        fill([](const entry& e) { return e.rights != access::ro && !is_state(e.address); });
    }
    /// 2022h as it scales commanded speeds: a count is 1/resolution r/min.
    constexpr std::uint16_t resolution() const {
        const std::uint16_t n = rescales_immediately_ ? (*this)[resolution_address] : resolution_;
        return n == 0 ? std::uint16_t{1} : n; // which no write sets
    }
    /// Puts a word into the EEPROM, as if a program had saved it long ago: no write is counted.
    constexpr void store(std::uint16_t address, std::uint16_t word) { set_eeprom(address, word); }
    /// Writes to the EEPROM the registers that a save keeps.
    constexpr void save() { keep(is_kept_); }

  private:
    static constexpr auto illegal_address =
        static_cast<std::uint8_t>(modbus::exception::illegal_data_address);
    static constexpr auto illegal_value = static_cast<std::uint8_t>(modbus::exception::illegal_data_value);
    static constexpr std::uint16_t resolution_address = servobus::zlac8015d::speed_resolution.address;
    static constexpr map index{servobus::zlac8015d::catalogue.entries};

    static constexpr bool is_marked(const entry& e) { return has(e.flags, saved); }
    static constexpr bool can_be_written(const entry& e) { return e.rights != access::ro; }

    static constexpr bool is_option_code(std::uint16_t address) {
        return address >= 0x2012 && address <= 0x2014;
    }
    static constexpr bool is_state(std::uint16_t address) { return address == 0x200D || address == 0x200E; }

    // The control word is the only register whose codes have holes in their range.
    constexpr bool accepts(const entry& e, std::uint32_t bits) const {
        if (!checks_option_codes_ && is_option_code(e.address)) return true;
        if (!e.limits.contains(e.number(bits))) return false;
        if (e.address != servobus::zlac8015d::control_word.address) return true;
        for (const named_value& v : e.values) {
            if (v.applies(bits)) return true;
        }
        return false;
    }

    choice is_kept_;
    bool checks_option_codes_;
    bool rescales_immediately_;
    std::uint16_t resolution_ = 1; // since the last power-on
};

} // namespace servobus::sim::detail
