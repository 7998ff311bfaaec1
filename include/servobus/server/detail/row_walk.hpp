// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: applies a part of a request to the rows that it names, one after another.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/server/detail/row_storage.hpp>
#include <servobus/server/detail/row_table.hpp>

namespace servobus::detail {

/// A step that is done with each row. Its low bits are the bits of `served_row` that forbid it.
enum class walk_step : u32 {
    read = served_row::no_read,              ///< encodes the values
    probe = served_row::no_read | 0x1'0000,  ///< checks that they can be read
    check = served_row::no_write,            ///< checks the rows and the values
    store = served_row::no_write | 0x2'0000, ///< stores values that were checked
};

/// `HasProbe`: a request reads and changes, so that its read is checked first.
template <class Values, bool HasProbe> class row_walk {
    static constexpr const auto& list = Values::list;
    static constexpr bool has_computed = list.places[static_cast<std::size_t>(pool::functions)] != 0;
    static constexpr bool has_bits = list.first[2] != 0;
    static constexpr bool has_words = list.first[4] != list.first[2];
    static constexpr bool has_pairs = [] {
        for (const plain_row& r : list.rows) {
            if (r.is_pair) return true;
        }
        return false;
    }();

  public:
    static constexpr bool must_probe = has_computed; // a function may do more than compute
    /// A step of a request that has this word order from its first check to its last store. A step that touches one
    /// word needs none.
    static constexpr walk_step in(word_order order, walk_step what) {
        const bool is_marked = can_switch_order && order == word_order::low_first;
        return static_cast<walk_step>(static_cast<u32>(what) | (is_marked ? low_first_flag : 0));
    }
    static constexpr unsigned illegal_address = 2, illegal_value = 3;

    /// Goes through `quantity` words or bits of a table from `address` on, whose values are or come in `data`. Returns
    /// 0, or an exception: a row is missing, is not whole or has not the right, or a value is out of range. A missing
    /// row counts before a value, wherever each is.
    [[gnu::noinline]] static constexpr unsigned go(Values& values, walk_step what, unsigned of,
                                                   unsigned address, unsigned quantity, std::uint8_t* data) {
        const unsigned first = find(of, address);
        if (first == missing) return illegal_address;
        const served_row* const row = Values::flash.rows + first;
        const auto step = static_cast<u32>(what);
        if (has_bits && (!has_words || of < 2)) return bits(values, step, row, quantity, data);
        return words(values, step, row, quantity, data);
    }

  private:
    static constexpr u32 probe_flag = 0x1'0000, store_flag = 0x2'0000, wrong_flag = 0x4'0000,
                         low_first_flag = 0x8'0000;
    static constexpr bool can_switch_order = !has_fixed_word_order<typename Values::device>;

    // The number of a row; `missing` if the table has none at this address. A binary search.
    static constexpr unsigned missing = ~0u;
    static constexpr unsigned find(unsigned of, unsigned address) {
        const auto& flash = Values::flash;
        unsigned low = flash.first[of];
        unsigned high = flash.first[of + 1];
        while (low != high) {
            const unsigned middle = (low + high) / 2;
            const unsigned there = flash.rows[middle].address;
            if (there == address) return middle;
            if (there < address) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        return missing;
    }

    static constexpr unsigned word_at(const std::uint8_t* p) { return p[0] * 256u + p[1]; }
    static constexpr std::uint8_t* put_word(std::uint8_t* p, u32 v) {
        p[0] = static_cast<std::uint8_t>(v >> 8 & 0xFFu);
        p[1] = static_cast<std::uint8_t>(v & 0xFFu);
        return p + 2;
    }
    static constexpr bool is_read(u32 step) { return (step & served_row::no_read) != 0; }
    static constexpr bool is_probe(u32 step) { return (HasProbe || must_probe) && (step & probe_flag) != 0; }
    static constexpr bool is_store(u32 step) { return (step & store_flag) != 0; }

    [[gnu::always_inline]] static constexpr unsigned bits(Values& values, u32 step, const served_row* row,
                                                          unsigned quantity, std::uint8_t* data) {
        for (unsigned i = 0;; ++row) {
            if (row->is(step)) return illegal_address;
            std::uint8_t& packed = data[i / 8];
            const unsigned at = i % 8;
            if (!is_read(step)) {
                if (is_store(step)) values.storage_.bits.store(row->slot(), packed >> at & 1u);
            } else if (!is_probe(step)) {
                if (at == 0) packed = 0; // the padding is zero
                packed = static_cast<std::uint8_t>(packed | value_of<pool::bits>(values, *row) << at);
            }
            if (++i == quantity) return 0;
            if (row->is(served_row::ends_run)) return illegal_address;
        }
    }

    [[gnu::always_inline]] static constexpr unsigned words(Values& values, u32 step, const served_row* row,
                                                           unsigned quantity, std::uint8_t* data) {
        const std::uint8_t* const end = data + std::size_t{2} * quantity;
        for (;; ++row) {
            if (row->is(step)) return illegal_address;
            const bool is_pair = has_pairs && row->is(served_row::two_words);
            if (is_pair && data + 2 == end) return illegal_address; // half of it
            if (is_read(step)) {
                if (is_probe(step)) {
                    data += is_pair ? 4 : 2;
                } else {
                    u32 v = is_pair ? in_word_order(step, value_of<pool::wide>(values, *row))
                                    : value_of<pool::narrow>(values, *row);
                    if (is_pair) data = put_word(data, v >> 16);
                    data = put_word(data, v);
                }
            } else {
                u32 v = word_at(data);
                data += 2;
                if (is_pair) {
                    v = in_word_order(step, v << 16 | word_at(data));
                    data += 2;
                }
                if (is_store(step)) {
                    store(values, is_pair, row->slot(), v);
                } else if (!is_inside(is_pair, row->slot(), v)) {
                    step |= wrong_flag; // a missing row still counts more
                }
            }
            if (data == end) return (step & wrong_flag) != 0 ? illegal_value : 0;
            if (row->is(served_row::ends_run)) return illegal_address;
        }
    }

    static constexpr u32 in_word_order([[maybe_unused]] u32 step, u32 v) {
        bool is_low_first = Values::device::facts.word_order == word_order::low_first;
        if constexpr (can_switch_order) is_low_first = (step & low_first_flag) != 0;
        return is_low_first ? v << 16 | v >> 16 : v;
    }
    static constexpr void store(Values& values, bool is_pair, unsigned slot, u32 v) {
        if (is_pair) {
            values.storage_.wide.store(slot, v);
        } else {
            values.storage_.narrow.store(slot, v);
        }
    }
    static constexpr bool is_inside(bool is_pair, unsigned slot, u32 v) {
        if (is_pair) return Values::template ranges<u32, pool::wide>()[slot].contains(v);
        return Values::template ranges<u16, pool::narrow>()[slot].contains(static_cast<u16>(v));
    }

    template <pool In> static constexpr u32 value_of(const Values& values, const served_row& r) {
        if constexpr (has_computed) {
            if (r.is(served_row::is_computed)) return Values::functions.all[r.slot()]();
        }
        return values.storage_.template of<In>().load(r.slot());
    }
};

} // namespace servobus::detail
