// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of a scan on a line without faults. An address has no device, one device, or two devices whose
// responses collide. Each finding must be right, and none may take longer than promised.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <servobus/client/scan.hpp>

#include "facade.hpp"

namespace trial {

/// A line with devices but without facades.
class inhabited_line final : public world {
  public:
    inhabited_line(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of)
        : world{seed, count, notes, of}, line_{port(), of.timing, watch{&court()}} {
        port().before_request = [this](servobus::bytes frame) { prepare_devices(frame); };
    }

    plain_line& line() { return line_; }
    participant& settle_one(std::uint8_t node_address) {
        using test_participant = participant_of<plain_line, test_device::device, test_device::registers>;
        return take_in(std::make_unique<test_participant>(state(), line_, others(), test_device::catalogue,
                                                          node_address, baud()));
    }

  private:
    plain_line line_;
};

class scan_run {
  public:
    scan_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)} {
        scene& on = in_.state();
        limits_.response = servobus::duration{on.between(5'000, 60'000) + 4u * on.timing.t3_5};
        for (std::uint8_t node_address = 1; node_address <= last_unit; ++node_address) inhabit(node_address);
        in_.court().set_quiet({});
    }

    world& place() { return in_; }

    void go() {
        scene& on = in_.state();
        for (int round = 0; round < 2; ++round) {
            for (std::uint8_t node_address = 1; node_address <= last_unit; ++node_address)
                look_for(node_address);
            in_.rest(on.random.below(500'000));
        }
    }

  private:
    using presence = servobus::presence;
    static constexpr std::uint8_t last_unit = 40;
    static constexpr std::size_t most_devices = 28; // the line holds 32

    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        c.resolution_us = 1; // a scan sets no gap of the node, which a coarse clock needs
        return c;
    }

    void inhabit(std::uint8_t node_address) {
        scene& on = in_.state();
        const std::uint32_t kind = on.random.below(6);
        const std::uint32_t late = on.timing.t3_5 + on.random.below(limits_.response.us / 2);
        if (kind >= 3 || in_.participants().size() >= most_devices) return;
        in_.settle_one(node_address).set_delay(servobus::duration{late});
        truth_[node_address] = presence::present;
        if (kind != 0) return;
        // The response of the second device begins while that of the first, seven characters long, is on
        // the wire.
        const std::uint32_t apart = on.random.below(on.wire_time(5));
        in_.settle_one(node_address).set_delay(servobus::duration{late + apart});
        truth_[node_address] = presence::garbled;
    }

    void look_for(std::uint8_t node_address) {
        scene& on = in_.state();
        // A register that the device has or one that it refuses: both responses show that it is present.
        const auto address = static_cast<std::uint16_t>(on.one_in(2) ? 0x0010 : 0x7000);
        const servobus::duration bound = in_.line().bound(8, 7, limits_, {});
        for (const auto& s : in_.participants()) s->executed().clear();
        in_.court().begin_operation();
        const std::uint64_t begun = on.now();
        const servobus::finding found = servobus::look_for(in_.line(), node_address, limits_, address);
        const std::uint64_t took = on.now() - begun;
        ++on.count->operations;
        ++on.count->had_to_succeed;
        ++on.count->succeeded;
        on.log->mix(static_cast<std::uint64_t>(found.what));
        if (found.what != truth_[node_address])
            throw broken{"scan: node " + std::to_string(node_address) + " is found " + text(found.what) +
                         ", but it is " + text(truth_[node_address])};
        if (took > 2u * (bound.us + 200u))
            throw broken{"G29: the scan of an address took " + std::to_string(took) + " us, its bound is " +
                         std::to_string(2 * bound.us)};
        if (found.has_word) judge_word(node_address, found.word);
        if (found.what == presence::present && found.has_word != (address == 0x0010))
            throw broken{"scan: a finding has a word after an exception, or none after a value"};
    }
    void judge_word(std::uint8_t node_address, std::uint16_t word) {
        for (const auto& s : in_.participants()) {
            if (s->address() != node_address) continue;
            for (const execution& e : s->executed()) {
                if (!e.words.empty() && e.words[0] == word) return;
            }
        }
        throw broken{"G2: a finding has a word that the register did not have"};
    }

    static const char* text(presence p) {
        static constexpr const char* names[] = {"absent", "present", "garbled", "failed"};
        return names[static_cast<unsigned>(p)];
    }

    inhabited_line in_;
    servobus::response_limits limits_;
    std::array<presence, last_unit + 1> truth_{}; // no response
};

} // namespace trial
