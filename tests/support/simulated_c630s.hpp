// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated C630S on a virtual line, as it comes from the factory: node 1, 57600 Bd. Its reply waits for
// P0C-25. Whoever tests a program hangs it on `line`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/modbus/rtu.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace simulated {

struct c630s_rig {
    servobus::sim::c630s model;
    servobus::sim::station<servobus::sim::c630s> station{model};
    servobus::sim::virtual_line wire{57600};
    using line_type = servobus::line<servobus::sim::virtual_line>;
    line_type line{wire, servobus::modbus::timing_at(57600)};

    std::vector<std::vector<std::uint8_t>> requests;

    explicit c630s_rig(servobus::sim::c630s_options options = {}) : model{options} {
        wire.attach(station);
        wire.set_hook(&c630s_rig::note, this);
    }
    c630s_rig(const c630s_rig&) = delete;
    c630s_rig& operator=(const c630s_rig&) = delete;

    /// Requests logged so far that equal this frame.
    std::size_t sent(servobus::bytes wanted) const {
        std::size_t n = 0;
        for (const auto& f : requests) n += servobus::same_bytes(f, wanted) ? 1u : 0u;
        return n;
    }

    /// Lets time pass.
    void run(std::uint32_t ms) { wire.pass(servobus::milliseconds(ms)); }

  private:
    static void note(void* self, const servobus::sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& rig = *static_cast<c630s_rig*>(self);
        rig.open_.push_back(b.value);
        if (rig.open_.size() != servobus::modbus::request_length(rig.open_)) return;
        rig.requests.push_back(rig.open_);
        rig.open_.clear();
    }

    std::vector<std::uint8_t> open_;
};

} // namespace simulated
