// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The register memory of the simulated ZLAC8015D: which addresses exist and what may be written to them, the
// volatile words and their copies in the EEPROM, and what was written in which order. Ranges, defaults and
// access are those of the device's catalogue.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/bytes.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::sim {

/// One register as it was written.
struct logged_write {
    std::uint16_t address = 0;
    std::uint16_t value = 0;
    std::uint32_t ordinal = 0; ///< 1 for the first word ever written
};

namespace detail {

class zlac8015d_memory {
  public:
    static constexpr std::uint16_t first = 0x2000;
    static constexpr std::size_t size = 0xB1; ///< 2000h .. 20B0h
    static constexpr std::size_t log_size = 64;

    static constexpr bool covers(std::uint16_t address) {
        return address >= first && address - first < static_cast<int>(size) && index[slot(address)] != none;
    }

    constexpr std::uint16_t operator[](std::uint16_t address) const { return words_[slot(address)]; }
    constexpr void set(std::uint16_t address, std::uint16_t word) { words_[slot(address)] = word; }
    constexpr std::int32_t pair(std::uint16_t address) const {
        return static_cast<std::int32_t>(
            join_words(words_[slot(address)], words_[slot(address) + 1], word_order::high_first));
    }
    constexpr void set_pair(std::uint16_t address, std::int32_t value) {
        const word_pair pair = split_words(static_cast<std::uint32_t>(value), word_order::high_first);
        set(address, pair.first);
        set(static_cast<std::uint16_t>(address + 1), pair.second);
    }

    /// The exception that a read of these registers meets, 0 if none.
    static constexpr std::uint8_t refuse_read(std::uint16_t address, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            if (!covers(static_cast<std::uint16_t>(address + i))) return illegal_address;
        }
        return 0;
    }

    /// The exception that a write meets, 0 if none. Addresses are judged before values.
    static constexpr std::uint8_t refuse_write(std::uint16_t address, words_view from) {
        for (std::size_t i = 0; i < from.size(); ++i) {
            const auto at = static_cast<std::uint16_t>(address + i);
            if (!covers(at) || row(at).rights == access::ro) return illegal_address;
        }
        for (std::size_t i = 0; i < from.size(); ++i) {
            const entry& e = row(static_cast<std::uint16_t>(address + i));
            if (e.words() == 1) {
                if (!accepts(e, from[i])) return illegal_value;
            } else if (e.address == address + i && i + 1 < from.size()) {
                if (!accepts(e, join_words(from[i], from[i + 1], word_order::high_first)))
                    return illegal_value;
            }
        }
        return 0;
    }

    constexpr void note(std::uint16_t address, std::uint16_t value) {
        ++written_[slot(address)];
        log_[noted_ % log_size] = {address, value, noted_ + 1};
        ++noted_;
    }
    constexpr std::uint32_t writes_to(std::uint16_t address) const {
        return covers(address) ? written_[slot(address)] : 0;
    }
    constexpr std::uint32_t writes() const { return noted_; }
    /// The `back`-th last write, 0 the latest; a default-made one if it is too long ago.
    constexpr logged_write write(std::size_t back) const {
        return back < noted_ && back < log_size ? log_[(noted_ - 1 - back) % log_size] : logged_write{};
    }

    /// Power comes on: what is saved comes from the EEPROM, the rest has its default.
    constexpr void power_on() {
        words_ = {};
        fill(words_, [](const entry&) { return true; });
        for (const entry& e : rows) {
            if (has(e.flags, saved)) words_[slot(e.address)] = eeprom_[slot(e.address)];
        }
    }
    /// The EEPROM of a new drive.
    constexpr void make_new() {
        fill(eeprom_, [](const entry& e) { return has(e.flags, saved); });
        power_on();
    }
    /// Factory defaults, in the EEPROM too; mode and control word stay.
    constexpr void restore() {
        fill(eeprom_, [](const entry& e) { return has(e.flags, saved); });
        for (const entry& e : rows) eeprom_writes_ += has(e.flags, saved) ? 1u : 0u;
        fill(words_, [](const entry& e) { return e.rights != access::ro && !is_state(e.address); });
    }
    /// Every register that is marked RW/S into the EEPROM.
    constexpr void save() {
        for (const entry& e : rows) {
            if (!has(e.flags, saved)) continue;
            eeprom_[slot(e.address)] = words_[slot(e.address)];
            ++eeprom_writes_;
        }
        ++saves_;
    }
    constexpr std::uint32_t eeprom_writes() const { return eeprom_writes_; }
    constexpr std::uint32_t saves() const { return saves_; }

  private:
    static constexpr auto illegal_address =
        static_cast<std::uint8_t>(modbus::exception::illegal_data_address);
    static constexpr auto illegal_value = static_cast<std::uint8_t>(modbus::exception::illegal_data_value);
    static constexpr std::uint8_t none = 0xFF;
    static constexpr std::span<const entry> rows = servobus::zlac8015d::catalogue.entries;

    // The catalogue's entry for each address.
    static constexpr std::array<std::uint8_t, size> index = [] {
        std::array<std::uint8_t, size> of{};
        for (std::uint8_t& i : of) i = none;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            for (std::size_t word = 0; word < rows[i].words(); ++word)
                of[rows[i].address - first + word] = static_cast<std::uint8_t>(i);
        }
        return of;
    }();

    static constexpr std::size_t slot(std::uint16_t address) { return std::size_t{address} - first; }
    static constexpr const entry& row(std::uint16_t address) { return rows[index[slot(address)]]; }
    static constexpr bool is_state(std::uint16_t address) { return address == 0x200D || address == 0x200E; }

    // Of the codes only the control word's have holes in their range.
    static constexpr bool accepts(const entry& e, std::uint32_t bits) {
        if (!e.limits.contains(e.number(bits))) return false;
        if (e.address != servobus::zlac8015d::control_word.address) return true;
        for (const named_value& v : e.values) {
            if (v.applies(bits)) return true;
        }
        return false;
    }

    static constexpr void fill(std::array<std::uint16_t, size>& to, bool (*which)(const entry&)) {
        for (const entry& e : rows) {
            if (e.initial == no_default || !which(e)) continue;
            const auto bits = static_cast<std::uint32_t>(static_cast<std::uint64_t>(e.initial));
            const std::size_t at = slot(e.address);
            to[at] = static_cast<std::uint16_t>(e.words() == 2 ? bits >> 16 : bits & 0xFFFFu);
            if (e.words() == 2) to[at + 1] = static_cast<std::uint16_t>(bits & 0xFFFFu);
        }
    }

    std::array<std::uint16_t, size> words_{};
    std::array<std::uint16_t, size> eeprom_{};
    std::array<std::uint32_t, size> written_{};
    std::array<logged_write, log_size> log_{};
    std::uint32_t noted_ = 0;
    std::uint32_t eeprom_writes_ = 0;
    std::uint32_t saves_ = 0;
};

} // namespace detail
} // namespace servobus::sim
