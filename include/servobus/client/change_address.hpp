// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Changes a node's address over the bus. Some drives acknowledge from the old address, some from the new
// one, some use the new one only after their next start, and any acknowledgement may be lost. So the
// function checks at which address the drive responds afterwards. Set-up tools include it.
//
//     const status moved = change_address<c630s::node_address>(servo, 9);
//     if (moved.error() == errc::not_reached) std::puts("switch the drive off and on");
//     else if (!moved) return 1; // otherwise the client has gone on to address 9
#pragma once

#include <array>
#include <cstdint>

#include <servobus/client/client.hpp>
#include <servobus/client/scan.hpp>

namespace servobus {

namespace detail {
/// Writes a setting of the line. Some devices store it by themselves, others at the next save command.
template <const auto& R, class Line, class Device>
constexpr status write_line_setting(client<Line, Device>& of, register_value<R> value) {
    static_assert(has(R.flags, flag::communication), "this register holds no setting of the line");
    if constexpr (has(R.flags, flag::saved_on_write)) {
        return of.template store<R>(value);
    } else {
        return of.template write<R>(value);
    }
}

/// Looks for a drive where none is expected. A lost request or response must not hide it. So it looks as often as
/// a read of the node is tried, at least twice, until something responds. Each look also waits for the quarantine,
/// within which a late response begins.
template <class Line, class Device>
constexpr finding look_hard_for(Line& on, const node<Device>& at, std::uint16_t address) {
    response_limits limits = at.limits;
    limits.response = limits.response + at.gaps.quarantine;
    finding found;
    for (unsigned looks = at.read_retries == 0 ? 2 : at.read_retries + 1u; looks != 0; --looks) {
        found = look_for(on, at.address, limits, address);
        if (found.what != presence::no_response) break;
    }
    return found;
}
} // namespace detail

/// Writes the address `to` into the register `R` of the client's node and checks at which address the drive
/// responds afterwards; the client's node has that address then. Exactly one drive may have the old address:
/// two would both take the new one and execute what is sent there. Blocking. It takes `1 + read_retries`
/// looks (`look_for`) at `to`, at least two, each limited by the sum of the node's response limit and
/// quarantine; a read, unless an echo is ruled out; one write; and three looks with the response limit.
/// Errors before the write: `bad_argument` for an address that the device cannot have, `busy` if anything
/// responds at `to`, the line's own if a look fails. Else the write's own; `not_reached`: the drive responds
/// at the old address only, and takes the new one at its next start or not at all; `timeout`: it responds at
/// neither.
template <const auto& R, class Line, class Device>
constexpr status change_address(client<Line, Device>& of, std::uint8_t to) {
    auto& at = of.node();
    auto& line = of.line();
    node<Device> moved = at;
    moved.address = to;
    if (!moved.is_valid() || to == at.address) return errc::bad_argument;
    const finding before = detail::look_hard_for(line, moved, R.address);
    if (before.what == presence::failed) return before.why.error();
    if (before.what != presence::no_response) return errc::busy;

    const status done = detail::write_line_setting<R>(of, checked(to));
    if (done.outcome() == outcome::not_sent || done.outcome() == outcome::refused) return done;
    // Twice at the new one: the drive may change slowly.
    for (const std::uint8_t node_address : std::array<std::uint8_t, 3>{to, at.address, to}) {
        if (look_for(line, node_address, at.limits, R.address).what != presence::present) continue;
        if (node_address == at.address) return status::sent(errc::not_reached);
        at.address = to;
        return status::sent(errc::ok);
    }
    return status::sent(errc::timeout);
}

} // namespace servobus
