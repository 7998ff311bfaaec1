// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What an adapter with a local echo does to the echo of a request: a byte is changed, the end is lost, or the
// whole echo arrives late, as with USB, and with it everything that follows.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/line/port.hpp>

#include "scene.hpp"

namespace trial {

class echo_path {
  public:
    explicit echo_path(scene& on) : on_{&on} {}

    /// From now on the echo is passed on, and faults affect it.
    void be_kept() { is_kept_ = true; }

    /// A request of this size begins to leave.
    void begins(std::size_t size) {
        if (!is_kept_) return;
        size_ = size;
        heard_ = 0;
        changed_at_ = lost_from_ = nowhere;
        if (on_->random.below(2000) < on_->chance) strike_at(static_cast<std::uint32_t>(size));
    }
    /// The port is lost, and with it the bytes that the adapter held back.
    void is_lost() { on_->held_until = 0; }

    bool is_holding() const { return on_->now() < on_->held_until; }

    /// Passes on the bytes that came from the wire, except those that a fault removes. Returns their number.
    servobus::transfer pass_on(servobus::byte_buffer in, servobus::transfer came) {
        if (!is_kept_ || !came) return came;
        std::uint16_t given = 0;
        for (std::uint16_t i = 0; i < *came; ++i) {
            const std::size_t at = heard_ < size_ ? heard_++ : nowhere;
            if (at != nowhere && at >= lost_from_) continue;
            in[given++] =
                at != nowhere && at == changed_at_ ? static_cast<std::uint8_t>(in[i] ^ wrong_bits_) : in[i];
        }
        return given;
    }

  private:
    static constexpr std::size_t nowhere = ~std::size_t{0};

    void strike_at(std::uint32_t size) {
        scene& on = *on_;
        // If the exchange ends early, its response arrives when no exchange waits for it.
        switch (on.random.below(4)) {
        case 0:
            on.strikes(strike::changed_echo);
            on.may_end_early = true;
            changed_at_ = on.random.below(size);
            wrong_bits_ = static_cast<std::uint8_t>(on.between(1, 255));
            return;
        case 1:
            on.strikes(strike::lost_echo);
            on.may_end_early = true;
            lost_from_ = on.one_in(2) ? 0 : on.random.below(size);
            return;
        default: hold(size);
        }
    }

    // A line waits for the echo for the duration of the frame and a pause of the adapter.
    void hold(std::uint32_t size) {
        scene& on = *on_;
        const std::uint32_t grace = on.wire_time(size) + on.timing.inter_byte.us + on.timing.t3_5;
        const bool is_too_late = on.one_in(4);
        on.strikes(strike::late_echo, is_too_late);
        std::uint32_t late = on.between(0, grace * 8 / 10);
        if (is_too_late) {
            on.may_end_early = true;
            late = grace + on.wire_time(3) + 1'000 + on.between(1, on.model.quarantine_us * 6 / 10);
        } else {
            on.borne = "G4";
        }
        on.held_until = on.now() + on.wire_time(size) + late;
    }

    scene* on_;
    std::size_t size_ = 0;
    std::size_t heard_ = 0;
    std::size_t changed_at_ = nowhere;
    std::size_t lost_from_ = nowhere;
    std::uint8_t wrong_bits_ = 0;
    bool is_kept_ = false;
};

} // namespace trial
