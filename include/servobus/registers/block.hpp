// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plans calls that read or write several registers, at compile time. Reads are sorted and merged into the
// fewest requests; no request covers an address that was not asked for. A write is one frame of adjacent
// registers. The header sends nothing. client/client.hpp includes it; programs include it to inspect a plan.
//
//     constexpr auto& plan = read_plan<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>;
//     static_assert(plan.count == 1 && plan.words == 2); // adjacent: one request
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/slice.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/register_value.hpp>

namespace servobus {

/// Rows as one template argument.
template <const auto&... Rs> struct rows {};

/// Adjacent registers that one request covers.
struct extent {
    u16 address = 0; ///< of the first register
    u16 words = 0;   ///< in all registers
};

namespace detail {

struct planned {
    u16 address = 0;
    u16 words = 0;
    u16 offset = 0; // index of its first word in the words of all requests
};

template <std::size_t N> constexpr void sort_by_address(planned (&rows)[N]) {
    for (std::size_t i = 1; i < N; ++i) {
        const planned row = rows[i];
        std::size_t j = i;
        for (; j > 0 && rows[j - 1].address > row.address; --j) rows[j] = rows[j - 1];
        rows[j] = row;
    }
}

// The device, among those of the rows, to which all rows belong: a variant rather than its family.
template <class Found, class... Others> struct common_device { using type = Found; };
template <class Found, class Next, class... Others>
struct common_device<Found, Next, Others...>
    : common_device<std::conditional_t<belongs_to<Found, Next>, Next, Found>, Others...> {};

template <class... Devices> struct same_device_of {
    using device = typename common_device<Devices...>::type;
    static constexpr bool value = (belongs_to<Devices, device> && ...);
};
template <const auto&... Rs> using same_device = same_device_of<typename row_type<Rs>::device...>;

template <const auto& A, const auto& B>
inline constexpr bool is_same_register = std::is_same_v<row_type<A>, row_type<B>>&& A.address == B.address;

template <std::size_t Rows> struct plan {
    extent requests[Rows]{};
    std::size_t count = 0;
    u16 words = 0;
    planned rows[Rows]{}; // in address order
    bool overlaps = false;

    constexpr u16 offset_of(u16 address) const {
        for (const planned& row : rows) {
            if (row.address == address) return row.offset;
        }
        return 0;
    }
};

template <std::size_t N> constexpr plan<N> plan_reads(const planned (&rows)[N], u16 most) {
    plan<N> p;
    for (std::size_t i = 0; i < N; ++i) p.rows[i] = rows[i];
    sort_by_address(p.rows);
    for (planned& row : p.rows) {
        extent* last = p.count == 0 ? nullptr : &p.requests[p.count - 1];
        if (last != nullptr && row.address < last->address + last->words) p.overlaps = true;
        const bool joins =
            last != nullptr && row.address == last->address + last->words && last->words + row.words <= most;
        if (joins) {
            last->words = static_cast<u16>(last->words + row.words);
        } else {
            p.requests[p.count++] = {row.address, row.words};
        }
        row.offset = p.words;
        p.words = static_cast<u16>(p.words + row.words);
    }
    return p;
}
} // namespace detail

/// The requests that read the registers `Rs`, in address order: the first `count` elements of `requests`.
/// `words` is the number of 16-bit words of all requests.
template <const auto&... Rs>
inline constexpr auto
    read_plan = detail::plan_reads<sizeof...(Rs)>({{Rs.address, static_cast<u16>(row_type<Rs>::words), 0}...},
                                                  detail::same_device<Rs...>::device::facts.max_read);

namespace detail {
template <device_class Device> struct fixed_word_order {
    static constexpr word_order value() { return Device::facts.word_order; }
    static constexpr void set(word_order) {}
};
struct open_word_order {
    word_order held = word_order::high_first;
    constexpr word_order value() const { return held; }
    constexpr void set(word_order to) { held = to; }
};
template <device_class Device>
using kept_word_order =
    std::conditional_t<has_fixed_word_order<Device>, fixed_word_order<Device>, open_word_order>;
} // namespace detail

/// The result of reading the registers `Rs`: their words, from which `get` decodes the value of each
/// register.
template <const auto&... Rs> class readings {

  public:
    static constexpr const auto& plan = read_plan<Rs...>;
    /// True if one frame carries all values, so that they are of the same moment.
    static constexpr bool is_one_frame = plan.count == 1;
    /// True if a register has two words, so that the word order matters.
    static constexpr bool has_pairs = ((row_type<Rs>::words == 2) || ...);

    constexpr readings() { clear(); }
    constexpr explicit readings(word_order order) {
        set_word_order(order);
        clear();
    }
    constexpr void clear() {
        for (u16& word : words_) {
            word = 0;
            if (!std::is_constant_evaluated())
                __asm__ volatile(""); // else GCC turns a small core's loop into a memset
        }
    }
    constexpr void set_word_order(word_order order) { word_order_.set(order); }

    /// The value of register `R`, one of `Rs`.
    template <const auto& R> constexpr reading<R> get() const {
        static_assert((detail::is_same_register<R, Rs> || ...), "this register was not read");
        constexpr u16 at = plan.offset_of(R.address);
        if constexpr (row_type<R>::words == 2) {
            return reading_of<R>(join_words(words_[at], words_[at + 1u], word_order_.value()));
        } else {
            return reading_of<R>(words_[at]);
        }
    }

    /// The raw words in address order; the client stores them here.
    constexpr slice<u16> words() { return words_; }

  private:
    u16 words_[plan.words];
    [[no_unique_address]] detail::kept_word_order<typename detail::same_device<Rs...>::device> word_order_{};

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert((!is_register_array<Rs> && ...), "an element of an array is a row by name: at<rows, i>");
    static_assert(detail::same_device<Rs...>::value, "a read has registers of one device");
    static_assert(((row_type<Rs>::rights != access::wo) && ...), "this register is write-only");
    static_assert(!read_plan<Rs...>.overlaps, "a read names each register once");
};

/// The value of register `R` in the result of `read<...>()`: the free twin of `readings::get`.
template <const auto& R, const auto&... Rs> constexpr auto get(const readings<Rs...>& from) {
    return from.template get<R>();
}

namespace detail {
// Takes a pointer and a size: constructing a span for every write and every step costs compile time.
constexpr bool are_adjacent(const extent* rows, std::size_t count) {
    for (std::size_t i = 1; i < count; ++i) {
        if (rows[i].address != rows[i - 1].address + rows[i - 1].words) return false;
    }
    return true;
}
} // namespace detail

/// The one frame that writes the registers `Rs`, which must be adjacent and in address order.
template <const auto&... Rs> struct write_plan {
    static constexpr extent rows[]{{Rs.address, static_cast<u16>(row_type<Rs>::words)}...};
    static constexpr u16 words = static_cast<u16>((row_type<Rs>::words + ...));

    static constexpr bool are_adjacent = detail::are_adjacent(rows, sizeof...(Rs));

    /// No assertions of the class: clang++ has no class where one has failed, and prints an error for each use.
    static constexpr void check() {
        static_assert(detail::same_device<Rs...>::value, "a write has registers of one device");
        static_assert(
            are_adjacent,
            "a write of several registers is one frame: they must be adjacent and in address order");
        static_assert(words <= detail::same_device<Rs...>::device::facts.max_write,
                      "more registers than this device takes in one write");
    }
};

} // namespace servobus
