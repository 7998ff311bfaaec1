// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive on a virtual line at its own baud rate, and a log of the requests on the wire. A test
// connects its program to `line`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <tests/support/transaction_fault.hpp>

namespace simulated {

template <class Model, class Options, std::uint32_t Baud> struct simulated_model {
    using line_type = servobus::line<servobus::sim::virtual_line>;

    refusing<Model> model;
    servobus::sim::station<refusing<Model>> station{model};
    servobus::sim::virtual_line wire;
    line_type line{wire, servobus::modbus::timing_at(Baud)};
    std::vector<std::vector<std::uint8_t>> requests;

    /// `seed`: of the faults of the line.
    explicit simulated_model(Options options = {}, std::uint64_t seed = 1)
        : model{options}, wire{Baud, seed} {
        wire.attach(station);
        wire.set_hook(&simulated_model::note, this);
    }
    simulated_model(const simulated_model&) = delete;
    simulated_model& operator=(const simulated_model&) = delete;

    /// Requests logged so far that equal this frame.
    std::size_t sent(servobus::bytes wanted) const {
        std::size_t n = 0;
        for (const auto& f : requests) n += servobus::same_bytes(f, wanted) ? 1u : 0u;
        return n;
    }

    /// Forgets what has been sent of a request, whose length may be damaged.
    void forget_open_request() { open_.clear(); }

    /// Lets time pass.
    void run(std::uint32_t ms) { wire.pass(servobus::milliseconds(ms)); }

  private:
    static void note(void* self, const servobus::sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& rig = *static_cast<simulated_model*>(self);
        rig.open_.push_back(b.value);
        if (rig.open_.size() != servobus::modbus::request_length(rig.open_)) return;
        rig.requests.push_back(rig.open_);
        rig.open_.clear();
    }

    std::vector<std::uint8_t> open_;
};

} // namespace simulated
