// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the table that the compiler makes of a server's rows. It is sorted by table and address, and each row has
// the place of its value. A row takes 4 bytes of flash. The range of a writable register takes 4, or 8 if it has two
// words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/block.hpp>
#include <servobus/registers/tables.hpp>
#include <servobus/server/computed.hpp>

namespace servobus::detail {

/// A row as it stays in flash.
struct served_row {
    static constexpr u16 two_words = 1; // a 0 or 1 that is added to numbers of words
    static constexpr u16 no_read = 2;
    static constexpr u16 no_write = 4;
    static constexpr u16 is_computed = 8;
    static constexpr u16 ends_run = 16; // the next address is not a row of its table
    static constexpr unsigned slot_at = 5;
    static constexpr std::size_t most_slots = 0x1'0000 >> slot_at;

    u16 address;
    u16 kind; // the bits above, and the slot of its value among those of its kind

    constexpr bool is(u32 bits) const { return (kind & bits) != 0; }
    constexpr unsigned slot() const { return kind >> slot_at; }
};

/// The range of a writable register. One comparison checks signed and unsigned values.
template <class Int> struct served_range {
    Int low;
    Int span; // highest - lowest

    constexpr bool contains(Int v) const { return static_cast<Int>(v - low) <= span; }
};

/// The storage of a value: words of two registers, of one, bits, or functions.
enum class pool : std::uint8_t { wide, narrow, bits, functions };
inline constexpr std::size_t pools = 4;

template <class T> struct type_tag { static constexpr char here = 0; };

/// A row as the compiler collects it.
struct plain_row {
    const char* type = nullptr; // an address for each class of rows
    table of{};
    pool in{};
    access rights{};
    bool is_pair = false; // two words
    bool ends_run = true;
    u16 address = 0;
    u16 slot = 0;
    std::int64_t low = 0, high = 0, initial = 0;

    constexpr u32 key() const { return static_cast<u32>(of) << 16 | address; }
    constexpr u32 end() const { return key() + (is_pair ? 2 : 1); }
};

// An element of a server's pack: a row, an array of rows or a computed row.
template <class Entry> struct served_entry {
    using row = Entry;
    static constexpr std::size_t size = 1;
    static constexpr bool is_computed = false;
};
template <class Row, std::size_t N> struct served_entry<reg_array<Row, N>> {
    using row = Row;
    static constexpr std::size_t size = N;
    static constexpr bool is_computed = false;
};
template <const auto& R, auto Function> struct served_entry<computed_row<R, Function>> {
    using row = std::remove_cvref_t<decltype(R)>;
    static constexpr std::size_t size = 1;
    static constexpr bool is_computed = true;
    static_assert(!is_row_array<row>::value,
                  "a function computes one row: name the elements of an array by at<rows, i>");
};
template <const auto& E> using entry_of = served_entry<std::remove_cvref_t<decltype(E)>>;

/// The raw range and the first value of a row of registers/values.hpp.
template <class T, class Row> constexpr void put_coded(plain_row& p, const Row& r) {
    static_assert(!takes_words<T>,
                  "a server has values of one or two whole registers in the device's word order: the "
                  "device keeps the registers of other values itself, as rows of u16");
    if constexpr (!takes_words<T>) {
        using coded = codec<T>;
        using number = typename coded::number;
        const range within = r.limits.is_stated ? r.limits : full<T>;
        p.low = 0; // of a float any bits
        p.high = static_cast<std::int64_t>(coded::mask);
        if constexpr (is_counted<T> && coded::is_in_order) {
            p.low = within.low - coded::options.offset;
            p.high = within.high - coded::options.offset;
        }
        const std::int64_t first = within.contains(0) ? 0 : within.low;
        p.initial = static_cast<std::int64_t>(
            coded::raw_of(static_cast<number>(r.initial == no_default ? first : r.initial)));
    }
}

template <class Row> constexpr plain_row plain(const Row& r) {
    plain_row p;
    p.type = &type_tag<Row>::here;
    p.of = table_of_row<Row>;
    p.rights = Row::rights;
    p.address = r.address;
    if constexpr (table_of_row<Row> <= table::discrete_inputs) {
        p.in = pool::bits;
        p.initial = r.initial;
    } else {
        check_row(r);
        p.is_pair = Row::words == 2;
        p.in = p.is_pair ? pool::wide : pool::narrow;
        if constexpr (has_codec<typename Row::value_type>) {
            put_coded<typename Row::value_type>(p, r);
            return p;
        }
        p.low = r.limits.low;
        p.high = r.limits.high;
        p.initial = r.initial == no_default ? (r.limits.contains(0) ? 0 : r.limits.low) : r.initial;
    }
    return p;
}
template <const auto& R, auto Function> constexpr plain_row plain(const computed_row<R, Function>&) {
    plain_row p = plain(R);
    p.in = pool::functions;
    return p;
}

/// All rows of a server, and what is counted of them.
template <std::size_t Rows> struct row_list {
    plain_row rows[Rows]{}; // in the order of table and address
    std::size_t places[pools]{};
    std::size_t ranges[pools]{};
    std::size_t first[5]{};        // rows of each table begin there
    std::size_t longest_run = 0;   // words that adjacent registers have
    std::size_t longest_bits = 0;  // adjacent coils or inputs
    std::size_t longest_write = 0; // words of adjacent registers that can be written
    bool can_read[4]{};
    bool can_write[4]{};
    bool overlaps = false;
    bool repeats = false;

    /// The stored holding register of one word at `address`; null if there is none.
    constexpr const plain_row* find_word(u16 address) const {
        for (const plain_row& r : rows) {
            if (r.of == table::holding_registers && r.address == address && r.in == pool::narrow) return &r;
        }
        return nullptr;
    }
    /// True if that register is 0 or 1, as one that switches the word order.
    constexpr bool has_switch_at(u16 address) const {
        const plain_row* const r = find_word(address);
        return r != nullptr && r->low == 0 && r->high == 1;
    }
};

template <std::size_t Rows> constexpr void count_runs(row_list<Rows>& list) {
    u32 run = 0, next = 0, written = 0;
    for (std::size_t i = 0; i < Rows; ++i) {
        const plain_row& r = list.rows[i];
        const auto t = static_cast<std::size_t>(r.of);
        const bool is_bits = t < 2;
        if (i != 0 && r.of == list.rows[i - 1].of && r.key() < next) {
            (r.key() == list.rows[i - 1].key() ? list.repeats : list.overlaps) = true;
        }
        const bool goes_on = i != 0 && r.key() == next && r.of == list.rows[i - 1].of;
        if (goes_on) list.rows[i - 1].ends_run = false;
        run = (goes_on ? run : 0) + (r.end() - r.key());
        written = r.rights == access::ro ? 0 : (goes_on ? written : 0) + (r.end() - r.key());
        next = r.end();
        std::size_t& longest = is_bits ? list.longest_bits : list.longest_run;
        if (run > longest) longest = run;
        if (!is_bits && written > list.longest_write) list.longest_write = written;
        list.can_read[t] = list.can_read[t] || r.rights != access::wo;
        list.can_write[t] = list.can_write[t] || r.rights != access::ro;
        for (std::size_t later = t + 1; later < 5; ++later) ++list.first[later];
    }
}

/// Sorts by merging, and numbers instead of rows: compilers limit the steps of a constant expression.
template <std::size_t Rows> constexpr void sort_rows(row_list<Rows>& list) {
    std::uint64_t numbers[2][Rows]{}; // a key and the index of its row
    for (std::size_t i = 0; i < Rows; ++i) numbers[0][i] = std::uint64_t{list.rows[i].key()} << 16 | i;
    std::size_t from = 0;
    for (std::size_t size = 1; size < Rows; size *= 2, from = 1 - from) {
        const std::uint64_t* const in = numbers[from];
        std::uint64_t* const out = numbers[1 - from];
        for (std::size_t begin = 0; begin < Rows; begin += 2 * size) {
            const std::size_t middle = begin + size < Rows ? begin + size : Rows;
            const std::size_t end = middle + size < Rows ? middle + size : Rows;
            std::size_t a = begin, b = middle;
            for (std::size_t to = begin; to < end; ++to)
                out[to] = b == end || (a != middle && in[a] <= in[b]) ? in[a++] : in[b++];
        }
    }
    const row_list<Rows> unsorted = list;
    for (std::size_t i = 0; i < Rows; ++i) list.rows[i] = unsorted.rows[numbers[from][i] & 0xFFFFu];
}

/// Values have their slots in the order of the pack, so that those of an array follow each other. Writable ones come
/// first: only they have ranges.
template <std::size_t Rows> constexpr void give_slots(row_list<Rows>& list) {
    for (unsigned writable = 2; writable-- != 0;) {
        for (plain_row& r : list.rows) {
            if ((r.rights != access::ro) != (writable == 1)) continue;
            std::size_t& places = list.places[static_cast<std::size_t>(r.in)];
            r.slot = static_cast<u16>(places++);
            if (writable == 1) list.ranges[static_cast<std::size_t>(r.in)] = places;
        }
    }
}

template <std::size_t Rows, class Entry>
constexpr void append(row_list<Rows>& list, std::size_t& at, const Entry& e) {
    list.rows[at++] = plain(e);
}
template <std::size_t Rows, class Row, std::size_t N>
constexpr void append(row_list<Rows>& list, std::size_t& at, const reg_array<Row, N>& e) {
    for (std::size_t i = 0; i < N; ++i) list.rows[at++] = plain(e[i]);
}

template <const auto&... Es> inline constexpr std::size_t count_of_rows = (entry_of<Es>::size + ...);
template <const auto&... Es>
inline constexpr auto rows_of = [] {
    row_list<count_of_rows<Es...>> list;
    std::size_t at = 0;
    (append(list, at, Es), ...);
    give_slots(list);
    sort_rows(list);
    count_runs(list);
    return list;
}();

/// The rows in flash.
template <std::size_t Rows> struct served_rows {
    served_row rows[Rows]{};
    std::conditional_t<(Rows < 256), std::uint8_t, u16> first[5]{};
};
template <const auto&... Es>
inline constexpr auto flash_rows = [] {
    served_rows<count_of_rows<Es...>> kept;
    for (std::size_t i = 0; i < count_of_rows<Es...>; ++i) {
        const plain_row& r = rows_of<Es...>.rows[i];
        const unsigned kind = (r.is_pair ? served_row::two_words : 0u) |
                              (r.rights == access::wo ? served_row::no_read : 0u) |
                              (r.rights == access::ro ? served_row::no_write : 0u) |
                              (r.in == pool::functions ? served_row::is_computed : 0u) |
                              (r.ends_run ? served_row::ends_run : 0u);
        kept.rows[i] = {r.address, static_cast<u16>(unsigned{r.slot} << served_row::slot_at | kind)};
    }
    for (std::size_t t = 0; t < 5; ++t)
        kept.first[t] =
            static_cast<std::remove_reference_t<decltype(kept.first[0])>>(rows_of<Es...>.first[t]);
    return kept;
}();

/// The ranges of writable registers by their slots.
template <class Int, std::size_t N> struct served_ranges { served_range<Int> all[N + (N == 0 ? 1 : 0)]{}; };
template <class Int, pool In, const auto&... Es>
inline constexpr auto flash_ranges = [] {
    served_ranges<Int, rows_of<Es...>.ranges[static_cast<std::size_t>(In)]> ranges;
    for (const plain_row& r : rows_of<Es...>.rows) {
        if (r.in == In && r.rights != access::ro)
            ranges.all[r.slot] = {static_cast<Int>(r.low), static_cast<Int>(r.high - r.low)};
    }
    return ranges;
}();

/// The functions of computed rows by their slots.
using row_function = u32 (*)();
template <std::size_t N> struct served_functions { row_function all[N + (N == 0 ? 1 : 0)]{}; };
template <class Entry> constexpr row_function function_of() {
    if constexpr (served_entry<Entry>::is_computed) {
        return &Entry::bits;
    } else {
        return nullptr;
    }
}
template <const auto&... Es>
inline constexpr auto flash_functions = [] {
    served_functions<rows_of<Es...>.places[static_cast<std::size_t>(pool::functions)]> kept;
    std::size_t at = 0; // all of them are read-only: in the order of the pack
    ((entry_of<Es>::is_computed
          ? static_cast<void>(kept.all[at++] = function_of<std::remove_cvref_t<decltype(Es)>>())
          : void()),
     ...);
    return kept;
}();

} // namespace servobus::detail
