// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What can happen to one transaction of a command on a virtual line, and a simulated drive that refuses a request.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace simulated {

/// A simulated drive that answers with exception 4, device failure, as long as a test wants it to.
template <class Model> struct refusing : Model {
    using Model::Model;

    bool refuses = false;
    unsigned refused = 0; ///< requests

    std::uint8_t read(std::uint16_t address, servobus::slice<std::uint16_t> to) {
        return is_refused() ? exception : Model::read(address, to);
    }
    std::uint8_t write(std::uint16_t address, servobus::words_view from) {
        return is_refused() ? exception : Model::write(address, from);
    }

  private:
    static constexpr std::uint8_t exception = 4;

    bool is_refused() {
        if (refuses) ++refused;
        return refuses;
    }
};

enum class transaction_fault {
    request_lost,
    request_damaged,
    response_lost,
    response_damaged,
    response_cut,
    response_late,    ///< after the limit, so that the next request may be on its way
    response_doubled, ///< its copy follows after the longest gap
    refused,
    port_lost_sending, ///< and back after 50 ms
    port_lost_awaiting,
};
inline constexpr transaction_fault transaction_faults[] = {
    transaction_fault::request_lost,      transaction_fault::request_damaged,
    transaction_fault::response_lost,     transaction_fault::response_damaged,
    transaction_fault::response_cut,      transaction_fault::response_late,
    transaction_fault::response_doubled,  transaction_fault::refused,
    transaction_fault::port_lost_sending, transaction_fault::port_lost_awaiting,
};

/// Disturbs one transaction of the command of a scene. The test calls it before each of its turns.
template <class Scene> class fault_injection {
  public:
    fault_injection(Scene& s, transaction_fault what, std::size_t number)
        : scene_{s}, what_{what}, number_{number}, before_{s.wire.struck()} {}

    void operator()() {
        const std::uint16_t request = scene_.begun() == number_ ? 1000 : 0;
        const std::uint16_t response = scene_.begun() == number_ + 1 ? 1000 : 0;
        servobus::sim::fault_plan& plan = scene_.wire.faults();
        switch (what_) {
        case transaction_fault::request_lost: plan.lost_request = request; break;
        case transaction_fault::request_damaged: plan.corrupted_request = request; break;
        case transaction_fault::response_lost: plan.lost_response = response; break;
        case transaction_fault::response_damaged: plan.corrupted_response = response; break;
        case transaction_fault::response_cut: plan.cut_response = response; break;
        case transaction_fault::response_late: plan.late_response = response; break;
        case transaction_fault::response_doubled: plan.doubled_response = response; break;
        case transaction_fault::refused: scene_.model.refuses = response != 0; break;
        case transaction_fault::port_lost_sending: lose_port(response != 0); break;
        case transaction_fault::port_lost_awaiting:
            lose_port(response != 0 && scene_.frames() == number_ + 1);
            break;
        }
    }
    /// The line is whole again.
    void end() {
        scene_.wire.faults() = {};
        scene_.wire.plug();
        scene_.model.refuses = false;
    }
    bool has_struck() const {
        return has_lost_port_ || scene_.model.refused != 0 || scene_.wire.struck() != before_;
    }

  private:
    void lose_port(bool is_due) {
        if (is_due && !has_lost_port_) {
            has_lost_port_ = true;
            back_at_ = scene_.wire.time_us() + 50'000;
            scene_.wire.unplug();
        }
        if (has_lost_port_ && scene_.wire.time_us() >= back_at_) scene_.wire.plug();
    }

    Scene& scene_;
    transaction_fault what_;
    std::size_t number_;
    std::uint32_t before_;
    std::uint64_t back_at_ = 0;
    bool has_lost_port_ = false;
};

} // namespace simulated
