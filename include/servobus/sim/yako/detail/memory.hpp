// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the register memory of a simulated YAKOTEC stepper: the rows of its variant, the vendor's
// exceptions, and 32-bit values in the word order of 0019h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/sim/memory.hpp>
#include <servobus/sim/yako/options.hpp>

namespace servobus::sim::detail {

using yako_index = register_index<0x0000, 0x140>;

/// The differences of closed loop and open loop.
struct yako_variant {
    yako_index rows;
    std::uint16_t last; ///< the last address
    std::uint8_t inputs;
    std::uint8_t outputs;
    bool has_encoder; ///< it has feedback and an index pulse
    bool (*is_valid)(servobus::yako::homing);
};

inline constexpr yako_variant yako_closed_loop_variant{
    yako_index{servobus::yako::closed_loop::catalogue.entries},
    0x0119,
    4,
    2,
    true,
    servobus::yako::closed_loop::is_valid};
inline constexpr yako_variant yako_open_loop_variant{yako_index{servobus::yako::open_loop::catalogue.entries},
                                                     0x013F,
                                                     7,
                                                     3,
                                                     false,
                                                     servobus::yako::open_loop::is_valid};

class yako_memory : public register_memory<0x0000, 0x140> {
  public:
    constexpr yako_memory(const yako_variant& of, yako_kept kept)
        : register_memory{of.rows}, of_{&of}, kept_{kept} {}

    static constexpr std::uint8_t wrong_value = 7; ///< exception

    constexpr bool covers(std::uint16_t address) const { return of_->rows.covers(address); }
    /// A register's word in the word order of the line.
    constexpr std::uint16_t word_on_line(std::uint16_t address) const { return (*this)[place_of(address)]; }
    constexpr void set_word_on_line(std::uint16_t address, std::uint16_t word) {
        set(place_of(address), word);
    }
    constexpr std::int64_t signed_word(std::uint16_t address) const {
        return static_cast<std::int16_t>((*this)[address]);
    }

    /// The exception of a read of these registers; 0 if it is allowed.
    constexpr std::uint8_t refuse_read(std::uint16_t address, std::size_t count) const {
        return count > max_read ? too_many : refuse_addresses(address, count);
    }
    /// The exception of a write; 0 if it is allowed. Addresses are checked first, then access, then values.
    constexpr std::uint8_t refuse_write(std::uint16_t address, words_view from) const {
        const std::uint8_t refusal = refuse_addresses(address, from.size());
        if (refusal != 0) return refusal;
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (row(address + i).rights == access::ro) return no_access;
        }
        for (std::size_t i = 0; i < from.size(); ++i) {
            const entry& e = row(address + i);
            if (e.words() == 1 && !accepts(e, from[i])) return wrong_value; // 32-bit values have no range
        }
        return 0;
    }

    /// Power on: writable registers are read from the EEPROM; those that are kept on write keep their values.
    constexpr void power_on() {
        const yako_memory before = *this;
        clear();
        recall(is_kept);
        for (const entry& e : of_->rows.rows()) {
            if (!is_kept(e) || !is_kept_on_write(e)) continue;
            for (std::size_t i = 0; i < e.words(); ++i) {
                const auto at = static_cast<std::uint16_t>(e.address + i);
                set(at, before[at]);
            }
        }
    }
    /// Fills the EEPROM as in a new drive, then the registers from it.
    constexpr void make_new() {
        fill_eeprom(is_kept);
        clear();
        recall(is_kept);
    }
    /// Restores the factory defaults, with `in_eeprom` in the EEPROM too.
    constexpr void restore(bool in_eeprom) {
        if (in_eeprom) wear(fill_eeprom(is_kept));
        fill(is_kept);
    }
    /// Writes to the EEPROM the registers that a save keeps.
    constexpr void save() { keep(kept_ == yako_kept::marked ? is_marked : is_kept); }

  private:
    static constexpr std::size_t max_read = 16;
    static constexpr std::uint8_t gap = 3;
    static constexpr std::uint8_t beyond = 4;
    static constexpr std::uint8_t too_many = 5;
    static constexpr std::uint8_t no_access = 6;

    static constexpr bool is_kept(const entry& e) { return e.rights != access::ro && !has(e.flags, trigger); }
    static constexpr bool is_setting_of_the_line(const entry& e) {
        return e.address >= servobus::yako::node_address.address &&
               e.address <= servobus::yako::rs485_format.address;
    }
    static constexpr bool is_marked(const entry& e) {
        return has(e.flags, saved) || is_setting_of_the_line(e);
    }
    constexpr bool is_kept_on_write(const entry& e) const {
        const bool is_line_format = e.address == servobus::yako::pair_word_order.address ||
                                    e.address == servobus::yako::closed_loop::speed_resolution.address;
        return kept_ == yako_kept::written ||
               (kept_ == yako_kept::line_settings && (is_setting_of_the_line(e) || is_line_format));
    }

    constexpr const entry& row(std::size_t address) const {
        return of_->rows.row(static_cast<std::uint16_t>(address));
    }
    constexpr std::uint16_t place_of(std::uint16_t address) const {
        const entry& e = row(address);
        const bool is_swapped = (*this)[servobus::yako::pair_word_order.address] != 0;
        if (e.words() == 1 || !is_swapped) return address;
        return static_cast<std::uint16_t>(2 * e.address + 1 - address);
    }
    constexpr std::uint8_t refuse_addresses(std::uint16_t address, std::size_t count) const {
        for (std::size_t i = address; i < address + count; ++i) {
            if (i > of_->last) return beyond;
            if (!covers(static_cast<std::uint16_t>(i))) return gap;
        }
        return 0;
    }
    constexpr bool accepts(const entry& e, std::uint16_t word) const {
        if (!e.limits.contains(e.number(word))) return false;
        return e.address != servobus::yako::closed_loop::homing_method.address ||
               of_->is_valid(from_bits<servobus::yako::homing>(word));
    }

    const yako_variant* of_;
    yako_kept kept_;
};

} // namespace servobus::sim::detail
