// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Faults of a line, on demand: how often each fault happens, a seeded source that decides frame by frame, and
// what a fault does to a frame's bytes. The same seed gives the same run. The virtual line uses it; include
// it in a simulator of your own, on a pseudo-terminal for example.
//
//     servobus::sim::fault_plan plan;
//     if (!servobus::sim::parse_faults("late,cut", plan)) return 1;
//     servobus::sim::fault_source source{1, plan};
//     std::array<std::uint8_t, servobus::sim::max_spoiled> sent{};
//     const std::size_t size = servobus::sim::spoil(source.decide(), response, sent);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::sim {

/// How often each fault happens, in thousandths of the frames, 0..1000. A frame may have several faults.
struct fault_plan {
    std::uint16_t lost_request = 0;      ///< the device receives nothing
    std::uint16_t corrupted_request = 0; ///< one byte arrives with wrong bits
    std::uint16_t lost_response = 0;
    std::uint16_t late_response = 0;
    std::uint16_t doubled_response = 0;
    std::uint16_t cut_response = 0;       ///< truncated anywhere, at least one byte before the end
    std::uint16_t noise_before = 0;       ///< 1 to 4 random bytes right before the response
    std::uint16_t noise_after = 0;        ///< 1 to 4 random bytes right after it
    std::uint16_t corrupted_response = 0; ///< one byte with wrong bits
    /// In addition to the device's own delay. By default beyond the response limit of each node, and within its limit
    /// and quarantine.
    duration late_by = milliseconds(120);
    /// From the end of a response to the start of its copy. With more than t3.5 the copy can be taken as the
    /// response to the next request: a client cannot distinguish them.
    duration doubled_after = milliseconds(1);
    bool is_unplugged = false; ///< no byte passes in either direction
};

/// A generator of random numbers (PCG-XSH-RR); the same seed gives the same numbers on every machine.
class dice {
  public:
    constexpr explicit dice(std::uint64_t seed) : state_{seed + step} { (void)roll(); }

    constexpr std::uint32_t roll() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005u + step;
        const auto mixed = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<unsigned>(old >> 59);
        return mixed >> turn | mixed << ((32 - turn) & 31);
    }
    /// 0 .. bound - 1. The bound is above 0 and small, so that the bias of the remainder does not matter.
    constexpr std::uint32_t below(std::uint32_t bound) { return roll() % bound; }
    constexpr bool strikes(std::uint16_t per_mille) { return below(1000) < per_mille; }

  private:
    static constexpr std::uint64_t step = 1442695040888963407u;
    std::uint64_t state_;
};

/// The faults of one frame.
struct fate {
    bool is_lost = false;
    bool is_doubled = false;
    bool is_cut = false;
    bool is_corrupted = false;
    std::uint8_t noise_before = 0; ///< bytes
    std::uint8_t noise_after = 0;
    duration delay{};       ///< in addition to the device's own
    std::uint32_t seed = 0; ///< selects where a frame is truncated or corrupted, and the noise

    constexpr bool is_clean() const {
        return !is_lost && !is_doubled && !is_cut && !is_corrupted && noise_before == 0 && noise_after == 0 &&
               delay == duration{};
    }
};

/// Decides the faults of each frame. Each decision uses the same number of random numbers, so that a change
/// of the plan in the middle of a run does not shift the random numbers of later frames.
class fault_source {
  public:
    constexpr explicit fault_source(std::uint64_t seed, const fault_plan& plan = {})
        : plan_{plan}, dice_{seed} {}

    constexpr fault_plan& plan() { return plan_; }
    constexpr const fault_plan& plan() const { return plan_; }

    /// The faults of the next request.
    constexpr fate decide_request() {
        fate f;
        f.is_lost = dice_.strikes(plan_.lost_request) || plan_.is_unplugged;
        f.is_corrupted = dice_.strikes(plan_.corrupted_request);
        f.seed = dice_.roll();
        return f;
    }

    /// The faults of the next response.
    constexpr fate decide() {
        fate f;
        f.is_lost = dice_.strikes(plan_.lost_response) || plan_.is_unplugged;
        f.delay = dice_.strikes(plan_.late_response) ? plan_.late_by : duration{};
        f.is_doubled = dice_.strikes(plan_.doubled_response);
        f.is_cut = dice_.strikes(plan_.cut_response);
        f.noise_before = noise(plan_.noise_before);
        f.noise_after = noise(plan_.noise_after);
        f.is_corrupted = dice_.strikes(plan_.corrupted_response);
        f.seed = dice_.roll();
        return f;
    }

  private:
    constexpr std::uint8_t noise(std::uint16_t per_mille) {
        const bool strikes = dice_.strikes(per_mille);
        const std::uint32_t size = 1 + dice_.below(4);
        return strikes ? static_cast<std::uint8_t>(size) : std::uint8_t{0};
    }

    fault_plan plan_;
    dice dice_;
};

/// Room for the longest frame with noise at both ends.
inline constexpr std::size_t max_spoiled = modbus::max_frame + 8;

/// Writes the bytes that appear on the line into `out`: noise, the frame truncated or with a wrong byte,
/// noise. `out` holds at least `frame.size() + 8` bytes, `max_spoiled` for any frame. Returns the number of
/// bytes; 0 if the frame is lost. The caller applies the delay and sends the copy of a duplicated response.
constexpr std::size_t spoil(const fate& what, bytes frame, byte_buffer out) {
    if (what.is_lost || frame.empty()) return 0;
    dice random{what.seed};
    std::size_t size = 0;
    for (unsigned i = 0; i < what.noise_before; ++i)
        out[size++] = static_cast<std::uint8_t>(random.roll() & 0xFFu);
    const auto length = static_cast<std::uint32_t>(frame.size());
    const std::uint32_t end = what.is_cut ? random.below(length) : length;
    const std::uint32_t wrong = what.is_corrupted ? random.below(length) : length;
    for (std::uint32_t i = 0; i < end; ++i) {
        const std::uint32_t flipped = i == wrong ? 1 + random.below(255) : 0;
        out[size++] = static_cast<std::uint8_t>(frame[i] ^ flipped);
    }
    for (unsigned i = 0; i < what.noise_after; ++i)
        out[size++] = static_cast<std::uint8_t>(random.roll() & 0xFFu);
    return size;
}

namespace detail {
constexpr bool same_word(const char* text, std::size_t length, const char* word) {
    for (std::size_t i = 0; i < length; ++i) {
        if (word[i] == '\0' || text[i] != word[i]) return false;
    }
    return word[length] == '\0';
}

constexpr bool add_fault(const char* text, std::size_t length, fault_plan& plan) {
    if (same_word(text, length, "none")) return true;
    if (same_word(text, length, "late")) {
        plan.late_response = 50;
    } else if (same_word(text, length, "lossy")) {
        plan.lost_request = plan.lost_response = 20;
    } else if (same_word(text, length, "noisy")) {
        plan.noise_before = plan.noise_after = plan.corrupted_response = plan.corrupted_request = 20;
    } else if (same_word(text, length, "doubled")) {
        plan.doubled_response = 50;
    } else if (same_word(text, length, "cut")) {
        plan.cut_response = 20;
    } else if (same_word(text, length, "unplugged")) {
        plan.is_unplugged = true;
    } else {
        return false;
    }
    return true;
}
} // namespace detail

/// Adds faults to a plan by name, from a list separated by commas: `late` (50 of 1000 responses, by 150 ms),
/// `lossy` (20 of 1000 requests, 20 of 1000 responses), `noisy` (noise before and after 20 of 1000 responses
/// each; a wrong byte in 20 of 1000 responses and requests), `doubled` (50 of 1000 responses), `cut` (20 of
/// 1000 responses), `unplugged`, `none`. Returns false and leaves the plan unchanged if a name is unknown or
/// empty.
constexpr bool parse_faults(const char* text, fault_plan& plan) {
    fault_plan parsed = plan;
    while (true) {
        std::size_t length = 0;
        while (text[length] != '\0' && text[length] != ',') ++length;
        if (!detail::add_fault(text, length, parsed)) return false;
        if (text[length] == '\0') break;
        text += length + 1;
    }
    plan = parsed;
    return true;
}

} // namespace servobus::sim
