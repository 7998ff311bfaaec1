// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A view of consecutive numbers in memory: a pointer and a size. The library uses it in place of std::span,
// to which and from which it converts: <span> and <array>, with the concepts of ranges and iterators, would
// nearly double the compile time of every source file that includes the library (bench/include_cost.py).
// Programs need not include it: they pass std::array, std::vector, std::span or a C array where a slice is
// expected.
//
//     constexpr int speeds[]{100, 200, 300};
//     static_assert(slice<const int>{speeds}.last(2)[0] == 200);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <type_traits>

namespace servobus {

/// A view of numbers in another object, which must outlive the view. As with std::span, a temporary that is
/// passed as a `slice<const T>` argument lives until the call returns.
template <class T> class slice {
    static_assert(std::is_integral_v<T>, "a slice is of numbers");
    template <class Of> static constexpr bool is_other = !std::is_same_v<const Of, const slice>;

  public:
    using element_type = T;
    using value_type = std::remove_cv_t<T>;

    constexpr slice() noexcept = default;
    constexpr slice(T* first, std::size_t size) noexcept : data_{first}, size_{size} {}
    template <std::size_t N>
    constexpr slice(T (&all)[N]) noexcept : data_{all}, size_{N} {} // NOLINT: implicit, as std::span
    /// A view of any object with `data()` and `size()`: a std::array, a std::vector, a std::span, or a slice
    /// of non-const numbers.
    template <class Of>
    requires(is_other<Of>) && requires(Of& of, T*& first) {
        first = of.data();
        of.size();
    }
    constexpr slice(Of& of) noexcept : data_{of.data()}, size_{of.size()} {} // NOLINT: implicit
    template <class Of>
    requires(is_other<Of>) && requires(const Of& of, T*& first) {
        first = of.data();
        of.size();
    }
    constexpr slice(const Of& of) noexcept : data_{of.data()}, size_{of.size()} {} // NOLINT: implicit

    constexpr T* data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }
    constexpr bool empty() const noexcept { return size_ == 0; }
    constexpr T* begin() const noexcept { return data_; }
    constexpr T* end() const noexcept { return data_ + size_; }

    constexpr T& operator[](std::size_t i) const noexcept {
        must_hold(i < size_);
        return data_[i];
    }
    constexpr T& front() const noexcept { return (*this)[0]; }
    constexpr T& back() const noexcept { return (*this)[size_ - 1]; }

    constexpr slice first(std::size_t count) const noexcept {
        must_hold(count <= size_);
        return {data_, count};
    }
    constexpr slice last(std::size_t count) const noexcept {
        must_hold(count <= size_);
        return {data_ + (size_ - count), count};
    }
    constexpr slice subspan(std::size_t from) const noexcept {
        must_hold(from <= size_);
        return {data_ + from, size_ - from};
    }
    constexpr slice subspan(std::size_t from, std::size_t count) const noexcept {
        must_hold(from <= size_ && count <= size_ - from);
        return {data_ + from, count};
    }

    /// Converts a temporary slice to a std::span. For other slices, and for slices of constants, the range
    /// constructor of std::span applies.
    template <template <class, std::size_t> class Span>
    requires(!std::is_const_v<T>) constexpr
    operator Span<T, static_cast<std::size_t>(-1)>() const&& noexcept { // NOLINT: implicit
        return Span<T, static_cast<std::size_t>(-1)>{data_, size_};
    }

  private:
    // As in std::span, checked only where the standard library's assertions are enabled.
    static constexpr void must_hold([[maybe_unused]] bool is_inside) noexcept {
#ifdef _GLIBCXX_ASSERTIONS
        if (!is_inside) __builtin_trap();
#endif
    }

    T* data_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace servobus
