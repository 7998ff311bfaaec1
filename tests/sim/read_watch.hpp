// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The cyclic reads of a bus. Each value is one that was read (G2). On a line without faults each present
// drive receives its next request in time (G19). Absent drives cost no more time than the plan states,
// including the stops that are sent in place of their reads, and are found again in the stated time (G28).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <servobus/modbus/rtu.hpp>

#include "fleet.hpp"

namespace trial {

class read_watch {
  public:
    read_watch(facade_world& in, fleet& of) : in_{in}, bus_{of}, reads_(of.polls().size()) {}

    void went_off(std::uint8_t node_address) {
        std::erase_if(returning_, [node_address](const returning& r) { return r.address == node_address; });
    }
    void came_back(std::uint8_t node_address) {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            if (polls()[i].node_address == node_address) reads_[i].attempts = 0;
        }
        returning_.push_back({node_address, now(), 1});
    }

    /// A request begins to leave. `whose` is the facade of its node, null if it has none.
    void begins(servobus::bytes frame, const facade* whose, bool is_stop) {
        for (read& r : reads_) r.urgent_frames += is_stop ? 1u : 0u;
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            const servobus::poll& p = polls()[i];
            if (p.node_address != frame[0]) continue;
            check_keep_alive(i);
            reads_[i].heard_at = is_live(p.node_address) ? now() : never;
            reads_[i].urgent_frames = 0;
            const auto own = servobus::modbus::read_frame(p.node_address, p.address, p.words);
            const servobus::bytes request = own;
            const bool is_own = std::equal(frame.begin(), frame.end(), request.begin(), request.end());
            const bool is_off = seat_at(p.node_address).device().is_off();
            if (is_own && !is_off) reads_[i].asked_at = now();
            if (is_off && (is_own || is_for_read(frame, whose))) try_absent(i);
        }
    }

    /// Each read of the plan was sent after `at` while its drive was present.
    bool are_all_asked_since(std::uint64_t at) const {
        return std::all_of(reads_.begin(), reads_.end(), [at](const read& r) { return r.asked_at > at; });
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            if (bus_.count(i) != reads_[i].count) check_value(i);
            reads_[i].count = bus_.count(i);
            if (!is_live(polls()[i].node_address)) reads_[i].heard_at = never;
            check_keep_alive(i);
        }
        end_retry();
        look_for_returned();
    }

  private:
    static constexpr std::uint64_t never = ~std::uint64_t{0};
    struct read {
        std::uint64_t heard_at = never; ///< when the last request to the present drive began
        std::uint64_t asked_at = 0;     ///< when the read was last sent while the drive was present
        std::uint32_t count = 0;
        std::uint32_t attempts = 0;      ///< since the drive is off
        std::uint64_t off_since = 0;     ///< when the first of them began
        std::uint32_t urgent_frames = 0; ///< since the last request to the drive
    };
    struct returning {
        std::uint8_t address;
        std::uint64_t since;
        std::uint32_t absent_reads;
    };

    std::span<const servobus::poll> polls() const { return bus_.polls(); }
    std::uint64_t now() const { return in_.state().now(); }
    bool is_faultless() const { return in_.is_faultless(); }
    seat& seat_at(std::uint8_t node_address) const {
        for (const auto& s : in_.seats()) {
            if (s->address() == node_address) return *s;
        }
        throw broken{"a plan reads a node that is not on the line"};
    }
    bool is_live(std::uint8_t node_address) const {
        return !seat_at(node_address).device().is_off() && !bus_.is_absent(node_address);
    }

    // A stop that the program has not commanded, sent in place of a read.
    static bool is_for_read(servobus::bytes frame, const facade* whose) {
        if (whose == nullptr || !whose->is_idle() || !whose->is_stop(frame)) return false;
        return !whose->has_open_stop(); // else it is the repetition of a commanded stop
    }

    void check_value(std::size_t i) {
        const std::vector<std::uint16_t> words = bus_.latest(i);
        auto& executed = seat_at(polls()[i].node_address).executed();
        const bool was_read = std::any_of(executed.rbegin(), executed.rend(), [&](const execution& e) {
            // The bus may already have begun the next request.
            return !e.is_write && e.refusal == 0 && e.words == words &&
                   e.transaction + 1 >= in_.state().transaction;
        });
        if (!words.empty() && !was_read)
            in_.court().by_chance_or("G2: the bus has a value of node " +
                                     std::to_string(polls()[i].node_address) +
                                     " that the registers did not have when they were read");
        if (executed.size() > 64) executed.erase(executed.begin(), executed.end() - 8);
    }

    void check_keep_alive(std::size_t i) const {
        const std::uint32_t most = polls()[i].keep_alive.us;
        if (most == 0 || reads_[i].heard_at == never || !is_faultless()) return;
        // The plan includes one stop of each facade.
        const auto reckoned =
            static_cast<std::uint32_t>(servobus::steps::urgent_frames * in_.facades().size());
        const std::uint32_t frames = reads_[i].urgent_frames;
        const std::uint32_t more = frames > reckoned ? frames - reckoned : 0;
        const std::uint64_t gap = now() - reads_[i].heard_at;
        if (gap > most + std::uint64_t{more} * bus_.longest_stop_us())
            throw broken{"G19: node " + std::to_string(polls()[i].node_address) +
                         " has received no request for " + std::to_string(gap) + " us, the plan promises " +
                         std::to_string(most)};
    }

    // A drive counts as absent after three attempts, and after its keep-alive if it has one. The attempts
    // after that cost the other drives time.
    void try_absent(std::size_t i) {
        if (reads_[i].attempts == 0) reads_[i].off_since = now();
        if (!is_faultless() || ++reads_[i].attempts <= absence_rules.failures) return;
        if (now() - reads_[i].off_since <= polls()[i].keep_alive.us) return;
        const std::uint32_t longest = bus_.longest_us(polls()[i]);
        if (retried_from_ == never) retried_from_ = now();
        longest_retry_ = std::max<std::uint64_t>(longest_retry_, longest);
        begun_ = now();
        exchanges_ = in_.court().exchanges();
        is_retrying_ = true;
    }
    void end_retry() {
        if (!is_retrying_ || in_.court().exchanges() == exchanges_) return;
        is_retrying_ = false;
        // The next request waits for the quarantine.
        std::uint64_t quiet = 0;
        for (const servobus::poll& p : polls()) quiet = std::max<std::uint64_t>(quiet, p.gaps.quarantine.us);
        cost_ += now() - begun_ + quiet;
        const std::uint64_t allowed =
            (now() - retried_from_) * bus_.absent_load_per_mille() / 1000 + 2 * longest_retry_;
        if (cost_ > allowed)
            throw broken{"G28: absent drives have cost " + std::to_string(cost_) + " us in " +
                         std::to_string(now() - retried_from_) + ", the plan states " +
                         std::to_string(allowed)};
    }

    void look_for_returned() {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            std::erase_if(returning_, [&](const returning& r) {
                return r.address == polls()[i].node_address && reads_[i].asked_at > r.since;
            });
        }
        std::uint32_t absent = 0;
        for (const servobus::poll& p : polls()) absent += is_live(p.node_address) ? 0u : 1u;
        for (returning& r : returning_) {
            r.absent_reads = std::max(r.absent_reads, absent);
            if (is_faultless() && now() - r.since > bus_.found_within_us(r.absent_reads))
                throw broken{"G28: node " + std::to_string(r.address) +
                             " is back and has not been found for " + std::to_string(now() - r.since) +
                             " us, the plan states " + std::to_string(bus_.found_within_us(r.absent_reads))};
        }
    }

    facade_world& in_;
    fleet& bus_;
    std::vector<read> reads_;
    std::vector<returning> returning_;
    std::uint64_t retried_from_ = never;
    std::uint64_t longest_retry_ = 0;
    std::uint64_t cost_ = 0;
    std::uint64_t begun_ = 0;
    unsigned exchanges_ = 0;
    bool is_retrying_ = false;
};

} // namespace trial
