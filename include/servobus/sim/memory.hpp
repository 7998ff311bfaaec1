// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register memory for simulated drives: which addresses exist, the volatile words and their copies in the
// EEPROM, and a log of the writes. The memory of each drive is derived from it and decides what may be written
// and what is kept (tests/run/sim/memory.cpp has a small one). Tests read the log:
//
//     struct memory : servobus::sim::register_memory<0x0010, 8> { // 0010h .. 0017h
//         memory() : register_memory{index} { fill([](const servobus::entry&) { return true; }); } // defaults
//     };
//     const bool is_enable = drive.last_write().address == 0x200E && drive.last_write().value == 8;
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/registers/catalogue.hpp>

namespace servobus::sim {

/// A write of one register.
struct logged_write {
    std::uint16_t address = 0;
    std::uint16_t value = 0;
    std::uint32_t ordinal = 0; ///< 1 for the first word that was written
};

/// Finds the catalogue's entry of each of `Size` addresses from `First`. All rows, 254 at most, are among these
/// addresses.
template <std::uint16_t First, std::size_t Size> class register_index {
  public:
    constexpr explicit register_index(std::span<const entry> rows) : rows_{rows} {
        for (std::uint8_t& i : of_) i = none;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            for (std::size_t word = 0; word < rows[i].words(); ++word)
                of_[rows[i].address - First + word] = static_cast<std::uint8_t>(i);
        }
    }

    constexpr std::span<const entry> rows() const { return rows_; }
    constexpr bool covers(std::uint16_t address) const {
        return address >= First && address - First < static_cast<int>(Size) && of_[address - First] != none;
    }
    /// The entry of an address that exists: ask `covers` first.
    constexpr const entry& row(std::uint16_t address) const { return rows_[of_[address - First]]; }

  private:
    static constexpr std::uint8_t none = 0xFF;

    std::span<const entry> rows_;
    std::array<std::uint8_t, Size> of_{};
};

/// The words of `Size` addresses from `First`, volatile and in an EEPROM. 32-bit values are stored with the high
/// word first. Calls with an address want one of these; only `writes_to` takes any. It refers to its index,
/// which must outlive it. A drive derives from it: the protected functions are what a power-on, a save and a
/// restore of the factory's values are made of, each for the rows that a `choice` takes.
template <std::uint16_t First, std::size_t Size> class register_memory {
  public:
    using map = register_index<First, Size>;
    static constexpr std::size_t log_size = 64;

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

    /// Counts a word that a client has written, and puts it into the log.
    constexpr void note(std::uint16_t address, std::uint16_t value) {
        ++written_[slot(address)];
        log_[noted_ % log_size] = {address, value, noted_ + 1};
        ++noted_;
    }
    constexpr std::uint32_t writes_to(std::uint16_t address) const {
        return index_->covers(address) ? written_[slot(address)] : 0;
    }
    constexpr std::uint32_t writes() const { return noted_; }
    /// The `back`-th last write, 0 for the latest; a default-constructed one if it is no longer in the log.
    constexpr logged_write write(std::size_t back) const {
        return back < noted_ && back < log_size ? log_[(noted_ - 1 - back) % log_size] : logged_write{};
    }
    /// Rows that were kept, and how often `keep` was called.
    constexpr std::uint32_t eeprom_writes() const { return eeprom_writes_; }
    constexpr std::uint32_t saves() const { return saves_; }

  protected:
    using choice = bool (*)(const entry&);

    constexpr explicit register_memory(const map& index) : index_{&index} {}

    /// Volatile words become 0.
    constexpr void clear() { words_ = {}; }
    /// Sets the chosen rows to their defaults, where the manual gives one.
    constexpr void fill(choice which) { fill(words_, which); }
    /// The same in the EEPROM. Returns how many rows were chosen.
    constexpr std::uint32_t fill_eeprom(choice which) {
        fill(eeprom_, which);
        std::uint32_t chosen = 0;
        for (const entry& e : index_->rows()) chosen += which(e) ? 1u : 0u;
        return chosen;
    }
    /// Counts writes of the EEPROM besides those of `keep`.
    constexpr void wear(std::uint32_t writes) { eeprom_writes_ += writes; }

    /// Sets a word of the EEPROM alone.
    constexpr void set_eeprom(std::uint16_t address, std::uint16_t word) { eeprom_[slot(address)] = word; }
    /// Copies the chosen rows from the EEPROM.
    constexpr void recall(choice which) {
        for (const entry& e : index_->rows()) {
            if (which(e)) copy(e, eeprom_, words_);
        }
    }
    /// Copies the chosen rows into the EEPROM.
    constexpr void keep(choice which) {
        for (const entry& e : index_->rows()) {
            if (!which(e)) continue;
            copy(e, words_, eeprom_);
            ++eeprom_writes_;
        }
        ++saves_;
    }

  private:
    using words = std::array<std::uint16_t, Size>;

    static constexpr std::size_t slot(std::uint16_t address) { return std::size_t{address} - First; }
    static constexpr void copy(const entry& e, const words& from, words& to) {
        for (std::size_t i = 0; i < e.words(); ++i) to[slot(e.address) + i] = from[slot(e.address) + i];
    }
    constexpr void fill(words& to, choice which) {
        for (const entry& e : index_->rows()) {
            if (e.initial == no_default || !which(e)) continue;
            const auto bits = static_cast<std::uint32_t>(static_cast<std::uint64_t>(e.initial));
            const std::size_t at = slot(e.address);
            to[at] = static_cast<std::uint16_t>(e.words() == 2 ? bits >> 16 : bits & 0xFFFFu);
            if (e.words() == 2) to[at + 1] = static_cast<std::uint16_t>(bits & 0xFFFFu);
        }
    }

    const map* index_;
    words words_{};
    words eeprom_{};
    std::array<std::uint32_t, Size> written_{};
    std::array<logged_write, log_size> log_{};
    std::uint32_t noted_ = 0;
    std::uint32_t eeprom_writes_ = 0;
    std::uint32_t saves_ = 0;
};

} // namespace servobus::sim
