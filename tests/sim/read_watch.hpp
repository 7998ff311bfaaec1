// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a bus sends by itself: the feedback of its drives and its cyclic reads. Each value is one that was read
// (G2). On a line without faults each present node receives its next request in time, and no watchdog stops a
// drive that is known (G19). Absent nodes cost no more time than the plan states and are found again in the
// stated time; a drive of which nothing is known is sent nothing by itself (G28, S1).
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
    read_watch(facade_world& in, fleet& of) : in_{in}, bus_{of}, reads_(of.polls().size()) {
        for (const servobus::controlled_node& d : of.controlled())
            drives_.push_back({.node = &d, .by = in.facade_at(d.address), .heard_at = never});
    }

    void went_off(std::uint8_t node_address) {
        std::erase_if(returning_, [node_address](const returning& r) { return r.address == node_address; });
        for (driven& d : drives_) {
            if (d.node->address == node_address) d.is_taken_over = false;
        }
    }
    void came_back(std::uint8_t node_address) {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            if (polls()[i].node_address == node_address) reads_[i].absence = {};
        }
        for (driven& d : drives_) {
            if (d.node->address == node_address) d.absence = {};
        }
        returning_.push_back({node_address, now(), 1});
    }

    /// A request begins to leave. `whose` is the facade of its node, null if it has none.
    void begins(servobus::bytes frame, const facade* whose, bool is_stop) {
        for (read& r : reads_) r.urgent_frames += is_stop ? 1u : 0u;
        for (driven& d : drives_) d.urgent_frames += is_stop && whose != d.by ? 1u : 0u;
        const bool is_off = participant_at(frame[0]).device().is_off();
        bool is_of_plan = false;
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            const servobus::poll& p = polls()[i];
            if (p.node_address != frame[0]) continue;
            check_keep_alive(i);
            reads_[i].heard_at = is_live(p.node_address) ? now() : never;
            reads_[i].urgent_frames = 0;
            const auto own = servobus::modbus::read_frame(p.node_address, p.address, p.words);
            const servobus::bytes request = own;
            if (!std::equal(frame.begin(), frame.end(), request.begin(), request.end())) continue;
            is_of_plan = true;
            if (!is_off) reads_[i].asked_at = now();
            if (is_off) try_absent(reads_[i].absence, p.keep_alive.us, bus_.longest_us(p));
        }
        if (!is_off) std::erase_if(returning_, [&](const returning& r) { return r.address == frame[0]; });
        for (driven& d : drives_) {
            if (d.by != whose) continue;
            check_gap(d);
            d.heard_at = now();
            d.urgent_frames = 0;
            if (!is_of_plan && is_off) try_absent_drive(d, frame);
        }
    }

    /// Each read of the plan was sent after `at`, but for those of drives that need an init.
    bool are_all_asked_since(std::uint64_t at) const {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            const facade* const f = in_.facade_at(polls()[i].node_address);
            if (reads_[i].asked_at <= at && (f == nullptr || !f->needs_init())) return false;
        }
        return true;
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            if (bus_.count(i) != reads_[i].count) check_value(i);
            reads_[i].count = bus_.count(i);
            if (!is_live(polls()[i].node_address)) reads_[i].heard_at = never;
            check_keep_alive(i);
        }
        for (driven& d : drives_) {
            follow(d);
            check_gap(d);
        }
        end_retry();
        look_for_returned();
    }

  private:
    static constexpr std::uint64_t never = ~std::uint64_t{0};
    struct attempts {
        std::uint32_t made = 0;      ///< since the node is off
        std::uint64_t off_since = 0; ///< when the first of them began
    };
    struct read {
        std::uint64_t heard_at = never; ///< when the last request to the present node began
        std::uint64_t asked_at = 0;     ///< when the read was last sent while the node was present
        std::uint32_t count = 0;
        attempts absence{};
        std::uint32_t urgent_frames = 0; ///< since the last request to the node
    };
    struct driven {
        const servobus::controlled_node* node;
        facade* by;
        std::uint64_t heard_at = 0;      ///< when the last request to it began
        std::uint32_t urgent_frames = 0; ///< of other drives, since then
        attempts absence{};
        bool is_taken_over = true; ///< by an init that was reported done, and never off since
        bool was_idle = true;
    };
    struct returning {
        std::uint8_t address;
        std::uint64_t since;
        std::uint32_t absent_reads;
    };

    std::span<const servobus::poll> polls() const { return bus_.polls(); }
    std::uint64_t now() const { return in_.state().now(); }
    bool is_faultless() const { return in_.is_faultless(); }
    participant& participant_at(std::uint8_t node_address) const {
        for (const auto& s : in_.participants()) {
            if (s->address() == node_address) return *s;
        }
        throw broken{"a plan reads a node that is not on the line"};
    }
    bool is_live(std::uint8_t node_address) const {
        return !participant_at(node_address).device().is_off() && !bus_.is_absent(node_address);
    }

    void follow(driven& d) {
        const bool is_off = d.by->place().device().is_off();
        const bool has_ended = !d.was_idle && d.by->is_idle();
        d.was_idle = d.by->is_idle();
        if (is_off) d.is_taken_over = false;
        if (!is_off && has_ended && d.by->wanted().is_init && d.by->last()) d.is_taken_over = true;
        if (d.by->needs_init()) d.is_taken_over = false; // so the program is told
    }
    // A drive that is known is read in time, and so its watchdog does not stop it.
    void check_gap(const driven& d) const {
        if (!d.is_taken_over || d.heard_at == never || !is_faultless()) return;
        const auto reckoned =
            static_cast<std::uint32_t>(servobus::steps::urgent_frames * (drives_.size() - 1));
        const std::uint32_t more = d.urgent_frames > reckoned ? d.urgent_frames - reckoned : 0;
        const std::uint64_t gap = now() - d.heard_at;
        if (gap > bus_.longest_gap_us(*d.node) + std::uint64_t{more} * bus_.longest_stop_us())
            throw broken{"G19: drive " + std::to_string(d.node->address) + " has received no request for " +
                         std::to_string(gap) + " us, the plan promises " +
                         std::to_string(bus_.longest_gap_us(*d.node))};
        if (more == 0 && d.by->is_stopped_by_watchdog())
            throw broken{"G19: its watchdog has stopped a drive that is known"};
    }

    void check_value(std::size_t i) {
        const std::vector<std::uint16_t> words = bus_.latest(i);
        auto& executed = participant_at(polls()[i].node_address).executed();
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
        // The plan includes one stop of each drive.
        const auto reckoned = static_cast<std::uint32_t>(servobus::steps::urgent_frames * drives_.size());
        const std::uint32_t frames = reads_[i].urgent_frames;
        const std::uint32_t more = frames > reckoned ? frames - reckoned : 0;
        const std::uint64_t gap = now() - reads_[i].heard_at;
        if (gap > most + std::uint64_t{more} * bus_.longest_stop_us())
            throw broken{"G19: node " + std::to_string(polls()[i].node_address) +
                         " has received no request for " + std::to_string(gap) + " us, the plan promises " +
                         std::to_string(most)};
    }

    // A read that the program has not commanded, of a drive that is off.
    void try_absent_drive(driven& d, servobus::bytes frame) {
        if (!servobus::modbus::is_read(frame[1]) || !d.by->is_idle() || d.by->has_open_stop()) return;
        const std::uint32_t watchdog = d.node->keep_alive.us;
        if (d.absence.made != 0 && watchdog != 0 && now() - d.absence.off_since > 2u * watchdog &&
            is_faultless())
            throw broken{"G28: a drive of which nothing is known is read"};
        std::uint32_t longest = 0;
        for (const servobus::poll& p : polls()) longest = std::max(longest, bus_.longest_us(p));
        try_absent(d.absence, 2 * watchdog, longest);
    }
    // A node counts as absent after three attempts, and after its watchdog's time if it has one. The attempts
    // after that cost the others time.
    void try_absent(attempts& of, std::uint32_t keep_alive_us, std::uint32_t longest) {
        if (of.made == 0) of.off_since = now();
        if (!is_faultless() || ++of.made <= servobus::back_off{}.failures) return;
        if (now() - of.off_since <= keep_alive_us) return;
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
        // A drive that needs an init is not polled.
        std::erase_if(returning_, [&](const returning& r) {
            const facade* const f = in_.facade_at(r.address);
            return f != nullptr && (f->needs_init() || !f->is_idle());
        });
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
    std::vector<driven> drives_;
    std::vector<returning> returning_;
    std::uint64_t retried_from_ = never;
    std::uint64_t longest_retry_ = 0;
    std::uint64_t cost_ = 0;
    std::uint64_t begun_ = 0;
    unsigned exchanges_ = 0;
    bool is_retrying_ = false;
};

} // namespace trial
