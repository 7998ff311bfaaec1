// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the author of a drive says to the judges of sim/conformance.hpp: how the simulated drive is seen from outside,
// what may happen to it, and the drive's own commands. examples/own_device/own_subject.hpp has one for the winch.
//
//     template <class S> unsigned interpretations() {
//         static_assert(sim::conformance_subject<S>, "the subject of a drive lacks something");
//         return S::interpretations;
//     }
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>

#include <servobus/sim/conformance/expected.hpp>

namespace servobus::sim {

namespace detail {
struct any_command_of_a_subject {
    template <class Enable, class Command>
    void operator()(const char*, const Enable&, const Command&, const expected&) const {}
};
} // namespace detail

/// What the author of a drive says to the kit. All of it is needed: what a drive cannot do is a function that does
/// nothing, and is said so by a constant.
template <class S>
concept conformance_subject = requires {
    typename S::machine;
}
&&requires(typename S::machine& m, const typename S::machine& seen, detail::any_command_of_a_subject each) {
    { S::address } -> std::convertible_to<std::uint8_t>;
    { S::baud } -> std::convertible_to<std::uint32_t>;
    { S::interpretations } -> std::convertible_to<unsigned>; // interpretations of the manual, at least 1
    { S::tolerance } -> std::convertible_to<std::int64_t>;   // of a place, in its counts
    { S::shows(0u) } -> std::same_as<what_shows>;
    // False for a command, by the name in a finding, that cannot be confirmed under an interpretation, and so must
    // fail.
    { S::can_be_done(0u, "") } -> std::same_as<bool>;
    { S::energises_by_reset } -> std::convertible_to<bool>; // a fault reset may
    // A stop or a start that meets a drive without power, such as one that has restarted, may energise it.
    { S::energises_by_level } -> std::convertible_to<bool>;
    {S::make(0u)};
    { S::is_energised(seen) } -> std::same_as<bool>;
    { S::is_turning(seen) } -> std::same_as<bool>;
    // The place of the shaft, which neither a restart nor clearing changes.
    { S::place(seen) } -> std::convertible_to<std::int64_t>;
    { S::starts(seen) } -> std::convertible_to<std::uint32_t>; // moves that it has begun
    S::restart(m);
    S::have_fault(m);
    S::end_fault(m);
    S::press_stop(m);
    S::release_stop(m);
    S::write_by_another(m); // a setting that no command of the program relies on
    S::commands(each);      // each(name, how it is enabled, command, expected)
};

} // namespace servobus::sim
