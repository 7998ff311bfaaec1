// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The cyclic reads of a bus: which is due, its exchange, and its last values. A read of a node with a facade belongs to
// that drive: it is sent while the drive knows of no restart, in the drive's word order. One read is under way at a
// time. bus.hpp gives it its turn on the line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/bus/detail/drive_list.hpp>
#include <servobus/bus/detail/planned_rows.hpp>
#include <servobus/bus/detail/read_order.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/core/epoch.hpp>
#include <servobus/core/status.hpp>
#include <servobus/modbus/exchange.hpp>

namespace servobus::detail {

/// The reads of `Plan`, with the line and the drives of its bus.
template <const auto& Plan, class Line, class... Drives> class cyclic_reads {
  protected:
    static constexpr std::size_t size = Plan.size;
    static constexpr duration longest_idle = milliseconds(5);

    constexpr explicit cyclic_reads(Line& on, Drives&... drives) : line_{&on}, drives_{drives...} {
        const instant now = on.now();
        last_retry_ = now;
        for (std::size_t i = 0; i < size; ++i) {
            states_[i].due = now;
            use_word_order(i, Plan.polls[i].word_order);
        }
    }

    constexpr bool is_read_on_the_wire() const { return reading_ != none && !is_read_waiting(); }
    constexpr bool is_read_waiting() const {
        return reading_ != none && exchange_.state() == Line::exchange::phase::ready;
    }
    /// The time within which nothing happens unless a byte arrives.
    constexpr duration step_reads() {
        if constexpr (size == 0) {
            return longest_idle;
        } else {
            // The program may have stalled since the read was begun.
            if (is_read_waiting() && !is_known(reading_)) {
                line_->abandon(exchange_);
                reading_ = none;
            }
            if (reading_ == none) {
                const duration idle = begin_due();
                if (reading_ == none) return idle;
            }
            const duration idle = line_->step(exchange_, Plan.polls[reading_].gaps);
            if (!exchange_.done()) return idle;
            conclude();
            return {};
        }
    }
    // Drops the values of reads whose drive is not known any more. Such a read is due as soon as it is known again.
    constexpr void drop_values_of_lost_drives() {
        if constexpr (Plan.drives != 0) {
            drives_.each([this](std::size_t k, const auto& drive) {
                if (!has_reads.of[k] || is_known(drive)) return;
                for (std::size_t i = 0; i < size; ++i) {
                    if (Plan.polls[i].node_address != Plan.controlled[k].address) continue;
                    states_[i].has_values = false;
                    states_[i].failures = 0;
                }
                pause_ = {};
            });
        }
    }
    // Drops values so old that the clock may wrap: they would seem new then.
    constexpr void drop_old_values() {
        const instant now = line_->now();
        if (since(dropped_at_, now) < longest_pause) return;
        dropped_at_ = now;
        for (state& s : states_) s.has_values = has_values(s, now);
    }
    // Returns ok, or the reason why a read has no values that are young enough.
    constexpr status why_not(std::size_t i, duration oldest, [[maybe_unused]] bool is_of_pairs) const {
        const state& s = states_[i];
        if (!is_known(i)) return errc::needs_init;
        const instant now = line_->now();
        if (!has_values(s, now) || since(s.taken, now) > oldest)
            return s.why.error() == errc::ok ? status{errc::timeout} : s.why;
        if constexpr (Plan.has_pairs) {
            if (is_of_pairs && order_of(i) == word_order::unknown) return errc::needs_word_order;
            if (is_of_pairs && order_of(i) != s.order.taken_in) return errc::timeout;
        }
        return {};
    }
    template <const auto& R>
    constexpr result<reading<R>> latest_row(place_of_rows at, duration oldest) const {
        constexpr bool is_pair = needs_word_order<R>();
        if (const status why = why_not(at.read, oldest, is_pair); !why) return why;
        if constexpr (is_bit<R>)
            return reading_of<R>(bit_at(at.offset));
        else if constexpr (takes_words<typename row_type<R>::value_type>)
            return codec<typename row_type<R>::value_type>::template value_in<R>(
                [&](std::size_t i) { return words_[at.offset + i]; }, taken_in(at.read));
        else if constexpr (is_pair)
            return reading_of<R>(join_words(words_[at.offset], words_[at.offset + 1], taken_in(at.read)));
        else
            return reading_of<R>(words_[at.offset]);
    }
    template <const auto&... Rs>
    constexpr result<readings<Rs...>> latest_rows(place_of_rows at, duration oldest) const {
        using values = readings<Rs...>;
        if (const status why = why_not(at.read, oldest, values::has_pairs); !why) return why;
        values v{taken_in(at.read)};
        constexpr const auto& plan = values::plan; // its requests are parts of the read
        if constexpr (requires { v.words(); }) {
            const auto words = v.words();
            std::size_t k = 0;
            for (std::size_t i = 0; i < plan.count; ++i) {
                const std::size_t from = at.offset + plan.requests[i].address - plan.requests[0].address;
                for (std::size_t w = 0; w < plan.requests[i].words; ++w) words[k++] = words_[from + w];
            }
        } else {
            for (std::size_t i = 0; i < plan.count; ++i) {
                const auto& part = plan.requests[i];
                const std::size_t from = at.offset + part.address - plan.requests[0].address;
                std::uint8_t data[plan.bytes]{};
                for (std::size_t k = 0; k < part.quantity; ++k) {
                    if (part.has_bits()) {
                        data[k / 8] = static_cast<std::uint8_t>(data[k / 8] | bit_at(from + k) << k % 8);
                    } else {
                        data[2 * k] = static_cast<std::uint8_t>(words_[from + k] >> 8);
                        data[2 * k + 1] = static_cast<std::uint8_t>(words_[from + k]);
                    }
                }
                (void)v.take(i, bytes{data}.first(part.size()));
            }
        }
        return v;
    }
    constexpr void use_word_order([[maybe_unused]] std::size_t i, [[maybe_unused]] word_order order) {
        if constexpr (Plan.has_pairs)
            states_[i].order.learned = {order, line_->epoch(Plan.polls[i].node_address)};
    }
    /// True while the node does not respond to its reads and is asked less often.
    constexpr bool is_asked_less(std::uint8_t node_address) const {
        const instant now = line_->now();
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == node_address && is_asked_less(i, now)) return true;
        }
        return false;
    }
    /// Good responses to read number `i`.
    constexpr std::uint32_t responses(std::size_t i) const { return states_[i].count; }
    constexpr std::uint16_t read_ticket() const { return exchange_.ticket(); }

    Line* line_;
    [[no_unique_address]] drive_list<Drives...> drives_;

  private:
    static constexpr std::size_t none = size;
    static constexpr duration longest_pause = milliseconds(1000); // between searches through all reads

    struct state {
        instant due{};
        instant taken{};
        std::uint32_t count = 0;
        status why{};
        std::uint8_t failures = 0;
        bool has_values = false;
        [[no_unique_address]] read_order<Plan.has_pairs> order;
    };

    // The drives that have cyclic reads.
    struct flags {
        bool of[Plan.drives + 1]{};
    };
    static constexpr flags has_reads = [] {
        flags has{};
        for (std::size_t i = 0; i < size; ++i) has.of[Plan.drive_at(Plan.polls[i].node_address)] = true;
        return has;
    }();

    // Calls `call(drive)` with the facade of read number `i`'s node, if it has one.
    template <class Call> constexpr void with_drive_of(std::size_t i, Call&& call) const {
        const std::size_t own = Plan.drive_at(Plan.polls[i].node_address);
        drives_.each([&](std::size_t k, auto& drive) {
            if (k == own) call(drive);
        });
    }
    template <class Drive> constexpr bool is_known(const Drive& drive) const {
        return drive.machine().is_known(line_->now(), line_->epoch(drive.address()));
    }
    // The node may be read, and its values count: it has no facade, or one that knows of no restart.
    constexpr bool is_known(std::size_t i) const {
        bool is = true;
        with_drive_of(i, [&](const auto& drive) { is = is_known(drive); });
        return is;
    }
    // The word order of a read's values; without 32-bit values there is none.
    constexpr word_order taken_in([[maybe_unused]] std::size_t i) const {
        if constexpr (Plan.has_pairs)
            return states_[i].order.taken_in;
        else
            return word_order::high_first;
    }
    // The word order of the node's facade. Without one: the learned one, or the one that the node was made with if the
    // node may have restarted since.
    constexpr word_order order_of(std::size_t i) const {
        const verified<word_order>& learned = states_[i].order.learned;
        const bool holds = learned.holds(line_->epoch(Plan.polls[i].node_address));
        word_order order = holds ? learned.value : Plan.polls[i].word_order;
        with_drive_of(i, [&](const auto& drive) {
            if constexpr (requires { drive.current_word_order(); }) order = drive.current_word_order();
        });
        return order;
    }
    // A keep-alive read does not back off until the node's own watchdog has passed: the node may still receive it.
    constexpr bool is_asked_less(std::size_t i, instant now) const {
        const state& s = states_[i];
        const duration alive = Plan.polls[i].keep_alive;
        return s.failures >= Plan.rules().failures &&
               (alive == duration{} || !has_values(s, now) || since(s.taken, now) > alive);
    }
    constexpr bool has_values(const state& s, instant now) const {
        return s.has_values && since(s.taken, now) <= longest_period;
    }

    // Begins the read that has waited longest. Returns the time to the next one. A search that finds none is not
    // repeated before the first is due: a step costs the same, however many reads there are.
    constexpr duration begin_due() {
        const instant now = line_->now();
        if (const duration passed = since(searched_at_, now); passed < pause_)
            return shorter_of(pause_ - passed, longest_idle);
        std::size_t best = none;
        duration waited{};
        duration next = longest_pause;
        for (std::size_t i = 0; i < size; ++i) {
            const state& s = states_[i];
            const duration ahead = since(now, s.due); // beyond a period the clock has jumped or wrapped
            if (went_back(s.due, now) && ahead <= Plan.polls[i].period) {
                next = shorter_of(next, ahead);
            } else if (is_asked_less(i, now) && since(last_retry_, now) < Plan.rules().retry_every) {
                next = shorter_of(next, Plan.rules().retry_every - since(last_retry_, now));
            } else if (!is_known(i)) {
                continue; // it is due as soon as its drive is known: `drop_values_of_lost_drives` ends the pause
            } else if (best == none || since(s.due, now) > waited) {
                best = i;
                waited = since(s.due, now);
            }
        }
        searched_at_ = now;
        pause_ = best == none ? next : duration{};
        if (best == none) return shorter_of(next, longest_idle);
        schedule(best, now);
        begin(best);
        return {};
    }
    constexpr void schedule(std::size_t i, instant now) {
        const poll& p = Plan.polls[i];
        state& s = states_[i];
        if (is_asked_less(i, now)) last_retry_ = now;
        // A read that came late is not sent twice: the next one is due a period after this one.
        s.due = since(s.due, now) < p.period ? s.due + p.period : now + p.period;
    }
    constexpr void begin(std::size_t i) {
        const poll& p = Plan.polls[i];
        request_[0] = p.node_address;
        const byte_buffer pdu = byte_buffer{request_}.subspan(1);
        std::size_t response = 5u + 2u * p.words;
        auto code = modbus::function::read_holding_registers;
        if constexpr (Plan.has_other_tables) {
            code = static_cast<modbus::function>(p.code);
            response = p.response_size();
        }
        modbus::put_trusted_request(pdu, code, p.address, Plan.has_other_tables ? p.quantity : p.words);
        exchange_.restart(modbus::close_trusted<typename Line::crc>(request_, 5),
                          byte_buffer{response_}.first(response), line_->timing(), p.limits,
                          priority::planned);
        reading_ = i;
    }
    constexpr void conclude() {
        state& s = states_[reading_];
        s.why = exchange_.status();
        if constexpr (Plan.has_other_tables) {
            if (s.why.error() == errc::ok && !exchange_.differs_from_request() &&
                !line_->is_echo_ruled_out(request_[0]))
                s.why = status::sent(errc::own_echo);
            if (s.why.error() == errc::ok && !has_zero_padding())
                s.why = status::sent(errc::unexpected_value);
        }
        if (s.why.error() == errc::ok) {
            const std::size_t at = Plan.offset_of(reading_);
            if (Plan.has_other_tables && Plan.polls[reading_].code <= 0x02) {
                keep_bits(at);
            } else {
                for (std::size_t i = 0; i < exchange_.words().size(); ++i)
                    words_[at + i] = exchange_.words()[i];
            }
            s.taken = line_->began_at();
            if constexpr (Plan.has_pairs) s.order.taken_in = order_of(reading_);
            s.has_values = true;
            ++s.count;
        }
        if (exchange_.status().has_response()) {
            s.failures = 0;
        } else if (s.failures < Plan.rules().failures) {
            ++s.failures;
        }
        // A read that took longer than its period goes after those that became due meanwhile.
        if (const instant now = line_->now(); !went_back(s.due, now)) s.due = now;
        reading_ = none;
    }

    // A bit by its number among those of all words; each word has the bits of two bytes, the first one high.
    constexpr unsigned bit_at(std::size_t i) const {
        const auto at = static_cast<unsigned>(i % 16) ^ 8u;
        return static_cast<unsigned>(words_[i / 16] >> at) & 1u;
    }
    // The standard demands zeros behind the last bit of a response.
    constexpr bool has_zero_padding() const {
        const poll& p = Plan.polls[reading_];
        const unsigned used = p.quantity % 8u;
        return p.code > 0x02 || used == 0 || response_[p.response_size() - 3] >> used == 0;
    }
    // Two bytes of bits are kept as a word, the first one high.
    constexpr void keep_bits(std::size_t at) {
        const bytes bits = bytes{response_}.subspan(3, Plan.polls[reading_].response_size() - 5);
        for (std::size_t i = 0; i < bits.size(); i += 2) {
            const unsigned low = i + 1 < bits.size() ? bits[i + 1] : 0u;
            words_[at + i / 2] = static_cast<std::uint16_t>(unsigned{bits[i]} << 8 | low);
        }
    }

    static constexpr std::size_t at_least_one(std::size_t n) { return n == 0 ? 1 : n; }

    state states_[at_least_one(size)]{};
    std::uint16_t words_[at_least_one(Plan.words)]{};
    std::uint8_t response_[Plan.response_room]{};
    std::uint8_t request_[8]{};
    typename Line::exchange exchange_{};
    instant last_retry_{};
    instant searched_at_{}; // for a read that is due
    duration pause_{};      // from then on, within which no read becomes due
    instant dropped_at_{};  // when old values were
    std::size_t reading_ = none;
};

} // namespace servobus::detail
