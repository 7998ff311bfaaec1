// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Tables of all registers of a device with their names, in one type and in address order. Tools, tests and
// the catalogues of the devices include it; programs on a target do not.
//
//     constexpr const entry* e = zlac8015d::catalogue.find(0x20A1);
//     static_assert(e->rights == access::ro && e->kind == value_kind::unsigned_word);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include <servobus/registers/descriptions.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>
#include <servobus/registers/value_form.hpp>

namespace servobus {

/// The type of a register's value. The four first are those of drives; registers/value_types.hpp has the others.
enum class value_kind : std::uint8_t {
    unsigned_word,
    signed_word,
    unsigned_pair,
    signed_pair,
    unsigned_quad,
    signed_quad,
    float_pair,
    float_quad,
    bcd_word,
    bcd_pair,
    sign_magnitude_word,
    sign_magnitude_pair,
    text,
};

/// The type's name in a map.
constexpr const char* text(value_kind k) {
    constexpr const char* names[] = {"u16", "i16",   "u32",   "i32",  "u64",  "i64", "f32",
                                     "f64", "bcd16", "bcd32", "sm16", "sm32", "text"};
    return names[static_cast<unsigned>(k)];
}
/// The words of a value; 0 for a text, which states them itself.
constexpr std::size_t words_of(value_kind k) {
    constexpr std::uint8_t words[] = {1, 1, 2, 2, 4, 4, 2, 4, 1, 2, 1, 2, 0};
    return words[static_cast<unsigned>(k)];
}
constexpr const char* text(access a) {
    constexpr const char* names[] = {"ro", "rw", "wo"};
    return names[static_cast<unsigned>(a)];
}

/// A name for a value of a register's field. It applies if `(bits & mask) == value`. A mask of 16 bits, 0xFFFF, is for
/// the whole value, also that of a pair. A coil's value above 1 is a word that function 05 sends.
struct named_value {
    u32 mask;
    u32 value;
    const char* name;

    constexpr bool is_whole() const { return mask == 0xFFFF; }
    constexpr bool applies(u32 bits) const { return is_whole() ? bits == value : (bits & mask) == value; }
};

/// Names a code: a value of the whole register.
constexpr named_value code(u32 value, const char* name) { return {0xFFFF, value, name}; }
/// Names a bit, or a mask of which all bits are set.
constexpr named_value named_bit(u32 mask, const char* name) { return {mask, mask, name}; }
/// Names a value of the bits in `mask`.
constexpr named_value field(u32 mask, u32 value, const char* name) { return {mask, value, name}; }

/// How a register's word is formatted as text.
enum class naming : std::uint8_t {
    number, ///< as a number with the register's unit
    names, ///< as the names of all `values` that apply; if none does, in hexadecimal, or with the unit if it has one
    halves, ///< as two bytes with the register's unit, the left axis in the high byte
};

/// A register's name. It stores its text, since the compiler composes the names of array elements.
class label {
  public:
    static constexpr std::size_t longest = 47;

    constexpr label() = default;
    constexpr label(const char* whole) { append(whole); } // NOLINT: implicit, a name is written as a text
    /// Joins a name from its parts: `position_segment_`, 3 and `_speed` give `position_segment_3_speed`.
    constexpr label(const char* before, unsigned number, const char* behind) {
        append(before);
        if (number >= 10) append(static_cast<char>('0' + number / 10 % 10));
        append(static_cast<char>('0' + number % 10));
        append(behind);
    }

    constexpr operator const char*() const { return text_; } // NOLINT: implicit, a label is a text

  private:
    // Not constexpr on purpose: a constant label that calls it does not compile.
    static void a_name_has_at_most_47_characters() {}
    constexpr void append(const char* more) {
        while (*more != '\0') append(*more++);
    }
    constexpr void append(char c) {
        if (used_ == longest) return a_name_has_at_most_47_characters(); // at run time the rest is cut off
        text_[used_++] = c;
    }

    char text_[longest + 1]{};
    std::size_t used_ = 0;
};

/// A register with its name. `limits` and `initial` are raw values; see `reg`.
struct entry {
    u16 address;
    label name;
    value_kind kind;
    access rights;
    range limits;
    std::int64_t initial;
    unit unit_of_count;
    flag flags;
    naming names = naming::number;
    std::span<const named_value> values{};
    /// Of a pair whose word order is not that of its device; `unknown`: that of the profile.
    word_order own_word_order = word_order::unknown;
    const value_form* form = nullptr; ///< null: the type says all

    constexpr std::size_t words() const {
        return kind == value_kind::text && form != nullptr ? form->words : words_of(kind);
    }
    /// True for some bits of a register, of which other entries may be parts too.
    constexpr bool is_part() const { return form != nullptr && form->is_part(); }
    /// The symbol of its unit, which may be the device's own; empty without a unit.
    constexpr const char* unit_symbol() const {
        return form != nullptr && form->symbol != nullptr ? form->symbol : symbol(unit_of_count.of);
    }
    constexpr bool is_signed() const {
        return kind == value_kind::signed_word || kind == value_kind::signed_pair;
    }

    /// A number, perhaps with names for some of its values: 0..100 %, and 255 is `no limit`.
    constexpr bool is_quantity() const { return names != naming::names || unit_of_count != unit{}; }
    /// True for a value that has a name of its own, as a whole.
    constexpr bool is_code(std::int64_t count) const {
        for (const named_value& v : values) {
            if (v.is_whole() && number(v.value) == count) return true;
        }
        return false;
    }
    /// True for what may be written: a value of the range, or a code.
    constexpr bool takes(std::int64_t count) const { return limits.contains(count) || is_code(count); }

    /// The number that the raw bits encode.
    constexpr std::int64_t number(u32 bits) const {
        switch (kind) {
        case value_kind::signed_word: return static_cast<i16>(static_cast<u16>(bits));
        case value_kind::signed_pair: return static_cast<i32>(bits);
        default: return bits;
        }
    }
};

namespace detail {
// The hooks of registers/value_forms.hpp.
template <class T> inline constexpr value_kind kind_of_coded = value_kind::unsigned_word;
template <class T> struct form_of {
    static_assert(
        sizeof(T) == 0,
        "a catalogue with floats, 64 bits, text or parts: include servobus/registers/value_forms.hpp");
};
template <class T> constexpr value_kind kind_of() {
    if constexpr (std::is_same_v<T, i16> || std::is_same_v<T, left_right<std::int8_t>>) {
        return value_kind::signed_word;
    } else if constexpr (std::is_same_v<T, u32>) {
        return value_kind::unsigned_pair;
    } else if constexpr (std::is_same_v<T, i32>) {
        return value_kind::signed_pair;
    } else if constexpr (has_codec<T>) {
        return form_of<T>::kind;
    } else {
        return value_kind::unsigned_word;
    }
}
} // namespace detail

/// The catalogue's entry of a row. A row that contradicts itself does not compile.
template <class T, access A, class D>
constexpr entry list(label name, const reg<T, A, D>& row, naming names = naming::number,
                     std::span<const named_value> values = {}) {
    detail::check_row(row);
    entry e{row.address, name,        detail::kind_of<T>(), A,
            row.limits,  row.initial, row.unit_of_count,    row.flags,
            names,       values};
    if constexpr (detail::has_codec<T>) {
        if (!row.limits.is_stated) e.limits = full<T>;
        e.form = detail::form_of<T>::form;
        e.own_word_order = detail::form_of<T>::own_word_order;
    }
    return e;
}

/// The catalogue's entries of an array of rows. Their names are numbered from 1, as in the manuals:
/// `list("position_segment_", speeds, "_speed")` begins with `position_segment_1_speed`.
template <class Row, std::size_t Count>
consteval std::array<entry, Count> list(const char* before, const reg_array<Row, Count>& rows,
                                        const char* behind = "", naming names = naming::number,
                                        std::span<const named_value> values = {}) {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return std::array<entry, Count>{
            list(label{before, static_cast<unsigned>(I + 1), behind}, rows[I], names, values)...};
    }
    (std::make_index_sequence<Count>{});
}

namespace detail {
template <class Part> struct entry_count { static constexpr std::size_t value = 1; };
template <std::size_t N> struct entry_count<std::array<entry, N>> { static constexpr std::size_t value = N; };
} // namespace detail

/// Joins entries and arrays of entries to one array in address order.
template <class... Parts> consteval auto in_address_order(const Parts&... parts) {
    constexpr std::size_t count = (detail::entry_count<Parts>::value + ...);
    std::array<const entry*, count> order{};
    std::size_t used = 0;
    const auto take = [&](const auto& part) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(part)>, entry>) {
            order[used++] = &part;
        } else {
            for (const entry& e : part) order[used++] = &e;
        }
    };
    (take(parts), ...);
    for (std::size_t i = 1; i < count; ++i) {
        const entry* const moved = order[i];
        std::size_t j = i;
        for (; j > 0 && order[j - 1]->address > moved->address; --j) order[j] = order[j - 1];
        order[j] = moved;
    }
    return [&]<std::size_t... I>(std::index_sequence<I...>) { return std::array<entry, count>{*order[I]...}; }
    (std::make_index_sequence<count>{});
}

/// A device's profile and all its registers.
struct catalogue {
    const profile* device;
    std::span<const entry> entries;              ///< in address order
    std::span<const description> descriptions{}; ///< in address order, one for each entry; or none at all

    /// The entry of the register at `address`, which may be any word of its value; null if there is none. Of the parts
    /// of a register, whose entries follow each other, the first.
    constexpr const entry* find(u16 address) const {
        std::size_t low = 0;
        std::size_t high = entries.size();
        while (low < high) {
            std::size_t middle = low + (high - low) / 2;
            const entry& e = entries[middle];
            if (address < e.address) {
                high = middle;
            } else if (address >= e.address + e.words()) {
                low = middle + 1;
            } else { // the first of the parts of a register
                while (middle != 0 && entries[middle - 1].address == e.address) --middle;
                return &entries[middle];
            }
        }
        return nullptr;
    }

    /// What the register at `address`, which may be either word of a pair, does. Empty if the catalogue has no
    /// sentence about it.
    constexpr const char* sentence(u16 address) const {
        const entry* const e = find(address);
        return e == nullptr ? "" : sentence_of(descriptions, e->address);
    }
    /// The sentence of an entry of this catalogue.
    constexpr const char* sentence(const entry& of) const {
        return descriptions.empty() ? ""
                                    : descriptions[static_cast<std::size_t>(&of - entries.data())].sentence;
    }
};

/// True if the addresses ascend and no entry overlaps the next. Parts of one register share its address, and no bit.
constexpr bool is_in_order(std::span<const entry> entries) {
    unsigned taken = 0; // bits of the register, by its parts so far
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const entry& e = entries[i];
        const bool shares =
            i != 0 && e.address == entries[i - 1].address && e.is_part() && entries[i - 1].is_part();
        if (i != 0 && !shares && e.address < entries[i - 1].address + entries[i - 1].words()) return false;
        if (!shares) taken = 0;
        if (!e.is_part()) continue;
        if ((taken & e.form->mask()) != 0) return false;
        taken |= e.form->mask();
    }
    return true;
}

/// True if each entry has exactly one description and no description is without an entry.
constexpr bool is_described(std::span<const entry> entries, std::span<const description> descriptions) {
    if (entries.size() != descriptions.size()) return false;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (entries[i].address != descriptions[i].address) return false;
    }
    return true;
}

} // namespace servobus
