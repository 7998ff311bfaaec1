// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plans reads of several rows of any tables and types of values, at compile time. The rows of each table are sorted and
// merged into the fewest requests. No request covers an address that was not asked for. registers/tables.hpp
// includes it; programs include it to inspect a plan.
//
//     // a coil, two input registers
//     constexpr auto& plan = readings<tank::valve, tank::level, tank::temperature>::plan;
//     static_assert(plan.count == 2 && plan.requests[0].code() == 0x01 && plan.requests[1].quantity == 2);
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/table_rows.hpp>

namespace servobus {

/// Adjacent rows of one table that one request reads.
struct table_extent {
    table of = table::coils;
    u16 address = 0;  ///< of the first row
    u16 quantity = 0; ///< registers or bits
    u16 offset = 0;   ///< of its data among those of all requests, in bytes

    /// The function that reads it.
    constexpr std::uint8_t code() const { return static_cast<std::uint8_t>(static_cast<unsigned>(of) + 1u); }
    constexpr bool has_bits() const { return of <= table::discrete_inputs; }
    /// The bytes of its data.
    constexpr std::size_t size() const {
        return has_bits() ? (quantity + 7u) / 8u : std::size_t{2} * quantity;
    }
    constexpr std::size_t response_size() const { return 5 + size(); }
    /// True if an echo of the request has the length and the byte count of its response.
    constexpr bool has_echo_like_response() const { return has_bits() && size() == 3 && address >> 8 == 3; }
    /// True if `response`, which is one to the request, repeats it.
    constexpr bool is_repeated_by(bytes response) const {
        return has_echo_like_response() && load_word(response, 2) == address &&
               load_word(response, 4) == quantity;
    }
};

namespace detail {

inline constexpr u16 most_bits = 2000; // in one read

struct table_row {
    table of;
    u16 address;
    u16 quantity;
    bool is_part = false; // of a register; the read may have its other parts too
};

constexpr bool comes_before(const table_row& a, const table_row& b) {
    return a.of != b.of ? a.of < b.of : a.address < b.address;
}

template <std::size_t Rows> struct table_plan {
    table_extent requests[Rows]{};
    std::size_t count = 0;
    std::size_t bytes = 0; // data of all requests
    std::size_t longest_response = 0;
    bool overlaps = false;
    bool has_echo_like_response = false; // one of the requests

    // The request that reads a row of the plan. Requests are sorted.
    constexpr const table_extent& request_of(table of, u16 address) const {
        std::size_t i = 0;
        while (requests[i].of != of || address - requests[i].address >= requests[i].quantity) ++i;
        return requests[i];
    }
};

template <std::size_t N> constexpr table_plan<N> plan_tables(table_row (&&rows)[N], u16 most_registers) {
    for (std::size_t i = 1; i < N; ++i) {
        const table_row row = rows[i];
        std::size_t j = i;
        for (; j > 0 && comes_before(row, rows[j - 1]); --j) rows[j] = rows[j - 1];
        rows[j] = row;
    }
    table_plan<N> p;
    for (std::size_t i = 0; i < N; ++i) {
        const table_row& row = rows[i];
        table_extent* last = p.count == 0 ? nullptr : &p.requests[p.count - 1];
        if (last != nullptr && last->of != row.of) last = nullptr;
        if (last != nullptr && row.address < last->address + last->quantity) {
            if (row.is_part && rows[i - 1].is_part && row.address == rows[i - 1].address) continue;
            p.overlaps = true;
        }
        const bool is_next = last != nullptr && row.address == last->address + last->quantity;
        const u16 most = row.of <= table::discrete_inputs ? most_bits : most_registers;
        if (is_next && last->quantity + row.quantity <= most)
            last->quantity = static_cast<u16>(last->quantity + row.quantity);
        else
            p.requests[p.count++] = {row.of, row.address, row.quantity, 0};
    }
    for (std::size_t i = 0; i < p.count; ++i) {
        table_extent& request = p.requests[i];
        request.offset = static_cast<u16>(p.bytes);
        p.bytes += request.size();
        if (request.has_echo_like_response()) p.has_echo_like_response = true;
        if (request.response_size() > p.longest_response) p.longest_response = request.response_size();
    }
    return p;
}

template <const auto& R> constexpr table_row table_row_of() {
    if constexpr (is_register_array<R>)
        return {}; // refused by `readings`
    else if constexpr (is_bit<R>)
        return {table_of<R>, R.address, 1};
    else
        return {table_of<R>, R.address, static_cast<u16>(row_type<R>::words),
                is_part<typename row_type<R>::value_type>};
}

template <const auto&... Rs>
inline constexpr auto read_plan_of_tables =
    plan_tables<sizeof...(Rs)>({table_row_of<Rs>()...}, same_device<Rs...>::device::facts.max_read);

// The request of a plan that has only one: less flash than the whole plan.
template <const auto&... Rs>
inline constexpr table_extent only_request = read_plan_of_tables<Rs...>.requests[0];

} // namespace detail

/// The result of reading rows of any tables: what the requests brought, from which `get` decodes the value of each row.
template <const auto&... Rs>
requires(detail::needs_table_calls<Rs> || ...) class readings<Rs...> {
    static_assert((!is_register_array<Rs> && ...), "an element of an array is a row by name: at<rows, i>");
    static_assert(detail::same_device<Rs...>::value, "a read has rows of one device");
    static_assert(((row_type<Rs>::rights != access::wo) && ...), "this row is write-only");
    static_assert(!detail::read_plan_of_tables<Rs...>.overlaps, "a read names each row once");

  public:
    static constexpr const auto& plan = detail::read_plan_of_tables<Rs...>;
    static constexpr bool is_one_frame = plan.count == 1; ///< all values are of the same moment
    static constexpr bool has_pairs = (detail::needs_word_order<Rs>() || ...);

    // cppcheck-suppress uninitMemberVar ; `clear` does it
    constexpr readings() { clear(); }
    // cppcheck-suppress uninitMemberVar ; `clear` does it
    constexpr explicit readings(word_order order) {
        set_word_order(order);
        clear();
    }
    constexpr void clear() {
        for (std::uint8_t& byte : data_) {
            byte = 0;
            if (!std::is_constant_evaluated()) __asm__ volatile(""); // no memset on a small core
        }
    }
    constexpr void set_word_order(word_order order) { word_order_.set(order); }

    /// The value of row `R`, one of `Rs`: a bool for a coil or a discrete input.
    template <const auto& R> constexpr auto get() const {
        static_assert((detail::is_same_register<R, Rs> || ...), "this row was not read");
        constexpr const table_extent& from = plan.request_of(table_of<R>, R.address);
        constexpr std::size_t index = static_cast<std::size_t>(R.address - from.address);
        if constexpr (is_bit<R>) {
            return (data_[from.offset + index / 8] >> index % 8 & 1u) != 0;
        } else if constexpr (detail::takes_words<typename row_type<R>::value_type>) {
            using codec = detail::codec<typename row_type<R>::value_type>;
            constexpr std::size_t first = from.offset + 2 * index;
            const auto word_at = [this](std::size_t i) { return load_word(bytes{data_}, first + 2 * i); };
            if constexpr (detail::is_scaled<R>())
                return codec::template value_in<R>(word_at, word_order_.value(), scale_of<codec>());
            else
                return codec::template value_in<R>(word_at, word_order_.value());
        } else if constexpr (row_type<R>::words == 2) {
            const bytes at = bytes{data_}.subspan(from.offset + 2 * index, 4);
            return reading_of<R>(join_words(load_word(at, 0), load_word(at, 2), word_order_.value()));
        } else {
            return reading_of<R>(load_word(bytes{data_}, from.offset + 2 * index));
        }
    }

    /// Takes the data of request number `i`, as many as it has. False if a bit after the last one is not 0, as the
    /// standard demands.
    constexpr bool take(std::size_t i, bytes data) {
        const table_extent& request = plan.requests[i];
        // Bounded twice: g++ -O3 warns of a write behind the array otherwise.
        for (std::size_t k = 0; k < data.size() && request.offset + k < sizeof data_; ++k)
            data_[request.offset + k] = data[k];
        const unsigned used = request.quantity % 8u;
        return !request.has_bits() || used == 0 || data[data.size() - 1] >> used == 0;
    }

  private:
    template <class Codec> constexpr std::int64_t scale_of() const {
        constexpr bool is_read = (detail::is_same_register<Codec::scale::row, Rs> || ...);
        static_assert(is_read || sizeof...(Rs) == 1,
                      "another row scales this one: name both, read<power, power_exponent>()");
        if constexpr (!is_read) { // the assertion is the only error
            return 0;
        } else {
            const auto scale = this->template get<Codec::scale::row>();
            if constexpr (Codec::scale::is_optional)
                return scale ? static_cast<std::int64_t>(count_of(*scale)) : Codec::scale::none_now;
            else
                return static_cast<std::int64_t>(count_of(scale));
        }
    }

    alignas(u16) std::uint8_t data_[plan.bytes]; // so a result of few bytes is returned in a register
    [[no_unique_address]] detail::kept_word_order<typename detail::same_device<Rs...>::device> word_order_{};
};

} // namespace servobus
