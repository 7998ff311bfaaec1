// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of numbers that lie somewhere else: a place and a size. It does what the library wants of std::span,
// is made of one and becomes one. The headers of std::span and std::array and their questions about ranges
// and iterators would cost the compiler nearly as much as this library (bench/include_cost.sh), in every
// source of a program.
#pragma once

#include <cstddef>
#include <type_traits>

namespace servobus {

/// Numbers in another object, which must live longer; as with std::span, a temporary lives as long as the
/// call that a `slice<const T>` of it is made for.
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
    /// Of what has `data()` and `size()`: a std::array, a std::vector, a std::span, a slice of what is not
    /// const.
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

    /// A temporary slice as a std::span; of any other, and of constants, std::span makes itself as of any
    /// range.
    template <template <class, std::size_t> class Span>
    requires(!std::is_const_v<T>) constexpr
    operator Span<T, static_cast<std::size_t>(-1)>() const&& noexcept { // NOLINT: implicit
        return Span<T, static_cast<std::size_t>(-1)>{data_, size_};
    }

  private:
    // As std::span: looked at where the standard library's assertions are on.
    static constexpr void must_hold([[maybe_unused]] bool is_inside) noexcept {
#ifdef _GLIBCXX_ASSERTIONS
        if (!is_inside) __builtin_trap();
#endif
    }

    T* data_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace servobus
