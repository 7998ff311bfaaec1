// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Names the known drive at an address, by registers that only one of them has, and whose values are in their ranges.
// `scan` names what it finds, `doctor` the drive that is there in place of the one on its command line.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <servobus/client/scan.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

namespace tool {

/// A register of a drive, and the words that it may hold.
struct held_by_drive {
    std::uint16_t address = 0;
    std::int64_t low = 0;
    std::int64_t high = 0;
};
template <const auto& Row> constexpr held_by_drive held_in() {
    return {Row.address, Row.limits.low, Row.limits.high};
}

/// The register in which a drive keeps its own address, where no other drive has it, and others whose ranges leave out
/// what a device of another kind is likely to hold there.
struct identity {
    const char* name;
    std::uint16_t own_address;
    std::array<held_by_drive, 3> proofs;
};
inline constexpr identity identities[] = {
    {"zlac8015d",
     servobus::zlac8015d::node_address.address,
     {held_in<servobus::zlac8015d::quick_stop_option_code>(), held_in<servobus::zlac8015d::left_pole_pairs>(),
      held_in<servobus::zlac8015d::rs485_baud_rate>()}},
    {"yako",
     servobus::yako::actual_node_address.address,
     {held_in<servobus::yako::microstep_resolution>(), held_in<servobus::yako::homing_ramp_time>(),
      held_in<servobus::yako::rs485_format>()}},
    {"c630s",
     servobus::c630s::node_address.address,
     {held_in<servobus::c630s::brake_off_to_power_off_delay>(),
      held_in<servobus::c630s::braking_resistor_heat_dissipation>(),
      held_in<servobus::c630s::mode_of_operation>()}},
};

/// Who responds at an address.
struct named_drive {
    const char* name =
        nullptr; ///< `yako` if it does not show which stepper it is; null if it is none or not known
    bool is_judged = true; ///< false: a read that decides had no response
};

namespace detail {
enum class proven : std::uint8_t { yes, no, unanswered };

// By the exceptions of a register that is not there; a busy or failing device does not tell.
inline bool is_refused(const servobus::finding& f) {
    return f.what == servobus::presence::present && f.why.exception() != 0 && f.why.exception() <= 3;
}

template <class Look> proven prove(const identity& of, std::uint8_t node_address, Look& look) {
    const auto judge = [](const servobus::finding& f, bool holds) {
        return f.has_word      ? (holds ? proven::yes : proven::no)
               : is_refused(f) ? proven::no
                               : proven::unanswered;
    };
    const servobus::finding own = look(of.own_address);
    if (const proven p = judge(own, own.word == node_address); p != proven::yes) return p;
    bool differs = false; // from a device that has the same word everywhere
    for (const held_by_drive& h : of.proofs) {
        const servobus::finding f = look(h.address);
        if (const proven p = judge(f, h.low <= f.word && f.word <= h.high); p != proven::yes) return p;
        differs = differs || f.word != own.word;
    }
    return differs ? proven::yes : proven::no;
}
} // namespace detail

/// `look(address)` reads a register of the drive, and returns a `servobus::finding`.
template <class Look> named_drive name_of_drive(std::uint8_t node_address, Look look) {
    named_drive who;
    for (const identity& known : identities) {
        const detail::proven is = detail::prove(known, node_address, look);
        if (is == detail::proven::unanswered) who.is_judged = false;
        if (is != detail::proven::yes) continue;
        if (known.name != std::string_view{"yako"}) return {known.name};
        // Only a closed loop has an encoder.
        const servobus::finding encoder = look(servobus::yako::closed_loop::encoder_resolution.address);
        if (encoder.has_word) return {"yako-closed-loop"};
        return {encoder.what == servobus::presence::present ? "yako-open-loop" : known.name};
    }
    return who;
}

} // namespace tool
