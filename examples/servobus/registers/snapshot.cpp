// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "snapshot.hpp"

#include <algorithm>

#include "../os/interrupts.hpp"

namespace tool {

bool snapshot::has_answer() const { return std::ranges::any_of(readings, &reading::is_read); }

bool snapshot::has_port() const {
    return std::ranges::none_of(
        readings, [](const reading& r) { return r.status.error() == servobus::errc::port_lost; });
}

std::optional<snapshot> take_snapshot(session& on, const target& of, std::span<const chosen> wanted) {
    snapshot taken{std::chrono::system_clock::now()};
    bool has_port = true;
    for (const chosen& what : wanted) {
        if (interrupts::came()) return std::nullopt;
        if (!has_port) {
            reading skipped = taken.readings.back();
            skipped.was_asked = false;
            taken.readings.push_back(skipped);
            continue;
        }
        reading r{std::vector<u16>(what.words)};
        r.status = on.read(what, r.words);
        if (!r.is_read()) r.why = why_text(of, r.status, on) + advice_on_number(what, r.status);
        has_port = r.status.error() != servobus::errc::port_lost;
        taken.readings.push_back(std::move(r));
    }
    return taken;
}

} // namespace tool
