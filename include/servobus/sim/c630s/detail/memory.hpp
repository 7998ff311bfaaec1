// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the parameters of the simulated C630S: as a read returns them, as they are in effect, and as the
// EEPROM keeps them; what may be written and when; and a log of the writes. Ranges, defaults and flags are
// those of the device's catalogue.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/bytes.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/sim/c630s/options.hpp>

namespace servobus::sim {

/// A write of one parameter of the simulated C630S.
struct c630s_write {
    std::uint16_t address = 0;
    std::int64_t value = 0;
    std::uint32_t ordinal = 0; ///< 1 for the first parameter that was written
};

namespace detail {

namespace coolmay = servobus::c630s;

class c630s_memory {
  public:
    static constexpr std::span<const entry> rows = coolmay::catalogue.entries;
    static constexpr std::size_t log_size = 64;

    constexpr explicit c630s_memory(const c630s_options& chosen)
        : servo_on_waits_{chosen.servo_on_waits_for_power_on} {}

    static constexpr bool covers(std::uint16_t address) { return slot(address) != none; }

    // Values

    /// The value that is in effect.
    constexpr std::int64_t operator[](std::uint16_t address) const {
        const std::size_t n = slot(address);
        return rows[n].number(in_force_[n]);
    }
    template <class Row> constexpr typename Row::value_type get(const Row& row) const {
        return from_bits<typename Row::value_type>(in_force_[slot(row.address)]);
    }
    template <class Row> constexpr bool is_on(const Row& row) const {
        return in_force_[slot(row.address)] != 0;
    }
    /// The value that a read returns.
    constexpr std::int64_t shown(std::uint16_t address) const {
        const std::size_t n = slot(address);
        return rows[n].number(shown_[n]);
    }
    /// Sets a value on behalf of the drive itself: it takes effect immediately and is not stored in the
    /// EEPROM.
    constexpr void set(std::uint16_t address, std::int64_t value) {
        const std::size_t n = slot(address);
        const auto bits = static_cast<std::uint64_t>(value);
        shown_[n] = static_cast<u32>(bits & (rows[n].words() == 2 ? 0xFFFF'FFFFu : 0xFFFFu));
        in_force_[n] = shown_[n];
        ++changes_;
    }
    /// How often a value has taken effect.
    constexpr std::uint32_t changes() const { return changes_; }

    // The bus

    /// Returns 0, or exception 2 if an address does not exist.
    constexpr std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) const {
        for (std::size_t i = 0; i < to.size(); ++i) {
            const auto at = static_cast<std::uint16_t>(address + i);
            const std::size_t n = slot(at);
            if (n == none) return illegal_address;
            const word_pair pair = split_words(shown_[n], current_word_order());
            to[i] = rows[n].words() == 1    ? static_cast<u16>(shown_[n])
                    : at == rows[n].address ? pair.first
                                            : pair.second;
        }
        return 0;
    }

    /// The exception of a write; 0 if it is allowed. Addresses are checked before values, values before the
    /// drive's state.
    constexpr std::uint8_t refuse_write(std::uint16_t address, words_view from, bool is_stopped) const {
        std::uint8_t refusal = each(address, from, [](std::size_t n, u32, std::size_t) {
            return rows[n].rights == access::ro ? illegal_address : std::uint8_t{0};
        });
        if (refusal != 0) return refusal;
        refusal = each(address, from, [](std::size_t n, u32 bits, std::size_t) {
            return accepts(rows[n], bits) ? std::uint8_t{0} : illegal_value;
        });
        if (refusal != 0 || is_stopped) return refusal;
        return each(address, from, [](std::size_t n, u32, std::size_t) {
            return has(rows[n].flags, when_stopped) ? refused : std::uint8_t{0};
        });
    }

    /// Calls `f(row number, bits, words)` for each parameter that a write concerns, until it returns a value
    /// other than 0. A single word of a 32-bit parameter is joined with its other word.
    template <class F> constexpr std::uint8_t each(std::uint16_t address, words_view from, const F& f) const {
        std::size_t used = 1;
        for (std::size_t i = 0; i < from.size(); i += used) {
            const auto at = static_cast<std::uint16_t>(address + i);
            const std::size_t n = slot(at);
            if (n == none) return illegal_address;
            used = 1;
            u32 bits = from[i];
            if (rows[n].words() == 2) {
                word_pair pair = split_words(shown_[n], current_word_order());
                const bool is_second = at != rows[n].address;
                (is_second ? pair.second : pair.first) = from[i];
                if (!is_second && i + 1 < from.size()) {
                    pair.second = from[i + 1];
                    used = 2;
                }
                bits = join_words(pair.first, pair.second, current_word_order());
            }
            const std::uint8_t refusal = f(n, bits, used);
            if (refusal != 0) return refusal;
        }
        return 0;
    }

    /// Takes a value that was accepted. It takes effect now or later, by its row's flags.
    constexpr void put(std::size_t n, u32 bits) {
        const entry& e = rows[n];
        shown_[n] = bits;
        log_[noted_ % log_size] = {e.address, e.number(bits), noted_ + 1};
        ++noted_;
        if (has(e.flags, after_power_cycle)) return;
        if (has(e.flags, at_stop)) {
            waits_for_stop_ = true;
        } else {
            in_force_[n] = bits;
            ++changes_;
        }
    }
    /// Stores a value in the EEPROM.
    constexpr void store(std::size_t n, u32 bits, std::size_t words) {
        eeprom_[n] = bits;
        eeprom_writes_ += static_cast<std::uint32_t>(words);
    }
    /// True if a write of this row is stored in the EEPROM, by P0C-13 and its group.
    constexpr bool wears_eeprom(std::size_t n) const {
        const unsigned group = rows[n].address >> 8;
        return is_on(coolmay::eeprom_update) && group != 0x0B && group != 0x0D;
    }

    /// If the motor is stopped, applies the values that waited for it, except for the terminals of S-ON.
    /// Returns true if a value changed.
    constexpr bool apply_at_stop_if(bool is_stopped) {
        if (!waits_for_stop_ || !is_stopped) return false;
        waits_for_stop_ = false;
        bool changes = false;
        for (std::size_t n = 0; n < rows.size(); ++n) {
            if (!has(rows[n].flags, at_stop) || shown_[n] == in_force_[n] || belongs_to_servo_on(n)) continue;
            in_force_[n] = shown_[n];
            changes = true;
            ++changes_;
        }
        return changes;
    }

    // Power and factory

    constexpr void make_new() {
        restore([](const entry&) { return true; });
        eeprom_[slot(coolmay::drive_number.address)] = 630;
        eeprom_[slot(coolmay::external_braking_resistor_power.address)] = 100;
        eeprom_[slot(coolmay::external_braking_resistance.address)] = 50;
        eeprom_writes_ = 0;
        power_on();
    }
    /// Power on: stored parameters are read from the EEPROM, the others get their defaults. `keeps_levels`:
    /// P31-00 is read from the EEPROM too. `is_reset`: a software restart, which does not apply values that
    /// wait for power-on.
    constexpr void power_on(bool keeps_levels = false, bool is_reset = false) {
        for (std::size_t n = 0; n < rows.size(); ++n) {
            const bool is_kept =
                has(rows[n].flags, saved_on_write) && (keeps_levels || rows[n].address >> 8 != 0x31);
            shown_[n] = is_kept ? eeprom_[n] : factory_bits(rows[n]);
            if (is_reset && (has(rows[n].flags, after_power_cycle) || belongs_to_servo_on(n))) continue;
            in_force_[n] = shown_[n];
        }
        waits_for_stop_ = false;
        set(coolmay::software_version.address, 24111);
        set(coolmay::min_braking_resistance.address, 25);
        set(coolmay::internal_braking_resistor_power.address, 60);
        set(coolmay::internal_braking_resistance.address, 40);
    }
    /// P02-31 = 1: writes the factory values to the EEPROM, except for the groups P00 and P01.
    constexpr void restore_factory() {
        restore([](const entry& e) { return e.address >= 0x0200; });
    }

    // What was written

    constexpr std::uint32_t eeprom_writes() const { return eeprom_writes_; }
    constexpr std::int64_t stored(std::uint16_t address) const {
        const std::size_t n = slot(address);
        return rows[n].number(eeprom_[n]);
    }
    constexpr std::uint32_t writes() const { return noted_; }
    /// True if a value waits for power-on.
    constexpr bool has_waiting() const {
        for (std::size_t n = 0; n < rows.size(); ++n) {
            if (has(rows[n].flags, after_power_cycle) && shown_[n] != in_force_[n]) return true;
        }
        return false;
    }
    /// The `back`-th last write, 0 for the latest; a default-constructed one if it is no longer in the log.
    constexpr c630s_write write(std::size_t back) const {
        return back < noted_ && back < log_size ? log_[(noted_ - 1 - back) % log_size] : c630s_write{};
    }

  private:
    static constexpr std::uint8_t illegal_address = 2;
    static constexpr std::uint8_t illegal_value = 3;
    static constexpr std::uint8_t refused = 4;
    static constexpr std::uint16_t none = 0xFFFF;
    static constexpr std::size_t count = rows.size();

    // The row of each address, at the group's number times 100 plus the parameter's number.
    static constexpr std::size_t groups = 0x32;
    static constexpr std::size_t numbers = 100; // of each group
    static constexpr std::array<std::uint16_t, groups* numbers> index = [] {
        std::array<std::uint16_t, groups * numbers> of{};
        for (std::uint16_t& i : of) i = none;
        for (std::size_t n = 0; n != rows.size(); ++n) {
            for (std::size_t word = 0; word != rows[n].words(); ++word) {
                const std::size_t address = rows[n].address + word;
                of[(address >> 8) * numbers + (address & 0xFFu)] = static_cast<std::uint16_t>(n);
            }
        }
        return of;
    }();

    static constexpr std::size_t slot(std::uint16_t address) {
        const unsigned group = address >> 8;
        const unsigned number = address & 0xFFu;
        return group < groups && number < numbers ? index[group * numbers + number] : none;
    }

    constexpr word_order current_word_order() const {
        return is_on(coolmay::pair_word_order) ? word_order::low_first : word_order::high_first;
    }

    // Three rows have holes in their range.
    static constexpr bool accepts(const entry& e, u32 bits) {
        const std::int64_t value = e.number(bits);
        if (!e.limits.contains(value)) return false;
        switch (e.address) {
        case coolmay::pulse_command_form.address: return value != 3;
        case coolmay::homing_control.address: return value != 7;
        case coolmay::auxiliary_speed_source.address: return value != 4;
        default: return true;
        }
    }

    // A change of S-ON's terminal or its logic waits for the next power-on [errata C15].
    constexpr bool belongs_to_servo_on(std::size_t n) const {
        const std::uint16_t address = rows[n].address;
        const bool is_di = address >= coolmay::di1_function.address && address <= coolmay::di8_logic.address;
        const bool is_vdi = address >= coolmay::virtual_input_functions[0].address &&
                            address <= coolmay::virtual_input_logics[15].address;
        if (!servo_on_waits_ || (!is_di && !is_vdi)) return false;
        const std::size_t function = address % 2 == 0 ? n : n - 1; // the logic is the row after its function
        constexpr auto servo_on = static_cast<u32>(coolmay::input_function::servo_on);
        return in_force_[function] == servo_on || shown_[function] == servo_on;
    }

    static constexpr u32 factory_bits(const entry& e) {
        if (e.initial == no_default) return 0;
        const auto bits = static_cast<std::uint64_t>(e.initial);
        return static_cast<u32>(bits & (e.words() == 2 ? 0xFFFF'FFFFu : 0xFFFFu));
    }

    template <class F> constexpr void restore(const F& which) {
        for (std::size_t n = 0; n < rows.size(); ++n) {
            if (!has(rows[n].flags, saved_on_write) || !which(rows[n])) continue;
            if (rows[n].initial != no_default) store(n, factory_bits(rows[n]), rows[n].words());
        }
    }

    std::array<u32, count> shown_{};
    std::array<u32, count> in_force_{};
    std::array<u32, count> eeprom_{};
    std::array<c630s_write, log_size> log_{};
    std::uint32_t noted_ = 0;
    std::uint32_t eeprom_writes_ = 0;
    std::uint32_t changes_ = 0;
    bool waits_for_stop_ = false;
    bool servo_on_waits_;
};

} // namespace detail
} // namespace servobus::sim
