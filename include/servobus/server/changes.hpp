// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The writes of a request as the hooks of a server get them: rows with their typed values. server/options.hpp includes
// it.
//
//     constexpr bool is_upside_down(const changes<row_values<tank::lowest, tank::highest>>& written) {
//         return written.get<tank::lowest>() > written.get<tank::highest>(); // either is written, or both
//     }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/registers/block.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/server/row_values.hpp>

namespace servobus {

/// The rows that a request writes. All of them exist, and their values are in range. It refers to the request's bytes:
/// do not keep it.
template <class Values> class changes {
  public:
    /// A write of `quantity` coils or words of `to`, from `address` on, whose values are in `data` as on the line.
    /// `order` is the word order of the request.
    constexpr changes(const Values& values, table to, u16 address, u16 quantity, const std::uint8_t* data,
                      word_order order)
        : values_{&values}, data_{data}, address_{address}, quantity_{quantity}, table_{to} {
        word_order_.set(order);
    }

    /// True if row `R` is written.
    template <const auto& R> constexpr bool is_written() const {
        constexpr detail::plain_row r = Values::template place_of<R>();
        return r.rights != access::ro && is_inside(r.of, r.address);
    }
    /// True if element `i` of an array of rows is written.
    template <const auto& R>
    requires is_register_array<R>
    constexpr bool is_written(std::size_t i) const { return is_inside(table_of<R>, R[i].address); }

    /// The value that row `R` has after the write: the new one if it is written, else the present one.
    template <const auto& R> constexpr auto get() const {
        constexpr detail::plain_row r = Values::template place_of<R>();
        return Values::template decode<R>(is_written<R>() ? bits_at<r.in>(r.address)
                                                          : values_->template load<R>(0));
    }
    /// The same of element `i` of an array of rows.
    template <const auto& R>
    requires is_register_array<R>
    constexpr auto get(std::size_t i) const {
        constexpr detail::plain_row r = Values::template place_of<R>();
        return reading_of<at<R, 0>>(is_written<R>(i) ? bits_at<r.in>(R[i].address)
                                                     : values_->template load<R>(i));
    }

    constexpr table to() const { return table_; } ///< coils or holding registers
    constexpr u16 address() const { return address_; }
    constexpr u16 quantity() const { return quantity_; } ///< coils, or words

  private:
    constexpr bool is_inside(table of, u16 address) const {
        return of == table_ && static_cast<u16>(address - address_) < quantity_;
    }
    template <detail::pool In> constexpr u32 bits_at(u16 address) const {
        const unsigned at = static_cast<u16>(address - address_);
        if constexpr (In == detail::pool::bits) {
            return data_[at / 8] >> at % 8 & 1u;
        } else if constexpr (In == detail::pool::wide) {
            return join_words(word_at(2 * at), word_at(2 * at + 2), word_order_.value());
        } else {
            return word_at(2 * at);
        }
    }
    constexpr u16 word_at(unsigned at) const { return static_cast<u16>(data_[at] * 256u + data_[at + 1]); }

    const Values* values_;
    const std::uint8_t* data_;
    u16 address_;
    u16 quantity_;
    table table_;
    [[no_unique_address]] detail::kept_word_order<typename Values::device> word_order_{};
};

} // namespace servobus
