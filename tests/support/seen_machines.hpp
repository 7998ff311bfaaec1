// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The view of each simulated drive from outside, and what may happen to it: for all judges, those of
// sim/conformance.hpp and those of tests/sim.
#pragma once

#include <cstdint>

#include <servobus/sim/c630s.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace seen {

namespace sim = servobus::sim;

struct wheels {
    /// On its way, or faster than 2 r/min, by which a wheel at rest varies [errata B31]; the register rounds down to
    /// 0.1 r/min.
    static bool is_turning(const sim::wheel_view& w) {
        return w.is_moving || w.speed >= 2'100'000 || w.speed <= -2'100'000;
    }
    static bool is_turning(const sim::zlac8015d& m) { return is_turning(m.left()) || is_turning(m.right()); }
    static bool is_energised(const sim::zlac8015d& m) { return m.enabled(); }
    static bool has_fault(sim::zlac8015d& m) {
        using namespace servobus::zlac8015d;
        return m.peek(left_faults.address) != 0 || m.peek(right_faults.address) != 0;
    }
    static std::int64_t place(const sim::zlac8015d& m) { return m.left().position; }
    static std::uint32_t starts(const sim::zlac8015d& m) { return m.starts(); }
    static void restart(sim::zlac8015d& m) { m.power_cycle(); }
    static void have_fault(sim::zlac8015d& m) {
        m.raise(servobus::zlac8015d::fault::overcurrent, servobus::zlac8015d::fault::none);
    }
    static void end_fault(sim::zlac8015d& m) { m.end_faults(); }
    static void press_stop(sim::zlac8015d& m) { m.set_input(true, false); }
    static void release_stop(sim::zlac8015d& m) { m.set_input(false, false); }
};

/// A YAKO of either variant.
struct stepper {
    template <class M> static bool is_turning(const M& m) { return m.view().is_moving; }
    template <class M> static bool is_energised(const M& m) { return m.enabled(); }
    template <class M> static bool has_fault(const M& m) { return m.alarm() != 0; }
    template <class M> static std::int64_t place(const M& m) { return m.view().shaft; }
    template <class M> static std::uint32_t starts(const M& m) { return m.starts(); }
    template <class M> static void restart(M& m) { m.power_cycle(); }
    template <class M> static void have_fault(M& m) { m.raise_alarm(1); }
    template <class M> static void end_fault(M& m) { m.end_alarm(); }
    /// Input X3, which must have a function that stops.
    template <class M> static void press_stop(M& m) { m.set_input(3, true); }
    template <class M> static void release_stop(M& m) { m.set_input(3, false); }
};

struct servo {
    static bool is_turning(const sim::c630s& m) { return !m.stands_still(); }
    static bool is_energised(const sim::c630s& m) { return m.enabled(); }
    static bool has_fault(const sim::c630s& m) { return m.has_fault(); }
    /// As slow as the facade accepts as standstill.
    static bool is_slow(const sim::c630s& m) {
        constexpr std::int64_t trembling = 3'000'000;
        return m.speed() < trembling && m.speed() > -trembling;
    }
    /// In reference units, by the factory's gear: 10000 a turn of 2^17 counts.
    static std::int64_t place(const sim::c630s& m) { return m.position() * 10'000 / 131'072; }
    static std::uint32_t starts(const sim::c630s& m) { return m.starts(); }
    static void restart(sim::c630s& m) { m.power_cycle(); }
    static void have_fault(sim::c630s& m) { m.raise(0x620, true); }
    static void end_fault(sim::c630s& m) { m.end_causes(); }
    /// The emergency stop, which input 6 has from the factory.
    static void press_stop(sim::c630s& m) { m.set_input(6, true); }
    static void release_stop(sim::c630s& m) { m.set_input(6, false); }
};

} // namespace seen
