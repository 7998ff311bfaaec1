// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the alarms of the simulated C630S: which are present, which can be reset, and the last ten with
// the values measured when they were raised. Source: manual V24.111, chapter 8 and section 7.11.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/device/c630s/alarms.hpp>

namespace servobus::sim {

namespace coolmay = servobus::c630s;

/// An alarm with the values measured when it was raised: P0B-34 to P0B-42.
struct c630s_record {
    std::uint16_t code = 0;        ///< 0x101 for Er.101; 0 for none
    std::uint32_t time = 0;        ///< s of power-on time
    std::int16_t speed = 0;        ///< r/min
    std::int16_t u_current = 0;    ///< 0.01 A
    std::int16_t v_current = 0;    ///< 0.01 A
    std::uint16_t bus_voltage = 0; ///< 0.1 V
    std::uint16_t inputs = 0;      ///< as P0B-03
    std::uint16_t outputs = 0;     ///< as P0B-05
};

namespace detail {

/// The alarms of a class; a bit for each, by its place in the table.
constexpr std::uint64_t c630s_alarms_of(coolmay::alarm_class kind) {
    std::uint64_t all = 0;
    for (std::size_t n = 0; n < std::size(coolmay::alarms); ++n) {
        if (coolmay::alarms[n].kind == kind) all |= std::uint64_t{1} << n;
    }
    return all;
}

class c630s_alarms {
  public:
    static constexpr std::size_t depth = 10;

    constexpr bool has_fault() const { return (present_ & faults) != 0; }
    constexpr bool has_warning() const { return (present_ & warnings) != 0; }
    constexpr bool is_present(std::uint16_t code) const {
        const std::size_t n = number(code);
        return n < count && is_set(n);
    }

    /// Raises an alarm that is not present. False if no alarm has the code.
    constexpr bool set(const c630s_record& what) {
        const std::size_t n = number(what.code);
        if (n == count) return false;
        present_ |= mask_of(n);
        for (std::size_t i = depth - 1; i > 0; --i) records_[i] = records_[i - 1];
        records_[0] = what;
        return true;
    }
    /// Ends an alarm of any kind.
    constexpr void end(std::uint16_t code) {
        if (present_ == 0) return;
        const std::size_t n = number(code);
        if (n < count) present_ &= ~mask_of(n);
    }
    /// Resets the alarms that can be reset; faults only while S-ON is off. `persists(code)` is true if the
    /// cause of an alarm is still present.
    template <class F> constexpr void reset(bool is_servo_on_given, const F& persists) {
        for (std::size_t n = 0; n < count; ++n) {
            const coolmay::alarm& a = coolmay::alarms[n];
            const bool is_fault = a.kind == coolmay::alarm_class::fault;
            if (!a.is_resettable || (is_fault && is_servo_on_given) || persists(a.code)) continue;
            present_ &= ~mask_of(n);
        }
    }
    /// Power on: clears the alarms whose cause has ended.
    template <class F> constexpr void switch_on(const F& persists) {
        for (std::size_t n = 0; n < count; ++n) {
            if (!persists(coolmay::alarms[n].code)) present_ &= ~mask_of(n);
        }
    }

    /// The newest fault that is present, else the newest warning; 0 for none.
    constexpr std::uint16_t current() const {
        const std::size_t at = place_of_current();
        if (at < depth) return records_[at].code;
        return 0;
    }
    /// Record 0 is the present alarm; without one it is empty, or with `shows_last` the newest record.
    /// Records 1 to 9 are the others, the newest first.
    constexpr c630s_record record(std::size_t which, bool shows_last = false) const {
        const std::size_t now = place_of_current();
        if (which == 0 && now == depth && shows_last) return records_[0];
        if (which == 0) return now < depth ? records_[now] : c630s_record{};
        const std::size_t at = now < depth && which <= now ? which - 1 : now < depth ? which : which - 1;
        return at < depth ? records_[at] : c630s_record{};
    }
    constexpr void clear_records() { records_ = {}; }

  private:
    static constexpr std::size_t count = std::size(coolmay::alarms);
    static_assert(count <= 64);

    static constexpr std::size_t number(std::uint16_t code) {
        std::size_t n = 0;
        while (n < count && coolmay::alarms[n].code != code) ++n;
        return n;
    }
    constexpr bool is_set(std::size_t n) const { return (present_ & mask_of(n)) != 0; }
    static constexpr std::uint64_t mask_of(std::size_t n) { return std::uint64_t{1} << n; }
    static constexpr std::uint64_t faults = c630s_alarms_of(coolmay::alarm_class::fault);
    static constexpr std::uint64_t warnings = c630s_alarms_of(coolmay::alarm_class::warning);
    constexpr std::size_t place_of_current() const {
        const coolmay::alarm_class wanted =
            has_fault() ? coolmay::alarm_class::fault : coolmay::alarm_class::warning;
        for (std::size_t i = 0; i < depth && records_[i].code != 0; ++i) {
            const std::size_t n = number(records_[i].code);
            if (n < count && is_set(n) && coolmay::alarms[n].kind == wanted) return i;
        }
        return depth;
    }

    std::uint64_t present_ = 0; // a bit for each alarm, by its place in the table
    std::array<c630s_record, depth> records_{};
};

} // namespace detail
} // namespace servobus::sim
