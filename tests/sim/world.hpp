// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line of one run: its baud rate and timing, the first time on its clock, how hostile it is, and the
// devices on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "participant.hpp"
#include "test_device.hpp"
#include "words.hpp"

namespace trial {

/// The properties of a line.
struct conditions {
    servobus::sim::line_settings wire;
    servobus::modbus::rtu_timing timing;
    std::uint32_t resolution_us = 1; ///< of the client's clock
    bool returns_while_nobody_is_there =
        false; ///< the adapter returns requests while no node can receive them
};

inline conditions draw_conditions(servobus::sim::dice& random) {
    static constexpr std::uint32_t rates[] = {1200,  9600,   19200,  38400,  57600,  57600,
                                              57600, 115200, 115200, 115200, 115200, 115200};
    conditions c;
    c.wire.baud = rates[random.below(12)];
    c.wire.echoes = random.below(4) == 0;
    c.wire.start = {random.below(3) == 0 ? ~random.below(3'000'000) : random.roll()};
    const bool is_strict = random.below(2) == 0;
    c.timing = servobus::modbus::timing_at(
        c.wire.baud, is_strict ? servobus::modbus::timing_mode::strict : servobus::modbus::timing_mode::host,
        servobus::microseconds(16'000 + random.below(10'000)));
    // A clock with a resolution of a millisecond is sufficient above 19200 Bd in host timing.
    if (!is_strict && c.wire.baud > 19200 && random.below(4) == 0) c.resolution_us = 1000;
    return c;
}
/// Random numbers for the conditions of a run, independent of those of its traffic.
inline servobus::sim::dice dice_of_conditions(std::uint64_t seed) {
    return servobus::sim::dice{seed * 2654435761u + 7};
}

/// How hostile a line is.
inline std::uint32_t draw_hostility(scene& on) {
    static constexpr std::uint32_t chances[] = {0, 30, 100, 200, 400};
    return chances[on.random.below(5)];
}

class world {
  public:
    world(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of)
        : baud_{of.wire.baud}, resolution_us_{of.resolution_us}, wire_{of.wire},
          log_{2u * of.timing.character + 100, notes}, port_{known(of), judge_, of.resolution_us},
          babbler_{scene_, of.wire.baud}, returns_requests_{of.returns_while_nobody_is_there} {
        scene_.count = &count;
        scene_.random = servobus::sim::dice{seed};
        scene_.manuals = interpretations{seed};
        // The line counts a gap from a look after the last byte to a look before the next one.
        scene_.blur_us = resolution_us_ + 2 * longest_turn_us;
        wire_.set_hook(&world::note_byte, this);
        judge_.set_slack(resolution_us_);
        port_.before_request = [this](servobus::bytes frame) { prepare_devices(frame); };
        stalls_one_in_ = draw_stalls(seed);
        (void)wire_.attach(babbler_);
    }
    world(const world&) = delete;
    world& operator=(const world&) = delete;
    virtual ~world() = default;

    /// The time of a superloop's other work between two steps of its line.
    static constexpr std::uint32_t longest_turn_us = 800;

    /// From now on the program stalls, in half of the runs.
    void begin_to_stall() {
        if (stalls_one_in_ != 0) port_.stalling.allow(scene_.random.roll(), stalls_one_in_);
    }

    /// From now on the program stalls, whatever was drawn.
    void stall_always() {
        static constexpr std::uint32_t chances[] = {10'000, 40'000, 150'000};
        port_.stalling.allow(scene_.random.roll(), chances[scene_.random.below(3)]);
    }

    std::uint32_t hostility = 0; ///< faults in a thousand frames
    std::uint32_t events = 0;    ///< other events in a thousand operations

    scene& state() { return scene_; }
    judge& court() { return judge_; }
    record& log() { return log_; }
    shaky_port& port() { return port_; }
    servobus::sim::virtual_line& wire() { return wire_; }
    babbler& others() { return babbler_; }
    std::vector<std::unique_ptr<participant>>& participants() { return participants_; }
    participant& any_participant() {
        return *participants_[scene_.random.below(static_cast<std::uint32_t>(participants_.size()))];
    }
    std::uint32_t resolution_us() const { return resolution_us_; }
    bool is_strict() const { return scene_.timing.mode == servobus::modbus::timing_mode::strict; }
    bool has_only_test_devices() const { return has_only_test_devices_; }
    /// No device is on the line.
    bool is_empty() const { return is_empty_; }

    /// The client does nothing for a time.
    void rest(std::uint64_t us) {
        scene_.hide_pause(); // the program does not look meanwhile
        scene_.stalled_us += us;
        const std::uint64_t end = wire_.time_us() + us;
        while (wire_.time_us() < end) {
            port_.look();
            const std::uint64_t left = end - wire_.time_us();
            std::uint64_t next = port_.next_plan();
            next = next > wire_.time_us() ? next - wire_.time_us() : left;
            const std::uint64_t step = std::min({left, next, std::uint64_t{1'000'000'000}});
            wire_.pass(servobus::duration{static_cast<std::uint32_t>(step)});
        }
        port_.look();
        scene_.hide_pause(); // also one of a response that came meanwhile
    }

    /// A node on the line sends without pause for a time. Returns the time at which it ends.
    std::uint64_t let_talk(std::uint32_t us) {
        const bool is_stuck = scene_.one_in(2);
        scene_.strikes(is_stuck ? strike::stuck_talker : strike::babbling_node);
        const std::uint64_t end = is_stuck ? babbler_.drone(us) : babbler_.babble(us);
        scene_.sounds_until(end);
        wire_.pass(servobus::microseconds(1)); // the line reads the schedule of the new bytes
        return end;
    }

    bool is_free(std::uint8_t node_address) const {
        for (const auto& s : participants_) {
            if (s->device_address() == node_address || s->address() == node_address) return false;
        }
        return true;
    }
    std::uint8_t free_unit() {
        for (;;) {
            const auto node_address = static_cast<std::uint8_t>(scene_.between(1, 120));
            if (is_free(node_address)) return node_address;
        }
    }

    void print() {
        vocabulary maps;
        for (const auto& s : participants_) maps[s->address()] = &s->map();
        trial::print(log_, maps, test_device::catalogue);
    }

  private:
    static void note_byte(void* self, const servobus::sim::wire_byte& b) {
        world& w = *static_cast<world*>(self);
        w.log_.byte(b.at_us, b.value, b.is_from_client);
        const bool is_kept_back = w.port_.is_gone() || w.port_.echo.is_holding();
        if (!b.is_from_client && !is_kept_back) w.judge_.arrives(b.at_us, b.value);
    }

    static std::uint32_t draw_stalls(std::uint64_t seed) {
        static constexpr std::uint32_t chances[] = {0, 0, 0, 500, 2'000, 10'000};
        return chances[servobus::sim::dice{seed * 0x85EB'CA6Bu + 3}.below(6)];
    }

    scene scene_;
    std::uint32_t baud_;
    std::uint32_t stalls_one_in_ = 0; ///< calls of the port
    std::uint32_t resolution_us_;
    servobus::sim::virtual_line wire_;
    record log_;
    judge judge_{scene_};
    shaky_port port_;
    babbler babbler_;
    std::vector<std::unique_ptr<participant>> participants_;
    bool returns_requests_;

  protected:
    std::uint32_t baud() const { return baud_; }
    void prepare_devices(servobus::bytes frame) {
        bool is_anyone_there = false;
        for (const auto& s : participants_) {
            const bool is_asked = frame[0] == s->device_address() || frame[0] == 0;
            is_anyone_there = is_anyone_there || is_asked;
            s->device().prepare(frame.size(), is_asked);
        }
        if (!returns_requests_) return;
        const bool is_returned = wire_.is_cut() || !is_anyone_there;
        wire_.set_unanswered_return(servobus::duration{is_returned ? scene_.between(1, 3'000) : 0u});
        if (is_returned) scene_.strikes(strike::returned_request, false);
    }
    /// Adds a place, and attaches its device to the line unless the line is empty.
    participant& take_in(std::unique_ptr<participant> s) {
        scene_.kinds[s->device_address()] = s->kind();
        scene_.positions[s->device_address()] = s->positions();
        participants_.push_back(std::move(s));
        has_only_test_devices_ = has_only_test_devices_ && participants_.back()->is_test_device();
        if (!is_empty_) (void)wire_.attach(participants_.back()->device());
        return *participants_.back();
    }
    void be_empty() { is_empty_ = true; }

  private:
    // Fills in the scene before the port is constructed, since the port uses it immediately.
    scene& known(const conditions& of) {
        scene_.wire = &wire_;
        scene_.log = &log_;
        scene_.timing = of.timing;
        return scene_;
    }

    bool has_only_test_devices_ = true;
    bool is_empty_ = false;
};

/// Sets limits that fit the device, as a user of the library would choose them.
inline void settle(world& in, participant& s) {
    scene& on = in.state();
    const std::uint32_t t3_5 = on.timing.t3_5;
    const std::uint32_t own = s.own_delay().us;
    s.limits().response = servobus::duration{on.between(30'000, 120'000) + 4 * t3_5 + own};
    s.limits().turnaround = servobus::duration{on.between(2'000, 20'000)};
    s.limits().leading_bytes = on.one_in(4) ? std::uint8_t{0} : std::uint8_t{4};
    s.gaps().quarantine = servobus::duration{on.between(30'000, 150'000) + 2 * t3_5 + own};
    s.gaps().gap = servobus::duration{on.one_in(3) ? on.between(0, 10'000) : 0u};
    // A coarse clock may show up to one tick more than has passed, but the drive needs t3.5.
    if (in.resolution_us() > 1) s.gaps().gap.us += t3_5 + in.resolution_us();
    const std::uint32_t most = std::min(s.limits().response.us * 6 / 10, s.gaps().quarantine.us * 8 / 10);
    s.usual_delay_us = on.one_in(4) ? on.between(t3_5, most) : t3_5 + on.random.below(500);
    s.usual_delay_us = std::max(s.usual_delay_us, own);
    s.set_delay(servobus::duration{s.usual_delay_us});
    s.set_listening(on.one_in(2));
}

} // namespace trial
