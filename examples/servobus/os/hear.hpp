// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Sends a request as it is, without the rules of a client, and keeps all that comes: what a client drops shows what is
// wrong with a line.
#pragma once

#include <utility>

#include "../frames/overheard.hpp"
#include "port.hpp"

namespace tool {

/// A second response of another device at the same address begins within this after the first.
inline constexpr servobus::duration until_second_response = servobus::milliseconds(25);

/// Sends a read and listens until a response has come and the line has rested, else for `longest`. An empty request: it
/// listens for so long. Ends early if the port is lost.
inline overheard hear(any_port& on, servobus::bytes request, servobus::duration longest) {
    constexpr servobus::duration most_after = servobus::milliseconds(300); // on a line that never rests
    overheard h;
    h.request.assign(request.begin(), request.end());
    std::uint8_t room[256];
    std::size_t sent = 0;
    bool has_left = request.empty(), is_answered = false;
    servobus::instant begun = on.now();
    servobus::instant last = begun;
    const auto is_over = [&] {
        const servobus::duration gone = since(begun, on.now());
        if (longest + most_after <= gone) return true;
        if (!is_answered && gone < longest) return false;
        return h.request.empty() || until_second_response <= since(last, on.now());
    };
    // A gateway may have closed its connection since the last response.
    bool is_anew = !on.is_network();
    const auto connects_anew = [&] {
        if (std::exchange(is_anew, true) || on.reopen() != servobus::errc::ok) return false;
        sent = 0;
        has_left = request.empty();
        begun = last = on.now();
        return true;
    };
    while (!is_over()) {
        if (sent != request.size()) {
            const servobus::transfer took = on.send(request.subspan(sent));
            if (!took && !connects_anew()) return h;
            if (took) sent += *took;
        }
        if (!has_left && sent == request.size() && on.sent()) {
            has_left = true;
            begun = on.now();
        }
        const servobus::transfer got = on.receive(room);
        if (!got && h.came.empty() && connects_anew()) continue;
        if (!got) return h;
        if (*got == 0) {
            on.wait(servobus::milliseconds(1));
            continue;
        }
        last = on.now();
        const servobus::duration at = has_left ? since(begun, last) : servobus::duration{};
        for (std::size_t i = 0; i < *got; ++i) h.came.push_back({at, room[i]});
        const parsed_read so_far = parse_overheard(h);
        is_answered = is_answered || !so_far.responses.empty() || so_far.of_gateway != 0;
    }
    h.listened = since(begun, on.now());
    return h;
}

} // namespace tool
