// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The material of `servobus doctor`: the registers of a drive as they were read, and tables of checks over them. A
// check is a row: how bad it is, the registers, when it applies, why it matters, and what mends it. Nothing here reads
// or writes, so that a test judges registers that it has made.
//
//     constexpr check brakes_off[] = {
//         {matters, {zlac8015d::parking_mode}, is_set, "the wheels cannot be pushed", {.write = "parking_mode=off"}}};
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/line_choices.hpp>

namespace tool::diagnosis {

using servobus::u16;
using servobus::u32;

/// How the line is used.
struct line_facts {
    std::uint32_t baud = 0; ///< bits a second; 0: it is not known, or there is no wire
    servobus::character_format format = servobus::character_format::n81;
    std::uint8_t node = 1;
    u32 response_ms = 100;   ///< how long a program waits for a response, if it sets no limit of its own
    u32 quarantine_ms = 100; ///< and after one that did not come
    u32 period_ms = 0;       ///< how often a program is to send a setpoint; 0: it is not known
};

/// The words of registers by address. The high word of a pair is at its lower address.
class held_registers {
  public:
    line_facts on{};

    void put(u16 address, u16 word) { words_[address] = word; }
    bool has(u16 address) const { return words_.contains(address); }
    /// 0 if it was not read.
    u16 word(u16 address) const {
        const auto found = words_.find(address);
        return found == words_.end() ? u16{0} : found->second;
    }
    u32 pair(u16 address) const {
        return servobus::join_words(word(address), word(static_cast<u16>(address + 1)),
                                    servobus::word_order::high_first);
    }
    template <class Row>
    requires requires(const Row& row) { row.address; }
    u16 word(const Row& row) const { return word(row.address); }
    template <class Row> std::int16_t number(const Row& row) const {
        return static_cast<std::int16_t>(word(row.address));
    }

  private:
    std::map<u16, u16> words_{};
};

enum class severity : std::uint8_t {
    refuses, ///< an enable does not succeed
    matters, ///< the motor does not turn, or otherwise than meant, or the line is lost
};
using enum severity;

/// The addresses of up to four registers; the first gives a finding its name.
class watched {
  public:
    template <class... Rows>
    constexpr watched(const Rows&... rows) // NOLINT: implicit, a table names its registers
        : all_{rows.address...}, size_{sizeof...(Rows)} {
        static_assert(sizeof...(Rows) <= most);
    }
    /// The same by their addresses.
    static constexpr watched at(std::initializer_list<u16> addresses) {
        watched w;
        for (const u16 a : addresses) w.all_[w.size_++] = a;
        return w;
    }
    constexpr std::span<const u16> all() const { return {all_.data(), size_}; }
    constexpr u16 operator[](std::size_t i) const { return all_[i]; }

  private:
    static constexpr std::size_t most = 4;
    std::array<u16, most> all_{};
    std::size_t size_ = 0;
};

/// A register and the content that it is to have; of a pair the high word is the upper half.
struct new_value {
    u16 address;
    u32 bits;

    friend bool operator==(const new_value&, const new_value&) = default;
};

struct check;
using condition = bool (*)(const held_registers&, const check&);
using phrase = std::string (*)(const held_registers&, const check&);
using new_values = std::vector<new_value> (*)(const held_registers&, const check&);

/// The way to mend a finding.
struct mend {
    const char* act = "";         ///< what a person does, a clause; empty: nothing besides the command
    const char* write = "";       ///< `REG=VALUE ...` for `servobus write`; empty: none
    new_values compose = nullptr; ///< the same, where it depends on what was read; may give none
};

struct check {
    severity is;
    watched of;
    condition applies;
    const char* why;
    mend by{};
    phrase more = nullptr; ///< sentences after `why`, of what was read
    u16 value = 0;         ///< what `applies` compares with
    /// The registers that show it, where that depends on what was read; null: `of`.
    watched (*shown_by)(const held_registers&, const check&) = nullptr;
    /// Registers that have to hold something else: the finding says how many, and they are listed where a person asks
    /// for it.
    new_values differing = nullptr;
};

/// The checks of a device, and what they read besides the registers that they name.
struct check_list {
    std::span<const check> checks;
    std::span<const u16> also{};
    std::span<const u16> needed{}; ///< to judge whether an enable is refused
};

// Conditions that several tables use

inline bool is_set(const held_registers& r, const check& c) { return r.word(c.of[0]) != 0; }
inline bool is_zero(const held_registers& r, const check& c) { return r.word(c.of[0]) == 0; }
inline bool is_value(const held_registers& r, const check& c) { return r.word(c.of[0]) == c.value; }
inline bool is_above(const held_registers& r, const check& c) { return r.word(c.of[0]) > c.value; }
inline bool is_pair_zero(const held_registers& r, const check& c) { return r.pair(c.of[0]) == 0; }
/// The first of two registers holds another word than the second one.
inline bool differs(const held_registers& r, const check& c) { return r.word(c.of[0]) != r.word(c.of[1]); }
inline bool exceeds_second(const held_registers& r, const check& c) {
    return r.word(c.of[0]) > r.word(c.of[1]);
}

/// A register that keeps the rate, or the format, of the line has another one than the line is used with.
template <class Device> bool has_other_rate(const held_registers& r, const check& c) {
    for (const servobus::rate_choice& choice : Device::on_line.rates) {
        if (choice.code == r.word(c.of[0])) return r.on.baud != 0 && choice.baud != r.on.baud;
    }
    return r.on.baud != 0;
}
template <class Device> bool has_other_format(const held_registers& r, const check& c) {
    for (const servobus::format_choice& choice : Device::on_line.formats) {
        if (choice.code == r.word(c.of[0])) return r.on.baud != 0 && choice.format != r.on.format;
    }
    return r.on.baud != 0;
}

/// `0x0040`
inline std::string hex_of(u16 word) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text = "0x";
    for (int shift = 12; shift >= 0; shift -= 4) text += digits[word >> shift & 15];
    return text;
}

// Writes that mend, for several tables

/// The code of the rate, or the format, that the line is used with.
template <class Device> std::vector<new_value> rate_in_use(const held_registers& r, const check& c) {
    for (const servobus::rate_choice& choice : Device::on_line.rates) {
        if (choice.baud == r.on.baud) return {{c.of[0], choice.code}};
    }
    return {};
}
template <class Device> std::vector<new_value> format_in_use(const held_registers& r, const check& c) {
    for (const servobus::format_choice& choice : Device::on_line.formats) {
        if (choice.format == r.on.format) return {{c.of[0], choice.code}};
    }
    return {};
}
/// The content of the second register for the first one, and the other way round.
inline std::vector<new_value> second_to_first(const held_registers& r, const check& c) {
    return {{c.of[0], r.word(c.of[1])}};
}
inline std::vector<new_value> first_to_second(const held_registers& r, const check& c) {
    return {{c.of[1], r.word(c.of[0])}};
}

/// Finds the checks that apply. A check of which a register could not be read is left out.
inline std::vector<const check*> find(const check_list& list, const held_registers& r) {
    std::vector<const check*> found;
    for (const check& c : list.checks) {
        bool is_known = true;
        for (const u16 address : c.of.all()) is_known = is_known && r.has(address);
        if (is_known && c.applies(r, c)) found.push_back(&c);
    }
    return found;
}

inline bool has_refusal(std::span<const check* const> found) {
    for (const check* c : found) {
        if (c->is == refuses) return true;
    }
    return false;
}

/// The rows of all registers that a list reads, in address order.
inline std::vector<const servobus::entry*> rows_of(const check_list& list, const servobus::catalogue& map) {
    std::map<u16, const servobus::entry*> rows;
    const auto add = [&](u16 address) {
        if (const servobus::entry* e = map.find(address)) rows[e->address] = e;
    };
    for (const check& c : list.checks) {
        for (const u16 address : c.of.all()) add(address);
    }
    for (const u16 address : list.also) add(address);
    for (const u16 address : list.needed) add(address);
    std::vector<const servobus::entry*> all;
    for (const auto& [address, row] : rows) all.push_back(row);
    return all;
}

} // namespace tool::diagnosis
