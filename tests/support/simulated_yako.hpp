// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated YAKOTEC stepper on a virtual line, and a log of the requests that passed on the wire. A machine
// with switches hangs on its shaft if it is asked for.
#pragma once

#include <cstddef>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>

namespace simulated {

/// Eight turns between the limits, with the home switch around the middle and hard stops a turn beyond.
inline servobus::sim::yako_machine yako_slide() {
    servobus::sim::yako_machine m;
    m.negative_stop = -5000;
    m.negative_limit = -4000;
    m.home_from = -250;
    m.home_to = 250;
    m.positive_limit = 4000;
    m.positive_stop = 5000;
    m.index = 100;
    return m;
}

/// `Model` is `sim::yako_closed_loop` or `sim::yako_open_loop`.
template <class Model> struct yako_rig {
    using line_type = servobus::line<servobus::sim::virtual_line>;

    Model model;
    servobus::sim::station<Model> station{model};
    servobus::sim::virtual_line wire{115200};
    line_type line{wire, servobus::modbus::timing_at(115200)};
    std::vector<std::vector<std::uint8_t>> requests;

    explicit yako_rig(servobus::sim::yako_options options = {}) : model{options} {
        wire.attach(station);
        wire.set_hook(&yako_rig::note, this);
    }
    yako_rig(const yako_rig&) = delete;
    yako_rig& operator=(const yako_rig&) = delete;

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
        auto& rig = *static_cast<yako_rig*>(self);
        rig.open_.push_back(b.value);
        if (rig.open_.size() != servobus::modbus::request_length(rig.open_)) return;
        rig.requests.push_back(rig.open_);
        rig.open_.clear();
    }

    std::vector<std::uint8_t> open_;
};

using yako_closed_loop_rig = yako_rig<servobus::sim::yako_closed_loop>;
using yako_open_loop_rig = yako_rig<servobus::sim::yako_open_loop>;

} // namespace simulated
