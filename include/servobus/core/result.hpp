// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value, or the status that says why there is none: what every call returns that reads. Those calls' headers
// include this one.
//
//     constexpr result<std::int16_t> speed{errc::timeout};
//     static_assert(!speed && speed.error() == errc::timeout && speed.value_or(0) == 0);
#pragma once

#include <cstdint>

#include <servobus/core/status.hpp>

namespace servobus {

/// A value, or the reason why there is none.
template <class T> class [[nodiscard]] result {
  public:
    // cppcheck-suppress passedByValue ; nearly all are a word or two
    constexpr result(T value) : value_{value} {} // NOLINT: implicit, `return value;`
    constexpr result(servobus::status why)       // NOLINT: implicit, `return x.status();`
        : code_{why.error()}, exception_{why.exception()} {}
    constexpr result(errc why) : code_{why} {} // NOLINT: implicit, `return errc::busy;`

    constexpr explicit operator bool() const { return code_ == errc::ok; }
    /// The value. Check for an error first: without a value it is default-constructed, or stale after `fail`.
    constexpr const T& value() const { return value_; }
    constexpr const T& operator*() const { return value_; }
    constexpr const T* operator->() const { return &value_; }
    constexpr T* operator->() { return &value_; }
    /// Sets the error; the stored value is kept.
    constexpr void fail(servobus::status why) {
        code_ = why.error();
        exception_ = why.exception();
    }
    constexpr T value_or(T other) const { return *this ? value_ : other; }

    constexpr errc error() const { return code_; }
    constexpr std::uint8_t exception() const { return exception_; }
    /// The reason as a status. A read changes nothing, so what was sent is told by the error: something may have
    /// been on the line if it is one of the transport's, after `send_failed`, or of the response.
    constexpr servobus::status status() const {
        return code_ > errc::send_failed ? servobus::status::sent(code_, exception_)
                                         : servobus::status{code_};
    }

  private:
    T value_{};
    errc code_ = errc::ok;
    std::uint8_t exception_ = 0;
};

static_assert(sizeof(result<std::int16_t>) == 4); // one register of a small core

} // namespace servobus
